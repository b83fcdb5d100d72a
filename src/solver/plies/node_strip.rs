//! Lines of nodes that run along rows of the neighbour's cells, as the neighbour sees them.
//!
//! Where both plies lie alike these are rows of nodes; where one is laid across the other they are columns, of which those within the
//! rows of a part are copied.

use std::ops::Range;

use super::narrow_phase::{PlySearch, ROWS};
use crate::kernels::ply_contact::Planes;
use crate::num::scalar::{Scalar, each};

/// Room for the nodes of a column within a part, and for the longest register from the last of them on.
const LENGTH: usize = 4 * ROWS;

/// Nodes along the neighbour's rows, in the neighbour's axes.
pub(super) struct NodeStrip<'a, S> {
    /// [m]
    pub(super) displacement: [&'a [S]; 3],
    /// Reference places along the line [m], and rounded to the precision of the state.
    pub(super) place: &'a [f64],
    /// See `place`.
    pub(super) rounded: &'a [S],
    /// The reference place across the line [m].
    pub(super) y: f64,
    /// Cells that the nodes are over.
    pub(super) over: &'a [u32],
    /// Which of them to look at.
    pub(super) range: Range<usize>,
    /// Mirror planes that all of them lie on.
    pub(super) planes: Planes,
    /// The one that lies on a plane across the line.
    pub(super) crossed: Option<usize>,
}

/// A row of nodes of a ply that lies as its neighbour does.
#[inline(always)]
pub(super) fn row<'a, S: Scalar>(
    look: &PlySearch<'a, S>,
    row: usize,
    columns: Range<usize>,
    over: &'a [u32],
) -> NodeStrip<'a, S> {
    let own = &look.own;
    NodeStrip {
        displacement: own.row(row),
        place: own.places(),
        rounded: own.rounded_places(),
        y: own.mesh.reference(row, 0)[1],
        over,
        range: columns,
        planes: in_axes_of_the_ply(look.planes_at(row, usize::MAX)),
        crossed: look.planes[0],
    }
}

/// A part of a column of nodes of a ply that is laid across its neighbour.
pub(super) struct StripColumn<S> {
    displacement: [[S; LENGTH]; 3],
    place: [f64; LENGTH],
    rounded: [S; LENGTH],
    over: [u32; LENGTH],
    /// +1 or −1: the neighbour's X over the ply's Y, the neighbour's Y over the ply's X.
    turn: [f64; 2],
    rows: Range<usize>,
}

impl<S: Scalar> StripColumn<S> {
    /// Room for columns within these rows, at most [`ROWS`] of them; `None` where the ply is not laid across its neighbour.
    #[inline(always)]
    pub(super) fn within(look: &PlySearch<'_, S>, rows: Range<usize>) -> Option<Self> {
        let seen = |own: [f64; 3]| look.theirs.mesh.to_ply(look.own.mesh.to_pack(own));
        let turn = [seen([0.0, 1.0, 0.0])[0], seen([1.0, 0.0, 0.0])[1]];
        let zero = S::splat(0.0);
        turn.iter().all(|turn| turn.abs() == 1.0).then_some(Self {
            displacement: [[zero; LENGTH]; 3],
            place: [0.0; LENGTH],
            rounded: [zero; LENGTH],
            over: [0; LENGTH],
            turn,
            rows,
        })
    }

    /// The row of a node of the line.
    #[inline(always)]
    pub(super) fn row(&self, at: usize) -> usize {
        if self.turn[0] > 0.0 { self.rows.start + at } else { self.rows.end - 1 - at }
    }

    /// The part of a column. `over`: of the rows of the part, each of `across` nodes.
    #[inline(always)]
    pub(super) fn line(
        &mut self,
        look: &PlySearch<'_, S>,
        column: usize,
        over: &[u32],
        across: usize,
    ) -> NodeStrip<'_, S> {
        let [along, side] = self.turn;
        for at in 0..self.rows.len() {
            let row = self.row(at);
            let [u, v, w] = look.own.row(row).map(|field| field[column]);
            let turned = [S::splat(along * v.to_f64()), S::splat(side * u.to_f64()), w];
            for (line, number) in self.displacement.iter_mut().zip(turned) {
                line[at] = number;
            }
            self.place[at] = along * look.own.mesh.reference(row, column)[1];
            self.rounded[at] = S::splat(self.place[at]);
            self.over[at] = over[(row - self.rows.start) * across + column];
        }
        let crossed = look.planes[1].filter(|row| self.rows.contains(row));
        NodeStrip {
            displacement: [&self.displacement[0], &self.displacement[1], &self.displacement[2]],
            place: &self.place,
            rounded: &self.rounded,
            y: side * look.own.mesh.reference(0, column)[0],
            over: &self.over,
            range: 0..self.rows.len(),
            planes: in_axes_of_the_ply(look.planes_at(usize::MAX, column)),
            crossed: crossed.map(|row| if along > 0.0 { row - self.rows.start } else { self.rows.end - 1 - row }),
        }
    }
}

/// The axes of the pack across planes replaced by those of the neighbour, which are the coordinates of its cells.
#[inline(always)]
fn in_axes_of_the_ply(planes: Planes) -> Planes {
    each!(axis in 2 => planes[axis].map(|_| axis))
}
