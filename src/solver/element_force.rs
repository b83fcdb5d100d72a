//! Element kernel: stretches, crossover equilibrium, shear, failure and corner forces of one row of elements.
//!
//! Forces are P1 = N1 e1 + (q/Λ1) n2 and P2 = N2 e2 + (q/Λ2) n1 with unit vectors n2 ⟂ e1 and n1 ⟂ e2 in the
//! element's plane. On the difference of opposite edges x1 − x2 + x3 − x4 act the yarns, whose stretch is a mean over the element, and an
//! hourglass stiffness in total form.
//!
//! An element whose two yarns have failed carries nothing; with one yarn left the trellis is gone, so shear is
//! released with the first failure.

use prefetch_index::prefetch_index;

use crate::num::scalar::{Mask, Real, each};
use crate::num::simd::CACHE_LINE;
use crate::physics::coupled_newton::Predictor;
use crate::physics::crossover::{self, Equilibrium};
use crate::physics::kinematics::{ElementConstants, ElementGeometry};
use crate::physics::kinematics::{Growth, Kinematics, Vector, differences, kinematics};
use crate::physics::membrane::{FadedShear, membrane, mode_force, trellis_shear};
use crate::physics::viscous_force;
use crate::physics::yarn_law::Sinusoidal;
use crate::solver::element_totals::{ElementRow, ElementTotals, RowMaxima, RowSums, corners, energies, field, release};

/// Life of a yarn that is to break in this step.
pub const MARKED_FOR_FAILURE: f64 = 0.75;
/// Stands for the strain of a piece of yarn that is broken or absent.
pub const BROKEN: f64 = -1.0;

/// Computes the columns asked for of one row of elements, from the last multiple of `R::LANES` before them on: columns beyond are at rest
/// and stay so, or are padding. `shear`: the fabric resists trellis shear.
#[inline(always)]
pub fn element_force<R: Real>(
    c: &ElementConstants<R>,
    shear: bool,
    row: &mut ElementRow<'_, R::Scalar>,
    totals: &mut ElementTotals,
) {
    let (range, dt, sample) = (row.range.clone(), row.dt, row.sample);
    let n = c.area;
    let step = n.splat_like(dt);
    let row_geometry = ElementGeometry::of_row(c, if row.is_even() { 1.0 } else { row.height });
    let mut sums = RowSums::default();
    let mut maxima = RowMaxima::new(n);
    let mut column = range.start - range.start % R::LANES;
    while column < range.end {
        let at = column + 1;
        ask_ahead::<R>(row, column);
        let motion = Motion::read(n, row, &row_geometry, column);
        let intact = each!(i in 2 => n.load(row.element[field::ALIVE + i], at));
        let [warp, weft] = YarnsLeft::were_alive(intact);
        let both = warp & weft;
        let cell = equilibrium(c, row, &motion, both, at, step);
        let yarns = YarnsLeft::evaluate(c, &motion.k.extension, intact);
        let strain = yarns.store_strains(&mut row.strain, &cell, at);
        maxima.strain = each!(i in 2 => maxima.strain[i].max(strain[i]));
        let elastic = yarns.elastic(&cell);
        let mut viscous = [n.zero(); 2];
        if let Some(fields) = &mut row.viscous {
            let (force, energy) = viscous_forces(c, fields, row.rate.as_mut(), &motion, &elastic, at, step);
            sums.dissipated.add(energy, column);
            viscous = force;
        }
        let in_plane = each!(i in 2 => elastic[i] + viscous[i]);
        let any_failed = yarns.any_failed.any();
        let trellis = shear.then(|| trellis_shear(&c.shear, &motion.k, sample | any_failed));
        let left = trellis.map(|trellis| trellis.only(yarns.both_left));
        let (warp, weft) = membrane(&motion.size, &motion.k, &in_plane, left.as_ref());
        let on_mode = mode_force(&motion.size, &motion.k, &elastic, left.as_ref());
        let elements = Elements { column, motion, cell, yarns, viscous, trellis, membrane: [warp, weft], on_mode };
        elements.store(row);

        let counted = n.within(column, &range);
        totals.unconverged += (both & !cell.converged).bits().count_ones();
        totals.solved += f64::from((both & counted).bits().count_ones());
        maxima.iterations = maxima.iterations + R::select(counted, cell.iterations, n.zero());
        maxima.residual = maxima.residual.max(cell.residual);
        if any_failed {
            release(c, row, &elements, dt, &mut sums, totals);
        }
        if sample {
            energies(c, row, &elements, &mut sums, &mut maxima);
        }
        column += R::LANES;
    }
    sums.add_to(totals, sample);
    maxima.add_to(totals);
}

/// Asks the cache for what the next rows have in these columns.
#[inline(always)]
fn ask_ahead<R: Real>(row: &ElementRow<'_, R::Scalar>, column: usize) {
    let [elements, nodes] = row.ahead;
    for at in (column..column + R::LANES).step_by(CACHE_LINE / size_of::<R::Scalar>()) {
        row.element.iter().for_each(|field| prefetch_index(&**field, at + 1 + elements));
        row.above.iter().for_each(|field| prefetch_index(field, at + nodes));
    }
}

/// All that failures and energies ask for.
pub(super) struct Elements<R: Real> {
    /// Column of the first element.
    pub(super) column: usize,
    pub(super) motion: Motion<R>,
    pub(super) cell: Equilibrium<R>,
    pub(super) yarns: YarnsLeft<R>,
    /// Viscous forces of the yarns [N].
    pub(super) viscous: [R; 2],
    /// Trellis shear of elements with two yarns; `None`: the fabric resists none.
    pub(super) trellis: Option<FadedShear<R>>,
    /// P1·Ly/2 and P2·Lx/2 [N].
    pub(super) membrane: [Vector<R>; 2],
    /// Force of the yarns on the difference of opposite edges [N].
    pub(super) on_mode: Vector<R>,
}

impl<R: Real> Elements<R> {
    /// Hourglass stiffness of those with two yarns in `both`, on the difference of opposite edges [N/m]: the mode is ¼ of that.
    #[inline(always)]
    pub(super) fn hourglass(&self, both: R::Mask) -> R {
        let [warp, weft] = self.motion.size.hourglass;
        R::select(both, warp.splat_like(1.0 / 16.0) * (warp + weft), warp.zero())
    }

    /// Keeps forces and heights.
    #[inline(always)]
    pub(super) fn store(&self, row: &mut ElementRow<'_, R::Scalar>) {
        let (at, any) = (self.column + 1, self.yarns.any);
        let [warp, weft] = &self.membrane;
        let zero = warp[0].zero();
        let stiffness = self.hourglass(self.yarns.both_left);
        for a in 0..3 {
            let mode = stiffness.fused(self.motion.k.mode[a], self.on_mode[a]);
            R::select(any, warp[a], zero).store(row.element[field::WARP_FORCE + a], at);
            R::select(any, weft[a], zero).store(row.element[field::WEFT_FORCE + a], at);
            R::select(any, mode, zero).store(row.element[field::HOURGLASS + a], at);
        }
        for i in 0..2 {
            R::select(any, self.cell.height[i], zero).store(row.element[field::HEIGHT + i], at);
        }
    }
}

/// Motion of elements.
pub(super) struct Motion<R> {
    pub(super) size: ElementGeometry<R>,
    pub(super) k: Kinematics<R>,
    /// Differences of velocities over an element, by component [m/s].
    pub(super) v: [Vector<R>; 3],
}

impl<R: Real> Motion<R> {
    /// `row_geometry`: the constants of elements of the finest length in this row.
    #[inline(always)]
    pub(super) fn read(
        n: R,
        row: &ElementRow<'_, R::Scalar>,
        row_geometry: &ElementGeometry<R>,
        column: usize,
    ) -> Self {
        let [ux, uy, uz] = each!(f in 3 => differences(&corners(n, row, f, column)));
        let v = each!(f in 3 => differences(&corners(n, row, 3 + f, column)));
        let size = match row.is_even() {
            true => *row_geometry,
            false => row_geometry.of_columns(n.load(row.width, column), n.load(row.per_width, column)),
        };
        Self { size, k: kinematics(&size, [&ux, &uy, &uz]), v }
    }
}

/// Equilibrium of the cells, from the heights predicted for them. Keeps what predicts the next ones.
#[inline(always)]
pub(super) fn equilibrium<R: Real>(
    c: &ElementConstants<R>,
    row: &mut ElementRow<'_, R::Scalar>,
    motion: &Motion<R>,
    both: R::Mask,
    at: usize,
    dt: R,
) -> Equilibrium<R> {
    let Motion { size, k, v } = motion;
    let warm = each!(i in 2 => dt.load(row.element[field::HEIGHT + i], at));
    let predictor = Predictor {
        dh_dstretch: each!(i in 2 => dt.load(row.element[field::PREDICTOR + i], at)),
        force_share: each!(i in 2 => dt.load(row.element[field::PREDICTOR + 2 + i], at)),
    };
    let warm = predictor.heights(warm, Growth::new(size, k, v, dt).stretching(k));
    let cell = crossover::solve::<R, Sinusoidal>(&c.cell, k.extension, warm, both);
    for i in 0..2 {
        cell.predictor.dh_dstretch[i].store(row.element[field::PREDICTOR + i], at);
        cell.predictor.force_share[i].store(row.element[field::PREDICTOR + 2 + i], at);
    }
    cell
}

/// Their yarns, and which of them fail.
pub(super) struct YarnsLeft<R: Real> {
    pub(super) was_alive: [R::Mask; 2],
    pub(super) failed: [R::Mask; 2],
    pub(super) alive: [R::Mask; 2],
    /// Elements that had both yarns before this step, or one.
    pub(super) both: R::Mask,
    pub(super) any: R::Mask,
    pub(super) both_left: R::Mask,
    pub(super) any_failed: R::Mask,
    /// Strains [-] and tensions [N] of yarns that none presses on.
    pub(super) free_strain: [R; 2],
    pub(super) free: [R; 2],
}

impl<R: Real> YarnsLeft<R> {
    /// `intact`: as stored.
    #[inline(always)]
    pub(super) fn evaluate(c: &ElementConstants<R>, extension: &[R; 2], intact: [R; 2]) -> Self {
        let n = c.area;
        let was_alive = Self::were_alive(intact);
        let failed = each!(i in 2 => was_alive[i] & intact[i].le(n.splat_like(MARKED_FOR_FAILURE)));
        let alive = each!(i in 2 => was_alive[i] & !failed[i]);
        let straight = each!(i in 2 => c.cell.yarn[i].straight(extension[i]));
        Self {
            was_alive,
            failed,
            alive,
            both: was_alive[0] & was_alive[1],
            any: was_alive[0] | was_alive[1],
            both_left: alive[0] & alive[1],
            any_failed: failed[0] | failed[1],
            free_strain: each!(i in 2 => straight[i].max(n.zero())),
            free: each!(i in 2 => c.cell.yarn[i].tension(straight[i])),
        }
    }

    #[inline(always)]
    pub(super) fn were_alive(intact: [R; 2]) -> [R::Mask; 2] {
        let half = intact[0].splat_like(0.5);
        each!(i in 2 => half.lt(intact[i]))
    }

    /// Elastic in-plane forces of what is left [N].
    #[inline(always)]
    pub(super) fn elastic(&self, cell: &Equilibrium<R>) -> [R; 2] {
        let elastic = each!(i in 2 => R::select(self.both_left, cell.in_plane[i], self.free[i]));
        each!(i in 2 => R::select(self.alive[i], elastic[i], elastic[i].zero()))
    }

    /// Keeps the strains that failure is judged by, those of broken yarns as [`BROKEN`], and gives them.
    #[inline(always)]
    pub(super) fn store_strains(
        &self,
        strains: &mut [&mut [R::Scalar]; field::STRAIN],
        cell: &Equilibrium<R>,
        at: usize,
    ) -> [R; 2] {
        each!(i in 2 => {
            let zero = cell.strain[i].zero();
            let strain = R::select(self.alive[i], cell.strain[i].max(zero), zero.splat_like(BROKEN));
            strain.store(strains[i], at);
            strain
        })
    }
}

/// Viscous forces of the yarns [N], which it keeps, and what they dissipated since the last step [J].
#[inline(always)]
pub(super) fn viscous_forces<R: Real>(
    c: &ElementConstants<R>,
    fields: &mut [&mut [R::Scalar]; field::VISCOUS],
    rate: Option<&mut [&mut [R::Scalar]; field::RATE]>,
    motion: &Motion<R>,
    elastic: &[R; 2],
    at: usize,
    dt: R,
) -> ([R; 2], R) {
    let Motion { size, k, v } = motion;
    let before = each!(i in 2 => dt.load(fields[i], at));
    let rate_before = rate.as_ref().map_or([dt.zero(); 2], |fields| each!(i in 2 => dt.load(fields[i], at)));
    let viscous = viscous_force::viscous_forces(c, size, k, v, elastic, [before, rate_before], dt);
    for i in 0..2 {
        viscous.force[i].store(fields[i], at);
    }
    if let Some(fields) = rate {
        for i in 0..2 {
            viscous.rate[i].store(fields[i], at);
        }
    }
    // N over the element's width times its length.
    let half = dt.splat_like(0.5);
    let energy = each!(i in 2 => viscous.work[i] * size.membrane[i] * (half / size.gradient[i]));
    (viscous.force, energy[0] + energy[1])
}
