//! The host loop of the GPU backend: plans batches of steps, keeps the ledger, follows the projectile, ends the run.
//!
//! Nothing here depends on how many steps a batch has: which steps are sampled follows from time alone, sums are
//! taken sample by sample, and what a batch computed beyond the end of a run is dropped. Nor does a shot depend on the others that are
//! computed with it: `device_loop` drives one or many, `samples` makes the history of each.

mod device_loop;
mod samples;
mod shots;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tracing::debug;

use crate::case::Case;
use crate::gpu::Device;
use crate::gpu::stepper::DeviceStepper;
use crate::model::Model;
use crate::run::backend::Backend;
use crate::run::checkpoint::LoopClock;
use crate::run::record::RunRecord;
use crate::run::{Observer, Options, Progress, Run, RunError, Skips, View, drive};
use crate::solver;
use crate::solver::state::State;
pub(super) use device_loop::DeviceLoop;
use samples::DeviceShot;
pub use shots::{DeviceBatch, DeviceUse, PreparedShot};

/// Runs a case on a device.
pub(super) fn run(
    case: &Case,
    device: &Device,
    options: &Options<'_>,
    clock: &LoopClock,
    interrupt: &AtomicBool,
    watch: &mut dyn Observer,
) -> Result<Run, RunError> {
    Ok(drive(DeviceSimulation::open(case, device, options)?, case, clock, interrupt, watch))
}

/// A run in progress on a device.
pub struct DeviceSimulation<'a> {
    /// Constant; of the part of the scene that is computed.
    pub model: Arc<Model<f32>>,
    pub(super) device_loop: DeviceLoop<'a>,
}

impl<'a> DeviceSimulation<'a> {
    /// Sets the whole scene of a case up on a device.
    ///
    /// # Errors
    /// When the case cannot become a model or the device cannot hold it.
    pub fn new(case: &Case, device: &'a Device) -> Result<Self, RunError> {
        Self::with_skips(case, device, Skips::WHOLE)
    }

    /// Sets a case up on a device without what `skips` leaves out.
    ///
    /// # Errors
    /// As [`DeviceSimulation::new`].
    pub fn with_skips(case: &Case, device: &'a Device, skips: Skips) -> Result<Self, RunError> {
        let (model, mut state) = solver::state::set_up::<f32>(case, skips.symmetry)?;
        if !skips.wavefront {
            state.reach_everything(&model);
        }
        let model = Arc::new(model);
        let mut shot = DeviceShot::new(0, Arc::clone(&model), &state);
        shot.record.skips = skips;
        let mut stepper = DeviceStepper::new(device, &model)?;
        stepper.upload(&model, &state);
        debug!(adapter = device.name(), bytes = stepper.sizes().total(), "state on the device");
        Ok(Self { model, device_loop: DeviceLoop::new(stepper, vec![shot], state) })
    }

    /// Steps per submission, fixed; results do not depend on it.
    #[must_use]
    pub fn with_batch(mut self, steps: usize) -> Self {
        self.device_loop.fix_batch(steps);
        self
    }

    /// A run that begins, or goes on from a checkpoint.
    pub(super) fn open(case: &Case, device: &'a Device, options: &Options<'_>) -> Result<Self, RunError> {
        match options.from {
            Some(checkpoint) => Self::resume(case, device, checkpoint),
            None => Self::with_skips(case, device, options.skips),
        }
    }

    /// Whether the run is over.
    pub fn finished(&self) -> bool {
        self.device_loop.finished()
    }

    /// Steps whose results are known.
    pub fn steps(&self) -> u64 {
        self.shot().step
    }

    /// The one shot there is.
    pub(super) fn shot(&self) -> &DeviceShot {
        &self.device_loop.shots[0]
    }

    pub(super) fn shot_mut(&mut self) -> &mut DeviceShot {
        &mut self.device_loop.shots[0]
    }

    /// Changes the state before the first batch: what no case can ask for.
    #[must_use]
    pub fn with_state(mut self, change: impl FnOnce(&Model<f32>, &mut State<f32>)) -> Self {
        let DeviceLoop { stepper, state, .. } = &mut self.device_loop;
        change(&self.model, state);
        stepper.upload(&self.model, state);
        self
    }

    /// Sends a batch off, and takes over the one before it, which computed while this one was recorded.
    pub fn advance(&mut self, case: &Case) {
        Backend::advance(self, case, &mut ());
    }

    /// Takes over everything on its way, so that nothing but the device knows more than the run.
    pub fn settle(&mut self, case: &Case) {
        let settled = self.device_loop.collect_all(&[case]);
        self.shot_mut().unless_lost(settled);
    }

    /// The result. `loop_seconds`: time spent in the loop [s].
    pub fn into_run(self, loop_seconds: f64) -> Run {
        self.device_loop.run_of(0, loop_seconds)
    }
}

impl Backend for DeviceSimulation<'_> {
    fn is_finished(&self, _: &Case) -> bool {
        self.finished()
    }

    fn next_time(&self) -> f64 {
        self.device_loop.time_of(self.device_loop.next)
    }

    fn time_step(&self) -> f64 {
        self.model.dt
    }

    fn record(&mut self) -> &mut RunRecord {
        &mut self.shot_mut().record
    }

    fn advance(&mut self, case: &Case, watch: &mut dyn Observer) -> bool {
        let advanced = self.device_loop.advance(&[case], watch);
        self.shot_mut().unless_lost(advanced);
        true
    }

    fn show_end(&mut self, watch: &mut dyn Observer) {
        if self.shot().step != self.device_loop.next || self.shot().record.lost.is_some() {
            return;
        }
        let DeviceLoop { stepper, state, next, .. } = &mut self.device_loop;
        match stepper.download(0, &self.model, state) {
            Ok(()) => {
                state.step = *next;
                watch.on_end(&View::Single(&self.model, state));
            }
            Err(error) => self.shot_mut().record.lost = Some(error.to_string()),
        }
    }

    fn keep(&mut self, case: &Case, watch: &mut dyn Observer, loop_seconds: f64) {
        if self.device_loop.complete || self.device_loop.next == 0 {
            return;
        }
        self.settle(case);
        if !self.finished() {
            watch.on_checkpoint(self, loop_seconds);
        }
    }

    fn progress(&self, case: &Case) -> Progress {
        let shot = self.shot();
        shot.record.progress(case, self.device_loop.time_of(shot.step), shot.step, self.model.whole_elements())
    }

    fn finish(self, loop_seconds: f64) -> Run {
        self.into_run(loop_seconds)
    }
}

#[cfg(test)]
#[path = "graphics_tests.rs"]
mod tests;
