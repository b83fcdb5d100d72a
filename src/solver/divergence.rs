//! Divergence: numbers and energies that no run can have, and the place they come from.

use nalgebra::Vector3;

use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::RigidBody;
use crate::solver::Divergence;
use crate::solver::element_totals::field as element;
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::node_update::field as node;
use crate::solver::state::State;

/// Looks for numbers that are not finite: which kernel made them, and where.
pub(crate) fn find_divergence<S: Scalar>(model: &Model<S>, state: &State<S>) -> Option<Divergence> {
    let grid = &model.grid;
    let bad = |x: &S| !x.to_f64().is_finite();
    let divergence = |kernel, name: &str, x: S, place| {
        Some(Divergence { step: state.step, kernel, quantity: format!("{name} = {x:?}"), place })
    };
    let forces = ["membrane force along warp", "membrane force along weft", "hourglass force"];
    let name_of = |field: usize| forces.get(field / 3).copied().unwrap_or("yarn height, or what predicts it");
    for place @ [ply, row, column] in model.element_places() {
        let number = |f: usize| state.elements.get(grid.first_element_row(ply) + row, f, column + 1);
        if let Some(f) = (0..element::ALIVE).find(|f| bad(&number(*f))) {
            return divergence("element_force", name_of(f), number(f), place);
        }
    }
    for place @ [ply, row, column] in model.node_places() {
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
        let speed = |[ply, row, column]: [usize; 3]| {
            Vector3::from(state.velocity(model.grid.first_node_row(ply) + row, column)).norm()
        };
        let speeds = model.node_places().map(|place| (place, speed(place)));
        let (place, speed) = speeds.fold(([0; 3], 0.0), |fastest, one| if one.1 > fastest.1 { one } else { fastest });
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
