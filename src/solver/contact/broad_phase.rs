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
use crate::solver::contact::ply_search::{PlySearch, ROWS, SearchPart};

/// Appends rows and columns of the nodes that may touch to the candidates, in order: in the precision of the state on numbers like `n`, in
/// double precision on numbers like `d`. Compiled once.
#[inline(never)]
pub(crate) fn broad_phase<R: Real, D: Real<Scalar = f64>>((n, d): (R, D), part: &mut SearchPart<'_, R::Scalar>) {
    n.vectorize(
        #[inline(always)]
        || pass(n, d, part),
    );
}

#[inline(always)]
fn pass<R: Real, D: Real<Scalar = f64>>(n: R, d: D, part: &mut SearchPart<'_, R::Scalar>) {
    let SearchPart { search, rows, columns, over, found } = part;
    let (search, rows, columns, candidates) = (*search, rows.clone(), columns.clone(), &mut found.candidates);
    let (own, theirs) = (&search.own, &search.theirs);
    let across = search.across();
    let clearance = Clearance::new(n, search.sign(), [own.z, theirs.z], search.touching - SLOP * search.thickness);
    if own.mesh.rotation == theirs.mesh.rotation {
        for (row, over) in rows.zip(over.chunks(across)) {
            let line = strip_of_row(search, row, columns.clone(), over);
            pass_strip(d, &clearance, search, &line, |column| candidates.push([row, column]));
        }
    } else if let Some(mut part) = StripColumn::within(search, rows.clone()) {
        let first = candidates.len();
        for column in columns {
            let mut left = 0_u64;
            pass_strip(d, &clearance, search, &part.line(search, column, over, across), |at| left |= 1 << at);
            let places = (0..ROWS).filter(|at| left & 1 << at != 0);
            candidates.extend(places.map(|at| [part.row(at), column]));
        }
        candidates[first..].sort_unstable();
    } else {
        candidates.extend(rows.flat_map(|row| columns.clone().map(move |column| [row, column])));
    }
}

/// Lets through what may touch of a line.
#[inline(always)]
fn pass_strip<R: Real, D: Real<Scalar = f64>>(
    d: D,
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
        let count = (0..most).take_while(|lane| line.over[at + lane] == first + *lane as u32).count();
        let mut left = !certainly_apart(clearance, search, line, at, cell).bits() & ((1 << count) - 1);
        // In the axes of a ply that does not lie along those of the pack rounding would differ from the search's.
        if left != 0 && quarters {
            for lane in (0..count).step_by(D::LANES) {
                let part = ((1 << D::LANES) - 1) << lane;
                if left & part != 0 {
                    left &= !(clear(d, search, line, at + lane, [cell[0], cell[1] + lane]).bits() << lane);
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
    let place = each!(side in 2 => n.load(&theirs.ply_type.columns.rounded, cell[1] + side) - x);
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
    let low =
        each!(side in 2 => places(d, &corner[0], &theirs.ply_type.columns.place, column + side, [across[0], theirs.z]));
    let high =
        each!(side in 2 => places(d, &corner[1], &theirs.ply_type.columns.place, column + side, [across[1], theirs.z]));
    let width = each!(side in 2 => d.load(&theirs.ply_type.columns.place, column + side));
    // More than the mesh has by rounding at least: what is near to a fold is let through.
    let area = (width[1] - width[0]) * d.splat_like(1.001 * (across[1] - across[0]));
    let bounds = [search.sign(), search.touching, SLOP * search.thickness];
    // Across planes the axes of the neighbour, which are the coordinates of its cells.
    let planes = each!(axis in 2 => line.planes[axis].map(|_| axis));
    stands_clear(&[low[0], low[1], high[1], high[0]], &point, bounds, area, planes)
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
    each!(a in 3 => {
        let mut wide = [0.0; WIDEST];
        for (wide, number) in wide[..D::LANES].iter_mut().zip(&displacement[a][at..at + D::LANES]) {
            *wide = number.to_f64();
        }
        reference[a] + d.load(&wide, 0)
    })
}

/// Room for the nodes of a column within a part, and for the longest register from the last of them on.
const LENGTH: usize = 4 * ROWS;

/// Nodes along the neighbour's rows, in the neighbour's axes.
pub(crate) struct NodeStrip<'a, S> {
    /// [m]
    pub(crate) displacement: [&'a [S]; 3],
    /// Reference places along the line [m], and rounded to the precision of the state.
    pub(crate) place: &'a [f64],
    /// See `place`.
    pub(crate) rounded: &'a [S],
    /// The reference place across the line [m].
    pub(crate) y: f64,
    /// Cells that the nodes are over.
    pub(crate) over: &'a [u32],
    /// Range of the nodes to look at.
    pub(crate) range: Range<usize>,
    /// Mirror planes that all of them lie on.
    pub(crate) planes: Planes,
    /// The one that lies on a plane across the line.
    pub(crate) crossed: Option<usize>,
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
        place: &own.ply_type.columns.place,
        rounded: &own.ply_type.columns.rounded,
        y: own.mesh.reference(row, 0)[1],
        over,
        range: columns,
        planes: search.planes_at(row, usize::MAX),
        crossed: search.planes[0],
    }
}

/// A part of a column of nodes of a ply that is laid across its neighbour.
pub(crate) struct StripColumn<S> {
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
    pub(crate) fn within(search: &PlySearch<'_, S>, rows: Range<usize>) -> Option<Self> {
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
    pub(crate) fn row(&self, at: usize) -> usize {
        if self.turn[0] > 0.0 { self.rows.start + at } else { self.rows.end - 1 - at }
    }

    /// The part of a column. `over`: of the rows of the part, each of `across` nodes.
    #[inline(always)]
    pub(crate) fn line(
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
            planes: search.planes_at(usize::MAX, column),
            crossed: crossed.map(|row| if along > 0.0 { row - self.rows.start } else { self.rows.end - 1 - row }),
        }
    }
}
