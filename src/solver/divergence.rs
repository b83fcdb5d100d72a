//! Divergence of a run: numbers that are not finite, energy that was never put in, and where.

use nalgebra::Vector3;

use crate::model::Model;
use crate::model::mesh::Mesh;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::RigidBody;
use crate::solver::Divergence;
use crate::solver::element_totals::field as element;
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::node_update::field as node;
use crate::solver::state::State;

/// Ply, row and column of the fastest node, and its speed [m/s].
fn fastest_node<S: Scalar>(model: &Model<S>, state: &State<S>) -> ([usize; 3], f64) {
    let mut fastest = ([0; 3], 0.0);
    for [ply, row, column] in nodes(model) {
        let speed = Vector3::from(state.velocity(model.grid.first_node_row(ply) + row, column)).norm();
        if speed > fastest.1 {
            fastest = ([ply, row, column], speed);
        }
    }
    fastest
}

/// Every node: ply, row, column.
pub fn nodes<S: Scalar>(model: &Model<S>) -> impl Iterator<Item = [usize; 3]> {
    (0..model.plies.len()).flat_map(move |ply| {
        let Mesh { rows, columns, .. } = model.ply_type(ply).mesh;
        (0..=rows).flat_map(move |row| (0..=columns).map(move |column| [ply, row, column]))
    })
}

/// Every element: ply, row, column.
pub fn elements<S: Scalar>(model: &Model<S>) -> impl Iterator<Item = [usize; 3]> {
    (0..model.plies.len()).flat_map(move |ply| {
        let Mesh { rows, columns, .. } = model.ply_type(ply).mesh;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [ply, row, column]))
    })
}

/// Looks for numbers that are not finite: which kernel made them, and where.
pub(crate) fn find_divergence<S: Scalar>(model: &Model<S>, state: &State<S>) -> Option<Divergence> {
    let grid = &model.grid;
    let bad = |x: &S| !x.to_f64().is_finite();
    let divergence = |kernel, name: &str, x: S, place| {
        Some(Divergence { step: state.step, kernel, quantity: format!("{name} = {x:?}"), place })
    };
    let name_of = |field: usize| match field {
        element::HEIGHT.. => "yarn height",
        element::PREDICTOR.. => "predictor of the yarn height",
        _ => ["membrane force along warp", "membrane force along weft", "hourglass force"][field / 3],
    };
    for place in elements(model) {
        let [ply, row, column] = place;
        let number = |f: usize| state.elements.get(grid.first_element_row(ply) + row, f, column + 1);
        if let Some(f) = (0..element::ALIVE).find(|f| bad(&number(*f))) {
            return divergence("element_force", name_of(f), number(f), place);
        }
    }
    for place in nodes(model) {
        let [ply, row, column] = place;
        let number = |f: usize| state.nodes.get(grid.first_node_row(ply) + row, f, column);
        if let Some(f) = (0..node::COUNT).find(|f| bad(&number(*f))) {
            let name = if f < node::VELOCITY { "displacement" } else { "velocity" };
            return divergence("node_update", name, number(f), place);
        }
    }
    None
}

/// Kinetic energy of a projectile that flies freely [J].
pub(crate) fn flying(body: Option<&RigidBody>) -> f64 {
    body.map_or(0.0, |b| if b.prescribed { 0.0 } else { b.kinetic_energy() })
}

/// Energy that was never put in, or that is no number: its kind, and how much [J]. `sampled`: the balance knows all kinds now.
pub(crate) fn excess(balance: &EnergyBalance, kinetic: f64, sampled: bool) -> Option<(&'static str, f64)> {
    let whole = balance.accounted_energy() + balance.gained();
    if !(kinetic <= balance.energy_limit() && balance.work.is_finite()) {
        Some(("kinetic energy", kinetic))
    } else if sampled && whole > balance.energy_limit() {
        Some(("energy by state functions", whole))
    } else {
        None
    }
}

/// Divergence and its place: a number that is not finite, or energy of some kind that was never put in [J].
pub(crate) fn diagnose<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    (name, energy): (&str, f64),
    available: f64,
) -> Divergence {
    let mut divergence = find_divergence(model, state).unwrap_or_else(|| {
        let (place, speed) = fastest_node(model, state);
        let [energy, available] = [energy, available].map(|energy| energy * model.planes.copies() as f64);
        Divergence {
            step: state.step,
            kernel: "node_update",
            quantity: format!(
                "{name} {energy:.6e} J where at most {available:.6e} J was ever put in; fastest node {speed:.6e} m/s"
            ),
            place,
        }
    });
    divergence.place = model.place_in_whole(divergence.place);
    divergence
}
