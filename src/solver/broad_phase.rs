//! The broad phase of contact between plies: lets through the nodes that may touch a cell of the neighbouring ply.
//!
//! Most nodes of a strip are over a row of cells, each over the next, and touch none: as many as a register holds are looked at in
//! one go, first whether they are certainly apart, in the precision of the state, then whether they stand clear of their cell, in
//! double precision. What neither shows is let through and looked at one by one. No outcome depends on it: what it
//! holds back would be left as it is.

use std::ops::Range;

use crate::model::layup::PENETRATING;
use crate::num::scalar::{Mask, Real, Scalar, each};
use crate::physics::ply_contact::{Clearance, Planes, SLOP, is_certainly_apart, stands_clear};
use crate::solver::ply_search::{PlySearch, ROWS};

/// The broad phase, compiled for the vectors of this processor.
pub trait BroadPhase<S: Scalar>: Send + Sync {
    /// Appends rows and columns of the nodes that may touch, in order. `over`: cells that the nodes of the rows are over.
    fn pass(
        &self,
        search: &PlySearch<'_, S>,
        rows: Range<usize>,
        columns: Range<usize>,
        over: &[u32],
        candidates: &mut Candidates,
    );
}

/// Rows and columns of nodes.
pub type Candidates = Vec<[u32; 2]>;

/// In the precision of the state on numbers like the first, in double precision on numbers like the second.
pub(super) struct Compiled<R, D>(pub(super) R, pub(super) D);

impl<R, D> BroadPhase<R::Scalar> for Compiled<R, D>
where
    R: Real + Send + Sync,
    D: Real<Scalar = f64> + Send + Sync,
{
    fn pass(
        &self,
        search: &PlySearch<'_, R::Scalar>,
        rows: Range<usize>,
        columns: Range<usize>,
        over: &[u32],
        candidates: &mut Candidates,
    ) {
        self.0.vectorize(
            #[inline(always)]
            || pass(self, search, rows, columns, over, candidates),
        );
    }
}

/// See [`BroadPhase::pass`].
#[inline(always)]
fn pass<R: Real, D: Real<Scalar = f64>>(
    compiled: &Compiled<R, D>,
    search: &PlySearch<'_, R::Scalar>,
    rows: Range<usize>,
    columns: Range<usize>,
    over: &[u32],
    candidates: &mut Candidates,
) {
    let (own, theirs) = (&search.own, &search.theirs);
    let across = search.across();
    let clearance =
        Clearance::new(compiled.0, search.sign(), [own.z, theirs.z], search.touching - SLOP * search.thickness);
    if own.mesh.rotation == theirs.mesh.rotation {
        for (row, over) in rows.zip(over.chunks(across)) {
            let line = strip_of_row(search, row, columns.clone(), over);
            broad_phase(compiled, &clearance, search, &line, |column| {
                candidates.push([row, column].map(|at| at as u32))
            });
        }
    } else if let Some(mut part) = StripColumn::within(search, rows.clone()) {
        let first = candidates.len();
        for column in columns {
            let mut left = 0_u64;
            broad_phase(compiled, &clearance, search, &part.line(search, column, over, across), |at| left |= 1 << at);
            let places = (0..ROWS).filter(|at| left & 1 << at != 0);
            candidates.extend(places.map(|at| [part.row(at), column].map(|at| at as u32)));
        }
        candidates[first..].sort_unstable();
    } else {
        candidates.extend(rows.flat_map(|row| columns.clone().map(move |column| [row, column].map(|at| at as u32))));
    }
}

/// Lets through what may touch of a line.
#[inline(always)]
fn broad_phase<R: Real, D: Real<Scalar = f64>>(
    Compiled(_, d): &Compiled<R, D>,
    clearance: &Clearance<R>,
    search: &PlySearch<'_, R::Scalar>,
    line: &NodeStrip<'_, R::Scalar>,
    mut through: impl FnMut(usize),
) {
    let columns = search.theirs.mesh.columns;
    let quarters = search.theirs.mesh.own_axis(0).is_some();
    let mut at = line.range.start;
    while at < line.range.end {
        let first = line.over[at];
        if first & PENETRATING != 0 {
            through(at);
            at += 1;
            continue;
        }
        let cell = [first as usize / columns, first as usize % columns];
        let most = R::LANES.min(line.range.end - at).min(columns - cell[1]);
        let count = consecutive(&line.over[at..at + most]);
        let mut left = !certainly_apart(clearance, search, line, at, cell).bits() & ((1 << count) - 1);
        // In the axes of a ply that does not lie along those of the pack rounding would differ from the search's.
        if left != 0 && quarters {
            for lane in (0..count).step_by(D::LANES) {
                let part = ((1 << D::LANES) - 1) << lane;
                if left & part != 0 {
                    left &= !(clear(*d, search, line, at + lane, [cell[0], cell[1] + lane]).bits() << lane);
                }
            }
            if let Some(crossed) = line.crossed.filter(|crossed| (at..at + count).contains(crossed)) {
                left |= 1 << (crossed - at);
            }
        }
        while left != 0 {
            through(at + left.trailing_zeros() as usize);
            left &= left - 1;
        }
        at += count;
    }
}

/// Nodes of a line, from one on, that are certainly apart from the cells from this one on.
#[inline(always)]
fn certainly_apart<R: Real>(
    clearance: &Clearance<R>,
    search: &PlySearch<'_, R::Scalar>,
    line: &NodeStrip<'_, R::Scalar>,
    at: usize,
    cell: [usize; 2],
) -> R::Mask {
    let (n, theirs) = (clearance.sign, &search.theirs);
    let x = n.load(line.rounded, at);
    let place = each!(side in 2 => n.load(theirs.rounded_places(), cell[1] + side) - x);
    let height = each!(side in 2 => theirs.mesh.reference(cell[0] + side, 0)[1] - line.y);
    let area = (place[1] - place[0]) * n.splat_like(height[1] - height[0]);
    let own = each!(a in 3 => n.load(line.displacement[a], at));
    let [below, above] = [theirs.row(cell[0]), theirs.row(cell[0] + 1)];
    let below = each!(side in 2 => Corner::new(clearance, &own, &below, cell[1] + side));
    let above = each!(side in 2 => Corner::new(clearance, &own, &above, cell[1] + side));
    let low = each!(side in 2 => below[side].arm(place[side], n.splat_like(height[0])));
    let high = each!(side in 2 => above[side].arm(place[side], n.splat_like(height[1])));
    let gap = [below[0].gap, below[1].gap, above[1].gap, above[0].gap];
    is_certainly_apart(clearance, &[low[0], low[1], high[1], high[0]], gap, area)
}

/// A corner of the cells that nodes are over, as they see it: what its displacement differs by, and how far they are from it [m].
struct Corner<R> {
    change: [R; 2],
    gap: R,
}

impl<R: Real> Corner<R> {
    /// `own`: displacement of the nodes; `row`: of the corners' row.
    #[inline(always)]
    fn new(clearance: &Clearance<R>, own: &[R; 3], row: &[&[R::Scalar]; 3], column: usize) -> Self {
        let change = each!(a in 3 => own[0].load(row[a], column) - own[a]);
        Self { change: [change[0], change[1]], gap: clearance.distance - clearance.sign * change[2] }
    }

    /// From the nodes to the corner, from how they lie at rest.
    #[inline(always)]
    fn arm(&self, x: R, y: R) -> [R; 2] {
        [x + self.change[0], y + self.change[1]]
    }
}

/// Nodes of a line, from one on, that stand over the cells from this one on, and clear of them.
#[inline(always)]
fn clear<D: Real<Scalar = f64>, S: Scalar>(
    d: D,
    search: &PlySearch<'_, S>,
    line: &NodeStrip<'_, S>,
    at: usize,
    [row, column]: [usize; 2],
) -> D::Mask {
    let (theirs, mesh) = (&search.theirs, search.theirs.mesh);
    let point = places(d, &line.displacement, line.place, at, [line.y, search.own.z]);
    let corner = [theirs.row(row), theirs.row(row + 1)];
    let across = [mesh.reference(row, 0)[1], mesh.reference(row + 1, 0)[1]];
    let low = each!(side in 2 => places(d, &corner[0], theirs.places(), column + side, [across[0], theirs.z]));
    let high = each!(side in 2 => places(d, &corner[1], theirs.places(), column + side, [across[1], theirs.z]));
    let area = if mesh.is_graded() {
        let mut areas = [0.0; WIDEST];
        for (area, column) in areas.iter_mut().zip(column..mesh.columns) {
            *area = mesh.area(row, column);
        }
        d.load(&areas, 0)
    } else {
        d.splat_like(mesh.area(row, column))
    };
    let bounds = [search.sign(), search.touching, SLOP * search.thickness];
    stands_clear(&[low[0], low[1], high[1], high[0]], &point, bounds, area, line.planes)
}

/// Double numbers in a register at most.
const WIDEST: usize = 8;

/// Places of the nodes of a line, from one on, in the axes in which it is displaced [m]. `place`: along it at rest; `y`, `z`: across it.
#[inline(always)]
fn places<D: Real<Scalar = f64>, S: Scalar>(
    d: D,
    displacement: &[&[S]; 3],
    place: &[f64],
    at: usize,
    [y, z]: [f64; 2],
) -> [D; 3] {
    let reference = [d.load(place, at), d.splat_like(y), d.splat_like(z)];
    each!(a in 3 => reference[a] + widened(d, displacement[a], at))
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

/// Count of numbers before one that does not follow the one before it.
#[inline(always)]
fn consecutive(over: &[u32]) -> usize {
    let follows = |(at, over_this): (usize, &u32)| *over_this == over[0] + at as u32;
    over.iter().enumerate().position(|it| !follows(it)).unwrap_or(over.len())
}

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
    /// Range of the nodes to look at.
    pub(super) range: Range<usize>,
    /// Mirror planes that all of them lie on.
    pub(super) planes: Planes,
    /// The one that lies on a plane across the line.
    pub(super) crossed: Option<usize>,
}

/// A row of nodes of a ply that lies as its neighbour does.
#[inline(always)]
fn strip_of_row<'a, S: Scalar>(
    search: &PlySearch<'a, S>,
    row: usize,
    columns: Range<usize>,
    over: &'a [u32],
) -> NodeStrip<'a, S> {
    let own = &search.own;
    NodeStrip {
        displacement: own.row(row),
        place: own.places(),
        rounded: own.rounded_places(),
        y: own.mesh.reference(row, 0)[1],
        over,
        range: columns,
        planes: in_axes_of_the_ply(search.planes_at(row, usize::MAX)),
        crossed: search.planes[0],
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
    pub(super) fn within(search: &PlySearch<'_, S>, rows: Range<usize>) -> Option<Self> {
        let seen = |own: [f64; 3]| search.theirs.mesh.to_ply(search.own.mesh.to_pack(own));
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
        search: &PlySearch<'_, S>,
        column: usize,
        over: &[u32],
        across: usize,
    ) -> NodeStrip<'_, S> {
        let [along, side] = self.turn;
        for at in 0..self.rows.len() {
            let row = self.row(at);
            let [u, v, w] = search.own.row(row).map(|field| field[column]);
            let turned = [S::splat(along * v.to_f64()), S::splat(side * u.to_f64()), w];
            for (line, number) in self.displacement.iter_mut().zip(turned) {
                line[at] = number;
            }
            self.place[at] = along * search.own.mesh.reference(row, column)[1];
            self.rounded[at] = S::splat(self.place[at]);
            self.over[at] = over[(row - self.rows.start) * across + column];
        }
        let crossed = search.planes[1].filter(|row| self.rows.contains(row));
        NodeStrip {
            displacement: [&self.displacement[0], &self.displacement[1], &self.displacement[2]],
            place: &self.place,
            rounded: &self.rounded,
            y: side * search.own.mesh.reference(0, column)[0],
            over: &self.over,
            range: 0..self.rows.len(),
            planes: in_axes_of_the_ply(search.planes_at(usize::MAX, column)),
            crossed: crossed.map(|row| if along > 0.0 { row - self.rows.start } else { self.rows.end - 1 - row }),
        }
    }
}

/// The axes of the pack across planes replaced by those of the neighbour, which are the coordinates of its cells.
#[inline(always)]
fn in_axes_of_the_ply(planes: Planes) -> Planes {
    each!(axis in 2 => planes[axis].map(|_| axis))
}

#[cfg(test)]
#[path = "broad_phase_tests.rs"]
mod tests;
