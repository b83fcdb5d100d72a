//! What a row of elements adds up to in one step.

use crate::num::scalar::{Real, Scalar, each};
use crate::num::sum::OrderedSum;

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
    /// Work of all forces on the element since the last step, viscous forces included [J].
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
    /// Largest yarn tension over the yarn's breaking load now [-], of those that carry less; only in ledger steps.
    pub max_load: f64,
    /// Largest |z displacement| of a corner of a standing element [m]; only in ledger steps.
    pub max_deflection: f64,
    /// Largest strain of warp and weft now [-].
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

/// Sums over a row, of the elements computed so far.
#[derive(Default)]
pub(super) struct RowSums {
    pub(super) work: OrderedSum,
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
    pub(super) fn add_to(&self, totals: &mut ElementTotals, ledger: bool) {
        totals.internal_work += self.work.total();
        totals.viscous_work += self.dissipated.total();
        totals.law_energy += self.law[0].total();
        totals.law_released += self.law[1].total();
        if !totals.failures.is_empty() {
            totals.released = each!(i in 2 => self.released[i].total());
        }
        if ledger {
            totals.stored += self.stored.total();
            totals.hourglass += self.hourglass.total();
        }
    }
}

/// Largest values in a row, lane by lane, and evaluations. Apart from the sums, which lie in memory: these stay in registers.
pub(super) struct RowLanes<R> {
    pub(super) strain: [R; 2],
    pub(super) residual: R,
    pub(super) tension: R,
    pub(super) load: R,
    pub(super) deflection: R,
    /// Whole numbers add up exactly in any order.
    pub(super) iterations: R,
}

impl<R: Real> RowLanes<R> {
    #[inline(always)]
    pub(super) fn new(n: R) -> Self {
        let zero = n.zero();
        Self { strain: [zero; 2], residual: zero, tension: zero, load: zero, deflection: zero, iterations: zero }
    }

    #[inline(always)]
    pub(super) fn add_to(&self, totals: &mut ElementTotals) {
        for i in 0..2 {
            totals.largest_strain[i] = totals.largest_strain[i].max(self.strain[i].reduce_max());
        }
        totals.max_residual = totals.max_residual.max(self.residual.reduce_max());
        totals.max_tension = totals.max_tension.max(self.tension.reduce_max());
        totals.max_load = totals.max_load.max(self.load.reduce_max());
        totals.max_deflection = totals.max_deflection.max(self.deflection.reduce_max());
        totals.iterations += (0..R::LANES).map(|lane| self.iterations.lane(lane).to_f64()).sum::<f64>();
    }
}
