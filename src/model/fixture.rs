//! Fixture of a ply: which elements of its mesh are there, and which nodes the frame holds.

use crate::case::{Edge, Edges, Opening};
use crate::model::mesh::{Mesh, corners};
use crate::physics::rigid_body::Cut;

/// Mass and support of a node in a frame that is not plain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NodeFixture {
    /// Quarters of the elements around it that are there, over the finest element; 0: there are none [-].
    pub share: f64,
    /// Whether all its displacements are held. A node without elements is.
    pub held: bool,
}

impl Mesh {
    /// Whether an element is there: its middle lies in the opening of the frame.
    pub fn is_present(&self, row: usize, column: usize) -> bool {
        if self.frame.opening == Opening::Mesh {
            return true;
        }
        let [first, _, last, _] = corners([row, column]).map(|(row, column)| self.reference(row, column));
        let [x, y, _] = self.to_pack([0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]), 0.0]);
        self.frame.contains([x, y])
    }

    /// Mass and support of a node. `edges`: of the opening, and of the mesh where that is the opening.
    pub(super) fn fixture(&self, edges: &Edges, row: usize, column: usize) -> NodeFixture {
        let [x, y] = self.reference(row, column);
        let [x, y, _] = self.to_pack([x, y, 0.0]);
        let sides = [
            (column == 0 && self.cut[0] != Cut::First, edges.left),
            (column == self.columns && self.cut[0] != Cut::Last, edges.right),
            (row == 0 && self.cut[1] != Cut::First, edges.bottom),
            (row == self.rows && self.cut[1] != Cut::Last, edges.top),
        ];
        let present = |&[row, column]: &[usize; 2]| self.is_present(row, column);
        let share: f64 = self
            .around(row, column)
            .filter(present)
            .map(|[r, c]| 0.25 * self.widths(r, c).iter().product::<f64>())
            .sum();
        let is_edge = sides.iter().any(|(at, _)| *at) || !self.around(row, column).all(|element| present(&element));
        let clamped = match self.frame.opening {
            Opening::Mesh => sides.contains(&(true, Edge::Clamped)),
            _ => is_edge && self.frame.clamps(edges, [x, y]),
        };
        NodeFixture { share, held: share == 0.0 || clamped || self.frame.clamps_corner([x, y]) }
    }
}
