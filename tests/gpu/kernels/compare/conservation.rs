//! What one ply gives another loses: exactly in the counts, and to rounding in the velocities.

use nalgebra::Vector3;
use ripstop::gpu::Device;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{self, IMPULSE_FIELDS};
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::Stage;
use ripstop::model::Model;
use ripstop::solver::state::State;

use super::{Outcome, Pair, idle, is_ply_kernel, motion, places};
use crate::gpu::kernels::scenes::Scene;

/// The counted impulses, and the counted shifts, of all nodes add up to nothing: no rounding, whatever the order.
pub(crate) fn cancels(device: &Device, scene: &Scene) -> Outcome {
    let counts_stay = |kernel: &Kernel| match kernel.name {
        "node_update" | "ply_search" | "ply_impulse" => kernel.source(),
        _ => idle(kernel),
    };
    let mut pair = Pair::new(device, scene, &counts_stay)?;
    pair.begin();
    pair.advance(&[Stage::Nodes, Stage::Plies], None)?;
    let counts: Vec<i64> = pair.read(BufferId::Impulses)?.into_iter().map(|word| i64::from(word as i32)).collect();
    if counts.iter().all(|count| *count == 0) {
        return Err("no impulse: the scene shows nothing".into());
    }
    // A count close to the end of its range would soon wrap around.
    let largest = counts.iter().map(|count| count.abs()).max().unwrap_or(0);
    if largest > i64::from(i32::MAX) / 2 {
        return Err(format!("{largest} counts on one node"));
    }
    // What a node is given without a share would wait there for a later step.
    let shares = pair.read(BufferId::Shares)?;
    let given = counts.chunks_exact(IMPULSE_FIELDS as usize).zip(&shares);
    let lost = given.filter(|(counts, share)| **share == 0 && counts.iter().any(|count| *count != 0)).count();
    if lost > 0 {
        return Err(format!("{lost} nodes are given impulses they do not take"));
    }
    let units = units(&scene.model);
    for field in 0..IMPULSE_FIELDS as usize {
        let of_field = counts.iter().skip(field).step_by(IMPULSE_FIELDS as usize);
        let sum: i64 = of_field.zip(&units).map(|(count, unit)| count * unit).sum();
        if sum != 0 {
            return Err(format!("{sum} counts too many in field {field}"));
        }
    }
    Ok(())
}

/// What each node counts impulses in, over the unit of the scene: as many as its mass is of that of an inner node of the finest elements,
/// rounded up to a power of two.
fn units(model: &Model<f32>) -> Vec<i64> {
    let mut units = vec![1; model.plies.len() * model.nodes_per_ply()];
    let from = layout::device_origin(model);
    for [ply, row, column] in places(model) {
        let share = |axis, line| layout::line(model.ply_type(ply), &from, axis, line).share;
        let mass = share(0, column) * share(1, row);
        let at = (model.grid.first_node_row(ply) + row) * (model.grid.columns + 1) + column;
        units[at] = (mass.ceil() as u64).next_power_of_two() as i64;
    }
    units
}

/// Contact between plies leaves the momentum of a free pack as it was, to the rounding of its nodes' velocities.
pub(crate) fn keeps_momentum(device: &Device, scene: &Scene) -> Outcome {
    let sources = |kernel: &Kernel| {
        let runs = kernel.name == "node_update" || is_ply_kernel(kernel);
        if runs { kernel.source() } else { idle(kernel) }
    };
    let mut pair = Pair::new(device, scene, &sources)?;
    pair.begin();
    let info = pair.gpu.whole_step(scene.state.step, None, 1);
    let run = |stage: Stage| -> Result<State<f32>, String> {
        pair.gpu.run_stages(&info, &[stage]).map_err(|e| e.to_string())?;
        pair.download()
    };
    let [before, after] = [run(Stage::Nodes)?, run(Stage::Plies)?];
    let (mut change, mut given, mut rounding) = (Vector3::zeros(), 0.0, 0.0);
    for place in places(&scene.model) {
        let [(mass, old), (_, new)] = [&before, &after].map(|state| motion(&scene.model, state, place));
        change += (new - old) * mass;
        given += ((new - old) * mass).norm();
        rounding += mass * new.norm() * f64::from(f32::EPSILON);
    }
    // Roundings of single nodes are of either sign and mostly cancel; all of one sign would be a leak.
    if given < 1e4 * rounding || change.norm() > 0.5 * rounding {
        return Err(format!(
            "momentum changes by {:e}, of {given:e} exchanged; rounding is {rounding:e}",
            change.norm()
        ));
    }
    Ok(())
}
