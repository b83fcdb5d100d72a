//! Constants of the projectile.

use super::Block;
use crate::kernels::rigid_body::RigidBody;
use crate::model::Model;
use crate::model::cover::shoulder;

/// Adds them to those of the scene.
pub(super) fn projectile(block: &mut Block, model: &Model<f32>) {
    // Without one the numbers are never read; a mass of one keeps them tame.
    let body = model.projectile.as_ref();
    let number = |pick: fn(&RigidBody) -> f64, none: f64| body.map_or(none, pick);
    let back = |b: &RigidBody| {
        let corners = b.body.profile.corner[..b.body.profile.count].iter().map(|c| c[1]);
        corners.fold(f64::MAX, f64::min) - b.body.profile.radius - nose(b)
    };
    block.double("body_mass", number(|b| b.mass, 1.0));
    block.double("body_inertia_x", number(|b| b.body.inertia[0], 1.0));
    block.double("body_inertia_y", number(|b| b.body.inertia[1], 1.0));
    block.double("body_inertia_z", number(|b| b.body.inertia[2], 1.0));
    block.double("body_radius", number(|b| b.body.radius, 0.0));
    block.double("body_bounding_radius", number(|b| b.body.bounding_radius, 1.0));
    block.double("body_nose", number(nose, 0.0));
    block.double("body_back", body.map_or(0.0, back));
    block.double("body_shoulder", number(|b| shoulder(b) - nose(b), 0.0));
    block.count("body_prescribed", body.map_or(0, |b| usize::from(b.prescribed)));
    block.count("body_bar", body.map_or(0, |b| usize::from(b.body.profile.bar)));
    block.double("friction", model.friction);
    block.double("rim_depth", number(|b| b.rim_depth, 0.0));
    block.double("profile_radius", number(|b| b.body.profile.radius, 0.0));
    block.count("profile_count", body.map_or(1, |b| b.body.profile.count));
    block.count("profile_flat", body.map_or(0, |b| usize::from(b.body.profile.is_flat())));
    block.double("profile_arc", number(|b| b.body.profile.arc, 0.0));
    let chisel = body.and_then(|b| b.body.profile.chisel);
    block.count("chisel", usize::from(chisel.is_some()));
    block.double("chisel_half", chisel.map_or(0.0, |c| c.half));
    block.double("chisel_sine", chisel.map_or(0.0, |c| c.sine));
    block.double("chisel_cosine", chisel.map_or(0.0, |c| c.cosine));
    block.double("chisel_slope", chisel.map_or(0.0, |c| c.slope));
    block.double("chisel_corner", chisel.map_or(0.0, |c| c.corner));
}

/// Directions that mirror planes hold: of velocity, of turning, a bit each.
pub(super) fn body_held(body: &RigidBody) -> usize {
    let [moves, turns] = body.freedom;
    let free = moves.iter().chain(&turns);
    free.enumerate().filter(|(_, free)| **free == 0.0).map(|(bit, _)| 1 << bit).sum()
}

/// From the centre of mass to the tip of the nose along the axis [m]: what the device measures gaps from.
pub(super) fn nose(body: &RigidBody) -> f64 {
    let profile = &body.body.profile;
    profile.corner[..profile.count].iter().map(|c| c[1]).fold(f64::MIN, f64::max) + profile.radius
}
