//! The loop itself, of one shot or of many that take the same steps.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::case::Case;
use crate::gpu::DeviceError;
use crate::gpu::buffers::SLOTS;
use crate::gpu::layout::StepInfo;
use crate::gpu::stepper::{BATCH, DeviceStepper};
use crate::gpu::submission::Pending;
use crate::run::due::{sample_due, time_up};
use crate::run::record::Environment;
use crate::run::{Observer, Run};
use crate::solver::state::State;

use super::samples::DeviceShot;

/// How long a batch of steps should take: long enough to hide its submission, short enough to follow progress and Ctrl-C.
const BATCH_TIME: [Duration; 2] = [Duration::from_millis(20), Duration::from_millis(80)];

/// Shots in progress on a device, by their numbers there. Cases are given to every call, one for each shot; time step, end time and times of
/// samples are the same in all of them.
pub(crate) struct DeviceLoop<'a> {
    pub(crate) stepper: DeviceStepper<'a>,
    pub(crate) shots: Vec<DeviceShot>,
    /// Of a single shot at the start; after that of whichever was asked for last.
    pub(super) state: State<f32>,
    /// Steps on their way, the oldest first.
    pending: VecDeque<(Vec<StepInfo>, Pending)>,
    /// Next step to be sent off, and the last one sent that is sampled.
    pub(crate) next: u64,
    pub(crate) sampled: Option<u64>,
    dt: f64,
    batch: usize,
    fixed_batch: bool,
    /// The last step of all is on its way.
    pub(super) complete: bool,
    collected: Instant,
}

impl<'a> DeviceLoop<'a> {
    /// Shots whose states are on the device.
    pub(super) fn new(stepper: DeviceStepper<'a>, shots: Vec<DeviceShot>, state: State<f32>) -> Self {
        Self {
            dt: shots.first().map_or(0.0, |shot| shot.model.dt),
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
        self.dt = shots.first().map_or(0.0, |shot| shot.model.dt);
        self.shots = shots;
        self.pending.clear();
        (self.next, self.sampled, self.complete) = (0, None, false);
    }

    /// Steps per submission, fixed.
    pub(super) fn fix_batch(&mut self, steps: usize) {
        self.batch = steps.clamp(1, BATCH);
        self.fixed_batch = true;
    }

    /// Whether every shot is over.
    pub(super) fn finished(&self) -> bool {
        self.running().next().is_none()
    }

    fn running(&self) -> impl Iterator<Item = (usize, &DeviceShot)> {
        self.shots.iter().enumerate().filter(|(_, shot)| !shot.ended)
    }

    pub(crate) fn time_of(&self, step: u64) -> f64 {
        step as f64 * self.dt
    }

    /// Whether the state of any shot has to be read before the step from `time` [s].
    fn state_due(&self, cases: &[&Case], watch: &dyn Observer, time: f64) -> bool {
        watch.snapshot_due(time, self.dt)
            || self.running().any(|(number, shot)| shot.state_due(cases[number], time, self.dt))
    }

    /// The steps of the next batch, whether the last of them ends the runs by time or request, and whether a state after it may
    /// have to be looked at.
    fn plan(&self, cases: &[&Case], watch: &dyn Observer) -> (Vec<StepInfo>, bool, bool) {
        let mut steps = Vec::with_capacity(self.batch);
        let (mut ends, mut looks) = (false, false);
        let Some((first, _)) = self.running().next() else { return (steps, ends, looks) };
        let (case, dt) = (cases[first], self.dt);
        let interrupted = self.running().any(|(_, shot)| shot.record.interrupted);
        let mut last = self.sampled;
        let mut slots = 0;
        while steps.len() < self.batch && slots < SLOTS && !ends && !looks {
            let index = self.next + steps.len() as u64;
            let time = self.time_of(index);
            if !steps.is_empty() && (self.state_due(cases, watch, time) || watch.checkpoint_due(time, dt)) {
                break; // the state is read before that step
            }
            let since = index - last.map_or(0, |l| l + 1) + 1;
            let last_time = last.map(|l| self.time_of(l));
            let sampled = sample_due(case, last_time, time, dt) || interrupted;
            steps.push(self.stepper.whole_step(index, sampled.then_some(slots), since as u32));
            if sampled {
                slots += 1;
                looks = self.running().any(|(number, shot)| shot.record.may_look(cases[number], last_time, time, dt));
                last = Some(index);
                ends = interrupted || (index > 0 && time_up(case, time, dt));
            }
        }
        (steps, ends, looks)
    }

    /// Sends a batch of steps off, and takes over the one before it, which computed while this one was recorded.
    ///
    /// # Errors
    /// When the device was lost. What goes wrong with a single shot ends that one alone.
    pub(super) fn advance(&mut self, cases: &[&Case], watch: &mut dyn Observer) -> Result<(), DeviceError> {
        let time = self.time_of(self.next);
        if !self.complete && self.state_due(cases, watch, time) {
            self.read_states(cases, watch, time)?;
        }
        // Nothing is sent off after a step whose state may have to be looked at before its sample is known.
        let mut waits = false;
        if !self.complete && !self.finished() {
            let (steps, ends, looks) = self.plan(cases, watch);
            self.complete = ends;
            waits = looks;
            self.next += steps.len() as u64;
            self.sampled = steps.iter().rev().find(|s| s.slot.is_some()).map(|s| s.index).or(self.sampled);
            let batch = self.stepper.submit(&steps);
            self.pending.push_back((steps, batch));
        }
        if waits {
            self.collect_all(cases)?;
        } else if !self.finished() && (self.complete || self.pending.len() > 1) {
            self.collect(cases)?;
        }
        Ok(())
    }

    /// Takes what is due of the states before the step from `time` [s], of shots that are not over by then.
    fn read_states(&mut self, cases: &[&Case], watch: &mut dyn Observer, time: f64) -> Result<(), DeviceError> {
        self.collect_all(cases)?;
        let Self { stepper, shots, state, .. } = self;
        for (number, shot) in shots.iter_mut().enumerate().filter(|(_, shot)| !shot.ended) {
            shot.read_state(stepper, state, cases[number], watch, (self.next, time))?;
        }
        Ok(())
    }

    pub(super) fn collect_all(&mut self, cases: &[&Case]) -> Result<(), DeviceError> {
        while !self.pending.is_empty() && !self.finished() {
            self.collect(cases)?;
        }
        Ok(())
    }

    /// Takes over the oldest batch on its way.
    fn collect(&mut self, cases: &[&Case]) -> Result<(), DeviceError> {
        let Some((steps, batch)) = self.pending.pop_front() else { return Ok(()) };
        let results = self.stepper.collect(&batch)?;
        self.adapt(steps.len());
        let last = self.complete && self.pending.is_empty();
        let Self { stepper, shots, state, .. } = self;
        for result in &results {
            let shot = &mut shots[result.shot];
            if shot.ended {
                continue; // it ran on beyond its end
            }
            match shot.take(stepper, state, cases[result.shot], &steps, result) {
                Err(lost @ DeviceError::Lost { .. }) => return Err(lost),
                taken => shot.unless_lost(taken),
            }
            shot.ended |= shot.record.over_but_interrupted() || last;
        }
        let running: Vec<usize> = self.running().map(|(number, _)| number).collect();
        if !running.is_empty() && running.len() < self.stepper.running.len() {
            self.stepper.set_running(running);
        }
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

    /// The result of a shot. `loop_seconds`: time spent in the loop [s].
    pub(super) fn run_of(&self, number: usize, loop_seconds: f64) -> Run {
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
            host_seconds: Some((loop_seconds - self.stepper.waited.as_secs_f64()).max(0.0)),
            kernel_seconds,
        };
        let shot = &self.shots[number];
        shot.record.clone().into_run(&shot.model, shot.step, machine)
    }
}
