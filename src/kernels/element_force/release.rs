//! Energy that failures release.

use super::ElementConstants;
use super::elements::{Elements, Motion};
use super::row::{ElementRow, field};
use super::totals::{ElementTotals, RowSums, YarnFailure};
use crate::kernels::crossover;
use crate::kernels::membrane::{membrane, mode_force};
use crate::num::scalar::{Mask, Real, Scalar, each};

/// Books what the yarns release that fail in this step, and takes them out.
#[inline(always)]
pub(super) fn release<R: Real>(
    c: &ElementConstants<R>,
    row: &mut ElementRow<'_, R::Scalar>,
    elements: &Elements<R>,
    dt: f64,
    sums: &mut RowSums,
    totals: &mut ElementTotals,
) {
    let Elements { column, motion, cell, yarns, forces } = elements;
    let Motion { size, k, v } = motion;
    let n = c.area;
    let zero = n.zero();
    let (both, any_failed) = (yarns.both(), yarns.any_failed());
    let was = forces.trellis.map(|trellis| trellis.only(both));
    let shear_before = was.map_or(zero, |was| was.energy);
    let tension = each!(i in 2 => R::select(yarns.was_alive[i], cell.tension[i], zero));
    let cells = size.cells * crossover::cell_energy(&c.cell, &tension, &cell.strain, cell.force);
    let before = cells + size.area * shear_before;
    let left = each!(i in 2 => R::select(yarns.alive[i], yarns.free[i], zero));
    let after = size.cells * crossover::cell_energy(&c.cell, &left, &yarns.free_strain, zero);
    // Forces that break in this step never act, so the last half step's work on them was not done either.
    // Of what acts now only the elastic part changes what is stored.
    let elastic = each!(i in 2 => R::select(yarns.was_alive[i], cell.in_plane[i], zero));
    let intact = each!(i in 2 => elastic[i] + forces.drag[i]);
    let (warp_intact, weft_intact) = membrane(size, k, &intact, was.as_ref());
    let mode_intact = mode_force(size, k, &elastic, was.as_ref());
    let [warp, weft] = &forces.membrane;
    let mut undone = zero;
    for a in 0..3 {
        undone = undone + (warp_intact[a] - warp[a]) * v[a][0] + (weft_intact[a] - weft[a]) * v[a][1];
        undone = undone + (mode_intact[a] - forces.on_mode[a]) * v[a][2];
    }
    let loss = before - after - n.splat_like(0.5 * dt) * undone;
    sums.released[0].add(R::select(any_failed, loss, zero), *column);
    // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
    let mode = &k.mode;
    let last = each!(a in 3 => v[a][2] * n.splat_like(dt));
    let product = mode[0] * (mode[0] - last[0]) + mode[1] * (mode[1] - last[1]) + mode[2] * (mode[2] - last[2]);
    let drop = n.splat_like(0.5) * (elements.hourglass(both) - elements.hourglass(yarns.both_left())) * product;
    sums.released[1].add(R::select(any_failed, drop, zero), *column);
    if let Some(law) = row.law_energy {
        sums.law[1].add(R::select(both & any_failed, law.shares(&k.extension) * cells, zero), *column);
    }
    for lane in 0..R::LANES {
        for yarn in 0..2 {
            if yarns.failed[yarn].lane(lane) {
                row.element[field::ALIVE + yarn][column + 1 + lane] = R::Scalar::splat(0.0);
                totals.failures.push(YarnFailure {
                    column: (column + lane) as u32,
                    yarn: yarn as u8,
                    strain: cell.strain[yarn].lane(lane).to_f64(),
                });
            }
        }
    }
}
