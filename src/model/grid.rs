//! The structured mesh and how its state is stored.

use crate::case::Pack;

/// Numbers processed at once at most; rows are padded so that every load stays inside its row.
const PAD: usize = 16;

/// Mesh of a pack: plies of `rows` × `columns` elements, warp along X (columns), weft along Y (rows).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Independent shots held side by side.
    pub shots: usize,
    /// Plies per shot.
    pub plies: usize,
    /// Elements along Y.
    pub rows: usize,
    /// Elements along X.
    pub columns: usize,
    /// Undeformed element lengths Lx, Ly [m].
    pub length: [f64; 2],
    /// Reference position of node (0, 0) [m]; the pack's centre is the origin.
    pub origin: [f64; 2],
    /// Numbers stored per field of a row of nodes.
    pub node_stride: usize,
    /// Numbers stored per field of a row of elements; element c is at c + 1.
    pub element_stride: usize,
}

impl Grid {
    /// Mesh of one shot at a pack.
    pub fn new(pack: &Pack) -> Self {
        let padded = (pack.columns + 1).next_multiple_of(PAD) + PAD;
        let length = [pack.element_length_x, pack.element_length_y];
        Self {
            shots: 1,
            plies: pack.plies as usize,
            rows: pack.rows,
            columns: pack.columns,
            length,
            origin: [-0.5 * length[0] * pack.columns as f64, -0.5 * length[1] * pack.rows as f64],
            node_stride: padded,
            element_stride: padded + PAD,
        }
    }

    /// Rows of nodes over all shots and plies.
    pub fn node_rows(&self) -> usize {
        self.shots * self.plies * (self.rows + 1)
    }

    /// Rows of elements over all shots and plies.
    pub fn element_rows(&self) -> usize {
        self.shots * self.plies * self.rows
    }

    /// Elements over all shots and plies.
    pub fn elements(&self) -> usize {
        self.element_rows() * self.columns
    }

    /// Ply (counted over shots) and row within it of a row of nodes.
    pub fn node_row(&self, row: usize) -> (usize, usize) {
        (row / (self.rows + 1), row % (self.rows + 1))
    }

    /// Ply (counted over shots) and row within it of a row of elements.
    pub fn element_row(&self, row: usize) -> (usize, usize) {
        (row / self.rows, row % self.rows)
    }

    /// Reference position of a node [m].
    pub fn reference(&self, row: usize, column: usize) -> [f64; 2] {
        [self.origin[0] + self.length[0] * column as f64, self.origin[1] + self.length[1] * row as f64]
    }
}
