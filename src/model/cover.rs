//! What fabric must be to cover a projectile.

use super::Mesh;
use crate::kernels::rigid_body::RigidBody;

/// Cells for which a yarn must run on unbroken to cover: one and a half times across the body at its widest.
pub(crate) fn unbroken_cells(mesh: &Mesh, body: &RigidBody) -> usize {
    (3.0 * body.body.radius / mesh.shortest()).ceil() as usize
}

/// Position along the axis of the foremost widest section, less a hundredth of the radius [m]; of a chisel the strip's.
pub(crate) fn shoulder(body: &RigidBody) -> f64 {
    let profile = &body.body.profile;
    let corners = &profile.corner[..profile.count];
    let widest = corners.iter().map(|c| c[0]).fold(0.0, f64::max);
    let front = corners.iter().filter(|c| c[0] >= widest).map(|c| c[1]).fold(f64::MIN, f64::max);
    front - 0.01 * body.body.radius
}
