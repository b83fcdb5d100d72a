//! Energies of the state, and the largest values that go with them.

use super::ElementConstants;
use super::elements::{Elements, Motion};
use super::row::{ElementRow, corners};
use super::totals::{RowLanes, RowSums};
use crate::kernels::crossover;
use crate::kernels::kinematics::dot;
use crate::num::scalar::{Real, each};

/// Adds those of a ledger step.
#[inline(always)]
pub(super) fn energies<R: Real>(
    c: &ElementConstants<R>,
    row: &ElementRow<'_, R::Scalar>,
    elements: &Elements<R>,
    sums: &mut RowSums,
    lanes: &mut RowLanes<R>,
) {
    let Elements { column, motion, cell, yarns, forces } = elements;
    let Motion { size, k, .. } = motion;
    let n = c.area;
    let zero = n.zero();
    let (any, both_left) = (yarns.any(), yarns.both_left());
    let tension =
        each!(i in 2 => R::select(yarns.alive[i], R::select(both_left, cell.tension[i], yarns.free[i]), zero));
    let strain = each!(i in 2 => R::select(both_left, cell.strain[i], yarns.free_strain[i]));
    let force = R::select(both_left, cell.force, zero);
    let shear_energy = forces.trellis.map_or(zero, |trellis| trellis.only(both_left).energy);
    let cells = size.cells * crossover::cell_energy(&c.cell, &tension, &strain, force);
    let energy = cells + size.area * shear_energy;
    sums.stored.add(R::select(any, energy, zero), *column);
    let hourglass = n.splat_like(0.5) * elements.hourglass(both_left) * dot(&k.mode, &k.mode);
    sums.hourglass.add(R::select(any, hourglass, zero), *column);
    if let Some(law) = row.law_energy {
        sums.law[0].add(R::select(both_left, law.shares(&k.extension) * cells, zero), *column);
    }
    lanes.tension = lanes.tension.max(tension[0].max(tension[1]));
    // Tension over breaking load is strain over failure strain.
    let part = each!(i in 2 => R::select(yarns.alive[i], strain[i] / c.cell.yarn[i].failure_strain, zero));
    // A mean over the failure length stands for what is beyond.
    let part = part.map(|part| R::select(part.lt(n.one()), part, zero));
    lanes.load = lanes.load.max(part[0].max(part[1]));
    let [p, q, r, s] = corners(n, row, 2, *column);
    lanes.deflection = lanes.deflection.max(R::select(any, p.abs().max(q.abs()).max(r.abs().max(s.abs())), zero));
}
