//! What may have moved: the device's rectangles, and everything outside them, which must keep every bit.

use ripstop::gpu::stepper::Stage;
use ripstop::model::Model;
use ripstop::model::layup;
use ripstop::model::layup::{PENETRATING, SIDES, neighbour};
use ripstop::solver::active_region::ActiveRegion;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;

use super::{Outcome, Pair, Seen, places};

/// What the device must take to have moved after a stage. It lets its rectangles grow by a ring at the end of a step, in
/// the projectile's kernel; the processor does so where the nodes move.
pub(super) fn follow(
    reach: &mut [ActiveRegion],
    model: &Model<f32>,
    stage: Stage,
    before: &State<f32>,
    after: &State<f32>,
) {
    if !matches!(stage, Stage::Plies | Stage::Projectile) {
        return;
    }
    if stage == Stage::Projectile && model.projectile.is_some() {
        for (ply, reach) in reach.iter_mut().enumerate() {
            *reach = reach.grown(1, &model.ply_type(ply).mesh);
        }
    }
    // Contact takes in what it touches: whatever it changed.
    for [ply, row, column] in places(model) {
        if bits(model, before, [ply, row, column]) != bits(model, after, [ply, row, column]) {
            reach[ply].activate(row, column);
        }
    }
}

fn bits(model: &Model<f32>, state: &State<f32>, [ply, row, column]: [usize; 3]) -> [u32; node::COUNT] {
    let row = model.grid.first_node_row(ply) + row;
    std::array::from_fn(|field| state.nodes.get(row, field, column).to_bits())
}

/// The rectangles, the cells that nodes are over, and the bits of what nothing has reached.
pub(super) fn compare(pair: &Pair<'_>, seen: &mut Seen, kernel: &'static str) -> Outcome {
    let (model, got) = (&pair.scene.model, pair.download()?);
    for (ply, (got, expected)) in got.active.iter().zip(&pair.reach).enumerate() {
        let differs = f64::from(u8::from(got != expected));
        seen.see([kernel, "reach"], differs, 0.0, 1.0, || format!("ply {ply}, {got:?} for {expected:?}"));
    }
    // Cells share their edge: over a ridge rounding says which of them a node is over, which moves no impulse.
    let mut beside = 0;
    for (at, (got, expected)) in got.over.iter().zip(&pair.expected.over).enumerate() {
        let (ply, side) = (at / model.nodes_per_ply() / SIDES, at / model.nodes_per_ply() % SIDES);
        let Some(other) = neighbour(ply, side, model.plies.len()) else { continue };
        let columns = model.ply_type(other).mesh.columns;
        let cell = |over: u32| [layup::element(over) / columns, layup::element(over) % columns];
        let apart = [0, 1].map(|i| cell(*got)[i].abs_diff(cell(*expected)[i]));
        if got & PENETRATING == expected & PENETRATING && apart.iter().all(|steps| *steps <= 1) {
            beside += usize::from(got != expected);
        } else {
            seen.see(["ply_contact", "cells"], (*got).into(), (*expected).into(), 1.0, || format!("place {at}"));
        }
    }
    let many = f64::from(u8::from(beside * 50 > got.over.len()));
    seen.see(["ply_contact", "cells"], many, 0.0, 1.0, || format!("{beside} of {} cells beside", got.over.len()));
    for place in places(model) {
        let [ply, row, column] = place;
        let reach = &pair.expected.active[ply];
        if reach.rows.contains(&row) && reach.columns.contains(&column) {
            continue;
        }
        let start = bits(model, &pair.scene.state, place);
        for (who, state) in [("device", &got), ("processor", &pair.expected)] {
            let differs = f64::from(u8::from(bits(model, state, place) != start));
            seen.see(["step", "untouched"], differs, 0.0, 1.0, || format!("{who}, {place:?}"));
        }
    }
    Ok(())
}
