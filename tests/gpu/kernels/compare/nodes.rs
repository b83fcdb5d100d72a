//! Displacement and velocity of the nodes, and what the supports take.

use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::stepper::Stage;
use ripstop::solver;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;

use super::{Outcome, Pair, STEPS, Seen, places};

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    for _ in 0..STEPS {
        pair.advance(&[Stage::Nodes], Some(0))?;
    }
    compare_nodes(pair, seen, "node_update", [pair.scales.length, pair.scales.speed])?;
    let supports = pair.read_floats(BufferId::Supports)?;
    let scale = pair.scales.force * pair.scene.model.dt;
    for a in 0..3 {
        let got: f64 = supports.iter().skip(a).step_by(3).sum();
        let expected = pair.ledger.support[a];
        seen.see(["node_update", "support"], got, expected, scale + expected.abs(), || format!("direction {a}"));
    }
    if pair.scene.elements {
        // Every held direction of a node that something pulls at has its own place.
        let used = supports.iter().filter(|impulse| **impulse != 0.0).count();
        seen.see(["step", "counters"], used as f64, held_directions(pair) as f64, 1.0, || "supports".into());
    }
    Ok(())
}

/// Held directions of nodes with a standing element.
fn held_directions(pair: &Pair<'_>) -> usize {
    let (model, state) = (&pair.scene.model, &pair.scene.state);
    let held = |[ply, row, column]: [usize; 3]| {
        let standing = solver::state::node_stands(model, state, ply, row, column);
        let inverse = &model.ply_type(ply).row_mass(row).inverse;
        if standing { inverse.iter().filter(|of| of[column] == 0.0).count() } else { 0 }
    };
    places(model).map(held).sum()
}

/// Displacement and velocity of every node after a kernel, by their scales.
pub(super) fn compare_nodes(pair: &Pair<'_>, seen: &mut Seen, kernel: &'static str, scales: [f64; 2]) -> Outcome {
    let (model, expected, got) = (&pair.scene.model, &pair.expected, pair.download()?);
    for [ply, in_ply, column] in places(model) {
        let row = model.grid.first_node_row(ply) + in_ply;
        for field in 0..node::COUNT {
            let number = |state: &State<f32>| f64::from(state.nodes.get(row, field, column));
            let row_of = [kernel, ["displacement", "velocity"][field / 3]];
            let step = expected.step - 1;
            let place = || format!("step {step}, ply {ply}, row {in_ply}, column {column}, field {field}");
            seen.see(row_of, number(&got), number(expected), scales[field / 3], place);
        }
    }
    Ok(())
}
