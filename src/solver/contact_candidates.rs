//! List of the nodes near the projectile, which lasts some steps.

use std::ops::RangeInclusive;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::model::Model;
use crate::model::mesh::Mesh;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::RigidBody;
use crate::solver::state::State;
use crate::solver::state::{node_position, row_positions};

/// Zone of a ply near a body.
struct Zone {
    /// Thickness of the plies in front [m].
    depth: f64,
    /// Places sampled between a node and its place behind no fabric, less one.
    samples: u32,
    /// Distance of any of these from the body [m].
    room: f64,
    /// Extent of the body along the axes of the ply, with that room [m].
    along: RangeInclusive<f64>,
    across: RangeInclusive<f64>,
}

impl Zone {
    fn new<S: Scalar>(model: &Model<S>, ply: usize, body: &RigidBody, margin: f64) -> Self {
        let depth = model.plies[ply].depth;
        // No further apart than the margin.
        let samples = (depth / margin).ceil().min(64.0) as u32;
        let room = margin + 0.5 * depth / f64::from(samples.max(1));
        let [along, across] = [0, 1].map(|axis| extent(body, &model.ply_type(ply).mesh, axis, room));
        Self { depth, samples, room, along, across }
    }

    /// Whether a node is near the body at its own place, behind no fabric, or between.
    fn has(&self, body: &RigidBody, position: &Vector3<f64>) -> bool {
        let moved =
            |sample: u32| Vector3::new(0.0, 0.0, self.depth * f64::from(sample) / f64::from(self.samples.max(1)));
        (0..=self.samples).any(|sample| body.gap(&(position - moved(sample))).0 < self.room)
    }
}

/// Nodes within `margin` of the body, or of it moved through the plies in front, in storage order: ply, row, column.
pub(super) fn find_candidates<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    body: &RigidBody,
    margin: f64,
) -> Vec<[u32; 3]> {
    let grid = &model.grid;
    let zones: Vec<_> = (0..model.plies.len()).map(|ply| Zone::new(model, ply, body, margin)).collect();
    let found = (0..grid.node_rows()).into_par_iter().with_min_len(16).map(|index| {
        let (ply, row) = grid.node_row(index);
        let mut out = Vec::new();
        let (mesh, zone) = (&model.ply_type(ply).mesh, &zones[ply]);
        if row > mesh.rows {
            return out;
        }
        for (column, [x, y, _]) in row_positions(model, state, ply, row).enumerate() {
            // Most nodes are beside the body.
            let reaches = zone.across.contains(&y) && zone.along.contains(&x);
            if reaches && zone.has(body, &node_position(model, state, ply, row, column)) {
                out.push([ply, row, column].map(|at| at as u32));
            }
        }
        out
    });
    found.collect::<Vec<_>>().concat()
}

/// From where to where a body reaches along the first or second axis of a ply, with `room` on either side [m].
fn extent(body: &RigidBody, mesh: &Mesh, axis: usize, room: f64) -> RangeInclusive<f64> {
    if body.body.profile.bar {
        return f64::NEG_INFINITY..=f64::INFINITY;
    }
    let mut direction = [0.0; 3];
    direction[axis] = 1.0;
    let direction = body.orientation.inverse_transform_vector(&mesh.to_pack(direction).into());
    let centre = mesh.to_ply(body.position.into())[axis];
    let [back, front] = [-direction, direction].map(|direction| body.body.support(direction.into()) + room);
    centre - back..=centre + front
}

#[cfg(test)]
#[path = "contact_candidates_tests.rs"]
mod tests;
