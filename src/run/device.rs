//! Run on a device: the loop over batches of steps, of one shot or of many that take the same steps.
//!
//! Nothing here depends on how many steps a batch has: which steps are sampled follows from time alone, sums are taken sample by sample,
//! and what a batch computed beyond the end of a run is dropped. Nor does a shot depend on the others that are computed with it.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use web_time::Instant;

use super::batch::DeviceShot;
use super::checkpoint::{self, BackendId, Checkpoint, Checkpointable, Header};
use super::record::{RunRecord, sample_due, time_up};
use super::{Backend, Observer, Options, Run, RunError, Skips, View, set_up};
use crate::case::Case;
use crate::gpu::buffers::{BufferId, SLOTS};
use crate::gpu::layout::StepInfo;
use crate::gpu::stepper::{BATCH, DeviceStepper};
use crate::gpu::submission::{Pending, StageTimes};
use crate::gpu::{Device, DeviceError};
use crate::model::Model;
use crate::solver::state::State;

/// Time that a batch of steps should take: long enough to hide its submission, short enough to follow progress and Ctrl-C.
const BATCH_TIME: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(80)];

/// Shots in progress on a device, by their numbers there; a run has one. Time step, end time and times of samples are the same in all of
/// them, and every call for many gets their cases.
pub struct DeviceSimulation<'a> {
    pub(super) stepper: DeviceStepper<'a>,
    pub(super) shots: Vec<DeviceShot>,
    /// State of a single shot at the start; after that the state read last.
    state: State<f32>,
    /// Steps on their way, the oldest first.
    pending: VecDeque<(Vec<StepInfo>, Pending)>,
    /// Next step to be sent off.
    next: u64,
    /// Last step sent that is sampled.
    sampled: Option<u64>,
    /// Steps of a batch.
    batch: usize,
    fixed_batch: bool,
    /// The last step of all is on its way.
    complete: bool,
    collected: Instant,
}

impl<'a> DeviceSimulation<'a> {
    /// Shots whose states are on the device.
    pub(super) fn of(stepper: DeviceStepper<'a>, shots: Vec<DeviceShot>, state: State<f32>) -> Self {
        Self {
            stepper,
            shots,
            state,
            pending: VecDeque::new(),
            next: 0,
            sampled: None,
            batch: 16,
            fixed_batch: false,
            complete: false,
            collected: Instant::now(),
        }
    }

    /// Begins again with other shots, whose states are on the device.
    pub(super) fn begin(&mut self, shots: Vec<DeviceShot>) {
        self.shots = shots;
        self.pending.clear();
        (self.next, self.sampled, self.complete) = (0, None, false);
    }

    /// Whether every shot is over.
    pub fn finished(&self) -> bool {
        self.running().next().is_none()
    }

    fn running(&self) -> impl Iterator<Item = (usize, &DeviceShot)> {
        self.shots.iter().enumerate().filter(|(_, shot)| !shot.ended)
    }

    fn dt(&self) -> f64 {
        self.shots.first().map_or(0.0, |shot| shot.model.dt)
    }

    fn time_of(&self, step: u64) -> f64 {
        step as f64 * self.dt()
    }

    /// Whether the state of any shot has to be read before the step from `time` [s].
    fn state_due(&self, cases: &[&Case], observer: &dyn Observer, time: f64) -> bool {
        observer.snapshot_due(time, self.dt())
            || self.running().any(|(number, shot)| shot.record.state_due(cases[number], time))
    }

    /// The steps of the next batch, whether the last of them ends the runs by time or request, and whether a state after it may
    /// have to be looked at.
    fn plan(&self, cases: &[&Case], observer: &dyn Observer) -> (Vec<StepInfo>, bool, bool) {
        let mut steps = Vec::with_capacity(self.batch);
        let (mut ends, mut looks) = (false, false);
        let Some((first, _)) = self.running().next() else { return (steps, ends, looks) };
        let (case, dt) = (cases[first], self.dt());
        let interrupted = self.running().any(|(_, shot)| shot.record.run.interrupted);
        let mut last = self.sampled;
        let mut slots = 0;
        while steps.len() < self.batch && slots < SLOTS && !ends && !looks {
            let index = self.next + steps.len() as u64;
            let time = self.time_of(index);
            if !steps.is_empty() && (self.state_due(cases, observer, time) || observer.checkpoint_due(time, dt)) {
                break; // the state is read before that step
            }
            let since = index - last.map_or(0, |l| l + 1) + 1;
            let last_time = last.map(|l| self.time_of(l));
            let sampled = sample_due(case, last_time, time, dt) || interrupted;
            steps.push(self.stepper.whole_step(index, sampled.then_some(slots), since as u32));
            if sampled {
                slots += 1;
                looks = self.running().any(|(number, shot)| shot.record.may_look(cases[number], last_time, time));
                last = Some(index);
                ends = interrupted || (index > 0 && time_up(case, time, dt));
            }
        }
        (steps, ends, looks)
    }

    /// Sends a batch of steps off, and takes over the one before it, which computed while this one was recorded. A failure of a single shot
    /// ends that one alone.
    pub(super) async fn advance_all(
        &mut self,
        cases: &[&Case],
        observer: &mut dyn Observer,
    ) -> Result<(), DeviceError> {
        let time = self.time_of(self.next);
        if !self.complete && self.state_due(cases, observer, time) {
            self.collect_all(cases).await?;
            let Self { stepper, shots, state, .. } = self;
            for (shot, case) in shots.iter_mut().zip(cases).filter(|(shot, _)| !shot.ended) {
                if shot.record.needs_state(case, time) || observer.snapshot_due(time, shot.model.dt) {
                    shot.download(stepper, state, self.next).await?;
                }
                shot.record.read_state(&shot.model, state, case, observer, time);
            }
        }
        // Nothing is sent off after a step whose state may have to be looked at before its sample is known.
        let mut waits = false;
        if !self.complete && !self.finished() {
            let (steps, ends, looks) = self.plan(cases, observer);
            self.complete = ends;
            waits = looks;
            self.next += steps.len() as u64;
            self.sampled = steps.iter().rev().find(|s| s.slot.is_some()).map(|s| s.index).or(self.sampled);
            let batch = self.stepper.submit(&steps);
            self.pending.push_back((steps, batch));
        }
        if waits {
            self.collect_all(cases).await?;
        } else if !self.finished() && (self.complete || self.pending.len() > 1) {
            self.collect(cases).await?;
        }
        Ok(())
    }

    async fn collect_all(&mut self, cases: &[&Case]) -> Result<(), DeviceError> {
        while !self.pending.is_empty() && !self.finished() {
            self.collect(cases).await?;
        }
        Ok(())
    }

    /// Takes over the oldest batch on its way.
    async fn collect(&mut self, cases: &[&Case]) -> Result<(), DeviceError> {
        let Some((steps, batch)) = self.pending.pop_front() else { return Ok(()) };
        let results = self.stepper.collect(&batch).await?;
        self.adapt(steps.len());
        let last = self.complete && self.pending.is_empty();
        let Self { stepper, shots, state, .. } = self;
        for result in &results {
            let shot = &mut shots[result.shot];
            if shot.ended {
                continue; // it ran on beyond its end
            }
            match shot.take(stepper, state, cases[result.shot], &steps, result).await {
                Err(lost @ DeviceError::Lost { .. }) => return Err(lost),
                taken => shot.unless_lost(taken),
            }
            shot.ended |= shot.record.is_over() || last;
        }
        let running: Vec<usize> = self.running().map(|(number, _)| number).collect();
        if !running.is_empty() && running.len() < self.stepper.running.len() {
            self.stepper.set_running(running);
        }
        Ok(())
    }

    /// Adapts the length of a batch to the time that the last one took.
    fn adapt(&mut self, steps: usize) {
        let spent = std::mem::replace(&mut self.collected, Instant::now()).elapsed();
        if self.fixed_batch || steps < self.batch {
            return;
        }
        match spent {
            short if short < BATCH_TIME[0] => self.batch = (2 * self.batch).min(BATCH),
            long if long > BATCH_TIME[1] => self.batch = (self.batch / 2).max(1),
            _ => {}
        }
    }

    /// Results of a shot. `loop_seconds`: time spent in the loop [s].
    pub(super) fn run_of(&self, number: usize, loop_seconds: f64) -> Run {
        // Timed steps only sample the run, its first ones are slow: all kernels together take no longer than the loop.
        let mut kernel_seconds = self.stepper.kernel_seconds();
        let total: f64 = kernel_seconds.iter().map(|(_, seconds)| seconds).sum();
        kernel_seconds.iter_mut().for_each(|(_, seconds)| *seconds *= (loop_seconds / total).min(1.0));
        let shot = &self.shots[number];
        Run {
            backend: "gpu",
            adapter: Some(self.stepper.device.name().to_owned()),
            threads: rayon::current_num_threads(),
            precision: "f32",
            host_seconds: Some((loop_seconds - self.stepper.waited.as_secs_f64()).max(0.0)),
            kernel_seconds,
            ..shot.record.clone().finish(&shot.model, loop_seconds)
        }
    }

    /// Sets a case up on a device with these skips.
    ///
    /// # Errors
    /// When the case cannot become a model, or the device cannot hold it.
    pub fn with_skips(case: &Case, device: &'a Device, skips: Skips) -> Result<Self, RunError> {
        let (model, state) = set_up::<f32>(case, skips)?;
        let shot = DeviceShot::new(0, Arc::clone(&model), &state, skips);
        let mut stepper = DeviceStepper::new(device, &model)?;
        stepper.upload(&model, &state);
        Ok(Self::of(stepper, vec![shot], state))
    }

    /// Steps per submission, fixed; results do not depend on it.
    #[must_use]
    pub fn with_batch(mut self, steps: usize) -> Self {
        (self.batch, self.fixed_batch) = (steps.clamp(1, BATCH), true);
        self
    }

    /// A run that begins, or goes on from a checkpoint.
    pub(super) fn open(case: &Case, device: &'a Device, options: &Options<'_>) -> Result<Self, RunError> {
        match options.from {
            Some(checkpoint) => Self::resume(case, device, checkpoint),
            None => Self::with_skips(case, device, options.skips),
        }
    }

    /// Steps whose results are known.
    pub fn steps(&self) -> u64 {
        self.shots[0].record.run.steps
    }

    /// The one shot there is.
    fn shot(&mut self) -> &mut DeviceShot {
        &mut self.shots[0]
    }

    /// Changes the state before the first batch, to one that no case can ask for.
    #[must_use]
    pub fn with_state(mut self, change: impl FnOnce(&Model<f32>, &mut State<f32>)) -> Self {
        let model = &self.shots[0].model;
        change(model, &mut self.state);
        self.stepper.upload(model, &self.state);
        self
    }

    /// Sends a batch off, and takes over the one before it, which computed while this one was recorded.
    pub fn advance(&mut self, case: &Case) {
        pollster::block_on(Backend::advance(self, case, &mut ()));
    }

    /// Takes over everything on its way, so that the record is up to date with the device.
    pub fn settle(&mut self, case: &Case) {
        let settled = pollster::block_on(self.collect_all(&[case]));
        self.shot().unless_lost(settled);
    }

    /// Results. `loop_seconds`: time spent in the loop [s].
    pub fn into_run(self, loop_seconds: f64) -> Run {
        self.run_of(0, loop_seconds)
    }
}

impl Backend for DeviceSimulation<'_> {
    fn is_finished(&self, _: &Case) -> bool {
        self.finished()
    }

    fn record(&mut self) -> &mut RunRecord {
        &mut self.shot().record
    }

    async fn advance(&mut self, case: &Case, observer: &mut dyn Observer) -> bool {
        let advanced = self.advance_all(&[case], observer).await;
        self.shot().unless_lost(advanced);
        true
    }

    fn ready_for_checkpoint(&mut self, case: &Case) -> bool {
        if self.complete || self.next == 0 {
            return false;
        }
        self.settle(case);
        !self.finished()
    }

    async fn show_end(&mut self, observer: &mut dyn Observer) {
        let Self { stepper, state, shots, next, .. } = self;
        let run = &shots[0].record.run;
        if run.steps != *next || run.lost.is_some() {
            return;
        }
        match shots[0].download(stepper, state, *next).await {
            Ok(()) => observer.on_end(&View::Single(&shots[0].model, state)),
            Err(error) => shots[0].record.run.lost = Some(error.to_string()),
        }
    }

    fn finish(self, loop_seconds: f64) -> Run {
        self.into_run(loop_seconds)
    }
}

/// Buffers that later steps depend on. The others hold nothing from one step to the next, but failures already read.
const KEPT: [BufferId; 9] = [
    BufferId::Nodes,
    BufferId::Cells,
    BufferId::Tiles,
    BufferId::ContactWork,
    BufferId::Status,
    BufferId::Supports,
    BufferId::Body,
    BufferId::Over,
    BufferId::Candidates,
];

/// Everything that varies during a run on a device. Buffers are saved as they are: the device counts energies between two samples, and has
/// positions of the projectile finer than any number of the host's state.
#[derive(Serialize, Deserialize)]
struct DeviceState<'a> {
    record: Cow<'a, RunRecord>,
    sampled: Option<u64>,
    events_read: u64,
    times: Cow<'a, StageTimes>,
    /// Time spent waiting for the device.
    waited: Duration,
    /// Bytes of each of [`KEPT`].
    buffers: Vec<Vec<u8>>,
}

impl Checkpointable for DeviceSimulation<'_> {
    fn clock(&self) -> [f64; 2] {
        [self.time_of(self.next), self.dt()]
    }

    /// After the last step sent off, whose results must have been taken over; see [`DeviceSimulation::settle`].
    fn save(&self, header: &Header, observer: &[u8], to: &mut dyn Write) -> io::Result<()> {
        let Self { stepper, next, sampled, shots, .. } = self;
        let [time, time_step] = self.clock();
        let header = Header { step: *next, time, time_step, ..header.clone() };
        let bytes =
            |id: &BufferId| pollster::block_on(stepper.read(*id)).map(|words| bytemuck::cast_slice(&words).to_vec());
        let state = DeviceState {
            record: Cow::Borrowed(&shots[0].record),
            sampled: *sampled,
            events_read: stepper.events_read[0],
            times: Cow::Borrowed(&stepper.times),
            waited: stepper.waited,
            buffers: KEPT.iter().map(bytes).collect::<Result<_, _>>().map_err(io::Error::other)?,
        };
        checkpoint::write(to, &header, observer, &state)
    }
}

impl<'a> DeviceSimulation<'a> {
    /// A run that goes on from a checkpoint, bit by bit as the one that wrote it.
    ///
    /// # Errors
    /// When the case cannot become a model, the device cannot hold it, or the checkpoint is not one of it.
    pub fn resume(case: &Case, device: &'a Device, checkpoint: &Checkpoint) -> Result<Self, RunError> {
        let from: DeviceState<'_> = checkpoint.state(case, &BackendId::Gpu(device.name().to_owned()))?;
        let mut simulation = Self::with_skips(case, device, checkpoint.header.skips)?;
        let Self { stepper, shots, .. } = &mut simulation;
        for (id, bytes) in KEPT.into_iter().zip(&from.buffers) {
            stepper.write(id, &bytemuck::pod_collect_to_vec::<u8, u32>(bytes));
        }
        shots[0].record = from.record.into_owned();
        stepper.events_read[0] = from.events_read;
        (stepper.times, stepper.waited) = (from.times.into_owned(), from.waited);
        (simulation.next, simulation.sampled) = (checkpoint.header.step, from.sampled);
        Ok(simulation)
    }
}
