//! What a shot of a batch has of its own, as the shaders see it.

use nalgebra::Vector3;

use super::Block;
use super::pack::node_mass;
use crate::kernels::ply_contact;
use crate::kernels::rigid_body::RigidBody;
use crate::model::Model;

/// Most shots in a batch: their constants fill a uniform of the size that every device grants.
pub const SHOTS: u64 = 2048;
/// Words of a shot's constants.
pub const SHOT_WORDS: u64 = 8;

/// Speed of any node over the largest at the start, at most: all the energy in one place.
const SPEED_MARGIN: f64 = 4.0;

/// The constants of a shot with that place in storage.
pub fn shot(model: &Model<f32>, number: usize) -> Block {
    let impact = model.projectile.as_ref().map_or_else(Vector3::zeros, |body| body.velocity);
    let mut block = Block::default();
    block.double("impact_x", impact.x);
    block.double("impact_y", impact.y);
    block.double("impact_z", impact.z);
    block.double("impulse_unit", impulse_unit(model));
    block.double("travel", model.dt * SPEED_MARGIN * start_speed(model));
    block.count("number", number);
    for pad in ["pad0", "pad1"] {
        block.count(pad, 0);
    }
    block
}

/// What impulses between plies are counted in [N·s]: sums are whole numbers of 32 bits, with room for eight times the
/// largest speed there is at the start, and for driving nodes out of other plies, which does not
/// depend on any speed. Light touches of many corners may add up to a few times that. In a graded mesh nodes of larger elements count in
/// larger units.
fn impulse_unit(model: &Model<f32>) -> f64 {
    let heaviest = model.ply_types.iter().map(node_mass).fold(0.0, f64::max);
    heaviest * (8.0 * start_speed(model) + 4.0 * ply_contact::FASTEST) / f64::from(1_u32 << 31)
}

/// Largest speed at the start [m/s], or 1 where nothing moves yet.
fn start_speed(model: &Model<f32>) -> f64 {
    let fabric =
        model.ply_types.iter().map(|ply_type| Vector3::from(ply_type.initial_velocity).norm()).fold(0.0, f64::max);
    let speed = fabric.max(model.projectile.as_ref().map_or(0.0, RigidBody::speed_bound));
    if speed > 0.0 { speed } else { 1.0 }
}
