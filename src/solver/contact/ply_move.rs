//! Gives the nodes of a ply the impulses of its contacts with other plies, a row at a time.

use std::ops::Range;

use crate::num::scalar::{Mask, OrderedSum, Real, Scalar, WIDEST, each, narrow, widen};
use crate::solver::node_update::{Neighbours, field, gather};

/// A row of nodes with the impulses on them.
pub struct PushedRow<'a, S> {
    /// Rows of elements on both sides.
    pub around: Neighbours<'a, S>,
    /// `None`: the yarns have no viscous forces.
    pub drag: Option<Drag<'a, S>>,
    /// 1/mass where free, 0 where held [1/kg]; X, Y, Z of the ply.
    pub inverse: [&'a [S]; 3],
    /// Lumped mass [kg].
    pub mass: &'a [S],
    /// Impulse on each node, then what moves it without a velocity left [N·s], in the axes of the pack.
    pub impulses: &'a [[f64; 6]],
    /// Cosine and sine of the angle from the pack's X axis to that of the ply.
    pub rotation: [f64; 2],
    /// Columns with impulses.
    pub range: Range<usize>,
    /// Time step of the velocities, and of the places [s].
    pub times: [f64; 2],
}

/// Viscous forces of the yarns around a row of nodes.
pub struct Drag<'a, S> {
    /// Of warp and weft in the elements below and above [N], stored as their forces are.
    pub rows: [[&'a [S]; 2]; 2],
    /// Heights of the elements below and above over the finest [-].
    pub heights: [f64; 2],
    /// Lengths of the elements along X over the finest [-]; empty where all are alike.
    pub width: &'a [S],
    /// Membrane force on an edge of the finest elements over the yarn's [-].
    pub membrane: [f64; 2],
}

/// Effect of moving the nodes of a ply; vectors in its axes.
#[derive(Clone, Debug, Default)]
pub struct PlyMoveTotals {
    /// Kinetic energy lost [J].
    pub(crate) loss: f64,
    /// Work of moving nodes without a velocity, against all forces but those of shock viscosity [J].
    pub(crate) correction_work: f64,
    /// Work of the forces on the change of velocity in the half step to come [J].
    pub(crate) half_step: f64,
    /// Change of the kinetic energy after the step [J].
    pub(crate) kinetic: f64,
    /// Change of the momentum [kg·m/s].
    pub(crate) momentum: [f64; 3],
    /// Impulse on held nodes, which the supports take [N·s].
    pub(crate) support: [f64; 3],
}

/// Moves the nodes of a row: in double precision on numbers like `d`, with forces in the precision of the state on numbers like `n`. Gives the
/// columns from the first to the last node moved. Compiled once.
#[inline(never)]
pub(crate) fn ply_move<R: Real, D: Real<Scalar = f64>>(
    (n, d): (R, D),
    row: &PushedRow<'_, R::Scalar>,
    node: &mut [&mut [R::Scalar]; field::COUNT],
    totals: &mut PlyMoveTotals,
) -> Range<usize> {
    n.vectorize(
        #[inline(always)]
        || advance(n, d, row, node, totals),
    )
}

#[inline(always)]
fn advance<R: Real, D: Real<Scalar = f64>>(
    n: R,
    d: D,
    row: &PushedRow<'_, R::Scalar>,
    node: &mut [&mut [R::Scalar]; field::COUNT],
    totals: &mut PlyMoveTotals,
) -> Range<usize> {
    let (range, [c, s]) = (&row.range, row.rotation.map(|x| d.broadcast(x)));
    let ([kick, dt], half) = (row.times.map(|time| d.broadcast(time)), d.broadcast(0.5));
    let (mut moved_columns, mut sums) = (0..0, [OrderedSum::default(); 4]);
    let [mut momentum, mut support] = [[OrderedSum::default(); 3]; 2];
    let mut first = range.start - range.start % R::LANES;
    while first < range.end {
        let mut forces = [[[R::Scalar::default(); WIDEST]; 3]; 2];
        let [force, viscous] = [gather(n, &row.around, first), viscous_force(n, row, first)];
        for a in 0..3 {
            force[a].store(&mut forces[0][a], 0);
            viscous[a].store(&mut forces[1][a], 0);
        }
        for half_row in (0..R::LANES).step_by(D::LANES) {
            let column = first + half_row;
            let mut pushes = [[0.0; WIDEST]; 6];
            let there = column.max(range.start)..(column + D::LANES).min(range.end);
            for at in there {
                for (push, impulse) in pushes.iter_mut().zip(row.impulses[at]) {
                    push[at - column] = impulse;
                }
            }
            let [x, y, z, p, q, r] = pushes.map(|push| d.load(&push, 0));
            let size = (x.abs() + y.abs() + z.abs()) + (p.abs() + q.abs() + r.abs());
            // What is no number is pushed, too, and seen.
            let pushed = !size.le(d.zero());
            if !pushed.any() {
                continue;
            }
            let impulse = [c * x + s * y, c * y - s * x, z];
            let correction = [c * p + s * q, c * q - s * p, r];
            let [mut loss, mut work, mut pull, mut energy] = [d.zero(); 4];
            let mass = widen(d, row.mass, column);
            for a in 0..3 {
                let inverse = widen(d, row.inverse[a], column);
                let u = widen(d, node[field::DISPLACEMENT + a], column);
                let free = widen(d, node[field::VELOCITY + a], column);
                let force = widen(d, &forces[0][a], half_row);
                let now = free + inverse * impulse[a];
                let moved = dt * inverse * correction[a];
                let place = u + (dt * (now - free) + moved);
                narrow(D::select(pushed, place, u), node[field::DISPLACEMENT + a], column);
                narrow(D::select(pushed, now, free), node[field::VELOCITY + a], column);
                // Viscosity sees velocities alone: against it nothing is stored, and nothing dissipated.
                work = work - (force - widen(d, &forces[1][a], half_row)) * moved;
                loss = loss - half * impulse[a] * ((free - inverse * force * kick) + now);
                pull = pull + inverse * force * dt * (now - free);
                energy = energy + (now - free) * (now + free);
                momentum[a].add(mass * (now - free), column);
                support[a].add(D::select(inverse.le(d.zero()), impulse[a], d.zero()), column);
            }
            let pulled = -(half * mass * pull);
            for (sum, part) in sums.iter_mut().zip([loss, work, pulled, half * mass * energy + pulled]) {
                sum.add(part, column);
            }
            let bits = pushed.bits();
            let (from, to) = (column + bits.trailing_zeros() as usize, column + 64 - bits.leading_zeros() as usize);
            moved_columns = if moved_columns.is_empty() { from } else { moved_columns.start }..to;
        }
        first += R::LANES;
    }
    let [loss, work, half_step, kinetic] = sums.map(|sum| sum.total());
    totals.loss += loss;
    totals.correction_work += work;
    totals.half_step += half_step;
    totals.kinetic += kinetic;
    for a in 0..3 {
        totals.momentum[a] += momentum[a].total();
        totals.support[a] += support[a].total();
    }
    moved_columns
}

/// Shock viscosity's part of the force on the nodes from a column on [N]. It is taken along the whole force of a yarn, which trellis shear turns a
/// little away from the yarn.
#[inline(always)]
fn viscous_force<R: Real>(n: R, row: &PushedRow<'_, R::Scalar>, column: usize) -> [R; 3] {
    let mut sum = [n.zero(); 3];
    let Some(Drag { rows, heights, width, membrane }) = &row.drag else { return sum };
    for (above, forces) in [&row.around.below, &row.around.above].into_iter().enumerate() {
        for right in 0..2 {
            // Columns of elements are stored one further.
            let at = column + right;
            let mut widths = [R::Scalar::splat(1.0); WIDEST];
            if !width.is_empty() {
                for lane in 0..R::LANES {
                    widths[lane] = width[(at + lane).saturating_sub(1)];
                }
            }
            for yarn in 0..2 {
                let (along, ahead) = if yarn == 0 {
                    (n.splat_like(heights[above]), right == 1)
                } else {
                    (n.load(&widths, 0), above == 1)
                };
                let force = each!(a in 3 => n.load(forces[3 * yarn + a], at));
                let size = (force[0] * force[0] + force[1] * force[1] + force[2] * force[2]).sqrt();
                let part = n.load(rows[above][yarn], at) * n.splat_like(membrane[yarn]) * along / size;
                // Slack yarns have none.
                let part = R::select(size.le(n.zero()), n.zero(), if ahead { part } else { -part });
                sum = each!(a in 3 => part.fused(force[a], sum[a]));
            }
        }
    }
    sum
}
