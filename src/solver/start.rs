//! The start of a run: model and state of a case, and what energy it has.

use nalgebra::Vector3;
use tracing::info;

use crate::case::Case;
use crate::kernels::rigid_body::RigidBody;
use crate::model::{Model, ModelError};
use crate::num::scalar::Scalar;
use crate::solver;
use crate::solver::state::State;

/// Model and state of a case: of the whole, or of the part that its mirror planes leave.
///
/// # Errors
/// When the case cannot become a model, or the projectile starts inside the fabric.
pub(crate) fn set_up<S: Scalar>(case: &Case, symmetry: bool) -> Result<(Model<S>, State<S>), ModelError> {
    let model = if symmetry { Model::<S>::part(case)? } else { Model::<S>::new(case)? };
    let state = State::new(case, &model);
    check_start(&model, &state)?;
    info!(
        plies = model.plies.len(),
        elements = model.whole_elements(),
        computed = model.elements(),
        mirrored = ?model.planes.names(),
        step_us = model.dt * 1e6,
        set_by = model.bound.set_by,
        numbers = state.nodes.data.len() + state.elements.data.len(),
        precision = S::NAME,
        "model built"
    );
    Ok((model, state))
}

/// Least energy that an error is measured against, over what rounding makes of the energy of a scene at rest [-].
const MEASURABLE: f64 = 1e3;

/// What a scene starts with, for the scale of errors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Given {
    /// Kinetic energy, at least what rounding can be measured against [J].
    pub energy: f64,
    /// Momentum [kg·m/s].
    pub momentum: Vector3<f64>,
    /// Mass of the fabric [kg].
    pub fabric_mass: f64,
}

/// Energy, momentum and fabric that the scene starts with.
pub(crate) fn given<S: Scalar>(model: &Model<S>, state: &State<S>) -> Given {
    let mut energy = 0.0;
    let mut momentum = Vector3::zeros();
    if model.ply_types.iter().any(|ply_type| ply_type.initial_velocity != [0.0; 3]) {
        for [ply, row, column] in solver::nodes(model) {
            let ply_type = model.ply_type(ply);
            let velocity = state.velocity(model.grid.first_node_row(ply) + row, column);
            let v = Vector3::from(ply_type.mesh.to_pack(velocity));
            let m = ply_type.row_mass(row).mass[column].to_f64();
            energy += 0.5 * m * v.norm_squared();
            momentum += v * m;
        }
    }
    if let Some(body) = state.body.as_ref() {
        energy += body.own_energy();
        momentum += body.velocity * if body.prescribed { 0.0 } else { body.mass };
    }
    let energy = energy.max(MEASURABLE * rounding(model, state.body.as_ref()));
    Given { energy, momentum, fabric_mass: model.fabric_mass() }
}

/// What rounding makes of the energy of a scene at rest [J].
fn rounding<S: Scalar>(model: &Model<S>, body: Option<&RigidBody>) -> f64 {
    let body = body.map_or(0.0, |body| {
        let moves = if body.prescribed { 0.0 } else { body.translation() };
        f64::EPSILON * moves + S::EPSILON * body.rotational_energy()
    });
    model.rounding() + body
}

/// Initial penetration is an input error, not something contact may repair.
fn check_start<S: Scalar>(model: &Model<S>, state: &State<S>) -> Result<(), ModelError> {
    let Some(body) = &state.body else { return Ok(()) };
    let mut deepest: f64 = 0.0;
    for [ply, row, column] in solver::nodes(model) {
        let (gap, _) = body.gap(&solver::node_position(model, state, ply, row, column));
        deepest = deepest.max(-gap);
    }
    // Room for rounding of a touching start in the state's precision.
    let rounding = 16.0 * S::EPSILON * (body.body.bounding_radius + body.position.norm());
    if deepest > rounding {
        return Err(ModelError::InitialPenetration { depth_mm: deepest * 1e3 });
    }
    Ok(())
}
