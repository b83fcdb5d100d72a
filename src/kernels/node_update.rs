//! Node kernel: gather of element forces, kick and drift of one row of nodes (leapfrog).
//!
//! Each node adds the forces of its up to four elements in a fixed order (gather, no scatter), so the sum does
//! not depend on threads. Held degrees of freedom have zero inverse mass.

use std::ops::Range;

use crate::kernels::element_force::field as element;
use crate::number::{Real, Scalar};
use crate::tally::Tally;

/// Fields of a node row, in storage order.
pub mod field {
    /// Displacement [m], three components.
    pub const DISPLACEMENT: usize = 0;
    /// Velocity [m/s], three components.
    pub const VELOCITY: usize = 3;
    /// Number of fields.
    pub const COUNT: usize = 6;
}

/// Element rows around a row of nodes.
pub struct Neighbours<'a, S> {
    /// Fields of the row of elements below, in storage order (only forces are read).
    pub below: [&'a [S]; element::COUNT],
    /// The same above.
    pub above: [&'a [S]; element::COUNT],
}

/// Masses of one row of nodes; three arrays by direction because rollers hold one direction only.
pub struct RowMass<'a, S> {
    /// 1/mass where free, 0 where held [1/kg]; X, Y, Z.
    pub inverse: [&'a [S]; 3],
    /// Lumped mass [kg].
    pub mass: &'a [S],
}

/// What of a row of nodes is to be advanced.
#[derive(Clone, Debug)]
pub struct Part {
    /// Columns.
    pub range: Range<usize>,
    /// Columns of the whole row.
    pub columns: usize,
    /// Whether the row is on the ply's edge.
    pub edge_row: bool,
}

/// Sums of one row of nodes over one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeTotals {
    /// ½ m v² after the step [J].
    pub kinetic: f64,
    /// ½ m v⁺·(v⁺ − Δt f/m): kinetic energy at the time of the positions, consistent with trapezoidal work [J].
    /// Only in ledger steps.
    pub kinetic_now: f64,
    /// Momentum after the step [kg·m/s]; only in ledger steps.
    pub momentum: [f64; 3],
    /// Impulse of the supports in this step [N·s].
    pub support: [f64; 3],
    /// Largest squared speed [m²/s²].
    pub max_speed_squared: f64,
}

/// Internal force on `LANES` nodes from column `column` on [N].
#[inline(always)]
pub fn gather<R: Real>(around: &Neighbours<'_, R::Scalar>, column: usize) -> [R; 3] {
    // Columns of elements are stored one further: left neighbour at `column`, right neighbour at `column` + 1.
    let (left, right) = (column, column + 1);
    [0, 1, 2].map(|a| {
        let warp = |row: &[&[R::Scalar]; element::COUNT], at| R::load(row[element::WARP_FORCE + a], at);
        let weft = |row: &[&[R::Scalar]; element::COUNT], at| R::load(row[element::WEFT_FORCE + a], at);
        let mode = |row: &[&[R::Scalar]; element::COUNT], at| R::load(row[element::HOURGLASS + a], at);
        let (above, below) = (&around.above, &around.below);
        let first = (warp(above, right) + weft(above, right)) - mode(above, right);
        let second = (weft(above, left) - warp(above, left)) + mode(above, left);
        let third = (warp(below, left) + weft(below, left)) + mode(below, left);
        let fourth = (warp(below, right) - weft(below, right)) + mode(below, right);
        (first + second) + (fourth - third)
    })
}

/// The same force in two parts: of the membrane, of the hourglass stiffness [N].
#[inline(always)]
pub fn gather_parts<R: Real>(around: &Neighbours<'_, R::Scalar>, column: usize) -> [[R; 3]; 2] {
    let (left, right) = (column, column + 1);
    let modes = [0, 1, 2].map(|a| {
        let mode = |row: &[&[R::Scalar]; element::COUNT], at| R::load(row[element::HOURGLASS + a], at);
        let (above, below) = (&around.above, &around.below);
        (mode(above, left) - mode(above, right)) + (mode(below, right) - mode(below, left))
    });
    let whole = gather::<R>(around, column);
    [[0, 1, 2].map(|a| whole[a] - modes[a]), modes]
}

/// Advances a part of one row of nodes: v += kick·f/m, u += drift·v.
#[inline(always)]
pub fn node_update<R: Real, const LEDGER: bool>(
    around: &Neighbours<'_, R::Scalar>,
    mass: &RowMass<'_, R::Scalar>,
    node: &mut [&mut [R::Scalar]; field::COUNT],
    part: &Part,
    kick: f64,
    drift: f64,
) -> NodeTotals {
    let Part { range, columns, edge_row } = part;
    let columns = *columns;
    let (kick_r, drift_r) = (R::splat(kick), R::splat(drift));
    let half = R::splat(0.5);
    let mut kinetic = Tally::default();
    let mut kinetic_now = Tally::default();
    let mut momentum = [Tally::default(); 3];
    let mut support = [Tally::default(); 3];
    let mut fastest = R::zero();
    let mut column = range.start;
    while column < range.end {
        let force = gather::<R>(around, column);
        let m = R::load(mass.mass, column);
        let mut speed = R::zero();
        let mut now = R::zero();
        let held_here = *edge_row || column == 0 || column + R::LANES >= columns;
        for a in 0..3 {
            let inverse = R::load(mass.inverse[a], column);
            let change = kick_r * force[a] * inverse;
            let velocity = R::load(node[field::VELOCITY + a], column) + change;
            let displacement = R::load(node[field::DISPLACEMENT + a], column) + drift_r * velocity;
            velocity.store(node[field::VELOCITY + a], column);
            displacement.store(node[field::DISPLACEMENT + a], column);
            speed = speed + velocity.squared();
            if LEDGER {
                now = now + velocity * (velocity - drift_r * force[a] * inverse);
                momentum[a].add(m * velocity, column);
            }
            if held_here {
                let held = inverse.le(R::zero());
                support[a].add(R::select(held, -(kick_r * force[a]), R::zero()), column);
            }
        }
        kinetic.add(half * m * speed, column);
        fastest = fastest.max(speed);
        if LEDGER {
            kinetic_now.add(half * m * now, column);
        }
        column += R::LANES;
    }
    let mut max_speed_squared: f64 = 0.0;
    for lane in 0..R::LANES {
        max_speed_squared = max_speed_squared.max(fastest.lane(lane).to_f64());
    }
    NodeTotals {
        kinetic: kinetic.total(),
        kinetic_now: kinetic_now.total(),
        momentum: momentum.map(|t| t.total()),
        support: support.map(|t| t.total()),
        max_speed_squared,
    }
}
