//! The sieve before the search: lets through the nodes that may touch a cell of the neighbouring ply.
//!
//! Of a row of nodes most are over a row of cells, each over the next, and touch none: as many as a register holds are looked at in
//! one go, first whether they are certainly apart, in the precision of the state, then whether they stand clear of their cell, in
//! double precision. What neither shows is let through and looked at one by one. No outcome depends on the sieve: what it
//! keeps would be left as it is.

use std::ops::Range;

use super::look::{Look, View};
use crate::kernels::ply_contact::{Clearance, Planes, SLOP, is_certainly_apart, stands_clear};
use crate::model::over::INSIDE;
use crate::number::{Mask, Real, Scalar, each};

/// A sieve, compiled for the vectors of this processor.
pub trait Sieve<S: Scalar>: Send + Sync {
    /// Appends the columns of the nodes of a row that may touch. `over`: cells that the nodes of the row are over.
    fn pass(&self, look: &Look<'_, S>, row: usize, columns: Range<usize>, over: &[u32], near: &mut Vec<usize>);
}

/// In the precision of the state on numbers like the first, in double precision on numbers like the second.
pub struct Compiled<R, D>(pub R, pub D);

impl<R, D> Sieve<R::Scalar> for Compiled<R, D>
where
    R: Real + Send + Sync,
    D: Real<Scalar = f64> + Send + Sync,
{
    fn pass(
        &self,
        look: &Look<'_, R::Scalar>,
        row: usize,
        columns: Range<usize>,
        over: &[u32],
        near: &mut Vec<usize>,
    ) {
        self.0.vectorize(
            #[inline(always)]
            || pass(self.0, self.1, look, row, columns, over, near),
        );
    }
}

/// See [`Sieve::pass`].
#[inline(always)]
fn pass<R: Real, D: Real<Scalar = f64>>(
    n: R,
    d: D,
    look: &Look<'_, R::Scalar>,
    row: usize,
    columns: Range<usize>,
    over: &[u32],
    near: &mut Vec<usize>,
) {
    let (own, theirs) = (&look.own, &look.theirs);
    if own.mesh.turn != theirs.mesh.turn {
        near.extend(columns);
        return;
    }
    let clearance = Clearance::new(n, look.sign(), [own.z, theirs.z], look.touching - SLOP * look.thickness);
    // Of every node of the row but that on the plane across it.
    let planes = look.planes_at(row, usize::MAX);
    let mut column = columns.start;
    while column < columns.end {
        let first = over[column];
        if first & INSIDE != 0 {
            near.push(column);
            column += 1;
            continue;
        }
        let cell = [first as usize / theirs.mesh.columns, first as usize % theirs.mesh.columns];
        let most = R::LANES.min(columns.end - column).min(theirs.mesh.columns - cell[1]);
        let count = consecutive(&over[column..column + most]);
        let mut left = !certainly_apart(&clearance, look, [row, column], cell).bits() & ((1 << count) - 1);
        if left != 0 && !own.turned {
            for lane in (0..count).step_by(D::LANES) {
                let part = ((1 << D::LANES) - 1) << lane;
                if left & part != 0 {
                    let clear = clear(d, look, [row, column + lane], [cell[0], cell[1] + lane], planes);
                    left &= !(clear.bits() << lane);
                }
            }
            if let Some(at) = look.planes[0].filter(|at| (column..column + count).contains(at)) {
                left |= 1 << (at - column);
            }
        }
        while left != 0 {
            near.push(column + left.trailing_zeros() as usize);
            left &= left - 1;
        }
        column += count;
    }
}

/// Which nodes of a row, from one on, are certainly apart from the cells from this one on.
#[inline(always)]
fn certainly_apart<R: Real>(
    clearance: &Clearance<R>,
    look: &Look<'_, R::Scalar>,
    [row, column]: [usize; 2],
    cell: [usize; 2],
) -> R::Mask {
    let (n, own, theirs) = (clearance.sign, &look.own, &look.theirs);
    let node = own.row(row);
    let y = own.mesh.reference(row, 0)[1];
    let x = n.load(own.rounded_places(), column);
    let place = each!(side in 2 => n.load(theirs.rounded_places(), cell[1] + side) - x);
    let height = [theirs.mesh.reference(cell[0], 0)[1] - y, theirs.mesh.reference(cell[0] + 1, 0)[1] - y];
    let area = (place[1] - place[0]) * n.with(height[1] - height[0]);
    let at = each!(a in 3 => n.load(node[a], column));
    let [below, above] = [theirs.row(cell[0]), theirs.row(cell[0] + 1)];
    let below = each!(side in 2 => Corner::new(clearance, &at, &below, cell[1] + side));
    let above = each!(side in 2 => Corner::new(clearance, &at, &above, cell[1] + side));
    let low = each!(side in 2 => below[side].arm(place[side], n.with(height[0])));
    let high = each!(side in 2 => above[side].arm(place[side], n.with(height[1])));
    let gap = [below[0].gap, below[1].gap, above[1].gap, above[0].gap];
    is_certainly_apart(clearance, &[low[0], low[1], high[1], high[0]], gap, area)
}

/// A corner of the cells that nodes are over, as they see it: what its displacement differs by, and how far they are from it [m].
struct Corner<R> {
    change: [R; 2],
    gap: R,
}

impl<R: Real> Corner<R> {
    /// `at`: displacement of the nodes; `row`: of the corners' row.
    #[inline(always)]
    fn new(clearance: &Clearance<R>, at: &[R; 3], row: &[&[R::Scalar]; 3], column: usize) -> Self {
        let change = each!(a in 3 => at[0].load(row[a], column) - at[a]);
        Self { change: [change[0], change[1]], gap: clearance.distance - clearance.sign * change[2] }
    }

    /// From the nodes to the corner, from how they lie at rest.
    #[inline(always)]
    fn arm(&self, x: R, y: R) -> [R; 2] {
        [x + self.change[0], y + self.change[1]]
    }
}

/// Which nodes of a row, from one on, stand over the cells from this one on, and clear of them.
#[inline(always)]
fn clear<D: Real<Scalar = f64>, S: Scalar>(
    d: D,
    look: &Look<'_, S>,
    [row, column]: [usize; 2],
    cell: [usize; 2],
    planes: Planes,
) -> D::Mask {
    let point = places(d, &look.own, [row, column]);
    let a = places(d, &look.theirs, cell);
    let b = places(d, &look.theirs, [cell[0], cell[1] + 1]);
    let c = places(d, &look.theirs, [cell[0] + 1, cell[1] + 1]);
    let e = places(d, &look.theirs, [cell[0] + 1, cell[1]]);
    let mesh = look.theirs.mesh;
    let area = if mesh.is_graded() {
        let mut areas = [0.0; WIDEST];
        for (area, column) in areas.iter_mut().zip(cell[1]..mesh.columns) {
            *area = mesh.area(cell[0], column);
        }
        d.load(&areas, 0)
    } else {
        d.with(mesh.area(cell[0], cell[1]))
    };
    stands_clear(&[a, b, c, e], &point, [look.sign(), look.touching, SLOP * look.thickness], area, planes)
}

/// Double numbers in a register at most.
const WIDEST: usize = 8;

/// Where the nodes of a row are, from one on [m]; the ply is not turned.
#[inline(always)]
fn places<D: Real<Scalar = f64>, S: Scalar>(d: D, view: &View<'_, S>, [row, column]: [usize; 2]) -> [D; 3] {
    let field = view.row(row);
    let y = view.mesh.reference(row, 0)[1];
    let reference = [d.load(view.places(), column), d.with(y), d.with(view.z)];
    each!(a in 3 => reference[a] + widened(d, field[a], column))
}

/// Consecutive numbers in double precision.
#[inline(always)]
fn widened<D: Real<Scalar = f64>, S: Scalar>(d: D, source: &[S], index: usize) -> D {
    let mut wide = [0.0; WIDEST];
    for (wide, number) in wide[..D::LANES].iter_mut().zip(&source[index..index + D::LANES]) {
        *wide = number.to_f64();
    }
    d.load(&wide, 0)
}

/// How many numbers there are before one that does not follow the one before it.
#[inline(always)]
fn consecutive(over: &[u32]) -> usize {
    let follows = |(at, over_this): (usize, &u32)| *over_this == over[0] + at as u32;
    over.iter().enumerate().position(|it| !follows(it)).unwrap_or(over.len())
}
