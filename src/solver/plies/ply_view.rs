//! A ply as contact sees it: in the axes of the pack.

use nalgebra::Vector3;

use crate::kernels::node_update::field as node;
use crate::math::scalar::Scalar;
use crate::model::{Mesh, Model, PlyType};
use crate::solver::state::{State, split};

/// A ply and the state of its nodes.
#[derive(Clone, Copy)]
pub(super) struct PlyView<'a, S> {
    pub(super) ply_type: &'a PlyType<S>,
    pub(super) mesh: &'a Mesh,
    /// At rest [m].
    pub(super) z: f64,
    turned: bool,
    /// Rows of the ply's nodes.
    nodes: &'a [S],
    stride: usize,
}

impl<'a, S: Scalar> PlyView<'a, S> {
    pub(super) fn new(model: &'a Model<S>, state: &'a State<S>, ply: usize) -> Self {
        let ply_type = model.ply_type(ply);
        let length = state.nodes.row_length();
        let first = model.grid.first_node_row(ply);
        Self {
            ply_type,
            mesh: &ply_type.mesh,
            z: model.plies[ply].z,
            turned: ply_type.mesh.rotation != [1.0, 0.0],
            nodes: &state.nodes.data[first * length..(first + ply_type.mesh.rows + 1) * length],
            stride: state.nodes.stride,
        }
    }

    /// Displacements of a row of nodes, in the ply's axes [m].
    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> [&'a [S]; 3] {
        let start = (row * node::COUNT + node::DISPLACEMENT) * self.stride;
        split(&self.nodes[start..start + 3 * self.stride], self.stride)
    }

    /// Reference places of the nodes of a row along it [m].
    #[inline(always)]
    pub(super) fn places(&self) -> &'a [f64] {
        &self.ply_type.columns.place
    }

    /// The same, rounded.
    #[inline(always)]
    pub(super) fn rounded_places(&self) -> &'a [S] {
        &self.ply_type.columns.rounded
    }

    #[inline(always)]
    fn vector(&self, field: usize, row: usize, column: usize) -> [f64; 3] {
        let at = (row * node::COUNT + field) * self.stride + column;
        [self.nodes[at].to_f64(), self.nodes[at + self.stride].to_f64(), self.nodes[at + 2 * self.stride].to_f64()]
    }

    #[inline(always)]
    fn to_pack(self, vector: [f64; 3]) -> Vector3<f64> {
        Vector3::from(if self.turned { self.mesh.to_pack(vector) } else { vector })
    }

    /// [m/s]
    #[inline(always)]
    pub(super) fn velocity(&self, row: usize, column: usize) -> Vector3<f64> {
        self.to_pack(self.vector(node::VELOCITY, row, column))
    }

    /// Position at the end of the step [m].
    #[inline(always)]
    pub(super) fn position(&self, row: usize, column: usize) -> Vector3<f64> {
        let [x, y, z] = self.vector(node::DISPLACEMENT, row, column);
        let [p, q] = self.mesh.reference(row, column);
        self.to_pack([p + x, q + y, self.z + z])
    }

    /// 1/mass along a direction [1/kg], in the whole scene: mirror planes hold no node in a single contact, only with its image.
    pub(super) fn inverse(&self, row: usize, column: usize, along: &Vector3<f64>) -> f64 {
        let inverse = &self.ply_type.row_mass(row).inverse;
        let [mut x, mut y, mut z] = [0, 1, 2].map(|a| inverse[a][column].to_f64());
        if let [across_x, across_y] = self.mesh.cut_across(row, column)
            && (across_x || across_y)
        {
            z *= self.mesh.part_of(row, column);
            x = if across_x || x > 0.0 { z } else { 0.0 };
            y = if across_y || y > 0.0 { z } else { 0.0 };
        }
        if x == y && y == z {
            return x;
        }
        let [p, q, r] = self.mesh.to_ply((*along).into());
        p * p * x + q * q * y + r * r * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver;
    use crate::solver::state::State;
    use crate::{case, model::Model};

    /// Two plies of S-720, the second laid across the first, between two clamps and two rollers.
    fn scene(symmetry: bool) -> (Model<f64>, State<f64>) {
        let text = r#"{"title": "t", "fabric": {"file": "fabrics/s-720.json"}, "solver": {"end_time_us": 1},
            "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 10, "mass_g": 1, "velocity_m_s": 100},
            "pack": {"width_mm": 25.4, "height_mm": 25.4, "layup": [{"plies": 1, "orientation_deg": 0},
            {"plies": 1, "orientation_deg": 90}],
            "edges": {"left": "roller", "right": "roller", "bottom": "clamped", "top": "clamped"}}}"#;
        let case = case::from_str("pack", text, &[]).unwrap_or_else(|error| unreachable!("{error}"));
        solver::set_up::<f64>(&case, symmetry).unwrap_or_else(|error| unreachable!("{error}"))
    }

    #[test]
    fn a_node_is_as_easy_to_move_in_a_part_as_in_the_whole() {
        let (whole, part) = (scene(false), scene(true));
        assert_eq!((whole.0.planes.copies(), part.0.planes.copies()), (1, 4));
        let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
        let along =
            [x, y, z, Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.48, -0.6, 0.64), Vector3::new(0.0, 0.8, -0.6)];
        // Of an element, half a crossover long and wide [kg].
        let mass = 0.2552 * 0.635e-3 * 0.635e-3;
        let mut kinds = [0; 4];
        for ply in 0..2 {
            let [of_whole, of_part] = [&whole, &part].map(|(model, state)| PlyView::new(model, state, ply));
            let (rows, columns) = (of_part.mesh.rows, of_part.mesh.columns);
            for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
                let place = of_part.position(row, column);
                let same = (0..=of_whole.mesh.rows)
                    .flat_map(|row| (0..=of_whole.mesh.columns).map(move |column| (row, column)))
                    .find(|(row, column)| (of_whole.position(*row, *column) - place).norm() < 1e-9);
                let Some((whole_row, whole_column)) = same else { unreachable!("{place}") };
                // What holds a node, and what of a cell is its own, from where it lies.
                let far = |x: f64| (x.abs() - 12.7e-3).abs() < 1e-9;
                let [px, py, _] = of_part.mesh.to_ply(place.into());
                let (roller, clamped) = (far(px), far(py));
                let own = mass * if roller { 0.5 } else { 1.0 };
                for along in &along {
                    let [of_whole, of_part] =
                        [of_whole.inverse(whole_row, whole_column, along), of_part.inverse(row, column, along)];
                    let across = of_part_axis(&part.0, ply, along);
                    let expected = match (clamped, roller) {
                        (true, _) => 0.0,
                        (false, true) => (1.0 - across * across) / own,
                        (false, false) => 1.0 / own,
                    };
                    assert!((of_part - expected).abs() < 1e-9 / own, "{ply} {place} {along}: {of_part} {expected}");
                    assert!((of_whole - expected).abs() < 1e-9 / own, "{ply} {place} {along}: {of_whole} {expected}");
                }
                kinds[usize::from(roller) + 2 * usize::from(clamped)] += 1;
            }
        }
        assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
    }

    /// What a direction has along the X axis of a ply.
    fn of_part_axis(model: &Model<f64>, ply: usize, along: &Vector3<f64>) -> f64 {
        model.ply_type(ply).mesh.to_ply((*along).into())[0]
    }
}
