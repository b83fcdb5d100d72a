//! Element kernel: stretches, crossover equilibrium, shear, failure and corner forces of one row of elements.
//!
//! Forces are P1 = N1 e1 + (q/Λ1) n2 and P2 = N2 e2 + (q/Λ2) n1 with unit vectors n2 ⟂ e1 and n1 ⟂ e2 in the
//! element's plane. One-point quads get an hourglass stiffness in total form on ¼(x1 − x2 + x3 − x4).
//!
//! An element whose two yarns have failed carries nothing; with one yarn left the trellis is gone, so shear is
//! released with the first failure.

use std::ops::Range;

use crate::kernels::crossover::{self, LawKernel, UnitCellParameters};
use crate::kernels::element_geometry::ElementGeometry;
use crate::kernels::kinematics::{differences, dot, kinematics, stretching};
use crate::kernels::law_energy::LawEnergy;
use crate::kernels::membrane::{membrane, trellis_shear, viscous};
use crate::kernels::predictor::Predictor;
use crate::kernels::prefetch;
use crate::kernels::shear::ShearConstants;
use crate::math::scalar::{Mask, Real, Scalar, each};
use crate::math::sum::OrderedSum;

/// Fields of an element row, in storage order.
pub mod field {
    /// P1·Ly/2 [N], three components.
    pub const WARP_FORCE: usize = 0;
    /// P2·Lx/2 [N], three components.
    pub const WEFT_FORCE: usize = 3;
    /// Hourglass force per corner [N], three components.
    pub const HOURGLASS: usize = 6;
    /// All forces.
    pub const FORCES: std::ops::Range<usize> = 0..9;
    /// What predicts the next heights: `dh_dstretch` [m] of warp and weft, `force_share` [-] of both; see [`Predictor`](super::Predictor).
    pub const PREDICTOR: usize = 9;
    /// Yarn heights h1, h2 [m].
    pub const HEIGHT: usize = 13;
    /// 1 while the yarn carries load, [`MARKED_FOR_FAILURE`](super::MARKED_FOR_FAILURE) when it is about to fail, 0 once it failed or where it is absent;
    /// warp, weft.
    pub const ALIVE: usize = 15;
    /// Number of fields.
    pub const COUNT: usize = 17;
    /// Further fields where yarns have shock viscosity: viscous forces of warp and weft [N].
    pub const VISCOUS: usize = 2;
    /// Further fields, behind those, where failure is judged over a length: strains of warp and weft [-], 0 where slack, broken ones [`BROKEN`](super::BROKEN).
    pub const STRAIN: usize = 2;
}

/// Life of a yarn that is to break in this step.
pub const MARKED_FOR_FAILURE: f64 = 0.75;
/// Stands for the strain of a piece of yarn that is broken or absent.
pub const BROKEN: f64 = -1.0;

/// Stretch of a yarn below which it counts as folded: its element's trellis energy fades with the stretch, so that a crumpled
/// element keeps a bounded stiffness and a force that is the slope of an energy. Enters the step bound.
pub const FOLDED_STRETCH: f64 = 0.5;
/// Largest fade(Λ)/Λ: the lever of shear in a folded element over 1.
pub const LONGEST_LEVER: f64 = 1.125 / FOLDED_STRETCH;

/// Constants of the element kernel; lengths are those of the finest elements.
#[derive(Clone, Copy, Debug)]
pub struct ElementConstants<R> {
    /// Unit cell.
    pub cell: UnitCellParameters<R>,
    /// Trellis shear.
    pub shear: ShearConstants<R>,
    /// 1/(2·Lx), 1/(2·Ly) [1/m].
    pub gradient: [R; 2],
    /// Tension to force: (Ly/2)/(2·w02) and (Lx/2)/(2·w01) [-].
    pub membrane: [R; 2],
    /// Shear resultant to force: Ly/2, Lx/2 [m].
    pub half_length: [R; 2],
    /// Hourglass stiffness contributed by each yarn while both are alive [N/m].
    pub hourglass: [R; 2],
    /// Shock viscosity of warp and weft over the stiffness, q1·L/c with c the wave speed of the straight yarn in the fabric [s].
    pub viscosity: [R; 2],
    /// Crossovers per element, and element area [m²], for energies.
    pub cells: R,
    /// [m²]
    pub area: R,
}

impl<S: Scalar> ElementConstants<S> {
    /// The same constants in every lane of numbers like `n`.
    pub fn spread<R: Real<Scalar = S>>(&self, n: R) -> ElementConstants<R> {
        let all = |value: S| n.broadcast(value);
        ElementConstants {
            cell: self.cell.spread(n),
            shear: self.shear.spread(n),
            gradient: self.gradient.map(all),
            membrane: self.membrane.map(all),
            half_length: self.half_length.map(all),
            hourglass: self.hourglass.map(all),
            viscosity: self.viscosity.map(all),
            cells: all(self.cells),
            area: all(self.area),
        }
    }
}

/// Node rows below and above a row of elements, and the row's own storage.
pub struct ElementRow<'a, S> {
    /// Displacement x, y, z then velocity x, y, z of the row of nodes below.
    pub below: [&'a [S]; 6],
    /// The same above.
    pub above: [&'a [S]; 6],
    /// Element fields; column c is stored at c + 1 so that node c finds its left neighbour at c.
    pub element: [&'a mut [S]; field::COUNT],
    /// Viscous forces of warp and weft [N], stored as the fields are; `None`: the yarns have no shock viscosity.
    pub viscous: Option<[&'a mut [S]; field::VISCOUS]>,
    /// Where strains of warp and weft go that are judged over a length, stored as the fields are; `None`: elements break at their own.
    pub strain: Option<[&'a mut [S]; field::STRAIN]>,
    /// Height of the row, over that of a row of the finest elements [-].
    pub height: f64,
    /// Lengths of the elements along X over the finest, and 1 over that [-].
    pub width: &'a [S],
    /// See `width`.
    pub per_width: &'a [S],
    /// What the unit-cell law makes of energy by itself, for the ledger; `None`: nothing.
    pub law_energy: Option<&'a LawEnergy>,
    /// How many numbers further on the next row of elements has its fields, and the next row of nodes those of the one above.
    pub prefetch: [usize; 2],
}

impl<S> ElementRow<'_, S> {
    /// Whether all elements of the ply are alike.
    #[inline(always)]
    fn is_even(&self) -> bool {
        self.width.is_empty()
    }
}

/// What of the kernel a step needs.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The fabric resists trellis shear.
    pub shear: bool,
    /// The energies of the state are asked for.
    pub ledger: bool,
}

/// A yarn that failed in this step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YarnFailure {
    /// Element column.
    pub column: u32,
    /// 0 warp, 1 weft.
    pub yarn: u8,
    /// Axial strain that broke it [-].
    pub strain: f64,
}

/// Sums of one row of elements over one step.
#[derive(Clone, Debug, Default)]
pub struct ElementTotals {
    /// Work of the membrane forces on the element since the last step, viscous forces included [J].
    pub internal_work: f64,
    /// The part of it that shock viscosity dissipated [J].
    pub viscous_work: f64,
    /// Energy released by failures in this step: membrane, hourglass [J].
    pub released: [f64; 2],
    /// Energy that the unit-cell law has made by itself in cells that failed in this step [J].
    pub law_released: f64,
    /// The same in whole cells now [J]; only in ledger steps.
    pub law_energy: f64,
    /// Elastic energy stored now (state function) [J]; only in ledger steps.
    pub stored: f64,
    /// Hourglass energy now [J]; only in ledger steps.
    pub hourglass: f64,
    /// Unit-cell solves that did not meet the residual.
    pub unconverged: u32,
    /// Residual evaluations, and cells that needed any.
    pub iterations: f64,
    /// Cells solved.
    pub solved: f64,
    /// Largest residual [N].
    pub max_residual: f64,
    /// Largest yarn tension now [N]; only in ledger steps.
    pub max_tension: f64,
    /// Largest yarn tension over the yarn's breaking load now [-]; only in ledger steps. Where failure is judged over a length, of
    /// pieces that carry less.
    pub max_load: f64,
    /// Largest |z displacement| of a corner of a standing element [m]; only in ledger steps.
    pub max_deflection: f64,
    /// Largest strain of warp and weft now [-]; only where failure is judged over a length.
    pub largest_strain: [f64; 2],
    /// Elements computed.
    pub computed: usize,
    /// Yarn failures in column order.
    pub failures: Vec<YarnFailure>,
}

impl ElementTotals {
    /// Ready for the next step; keeps the capacity of the failure list.
    pub fn clear(&mut self) {
        let mut failures = std::mem::take(&mut self.failures);
        failures.clear();
        *self = Self { failures, ..Self::default() };
    }
}

/// Most numbers in a register.
const WIDEST: usize = 16;

/// Share of the energy of cells with two yarns that the unit-cell law has made by itself [-].
#[inline(always)]
fn law_share<R: Real>(n: R, table: Option<&LawEnergy>, stretch: &[R; 2]) -> R {
    let Some(table) = table else { return n };
    let mut values = [R::Scalar::splat(0.0); WIDEST];
    for lane in 0..R::LANES {
        let at = [0, 1].map(|i: usize| stretch[i].lane(lane).to_f64());
        values[lane] = R::Scalar::splat(table.at(at));
    }
    n.load(&values, 0)
}

/// A field of the nodes at the corners of elements from `column` on, counter-clockwise.
#[inline(always)]
fn corners<R: Real>(n: R, row: &ElementRow<'_, R::Scalar>, field: usize, column: usize) -> [R; 4] {
    let (below, above) = (row.below[field], row.above[field]);
    [n.load(below, column), n.load(below, column + 1), n.load(above, column + 1), n.load(above, column)]
}

/// Computes `range` of one row of elements, from the last multiple of `R::LANES` before it on: columns beyond it are at rest and stay
/// so, or are padding.
///
/// `dt` is the time since the forces in the row were computed [s] (0 at the start, when there are none).
#[inline(always)]
pub fn element_force<R: Real, L: LawKernel>(
    c: &ElementConstants<R>,
    row: &mut ElementRow<'_, R::Scalar>,
    range: Range<usize>,
    dt: f64,
    extent: Extent,
    totals: &mut ElementTotals,
) {
    let Extent { shear, ledger } = extent;
    let n = c.area;
    let zero = n.zero();
    let half_dt = n.splat_like(0.5 * dt);
    let graded = !row.is_even();
    let tall = ElementGeometry::of_row(c, if graded { row.height } else { 1.0 });
    let mut work = OrderedSum::default();
    let mut dissipated = OrderedSum::default();
    let mut stored = OrderedSum::default();
    let mut of_law = [OrderedSum::default(); 2];
    let mut hourglass = OrderedSum::default();
    // Whole numbers add up exactly in any order.
    let mut iterations = zero;
    let mut released = [OrderedSum::default(); 2];
    let mut largest_strain = [zero; 2];
    let (mut residual, mut largest, mut load, mut deflection) = (zero, zero, zero, zero);
    let mut column = range.start - range.start % R::LANES;
    while column < range.end {
        let at = column + 1;
        for line in prefetch::lines::<R::Scalar>(column..column + R::LANES) {
            let [elements, nodes] = row.prefetch;
            prefetch::ask(row.element.iter().map(|field| &**field), line + 1, elements);
            prefetch::ask(row.above, line, nodes);
        }
        let [ux, uy, uz] = each!(f in 3 => differences(&corners(n, row, f, column)));
        let [vx, vy, vz] = each!(f in 3 => differences(&corners(n, row, 3 + f, column)));
        let size =
            if graded { tall.of_columns(n.load(row.width, column), n.load(row.per_width, column)) } else { tall };
        let k = kinematics(&size, &[ux[0], uy[0], uz[0]], &[ux[1], uy[1], uz[1]]);

        let half = n.splat_like(0.5);
        let life = each!(i in 2 => n.load(row.element[field::ALIVE + i], at));
        let was_alive = each!(i in 2 => half.lt(life[i]));
        let both = was_alive[0] & was_alive[1];
        let any = was_alive[0] | was_alive[1];
        let warm = each!(i in 2 => n.load(row.element[field::HEIGHT + i], at));
        let guide = Predictor {
            dh_dstretch: each!(i in 2 => n.load(row.element[field::PREDICTOR + i], at)),
            force_share: each!(i in 2 => n.load(row.element[field::PREDICTOR + 2 + i], at)),
        };
        let warm = guide.heights(warm, stretching(&size, &k, [&vx, &vy, &vz], n.splat_like(dt)));
        let cell = crossover::solve::<R, L>(&c.cell, k.extension, warm, both);
        for i in 0..2 {
            cell.guide.dh_dstretch[i].store(row.element[field::PREDICTOR + i], at);
            cell.guide.force_share[i].store(row.element[field::PREDICTOR + 2 + i], at);
        }

        let failed = each!(i in 2 => {
            let at_end = if row.strain.is_some() { life[i].le(n.splat_like(MARKED_FOR_FAILURE)) } else { c.cell.yarn[i].failure_strain.le(cell.strain[i]) };
            was_alive[i] & at_end
        });
        if let Some(strains) = &mut row.strain {
            for i in 0..2 {
                let strain = R::select(was_alive[i] & !failed[i], cell.strain[i].max(zero), n.splat_like(BROKEN));
                strain.store(strains[i], at);
                largest_strain[i] = largest_strain[i].max(strain);
            }
        }
        let alive = [was_alive[0] & !failed[0], was_alive[1] & !failed[1]];
        let both_left = alive[0] & alive[1];
        let any_failed = failed[0] | failed[1];
        let straight = each!(i in 2 => c.cell.yarn[i].straight(k.extension[i]));
        let free_strain = each!(i in 2 => straight[i].max(zero));
        let free = each!(i in 2 => c.cell.yarn[i].tension(straight[i]));
        let elastic = each!(i in 2 => R::select(both_left, cell.in_plane[i], free[i]));
        let elastic = each!(i in 2 => R::select(alive[i], elastic[i], zero));
        let mut drag = [zero; 2];
        if let Some(fields) = &mut row.viscous {
            let before = each!(i in 2 => n.load(fields[i], at));
            let viscous = viscous(c, &size, &k, [&vx, &vy, &vz], &elastic, before, n.splat_like(dt));
            drag = viscous.force;
            for i in 0..2 {
                drag[i].store(fields[i], at);
            }
            // N over the element's width times its length.
            let energy = each!(i in 2 => viscous.work[i] * size.membrane[i] * (half / size.gradient[i]));
            dissipated.add(energy[0] + energy[1], column);
        }
        let pull = each!(i in 2 => elastic[i] + drag[i]);

        let trellis = shear.then(|| trellis_shear(&c.shear, &k, ledger | any_failed.any()));
        let left = trellis.map(|trellis| trellis.only(both_left));
        let (warp, weft) = membrane(&size, &k, &pull, left.as_ref());

        // Work done on the element between the last positions and these (trapezoid), and the new forces.
        let mut power = zero;
        let v = [vx, vy, vz];
        for a in 0..3 {
            let warp_new = R::select(any, warp[a], zero);
            let weft_new = R::select(any, weft[a], zero);
            let warp_sum = n.load(row.element[field::WARP_FORCE + a], at) + warp_new;
            let weft_sum = n.load(row.element[field::WEFT_FORCE + a], at) + weft_new;
            power = weft_sum.fused(v[a][1], warp_sum.fused(v[a][0], power));
            warp_new.store(row.element[field::WARP_FORCE + a], at);
            weft_new.store(row.element[field::WEFT_FORCE + a], at);
        }
        work.add(half_dt * power, column);

        let stiffness = size.hourglass[0] + size.hourglass[1];
        let quarter = n.splat_like(0.25);
        let mode = [quarter * ux[2], quarter * uy[2], quarter * uz[2]];
        let kh = R::select(both_left, stiffness, zero);
        for a in 0..3 {
            let force = R::select(any, quarter * kh * mode[a], zero);
            force.store(row.element[field::HOURGLASS + a], at);
        }

        R::select(any, cell.height[0], zero).store(row.element[field::HEIGHT], at);
        R::select(any, cell.height[1], zero).store(row.element[field::HEIGHT + 1], at);
        let counted = n.within(column, &range);
        totals.unconverged += (both & !cell.converged).count();
        totals.solved += f64::from((both & counted).count());
        iterations = iterations + R::select(counted, cell.iterations, zero);
        residual = residual.max(cell.residual);

        if any_failed.any() {
            let was = trellis.map(|trellis| trellis.only(both));
            let shear_before = was.map_or(zero, |was| was.energy);
            let tension = each!(i in 2 => R::select(was_alive[i], cell.tension[i], zero));
            let cells = size.cells * crossover::cell_energy(&c.cell, &tension, &cell.strain, cell.force);
            let before = cells + size.area * shear_before;
            let left = each!(i in 2 => R::select(alive[i], free[i], zero));
            let after = size.cells * crossover::cell_energy(&c.cell, &left, &free_strain, zero);
            // Forces that break in this step never act, so the last half step's work on them was not done either.
            // Of what acts now only the elastic part changes what is stored.
            let intact = each!(i in 2 => R::select(was_alive[i], cell.in_plane[i], zero) + drag[i]);
            let (warp_intact, weft_intact) = membrane(&size, &k, &intact, was.as_ref());
            let mut undone = zero;
            for a in 0..3 {
                undone = undone + (warp_intact[a] - warp[a]) * v[a][0] + (weft_intact[a] - weft[a]) * v[a][1];
            }
            let loss = before - after - half_dt * undone;
            released[0].add(R::select(any_failed, loss, zero), column);
            // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
            let last = each!(a in 3 => quarter * v[a][2] * n.splat_like(dt));
            let product = mode[0] * (mode[0] - last[0]) + mode[1] * (mode[1] - last[1]) + mode[2] * (mode[2] - last[2]);
            let drop = half * (R::select(both, stiffness, zero) - kh) * product;
            released[1].add(R::select(any_failed, drop, zero), column);
            if row.law_energy.is_some() {
                let share = law_share(zero, row.law_energy, &k.extension);
                of_law[1].add(R::select(both & any_failed, share * cells, zero), column);
            }
            for lane in 0..R::LANES {
                for yarn in 0..2 {
                    if failed[yarn].lane(lane) {
                        row.element[field::ALIVE + yarn][at + lane] = R::Scalar::splat(0.0);
                        totals.failures.push(YarnFailure {
                            column: (column + lane) as u32,
                            yarn: yarn as u8,
                            strain: cell.strain[yarn].lane(lane).to_f64(),
                        });
                    }
                }
            }
        }

        if ledger {
            let tension = each!(i in 2 => R::select(alive[i], R::select(both_left, cell.tension[i], free[i]), zero));
            let strain = each!(i in 2 => R::select(both_left, cell.strain[i], free_strain[i]));
            let force = R::select(both_left, cell.force, zero);
            let shear_energy = left.map_or(zero, |left| left.energy);
            let cells = size.cells * crossover::cell_energy(&c.cell, &tension, &strain, force);
            let energy = cells + size.area * shear_energy;
            stored.add(R::select(any, energy, zero), column);
            hourglass.add(R::select(any, half * kh * dot(&mode, &mode), zero), column);
            if row.law_energy.is_some() {
                let share = law_share(zero, row.law_energy, &k.extension);
                of_law[0].add(R::select(both_left, share * cells, zero), column);
            }
            largest = largest.max(tension[0].max(tension[1]));
            // Tension over breaking load is strain over failure strain.
            let part = each!(i in 2 => R::select(alive[i], strain[i] / c.cell.yarn[i].failure_strain, zero));
            // A mean over the failure length stands for what is beyond.
            let part =
                if row.strain.is_some() { part.map(|part| R::select(part.lt(n.one()), part, zero)) } else { part };
            load = load.max(part[0].max(part[1]));
            let [p, q, r, s] = corners(n, row, 2, column);
            deflection = deflection.max(R::select(any, p.abs().max(q.abs()).max(r.abs().max(s.abs())), zero));
        }
        column += R::LANES;
    }
    for i in 0..2 {
        totals.largest_strain[i] = totals.largest_strain[i].max(largest_strain[i].reduce_max());
    }
    totals.max_residual = totals.max_residual.max(residual.reduce_max());
    totals.max_tension = totals.max_tension.max(largest.reduce_max());
    totals.max_load = totals.max_load.max(load.reduce_max());
    totals.max_deflection = totals.max_deflection.max(deflection.reduce_max());
    totals.internal_work += work.total();
    totals.viscous_work += dissipated.total();
    totals.law_energy += of_law[0].total();
    totals.law_released += of_law[1].total();
    totals.iterations += (0..R::LANES).map(|lane| iterations.lane(lane).to_f64()).sum::<f64>();
    if !totals.failures.is_empty() {
        totals.released = each!(i in 2 => released[i].total());
    }
    if ledger {
        totals.stored += stored.total();
        totals.hourglass += hourglass.total();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::law_energy::COUNT;

    #[test]
    fn every_lane_has_the_share_of_its_own_stretches() {
        let values = (0..COUNT * COUNT).map(|at| 1.0 + at as f64).collect();
        let table = LawEnergy { low: [0.0; 2], per_stretch: [1.0; 2], values };
        let share = |stretch: [f64; 2]| law_share(0.0, Some(&table), &stretch);
        assert_eq!(share([2.0, 3.0]), 1.0 + (2 * COUNT + 3) as f64);
        assert_eq!(share([0.5, 0.25]), 1.0 + 0.5 * COUNT as f64 + 0.25);
        assert_eq!(law_share(0.0, None, &[2.0, 3.0]), 0.0);
    }
}
