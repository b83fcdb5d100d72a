//! A ply as contact sees it: in the axes of the pack.

use nalgebra::Vector3;

use crate::model::Model;
use crate::model::mesh::Mesh;
use crate::model::ply_type::PlyType;
use crate::num::scalar::Scalar;
use crate::solver::node_update::field as node;
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

    /// Reference places of the nodes of a row along it, rounded.
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
