//! Planes of mirror symmetry of a whole scene, and the part of it that has to be computed.
//!
//! Where pack, projectile and motion are their own mirror images about x = 0 or y = 0 (the pack's axes), one side is enough: nodes on
//! the plane have the elements of that side only, half their mass, and rollers; the projectile has its share of mass and
//! inertia, and does not leave the plane. Every force and every mass on a plane is then exactly half of the whole
//! scene's, so that positions, velocities and failures are those of the whole scene.

use nalgebra::Vector3;

use super::Mesh;
use crate::case::{Case, Edge, Edges, Layer, Shape, Variability};
use crate::kernels::mirror_planes::{Cut, MirrorPlanes};
use crate::kernels::rigid_body::RigidBody;

/// Rounding of directions and places allowed in a symmetric scene, over their size [-].
const ROUNDING: f64 = 1e-12;

/// The planes of a case. `body`: its projectile, not yet cut.
pub(super) fn planes_of(case: &Case, body: Option<&RigidBody>) -> MirrorPlanes {
    if case.variability.as_ref().is_some_and(Variability::strength_varies) {
        return MirrorPlanes::NONE;
    }
    let layers = case.layers();
    let is_plane = |axis: usize| {
        let flies = match (&case.projectile, body) {
            (Some(projectile), Some(body)) => is_mirrored(body, &projectile.shape, axis),
            _ => true,
        };
        flies && layers.iter().all(|layer| is_laid_evenly(case, layer, axis))
    };
    MirrorPlanes([is_plane(0), is_plane(1)])
}

/// A layer's edges with rollers where its mesh is cut.
pub(super) fn cut_edges(mesh: &Mesh, edges: Edges) -> Edges {
    let cut = |axis: usize, at: Cut, edge: Edge| if mesh.cut[axis] == at { Edge::Roller } else { edge };
    Edges {
        left: cut(0, Cut::First, edges.left),
        right: cut(0, Cut::Last, edges.right),
        bottom: cut(1, Cut::First, edges.bottom),
        top: cut(1, Cut::Last, edges.top),
    }
}

/// Whether a projectile and its motion are their own mirror image about a plane across `axis` of the pack.
fn is_mirrored(body: &RigidBody, shape: &Shape, axis: usize) -> bool {
    let across = Vector3::ith(axis, 1.0);
    let within = |vector: &Vector3<f64>, size: f64| vector[axis].abs() <= ROUNDING * size;
    let local = body.orientation.inverse_transform_vector(&across);
    let stands = match shape {
        // The edge of a chisel lies along x of the body, a bar along y.
        Shape::Fragment { .. } | Shape::Bar { .. } => local.x.abs().min(local.y.abs()) <= ROUNDING,
        _ => true,
    };
    let spin = body.angular_velocity();
    stands
        && local.z.abs() <= ROUNDING
        && within(&body.position, body.body.bounding_radius)
        && within(&body.velocity, body.velocity.norm())
        && (spin - across * spin[axis]).norm() <= ROUNDING * spin.norm()
}

/// Whether the plies of a layer are their own mirror image about a plane across `axis` of the pack, which runs along nodes.
fn is_laid_evenly(case: &Case, layer: &Layer, axis: usize) -> bool {
    let mesh = Mesh::of_layer(layer);
    let Some(own) = mesh.own_axis(axis) else { return false };
    let Edges { left, right, bottom, top } = layer.edges;
    let ends = [left == right, bottom == top];
    let sine = case.pack.initial_deflection.is_none_or(|d| {
        let waves = [d.warp_half_waves, d.weft_half_waves][own];
        waves == 0 || waves % 2 == 1
    });
    let velocity = Vector3::from(layer.initial_velocity);
    mesh.is_even_sided(own) && ends[own] && sine && velocity[axis].abs() <= ROUNDING * velocity.norm()
}
