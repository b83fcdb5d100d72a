//! Internal force on a node from its up to four elements, in fixed order, so that the sum does not depend on threads.

use crate::model::Model;
use crate::num::scalar::{Real, Scalar, each};
use crate::solver::element_totals::field as element;
use crate::solver::state::{Rows, split};

/// Element rows around a row of nodes.
pub struct Neighbours<'a, S> {
    /// Forces of the row of elements below, in storage order.
    pub below: [&'a [S]; element::FORCES.end],
    /// Fields of the row above.
    pub above: [&'a [S]; element::FORCES.end],
}

/// Element rows around a row of nodes; `nothing` where the ply ends.
pub(super) fn neighbours<'a, S: Scalar>(
    model: &Model<S>,
    elements: &'a Rows<S>,
    nothing: &'a [S],
    ply: usize,
    row: usize,
) -> Neighbours<'a, S> {
    let index = model.grid.first_element_row(ply) + row;
    let below = if row > 0 { elements.row(index - 1) } else { nothing };
    let above = if row < model.ply_type(ply).mesh.rows { elements.row(index) } else { nothing };
    Neighbours { below: split(below, elements.stride), above: split(above, elements.stride) }
}

/// Internal force on `LANES` nodes like `n` from column `column` on [N].
#[inline(always)]
pub fn gather<R: Real>(n: R, around: &Neighbours<'_, R::Scalar>, column: usize) -> [R; 3] {
    // Columns of elements are stored one further: left neighbour at `column`, right neighbour at `column` + 1.
    let (left, right) = (column, column + 1);
    let (above, below) = (&around.above, &around.below);
    each!(a in 3 => {
        let (warp, weft, mode) = (element::WARP_FORCE + a, element::WEFT_FORCE + a, element::HOURGLASS + a);
        let first = (n.load(above[warp], right) + n.load(above[weft], right)) - n.load(above[mode], right);
        let second = (n.load(above[weft], left) - n.load(above[warp], left)) + n.load(above[mode], left);
        let third = (n.load(below[warp], left) + n.load(below[weft], left)) + n.load(below[mode], left);
        let fourth = (n.load(below[warp], right) - n.load(below[weft], right)) + n.load(below[mode], right);
        (first + second) + (fourth - third)
    })
}
