//! From a case to its plies: which are alike, where they lie, at what distance they touch.

use nalgebra::Vector3;

use crate::case::{Case, Edge, Edges, Layer, Shape, Variability};
use crate::model::mesh::Mesh;
use crate::model::{Model, Ply};
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::{Cut, MirrorPlanes, RigidBody};

/// Layers of a case that differ from each other, and its plies, the struck one first.
pub(super) fn layup(case: &Case) -> (Vec<Layer>, Vec<Ply>) {
    let mut layers: Vec<Layer> = Vec::new();
    let (mut ply_types, mut standoffs) = (Vec::new(), Vec::new());
    for layer in case.layers().iter() {
        let alike = |other: &Layer| Layer { plies: other.plies, standoff: other.standoff, ..layer.clone() } == *other;
        let ply_type = layers.iter().position(alike).unwrap_or(layers.len());
        if ply_type == layers.len() {
            layers.push(layer.clone());
        }
        ply_types.extend(std::iter::repeat_n(ply_type, layer.plies as usize));
        standoffs.resize(ply_types.len(), 0.0);
        standoffs[ply_types.len() - layer.plies as usize] = layer.standoff;
    }
    let thickness = |at: usize| layers[ply_types[at]].fabric.thickness;
    let (mut z, mut depth) = (0.0, 0.0);
    let ply = |(at, ply_type): (usize, &usize)| {
        let mean = if at + 1 < ply_types.len() { 0.5 * (thickness(at) + thickness(at + 1)) } else { 0.0 };
        let spacing = case.pack.spacing.unwrap_or(mean) + standoffs.get(at + 1).copied().unwrap_or(0.0);
        let ply = Ply { ply_type: *ply_type, z, depth, thickness: mean, touching: mean.min(spacing) };
        z += spacing;
        depth += ply.touching;
        ply
    };
    let plies = ply_types.iter().enumerate().map(ply).collect();
    (layers, plies)
}

/// In front, behind: the two neighbours of a ply.
pub const SIDES: usize = 2;

/// Set beside the element where the node is inside it, closer than the two plies touch.
pub const PENETRATING: u32 = 1 << 31;

/// The element a node is over.
#[inline]
pub fn element(over: u32) -> usize {
    (over & !PENETRATING) as usize
}

/// A little nearer to the centre than it is [-].
const INWARD: f64 = 1.0 - 1e-9;

/// Element (row·columns + column) of the ply in front, then of the ply behind, nearest to each node at rest; shape
/// (plies, 2, (rows + 1)·(columns + 1)) of the storage grid. Empty for a single ply.
pub(crate) fn over_at_rest<S: Scalar>(model: &Model<S>) -> Vec<u32> {
    let plies = model.plies.len();
    if plies < 2 {
        return Vec::new();
    }
    let per_side = model.nodes_per_ply();
    // Of cells that are as near, the one towards the centre, so that mirror images are over mirror images.
    let inward = if model.mirror == MirrorPlanes::NONE { 1.0 } else { INWARD };
    let mut over = vec![0; plies * SIDES * per_side];
    for (at, part) in over.chunks_mut(per_side).enumerate() {
        let (ply, side) = (at / SIDES, at % SIDES);
        let Some(other) = neighbour(ply, side, plies) else { continue };
        let (own, theirs) = (model.ply_type(ply), &model.ply_type(other).mesh);
        for (row, column) in own.nodes() {
            let [x, y] = own.mesh.reference(row, column);
            let [x, y, _] = theirs.to_ply(own.mesh.to_pack([x, y, 0.0]));
            let [row_over, column_over] = theirs.element_at([x, y].map(|at| at * inward));
            part[row * (model.grid.columns + 1) + column] = (row_over * theirs.columns + column_over) as u32;
        }
    }
    over
}

/// The ply in front (0) or behind (1).
pub fn neighbour(ply: usize, side: usize, plies: usize) -> Option<usize> {
    if side == 0 { ply.checked_sub(1) } else { Some(ply + 1).filter(|next| *next < plies) }
}

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
    mesh.lines[own].is_mirrored() && ends[own] && sine && velocity[axis].abs() <= ROUNDING * velocity.norm()
}
