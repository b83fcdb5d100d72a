//! The host loop of the GPU backend: plans batches, keeps the ledger, follows the projectile, ends the run.
//!
//! Nothing here depends on how many steps a batch has: which steps are sampled follows from time alone, sums are
//! taken sample by sample, and what a batch computed beyond the end of the run is dropped.

mod samples;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Vector3;
use tracing::debug;

use crate::case::Case;
use crate::gpu::buffers::SLOTS;
use crate::gpu::layout::StepInfo;
use crate::gpu::stepper::{BATCH, DeviceStepper, Pending};
use crate::gpu::{Device, DeviceError};
use crate::model::Model;
use crate::run::backend::Backend;
use crate::run::due::{sample_due, time_up};
use crate::run::pieces;
use crate::run::profile;
use crate::run::record::{Environment, RunRecord};
use crate::run::{Observer, Options, Progress, Run, RunError, Skips, View};
use crate::solver;
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::state::State;

/// How long a batch should take: long enough to hide its submission, short enough to follow progress and Ctrl-C.
const BATCH_TIME: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(80)];

/// A run in progress on a device.
pub struct DeviceSimulation<'a> {
    /// Constant; of the part of the scene that is computed.
    pub model: Arc<Model<f32>>,
    /// The state at the start, and after a batch that asked for it.
    state: State<f32>,
    pub(super) stepper: DeviceStepper<'a>,
    pub(super) balance: EnergyBalance,
    pub(super) record: RunRecord,
    given: (f64, Vector3<f64>),
    /// Batches on their way with their steps, the oldest first.
    pending: VecDeque<(Vec<StepInfo>, Pending)>,
    /// Next step to be sent off, and the last one sent that is sampled.
    pub(super) next: u64,
    pub(super) sampled: Option<u64>,
    /// Steps whose results are known.
    pub(super) step: u64,
    batch: usize,
    fixed_batch: bool,
    /// The last step of the run is on its way.
    complete: bool,
    ended: bool,
    collected: Instant,
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
        let (model, mut state) = solver::set_up::<f32>(case, skips.symmetry)?;
        if !skips.wavefront {
            state.reach_everything(&model);
        }
        let mut record = RunRecord::new(&model, state.body.as_ref());
        record.skips = skips;
        let mut stepper = DeviceStepper::new(device, &model)?;
        stepper.upload(&model, &state);
        debug!(adapter = device.name(), bytes = stepper.sizes().total(), "state on the device");
        Ok(Self {
            given: solver::given(&model, &state),
            record,
            balance: EnergyBalance::of_part(model.planes),
            model: Arc::new(model),
            state,
            stepper,
            pending: VecDeque::new(),
            next: 0,
            sampled: None,
            step: 0,
            batch: 16,
            fixed_batch: false,
            complete: false,
            ended: false,
            collected: Instant::now(),
        })
    }

    /// Steps per submission, fixed; results do not depend on it.
    #[must_use]
    pub fn with_batch(mut self, steps: usize) -> Self {
        self.batch = steps.clamp(1, BATCH);
        self.fixed_batch = true;
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
        self.ended
    }

    /// Steps whose results are known.
    pub fn steps(&self) -> u64 {
        self.step
    }

    pub(super) fn time_of(&self, step: u64) -> f64 {
        step as f64 * self.model.dt
    }

    /// Changes the state before the first batch: what no case can ask for.
    #[must_use]
    pub fn with_state(mut self, change: impl FnOnce(&Model<f32>, &mut State<f32>)) -> Self {
        change(&self.model, &mut self.state);
        self.stepper.upload(&self.model, &self.state);
        self
    }

    /// Whether the state has to be read before the step from `time` [s].
    fn state_due(&self, case: &Case, watch: &dyn Observer, time: f64) -> bool {
        self.record.profile_due(case, time, self.model.dt)
            || self.record.deflection_due(case, time, self.model.dt)
            || watch.snapshot_due(time, self.model.dt)
    }

    /// The steps of the next batch, whether the last of them ends the run by time or request, and whether the state after it may
    /// have to be looked at.
    fn plan(&self, case: &Case, watch: &dyn Observer) -> (Vec<StepInfo>, bool, bool) {
        let dt = self.model.dt;
        let mut last = self.sampled;
        let mut slots = 0;
        let mut steps = Vec::with_capacity(self.batch);
        let (mut ends, mut looks) = (false, false);
        while steps.len() < self.batch && slots < SLOTS && !ends && !looks {
            let index = self.next + steps.len() as u64;
            let time = self.time_of(index);
            if !steps.is_empty() && (self.state_due(case, watch, time) || watch.checkpoint_due(time, dt)) {
                break; // the state is read before that step
            }
            let since = index - last.map_or(0, |l| l + 1) + 1;
            let sampled = sample_due(case, last.map(|l| self.time_of(l)), time, dt) || self.record.interrupted;
            let slot = sampled.then_some(slots);
            steps.push(self.stepper.whole_step(index, slot, since as u32));
            if sampled {
                slots += 1;
                looks = self.record.may_look(case, last.map(|l| self.time_of(l)), time, dt);
                last = Some(index);
                ends = self.record.interrupted || (index > 0 && time_up(case, time, dt));
            }
        }
        (steps, ends, looks)
    }

    /// Sends a batch off, and takes over the one before it, which computed while this one was recorded.
    pub fn advance(&mut self, case: &Case) {
        Backend::advance(self, case, &mut ());
    }

    /// Ends the run where the device gave up.
    fn unless_lost(&mut self, done: Result<(), DeviceError>) {
        if let Err(error) = done {
            self.record.lost = Some(error.to_string());
            self.ended = true;
        }
    }

    fn try_advance(&mut self, case: &Case, watch: &mut dyn Observer) -> Result<(), DeviceError> {
        let time = self.time_of(self.next);
        if !self.complete && self.state_due(case, watch, time) {
            self.read_state(case, watch, time)?;
        }
        // Nothing is sent off after a step whose state may have to be looked at before its sample is known.
        let mut waits = false;
        if !self.complete && !self.ended {
            let (steps, ends, looks) = self.plan(case, watch);
            self.complete = ends;
            waits = looks;
            self.next += steps.len() as u64;
            self.sampled = steps.iter().rev().find(|s| s.slot.is_some()).map(|s| s.index).or(self.sampled);
            let batch = self.stepper.submit(&steps);
            self.pending.push_back((steps, batch));
        }
        if waits {
            self.collect_all(case)?;
        } else if !self.ended && (self.complete || self.pending.len() > 1) {
            self.collect(case)?;
        }
        Ok(())
    }

    /// Takes what is due of the state before the step from `time` [s], unless the run is over by then.
    fn read_state(&mut self, case: &Case, watch: &mut dyn Observer, time: f64) -> Result<(), DeviceError> {
        self.collect_all(case)?;
        if self.ended {
            return Ok(());
        }
        let dt = self.model.dt;
        let [profile, watched] = [self.record.profile_due(case, time, dt), watch.snapshot_due(time, dt)];
        // Fabric that has not failed hangs together; nobody needs to see it for that.
        if profile || watched || self.record.has_failures() {
            self.stepper.download(&self.model, &mut self.state)?;
            self.state.step = self.next;
        }
        if profile {
            self.record.profiles.push(profile::take(&self.model, &self.state, case, time));
        }
        if self.record.deflection_due(case, time, dt) {
            let (model, state) = (&self.model, &self.state);
            self.record.look_at_deflection(case, time, dt, |ply| pieces::hanging(model, state, ply));
        }
        if watched {
            watch.on_snapshot(&View::Single(&self.model, &self.state));
        }
        Ok(())
    }

    /// Takes over everything on its way, so that nothing but the device knows more than the run.
    pub fn settle(&mut self, case: &Case) {
        let settled = self.collect_all(case);
        self.unless_lost(settled);
    }

    fn collect_all(&mut self, case: &Case) -> Result<(), DeviceError> {
        while !self.pending.is_empty() && !self.ended {
            self.collect(case)?;
        }
        Ok(())
    }

    /// Takes over the oldest batch on its way.
    fn collect(&mut self, case: &Case) -> Result<(), DeviceError> {
        let Some((steps, batch)) = self.pending.pop_front() else { return Ok(()) };
        let result = self.stepper.collect(&batch)?;
        self.adapt(steps.len());
        self.take(case, &steps, &result)?;
        self.ended |= self.record.over_but_interrupted() || (self.complete && self.pending.is_empty());
        Ok(())
    }

    fn adapt(&mut self, steps: usize) {
        let spent = self.collected.elapsed();
        self.collected = Instant::now();
        if self.fixed_batch || steps < self.batch {
            return;
        }
        if spent < BATCH_TIME[0] {
            self.batch = (2 * self.batch).min(BATCH);
        } else if spent > BATCH_TIME[1] {
            self.batch = (self.batch / 2).max(1);
        }
    }

    /// The result. `loop_seconds`: time spent in the loop [s].
    pub fn into_run(self, loop_seconds: f64) -> Run {
        // Timed steps only sample the run, its first ones are slow: all kernels together take no longer than the loop.
        let mut kernel_seconds = self.stepper.kernel_seconds();
        let total: f64 = kernel_seconds.iter().map(|(_, seconds)| seconds).sum();
        for (_, seconds) in &mut kernel_seconds {
            *seconds *= (loop_seconds / total).min(1.0);
        }
        let machine = Environment {
            backend: "gpu",
            adapter: Some(self.stepper.device.name().to_owned()),
            threads: rayon::current_num_threads(),
            precision: "f32",
            loop_seconds,
            host_seconds: Some((loop_seconds - self.stepper.waited().as_secs_f64()).max(0.0)),
            kernel_seconds,
        };
        self.record.into_run(&self.model, self.step, machine)
    }
}

impl Backend for DeviceSimulation<'_> {
    fn is_finished(&self, _: &Case) -> bool {
        self.ended
    }

    fn next_time(&self) -> f64 {
        self.time_of(self.next)
    }

    fn time_step(&self) -> f64 {
        self.model.dt
    }

    fn record(&mut self) -> &mut RunRecord {
        &mut self.record
    }

    fn advance(&mut self, case: &Case, watch: &mut dyn Observer) -> bool {
        let advanced = self.try_advance(case, watch);
        self.unless_lost(advanced);
        true
    }

    fn show_end(&mut self, watch: &mut dyn Observer) {
        if self.step != self.next || self.record.lost.is_some() {
            return;
        }
        match self.stepper.download(&self.model, &mut self.state) {
            Ok(()) => {
                self.state.step = self.next;
                watch.on_end(&View::Single(&self.model, &self.state));
            }
            Err(error) => self.record.lost = Some(error.to_string()),
        }
    }

    fn keep(&mut self, case: &Case, watch: &mut dyn Observer, loop_seconds: f64) {
        if self.complete || self.next == 0 {
            return;
        }
        self.settle(case);
        if !self.ended {
            watch.on_checkpoint(self, loop_seconds);
        }
    }

    fn progress(&self, case: &Case) -> Progress {
        self.record.progress(case, self.time_of(self.step), self.step, self.model.whole_elements())
    }

    fn finish(self, loop_seconds: f64) -> Run {
        self.into_run(loop_seconds)
    }
}

#[cfg(test)]
mod tests;
