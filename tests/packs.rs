//! Packs of several plies.
//!
//! Promises: two plies that meet share their momentum and lose what an inelastic impact loses; friction slows by μN and never
//! reverses; a stack under a plate moves as one; nodes slide over many cells; holes are holes; nothing tunnels; symmetric
//! scenes give symmetric results; a pack of n plies is a ply n times as heavy and stiff; skipping and threads change no bit.
//! Red when: an impulse has a wrong sign or is given to one side only, a mass is shared out wrongly, a node forgets its
//! cell, the reach grows too slowly.

mod collisions;
mod shots;
mod symmetry;

use ripstop::case::{self, Case};
use ripstop::run::Simulation;

/// A pack from the JSON of its parts; the fabric is S-720 without shear where nothing else is said.
fn pack(pack: &str, more: &str, sets: &[&str]) -> Case {
    let text = format!(
        r#"{{"title": "pack", "fabric": {{"file": "fabrics/s-720.json"}}, "pack": {pack}, {more}
        "solver": {{"end_time_us": 20, "numerics": "paper"}}}}"#
    );
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::from_str("pack", &text, &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// Mass of a ply and its mean velocity in the pack's axes.
fn motion(simulation: &Simulation<f64>, ply: usize) -> (f64, [f64; 3]) {
    let (model, state) = (&simulation.model, &simulation.state);
    let ply_type = model.ply_type(ply);
    let mut mass = 0.0;
    let mut momentum = [0.0; 3];
    for row in 0..=ply_type.mesh.rows {
        for column in 0..=ply_type.mesh.columns {
            let m = ply_type.row_mass(row).mass[column];
            let velocity = ply_type.mesh.to_pack(state.velocity(model.grid.first_node_row(ply) + row, column));
            mass += m;
            for a in 0..3 {
                momentum[a] += m * velocity[a];
            }
        }
    }
    (mass, momentum.map(|p| p / mass))
}

/// Steps until a time [s].
fn advance(simulation: &mut Simulation<f64>, case: &Case, until: f64) {
    while simulation.time() < until {
        simulation.advance(case);
    }
}
