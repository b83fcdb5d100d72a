//! How the state of a pack is stored: rows of nodes and elements, ply after ply.

use super::mesh::Mesh;

/// Numbers processed at once at most; rows are padded so that every load stays inside its row.
const PAD: usize = 32;

/// Storage of a pack. Every ply has room for the largest mesh among them; what a smaller one leaves is never computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Plies, the struck one first.
    pub plies: usize,
    /// Most elements along weft.
    pub rows: usize,
    /// Most elements along warp.
    pub columns: usize,
    /// Numbers stored per field of a row of nodes.
    pub node_stride: usize,
    /// Numbers stored per field of a row of elements; element c is at c + 1.
    pub element_stride: usize,
}

impl Grid {
    /// Storage for `plies` plies of these meshes.
    pub fn new<'a>(plies: usize, meshes: impl Iterator<Item = &'a Mesh>) -> Self {
        let [rows, columns] = meshes.fold([0; 2], |[r, c], mesh| [r.max(mesh.rows), c.max(mesh.columns)]);
        let node_stride = Self::node_stride(columns);
        Self { plies, rows, columns, node_stride, element_stride: node_stride + PAD }
    }

    /// Numbers stored per field of a row of nodes of a mesh with so many columns.
    pub(crate) fn node_stride(columns: usize) -> usize {
        (columns + 1).next_multiple_of(PAD) + PAD
    }

    /// Rows of nodes over all plies.
    pub fn node_rows(&self) -> usize {
        self.plies * (self.rows + 1)
    }

    /// Rows of elements over all plies.
    pub fn element_rows(&self) -> usize {
        self.plies * self.rows
    }

    /// Ply and row within it of a row of nodes.
    pub(crate) fn node_row(&self, row: usize) -> (usize, usize) {
        (row / (self.rows + 1), row % (self.rows + 1))
    }

    /// Ply and row within it of a row of elements.
    pub(crate) fn element_row(&self, row: usize) -> (usize, usize) {
        (row / self.rows, row % self.rows)
    }

    /// First row of nodes of a ply.
    pub fn first_node_row(&self, ply: usize) -> usize {
        ply * (self.rows + 1)
    }

    /// First row of elements of a ply.
    pub fn first_element_row(&self, ply: usize) -> usize {
        ply * self.rows
    }
}
