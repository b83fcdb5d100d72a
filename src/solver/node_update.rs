//! Node kernel: gather of element forces, kick and drift of one row of nodes (leapfrog).
//!
//! Each node adds the forces of its up to four elements in a fixed order (gather, no scatter), so the sum does
//! not depend on threads. Held degrees of freedom have zero inverse mass.

use std::ops::Range;

use crate::model::Model;
use crate::num::scalar::{OrderedSum, Real, Scalar, each};
use crate::solver::element_totals::field as element;
use crate::solver::state::{Rows, split};

/// Fields of a node row, in storage order.
pub mod field {
    /// Displacement [m], three components.
    pub const DISPLACEMENT: usize = 0;
    /// Velocity [m/s], three components.
    pub const VELOCITY: usize = 3;
    /// Number of fields.
    pub const COUNT: usize = 6;
    /// Depth of the crater in the clay behind the node [m]: one field more, where there is clay.
    pub const CRATER: usize = COUNT;
}

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

/// The fields of a row of nodes; that of the crater is empty where there is no clay.
pub type NodeRow<'a, S> = [&'a mut [S]; field::CRATER + 1];

/// Pass over a part of a row of nodes.
pub struct NodePass<'a, S> {
    /// Rows of elements on both sides.
    pub around: Neighbours<'a, S>,
    /// 1/mass where free, 0 where held [1/kg]; X, Y, Z, because rollers hold one direction only.
    pub inverse: [&'a [S]; 3],
    /// Lumped mass [kg].
    pub mass: &'a [S],
    /// Columns to be advanced.
    pub range: Range<usize>,
    /// Columns of the whole row.
    pub columns: usize,
    /// Whether the row is on the ply's edge, or in a frame that may hold any node.
    pub edge_row: bool,
    /// Time since the last forces, of this kick, and of this drift [s].
    pub times: [f64; 3],
    /// Whether momenta are asked for.
    pub sample: bool,
    /// Gap [m] to the clay behind the ply, what that takes of the velocity of a node that it resists, per time, at its surface [m/s²], and what
    /// this gains with the depth, over it [1/m].
    pub clay: Option<[f64; 3]>,
}

/// Sums of one row of nodes over one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeTotals {
    /// ½ m v² after the step [J].
    pub kinetic: f64,
    /// Work on the elements in the half step before the positions and in the one after them, −½ Δt f·v⁻ and −½ Δt f·v⁺ [J].
    pub work: [f64; 2],
    /// Momentum after the step [kg·m/s]; only in sample steps.
    pub momentum: [f64; 3],
    /// Impulse of the supports in this step [N·s].
    pub support: [f64; 3],
    /// Largest squared speed [m²/s²].
    pub max_speed_squared: f64,
    /// Taken by clay in this step [J], and its deepest crater [m].
    pub clay: [f64; 2],
}

/// Advances a part of one row of nodes, as many like `n` at a time as that holds: v += kick·f/m, u += drift·v. Compiled once.
#[inline(never)]
pub fn node_update<R: Real>(n: R, pass: &NodePass<'_, R::Scalar>, node: &mut NodeRow<'_, R::Scalar>) -> NodeTotals {
    n.vectorize(
        #[inline(always)]
        || advance(n, pass, node),
    )
}

#[inline(always)]
fn advance<R: Real>(n: R, pass: &NodePass<'_, R::Scalar>, node: &mut NodeRow<'_, R::Scalar>) -> NodeTotals {
    let NodePass { around, inverse, mass, range, columns, edge_row, times: [span, kick, drift], sample, clay } = pass;
    let halves = [span, drift].map(|time| n.splat_like(-0.5 * time));
    // Gap, most that clay takes of a velocity in this step at its surface, gain with the depth, and 1/Δt.
    let clay = clay.map(|[gap, rate, gain]| [gap, rate * kick, gain, 1.0 / drift].map(|number| n.splat_like(number)));
    let (kick, drift, columns, sample) = (n.splat_like(*kick), n.splat_like(*drift), *columns, *sample);
    let (half, rest) = (n.splat_like(0.5), n.splat_like(R::REST));
    let mut kinetic = OrderedSum::default();
    let mut work = [OrderedSum::default(); 2];
    let mut momentum = [OrderedSum::default(); 3];
    let mut support = [OrderedSum::default(); 3];
    let mut fastest = n.zero();
    let (mut into_clay, mut deepest) = (OrderedSum::default(), n.zero());
    let mut held = clay.is_some();
    let mut column = range.start - range.start % R::LANES;
    while column < range.end {
        let force = gather(n, around, column);
        let m = n.load(mass, column);
        let mut speed = n.zero();
        let mut power = [n.zero(); 2];
        let held_here = *edge_row || column == 0 || column + R::LANES >= columns;
        held |= held_here;
        for a in 0..3 {
            let inverse = n.load(inverse[a], column);
            let before = n.load(node[field::VELOCITY + a], column);
            let velocity = (kick * force[a]).fused(inverse, before);
            let mut velocity = R::select(velocity.abs().lt(rest), n.zero(), velocity);
            if let Some([gap, at_surface, gain, per_step]) = clay.filter(|_| a == 2) {
                // Plastic: for the part of the step that is deeper than the crater; it stops what goes there at most, and throws nothing back.
                let depth = n.load(node[field::DISPLACEMENT + a], column) - gap;
                let crater = n.load(node[field::CRATER], column).max(depth);
                let most = at_surface * (gain * crater + n.one());
                let into = (depth - crater).fused(per_step, velocity).max(n.zero());
                let taken = into * most / velocity.max(most);
                velocity = velocity - taken;
                into_clay.add(half * m * taken * (before + velocity), column);
                support[a].add(-(m * taken), column);
                crater.store(node[field::CRATER], column);
                deepest = deepest.max(crater);
            }
            power = [force[a].fused(before, power[0]), force[a].fused(velocity, power[1])];
            let displacement = drift.fused(velocity, n.load(node[field::DISPLACEMENT + a], column));
            velocity.store(node[field::VELOCITY + a], column);
            displacement.store(node[field::DISPLACEMENT + a], column);
            speed = velocity.fused(velocity, speed);
            if sample {
                momentum[a].add(m * velocity, column);
            }
            if held_here {
                let fixed = inverse.le(n.zero());
                support[a].add(R::select(fixed, -(kick * force[a]), n.zero()), column);
            }
        }
        kinetic.add(half * m * speed, column);
        fastest = fastest.max(speed);
        for i in 0..2 {
            work[i].add(halves[i] * power[i], column);
        }
        column += R::LANES;
    }
    // What is not asked for need not be added up.
    let mut totals = NodeTotals {
        kinetic: kinetic.total(),
        work: each!(i in 2 => work[i].total()),
        max_speed_squared: fastest.reduce_max(),
        clay: [into_clay.total(), deepest.reduce_max()],
        ..NodeTotals::default()
    };
    if sample {
        totals.momentum = each!(a in 3 => momentum[a].total());
    }
    if held {
        totals.support = each!(a in 3 => support[a].total());
    }
    totals
}
