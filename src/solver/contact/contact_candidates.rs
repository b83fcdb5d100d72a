//! List of the nodes near the projectile, which lasts some steps.

use std::ops::RangeInclusive;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::model::Model;
use crate::model::mesh::Mesh;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::RigidBody;
use crate::solver::state::{State, node_position, row_positions};

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
pub(crate) fn find_candidates<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    body: &RigidBody,
    margin: f64,
) -> Vec<[usize; 3]> {
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
            if reaches && zone.has(body, &node_position(model, state, [ply, row, column])) {
                out.push([ply, row, column]);
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
mod tests {
    use super::*;
    use std::path::Path;

    use crate::case;
    use crate::solver::node_update::field as node;

    /// A case of a smaller pack, its projectile changed, ready to run.
    fn scene(file: &str, projectile: &str) -> (Model<f64>, State<f64>) {
        let sets = ["/expect=[]", "/sources={}", "/pack/width_mm=40", "/pack/height_mm=40"].map(str::to_owned);
        let sets = [&sets[..], &[format!("/projectile={projectile}")]].concat();
        let case = case::read(Path::new(file), &sets).unwrap_or_else(|error| unreachable!("{error}"));
        let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        let state = State::new(&case, &model);
        (model, state)
    }

    /// Every node that comes within the margin when it is moved through any part of the plies in front is listed, and few that
    /// do not come within a margin more.
    #[test]
    fn all_nodes_near_the_body_are_listed() {
        let common =
            r#""mass_g": 3, "velocity_m_s": 155, "offset_mm": [7.3, -4.1], "obliquity_deg": 40, "azimuth_deg": 25"#;
        let shapes = [
            r#""shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "yaw_deg": 20"#,
            r#""shape": "cylinder", "diameter_mm": 9, "length_mm": 3, "edge_radius_mm": 0.4, "yaw_deg": -25"#,
            r#""shape": "sphere", "diameter_mm": 8"#,
            r#""shape": "cone", "diameter_mm": 6, "length_mm": 30, "nose_length_mm": 30, "edge_radius_mm": 0"#,
            r#""shape": "ogive", "diameter_mm": 6, "length_mm": 14, "nose_length_mm": 9, "edge_radius_mm": 0"#,
            r#""shape": "fragment", "diameter_mm": 7, "length_mm": 8, "roll_deg": 30"#,
        ];
        for shape in shapes {
            for file in ["cases/s728-4ply-91.json", "cases/hybrid-8ply-200.json"] {
                let (model, mut state) = scene(file, &format!("{{{shape}, {common}}}"));
                for row in 0..model.grid.node_rows() {
                    for column in 0..model.grid.columns {
                        let swell = 1e-3 * (0.3 * row as f64 + 0.7 * column as f64).sin();
                        (0..3)
                            .for_each(|a| state.nodes.set(row, node::DISPLACEMENT + a, column, swell * (1 + a) as f64));
                    }
                }
                let Some(mut body) = state.body.clone() else { unreachable!() };
                body.position += body.flight * 4e-3;
                let margin = 1.5e-3;
                let listed = find_candidates(&model, &state, &body, margin);
                let within = |room: f64| {
                    let mut all = model.node_places().collect::<Vec<_>>();
                    all.retain(|&[ply, row, column]| {
                        let position = node_position(&model, &state, [ply, row, column]);
                        let moved = |part: u32| {
                            position - Vector3::new(0.0, 0.0, model.plies[ply].depth * f64::from(part) / 40.0)
                        };
                        (0..=40).any(|part| body.gap(&moved(part)).0 < room)
                    });
                    all
                };
                let (least, most) = (within(margin), within(2.0 * margin));
                assert!(least.len() > 20, "{shape} {file}: {}", least.len());
                assert!(least.iter().all(|place| listed.contains(place)), "{shape} {file}");
                assert!(listed.iter().all(|place| most.contains(place)), "{shape} {file}");
                assert!(listed.is_sorted(), "in storage order");
            }
        }
    }
}
