//! The broad phase of contact: lets through the nodes that may touch a cell of the neighbouring ply, and lists those near the projectile.
//!
//! The list lasts some steps. Between plies, most nodes of a strip are over a row of cells, each over the next, and touch none: as many as
//! a register holds are looked at in one go, first whether they are certainly apart, in the precision of the state, then whether they
//! stand clear of their cell, in double precision. What neither shows is let through and looked at one by one. No outcome depends on it:
//! what it holds back would be left as it is.

use std::ops::{Range, RangeInclusive};

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::model::Model;
use crate::model::layup::PENETRATING;
use crate::model::mesh::Mesh;
use crate::num::scalar::{Mask, Real, Scalar, each, widen};
use crate::physics::ply_contact::{Clearance, Planes, SLOP, is_certainly_apart, stands_clear};
use crate::physics::rigid_body::RigidBody;
use crate::solver::contact::ply_search::{PlySearch, ROWS, SearchPart};
use crate::solver::state::{State, node_position, row_positions};

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
    each!(a in 3 => reference[a] + widen(d, displacement[a], at))
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

/// Zone of a ply near a body.
struct Zone {
    /// Thickness of the plies in front [m].
    depth: f64,
    /// Places sampled between a node and its place behind no fabric, less one.
    samples: u32,
    /// Distance of any of these from the body [m].
    room: f64,
    /// Extent of the body along the axes of the ply, with that room [m].
    along: RangeInclusive<f64>,
    across: RangeInclusive<f64>,
}

impl Zone {
    fn new<S: Scalar>(model: &Model<S>, ply: usize, body: &RigidBody, margin: f64) -> Self {
        let depth = model.plies[ply].depth;
        // No further apart than the margin.
        let samples = (depth / margin).ceil().min(64.0) as u32;
        let room = margin + 0.5 * depth / f64::from(samples.max(1));
        let [along, across] = [0, 1].map(|axis| extent(body, &model.ply_type(ply).mesh, axis, room));
        Self { depth, samples, room, along, across }
    }

    /// Whether a node is near the body at its own place, behind no fabric, or between.
    fn has(&self, body: &RigidBody, position: &Vector3<f64>) -> bool {
        let moved =
            |sample: u32| Vector3::new(0.0, 0.0, self.depth * f64::from(sample) / f64::from(self.samples.max(1)));
        (0..=self.samples).any(|sample| body.gap(&(position - moved(sample))).0 < self.room)
    }
}

/// Nodes within `margin` of the body, or of it moved through the plies in front, in storage order: ply, row, column.
pub(crate) fn find_candidates<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    body: &RigidBody,
    margin: f64,
) -> Vec<[usize; 3]> {
    let grid = &model.grid;
    let zones: Vec<_> = (0..model.plies.len()).map(|ply| Zone::new(model, ply, body, margin)).collect();
    let found = (0..grid.node_rows()).into_par_iter().with_min_len(16).map(|index| {
        let (ply, row) = grid.node_row(index);
        let mut out = Vec::new();
        let (mesh, zone) = (&model.ply_type(ply).mesh, &zones[ply]);
        if row > mesh.rows {
            return out;
        }
        for (column, [x, y, _]) in row_positions(model, state, ply, row).enumerate() {
            // Most nodes are beside the body.
            let reaches = zone.across.contains(&y) && zone.along.contains(&x);
            if reaches && zone.has(body, &node_position(model, state, [ply, row, column])) {
                out.push([ply, row, column]);
            }
        }
        out
    });
    found.collect::<Vec<_>>().concat()
}

/// From where to where a body reaches along the first or second axis of a ply, with `room` on either side [m].
fn extent(body: &RigidBody, mesh: &Mesh, axis: usize, room: f64) -> RangeInclusive<f64> {
    if body.body.profile.bar {
        return f64::NEG_INFINITY..=f64::INFINITY;
    }
    let mut direction = [0.0; 3];
    direction[axis] = 1.0;
    let direction = body.orientation.inverse_transform_vector(&mesh.to_pack(direction).into());
    let centre = mesh.to_ply(body.position.into())[axis];
    let [back, front] = [-direction, direction].map(|direction| body.body.support(direction.into()) + room);
    centre - back..=centre + front
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::case;
    use crate::solver::node_update::field as node;

    /// A case of a smaller pack, its projectile changed, ready to run.
    fn scene(file: &str, projectile: &str) -> (Model<f64>, State<f64>) {
        let sets = ["/expect=[]", "/sources={}", "/pack/width_mm=40", "/pack/height_mm=40"].map(str::to_owned);
        let sets = [&sets[..], &[format!("/projectile={projectile}")]].concat();
        let case = case::read(Path::new(file), &sets).unwrap_or_else(|error| unreachable!("{error}"));
        let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        let state = State::new(&case, &model);
        (model, state)
    }

    /// Every node that comes within the margin when it is moved through any part of the plies in front is listed, and few that
    /// do not come within a margin more.
    #[test]
    fn all_nodes_near_the_body_are_listed() {
        let common =
            r#""mass_g": 3, "velocity_m_s": 155, "offset_mm": [7.3, -4.1], "obliquity_deg": 40, "azimuth_deg": 25"#;
        let shapes = [
            r#""shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "yaw_deg": 20"#,
            r#""shape": "cylinder", "diameter_mm": 9, "length_mm": 3, "edge_radius_mm": 0.4, "yaw_deg": -25"#,
            r#""shape": "sphere", "diameter_mm": 8"#,
            r#""shape": "cone", "diameter_mm": 6, "length_mm": 30, "nose_length_mm": 30, "edge_radius_mm": 0"#,
            r#""shape": "ogive", "diameter_mm": 6, "length_mm": 14, "nose_length_mm": 9, "edge_radius_mm": 0"#,
            r#""shape": "fragment", "diameter_mm": 7, "length_mm": 8, "roll_deg": 30"#,
        ];
        for shape in shapes {
            for file in ["cases/s728-4ply-91.json", "cases/hybrid-8ply-200.json"] {
                let (model, mut state) = scene(file, &format!("{{{shape}, {common}}}"));
                for row in 0..model.grid.node_rows() {
                    for column in 0..model.grid.columns {
                        let swell = 1e-3 * (0.3 * row as f64 + 0.7 * column as f64).sin();
                        (0..3)
                            .for_each(|a| state.nodes.set(row, node::DISPLACEMENT + a, column, swell * (1 + a) as f64));
                    }
                }
                let Some(mut body) = state.body.clone() else { unreachable!() };
                body.position += body.flight * 4e-3;
                let margin = 1.5e-3;
                let listed = find_candidates(&model, &state, &body, margin);
                let within = |room: f64| {
                    let mut all = model.node_places().collect::<Vec<_>>();
                    all.retain(|&[ply, row, column]| {
                        let position = node_position(&model, &state, [ply, row, column]);
                        let moved = |part: u32| {
                            position - Vector3::new(0.0, 0.0, model.plies[ply].depth * f64::from(part) / 40.0)
                        };
                        (0..=40).any(|part| body.gap(&moved(part)).0 < room)
                    });
                    all
                };
                let (least, most) = (within(margin), within(2.0 * margin));
                assert!(least.len() > 20, "{shape} {file}: {}", least.len());
                assert!(least.iter().all(|place| listed.contains(place)), "{shape} {file}");
                assert!(listed.iter().all(|place| most.contains(place)), "{shape} {file}");
                assert!(listed.is_sorted(), "in storage order");
            }
        }
    }
}
