//! Both backends from the same state, kernel by kernel: what differs, where, and by how much.
//!
//! The processor runs the case in single precision. For a compared step its state is put on the device, and widened into
//! a double-precision state; the three compute the step, and after the elements both followers are given the leader's state
//! again, so that a difference belongs to one kernel. (Contact follows the nodes without this: the nodes mark what it
//! looks at.) What single precision costs in the run stands beside what the device adds, which may be twice as much.

mod lockstep;
mod scales;
mod tolerances;

use std::sync::atomic::{AtomicBool, Ordering};

use crate::case::Case;
use crate::gpu::Device;
use crate::run::RunError;

use lockstep::{Lockstep, Twin};
pub use scales::Scales;
pub use tolerances::{ROUNDING, TOLERANCES, Tolerance, line, markdown};

/// One number that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct BackendDifference {
    /// Step.
    pub step: u64,
    /// Index into [`TOLERANCES`].
    pub what: usize,
    /// Ply, row, column of the node or element.
    pub place: [usize; 3],
    /// Component, or yarn.
    pub component: usize,
    /// Single precision on the processor.
    pub cpu: f64,
    /// The device.
    pub gpu: f64,
    /// Double precision on the processor.
    pub wide: f64,
    /// |gpu − cpu| over the scale [-].
    pub relative: f64,
    /// |cpu − wide| over the scale [-].
    pub rounding: f64,
    /// What `relative` may be on the device [-]: nothing, until a comparison has taken it in.
    pub limit: f64,
}

impl BackendDifference {
    /// Whether the device differs more than it may.
    pub fn is_over(&self) -> bool {
        // A NaN is over, whatever the tolerance.
        self.relative.is_nan() || self.relative > self.limit
    }

    fn is_larger(&self, other: &Self) -> bool {
        !other.relative.is_nan() && (self.relative.is_nan() || self.relative > other.relative)
    }
}

/// A whole comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Whether the device is a card.
    hardware: bool,
    /// Steps followed.
    pub steps: u64,
    /// Steps compared.
    pub compared: u64,
    /// Numbers compared.
    pub numbers: u64,
    /// The largest difference of each line of [`TOLERANCES`], where it was seen.
    pub worst: Vec<Option<BackendDifference>>,
    /// Largest |cpu − wide| over the scale, line by line.
    pub rounding: Vec<f64>,
    /// The first difference over its tolerance.
    pub first: Option<BackendDifference>,
    /// Differences over the line of the table that they belong to, each larger than those of its line before: the first one over whatever is
    /// allowed in the end is among them.
    over: Vec<BackendDifference>,
}

impl Comparison {
    fn new(hardware: bool) -> Self {
        let count = TOLERANCES.len();
        Self {
            hardware,
            steps: 0,
            compared: 0,
            numbers: 0,
            worst: vec![None; count],
            rounding: vec![0.0; count],
            first: None,
            over: Vec::new(),
        }
    }

    fn see(&mut self, mut d: BackendDifference) {
        d.limit = TOLERANCES[d.what].limit(self.hardware);
        self.numbers += 1;
        let what = d.what;
        self.rounding[what] = self.rounding[what].max(d.rounding);
        if self.worst[what].as_ref().is_none_or(|worst| d.is_larger(worst)) {
            if d.is_over() {
                self.over.push(d.clone());
            }
            self.worst[what] = Some(d);
        }
    }

    /// Judges what was seen. Two runs in single precision may differ by twice what one of them differed from double precision anywhere in
    /// the run: where plies hardly touch, and at ridges, a rounding of a place decides what pushes.
    fn judged(mut self) -> Self {
        let rounding = std::mem::take(&mut self.rounding);
        for d in self.worst.iter_mut().flatten().chain(&mut self.over) {
            if d.limit > 0.0 {
                d.limit = d.limit.max(2.0 * rounding[d.what]);
            }
        }
        self.first = self.over.iter().find(|d| d.is_over()).cloned();
        Self { rounding, ..self }
    }
}

/// Follows a case for `steps` steps, or to its end, and compares every `every`-th.
///
/// # Errors
/// When the case cannot become a model, or the device cannot hold it or is lost.
pub fn compare(
    case: &Case,
    device: &Device,
    steps: Option<u64>,
    every: u64,
    interrupt: &AtomicBool,
) -> Result<Comparison, RunError> {
    let mut lockstep = Lockstep::new(case, device)?;
    let all = (case.solver.end_time / lockstep.leader.model.dt).ceil() as u64 + 1;
    let count = steps.unwrap_or(all).min(all);
    while lockstep.leader.state.step < count && !interrupt.load(Ordering::Relaxed) {
        if lockstep.leader.state.step.is_multiple_of(every) {
            lockstep.compare_step()?;
        } else {
            let Twin { model, state, stepper, ledger, .. } = &mut lockstep.leader;
            stepper.step(model, state, ledger, false);
        }
    }
    lockstep.comparison.steps = lockstep.leader.state.step;
    Ok(lockstep.comparison.judged())
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
