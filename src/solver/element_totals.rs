//! A row of elements and the rows of nodes around it.

use std::ops::Range;

use crate::model::unit_cell::LawEnergy;
use crate::num::scalar::{Mask, OrderedSum, Real, Scalar, each};
use crate::physics::crossover;
use crate::physics::kinematics::{ElementConstants, dot};
use crate::physics::membrane::{membrane, mode_force};
use crate::solver::FailureEvent;
use crate::solver::element_force::{Elements, Motion};

/// Fields of an element row, in storage order.
pub mod field {
    /// P1·Ly/2 [N], three components.
    pub(crate) const WARP_FORCE: usize = 0;
    /// P2·Lx/2 [N], three components.
    pub(crate) const WEFT_FORCE: usize = 3;
    /// Force on the difference of opposite edges, of yarns and hourglass stiffness, per corner [N], three components.
    pub const HOURGLASS: usize = 6;
    /// All forces.
    pub const FORCES: std::ops::Range<usize> = 0..9;
    /// Predictor of the next heights: `dh_dstretch` [m] of warp and weft, `force_share` [-] of both; see [`Predictor`](crate::physics::coupled_newton::Predictor).
    pub const PREDICTOR: usize = 9;
    /// Yarn heights h1, h2 [m].
    pub const HEIGHT: usize = 13;
    /// 1 while the yarn carries load, [`MARKED_FOR_FAILURE`](crate::solver::element_force::MARKED_FOR_FAILURE) when it is about to fail, 0 once it failed or where it is absent;
    /// warp, weft.
    pub const ALIVE: usize = 15;
    /// Number of fields.
    pub const COUNT: usize = 17;
    /// Further fields where yarns have forces that depend on rates, of shock viscosity or of the rate of strain: viscous forces of warp and weft [N].
    pub const VISCOUS: usize = 2;
    /// Further fields where their stress depends on the rate of strain: overstress over the stress, of warp and weft [-].
    pub const RATE: usize = 2;
    /// Further fields, the last ones: strains of warp and weft that failure is judged by [-], 0 where slack, broken ones [`BROKEN`](crate::solver::element_force::BROKEN).
    pub const STRAIN: usize = 2;
}

/// Node rows below and above a row of elements, and the row's own storage.
pub struct ElementRow<'a, S> {
    /// Displacement x, y, z then velocity x, y, z of the row of nodes below.
    pub below: [&'a [S]; 6],
    /// Fields of the row above.
    pub above: [&'a [S]; 6],
    /// Element fields; column c is stored at c + 1 so that node c finds its left neighbour at c.
    pub element: [&'a mut [S]; field::COUNT],
    /// Viscous forces of warp and weft [N], stored as the fields are; `None`: the yarns have none.
    pub viscous: Option<[&'a mut [S]; field::VISCOUS]>,
    /// Overstress of the rate of strain over the tension [-], stored as the fields are; `None`: there is none.
    pub rate: Option<[&'a mut [S]; field::RATE]>,
    /// Strains of warp and weft that failure is judged by [-], stored as the fields are.
    pub strain: [&'a mut [S]; field::STRAIN],
    /// Height of the row, over that of a row of the finest elements [-].
    pub height: f64,
    /// Lengths of the elements along X over the finest, and 1 over that [-].
    pub width: &'a [S],
    /// See `width`.
    pub per_width: &'a [S],
    /// Energy that the unit-cell law makes by itself; `None`: none.
    pub law_energy: Option<&'a LawEnergy>,
    /// Distance in numbers to the fields of the next row of elements, and to those of the next row of nodes.
    pub ahead: [usize; 2],
    /// Columns to be computed.
    pub range: Range<usize>,
    /// Time since the forces in the row were computed [s]; 0 at the start, when there are none.
    pub dt: f64,
    /// Whether the energies of the state are asked for.
    pub sample: bool,
}

impl<S> ElementRow<'_, S> {
    /// Whether all elements of the ply are alike.
    #[inline(always)]
    pub(super) fn is_even(&self) -> bool {
        self.width.is_empty()
    }
}

/// A field of the nodes at the corners of elements from `column` on, counter-clockwise.
#[inline(always)]
pub(super) fn corners<R: Real>(n: R, row: &ElementRow<'_, R::Scalar>, field: usize, column: usize) -> [R; 4] {
    let (below, above) = (row.below[field], row.above[field]);
    [n.load(below, column), n.load(below, column + 1), n.load(above, column + 1), n.load(above, column)]
}

/// Sums of one row of elements over one step.
#[derive(Clone, Debug, Default)]
pub struct ElementTotals {
    /// Work on them since the last step that shock viscosity dissipated [J].
    pub viscous_work: f64,
    /// Energy released by failures in this step: membrane, hourglass [J].
    pub released: [f64; 2],
    /// Energy that the unit-cell law has made by itself in cells that failed in this step [J].
    pub law_released: f64,
    /// Energy that the unit-cell law has made in whole cells now [J]; only in sampled steps.
    pub law_energy: f64,
    /// Elastic energy stored now (state function) [J]; only in sample steps.
    pub stored: f64,
    /// Hourglass energy now [J]; only in sample steps.
    pub hourglass: f64,
    /// Unit-cell solves that did not meet the residual.
    pub unconverged: u32,
    /// Residual evaluations, and cells that needed any.
    pub iterations: f64,
    /// Cells solved.
    pub solved: f64,
    /// Largest residual [N].
    pub max_residual: f64,
    /// Largest |z displacement| of a corner of a standing element [m]; only in sample steps.
    pub max_deflection: f64,
    /// Largest strain of warp and weft now [-].
    pub largest_strain: [f64; 2],
    /// Elements computed.
    pub computed: usize,
    /// Yarn failures in column order, with column, yarn and strain alone.
    pub failures: Vec<FailureEvent>,
}

impl ElementTotals {
    /// Ready for the next step; keeps the capacity of the failure list.
    pub fn clear(&mut self) {
        let mut failures = std::mem::take(&mut self.failures);
        failures.clear();
        *self = Self { failures, ..Self::default() };
    }
}

/// Sums over a row, of the elements computed so far.
#[derive(Default)]
pub(super) struct RowSums {
    pub(super) dissipated: OrderedSum,
    /// Released by failures: membrane, hourglass.
    pub(super) released: [OrderedSum; 2],
    pub(super) stored: OrderedSum,
    pub(super) hourglass: OrderedSum,
    /// Made by the unit-cell law, in whole cells and in those that failed.
    pub(super) law: [OrderedSum; 2],
}

impl RowSums {
    #[inline(always)]
    pub(super) fn add_to(&self, totals: &mut ElementTotals, sample: bool) {
        totals.viscous_work += self.dissipated.total();
        totals.law_energy += self.law[0].total();
        totals.law_released += self.law[1].total();
        if !totals.failures.is_empty() {
            totals.released = each!(i in 2 => self.released[i].total());
        }
        if sample {
            totals.stored += self.stored.total();
            totals.hourglass += self.hourglass.total();
        }
    }
}

/// Largest values in a row, lane by lane, and evaluations. Apart from the sums, which lie in memory: these stay in registers.
pub(super) struct RowMaxima<R> {
    pub(super) strain: [R; 2],
    pub(super) residual: R,
    pub(super) deflection: R,
    /// Whole numbers add up exactly in any order.
    pub(super) iterations: R,
}

impl<R: Real> RowMaxima<R> {
    #[inline(always)]
    pub(super) fn new(n: R) -> Self {
        let zero = n.zero();
        Self { strain: [zero; 2], residual: zero, deflection: zero, iterations: zero }
    }

    #[inline(always)]
    pub(super) fn add_to(&self, totals: &mut ElementTotals) {
        for i in 0..2 {
            totals.largest_strain[i] = totals.largest_strain[i].max(self.strain[i].reduce_max());
        }
        totals.max_residual = totals.max_residual.max(self.residual.reduce_max());
        totals.max_deflection = totals.max_deflection.max(self.deflection.reduce_max());
        totals.iterations += (0..R::LANES).map(|lane| self.iterations.lane(lane).to_f64()).sum::<f64>();
    }
}

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
    let Elements { column, motion, cell, yarns, viscous, trellis, membrane: [warp, weft], on_mode } = elements;
    let Motion { size, k, v } = motion;
    let n = c.area;
    let zero = n.zero();
    let (both, any_failed) = (yarns.both, yarns.any_failed);
    let was = trellis.map(|trellis| trellis.only(both));
    let shear_before = was.map_or(zero, |was| was.energy);
    let tension = each!(i in 2 => R::select(yarns.was_alive[i], cell.tension[i], zero));
    let cells = size.cells * crossover::cell_energy(&c.cell, &tension, &cell.strain, cell.force);
    let before = cells + size.area * shear_before;
    let left = each!(i in 2 => R::select(yarns.alive[i], yarns.free[i], zero));
    let after = size.cells * crossover::cell_energy(&c.cell, &left, &yarns.free_strain, zero);
    // Forces that break in this step never act, so the last half step's work on them was not done either.
    // Of what acts now only the elastic part changes what is stored.
    let elastic = each!(i in 2 => R::select(yarns.was_alive[i], cell.in_plane[i], zero));
    let intact = each!(i in 2 => elastic[i] + viscous[i]);
    let (warp_intact, weft_intact) = membrane(size, k, &intact, was.as_ref());
    let mode_intact = mode_force(size, k, &elastic, was.as_ref());
    let mut undone = zero;
    for a in 0..3 {
        undone = undone + (warp_intact[a] - warp[a]) * v[a][0] + (weft_intact[a] - weft[a]) * v[a][1];
        undone = undone + (mode_intact[a] - on_mode[a]) * v[a][2];
    }
    let loss = before - after - n.splat_like(0.5 * dt) * undone;
    sums.released[0].add(R::select(any_failed, loss, zero), *column);
    // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
    let mode = &k.mode;
    let last = each!(a in 3 => v[a][2] * n.splat_like(dt));
    let product = mode[0] * (mode[0] - last[0]) + mode[1] * (mode[1] - last[1]) + mode[2] * (mode[2] - last[2]);
    let drop = n.splat_like(0.5) * (elements.hourglass(both) - elements.hourglass(yarns.both_left)) * product;
    sums.released[1].add(R::select(any_failed, drop, zero), *column);
    if let Some(law) = row.law_energy {
        sums.law[1].add(R::select(both & any_failed, law.shares(&k.extension) * cells, zero), *column);
    }
    for lane in 0..R::LANES {
        for yarn in 0..2 {
            if yarns.failed[yarn].lane(lane) {
                row.element[field::ALIVE + yarn][column + 1 + lane] = R::Scalar::splat(0.0);
                totals.failures.push(FailureEvent {
                    i: (column + lane) as u32,
                    yarn: yarn as u8,
                    strain: cell.strain[yarn].lane(lane).to_f64(),
                    ..FailureEvent::default()
                });
            }
        }
    }
}

/// Adds those of a sample step.
#[inline(always)]
pub(super) fn energies<R: Real>(
    c: &ElementConstants<R>,
    row: &ElementRow<'_, R::Scalar>,
    elements: &Elements<R>,
    sums: &mut RowSums,
    maxima: &mut RowMaxima<R>,
) {
    let Elements { column, motion, cell, yarns, trellis, .. } = elements;
    let Motion { size, k, .. } = motion;
    let n = c.area;
    let zero = n.zero();
    let (any, both_left) = (yarns.any, yarns.both_left);
    let tension =
        each!(i in 2 => R::select(yarns.alive[i], R::select(both_left, cell.tension[i], yarns.free[i]), zero));
    let strain = each!(i in 2 => R::select(both_left, cell.strain[i], yarns.free_strain[i]));
    let force = R::select(both_left, cell.force, zero);
    let shear_energy = trellis.map_or(zero, |trellis| trellis.only(both_left).energy);
    let cells = size.cells * crossover::cell_energy(&c.cell, &tension, &strain, force);
    let energy = cells + size.area * shear_energy;
    sums.stored.add(R::select(any, energy, zero), *column);
    let hourglass = n.splat_like(0.5) * elements.hourglass(both_left) * dot(&k.mode, &k.mode);
    sums.hourglass.add(R::select(any, hourglass, zero), *column);
    if let Some(law) = row.law_energy {
        sums.law[0].add(R::select(both_left, law.shares(&k.extension) * cells, zero), *column);
    }
    let [p, q, r, s] = corners(n, row, 2, *column);
    maxima.deflection = maxima.deflection.max(R::select(any, p.abs().max(q.abs()).max(r.abs().max(s.abs())), zero));
}
