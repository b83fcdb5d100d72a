//! Shot on a device: makes rows of the history of the results of a batch of steps.

use std::sync::Arc;

use super::record::RunRecord;
use super::{Observer, Skips};
use crate::case::Case;
use crate::gpu::DeviceError;
use crate::gpu::layout::{self, BODY_WORDS, BodyRecord, STATUS_WORDS, StepInfo, WorkgroupSums, status, sum};
use crate::gpu::stepper::DeviceStepper;
use crate::gpu::submission::BatchResult;
use crate::model::Model;
use crate::physics::rigid_body::RigidBody;
use crate::solver;
use crate::solver::energy_balance::PlyMoment;
use crate::solver::state::State;

/// A shot in progress.
pub(super) struct DeviceShot {
    pub(super) model: Arc<Model<f32>>,
    pub(super) record: RunRecord,
    /// Place on the device.
    number: usize,
    pub(super) ended: bool,
}

impl DeviceShot {
    /// A shot that begins from a state, at a place on the device.
    pub(super) fn new(number: usize, model: Arc<Model<f32>>, state: &State<f32>, skips: Skips) -> Self {
        let mut record = RunRecord::new(&model, state.body.as_ref(), skips);
        record.given = solver::state::given(&model, state);
        Self { model, record, number, ended: false }
    }

    /// Ends the run where the device gave up.
    pub(super) fn unless_lost(&mut self, done: Result<(), DeviceError>) {
        if let Err(error) = done {
            self.record.run.lost = Some(error.to_string());
            self.ended = true;
        }
    }

    /// Takes what is due of the state before a step, the first that was not sent off, from the positions at `time` [s].
    pub(super) fn read_state(
        &mut self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        case: &Case,
        observer: &mut dyn Observer,
        (step, time): (u64, f64),
    ) -> Result<(), DeviceError> {
        if self.record.needs_state(case, time) || observer.snapshot_due(time, self.model.dt) {
            self.download(stepper, state, step)?;
        }
        self.record.read_state(&self.model, state, case, observer, time);
        Ok(())
    }

    /// Takes the results of a batch of steps, sample by sample, up to the end of the run.
    pub(super) fn take(
        &mut self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        case: &Case,
        steps: &[StepInfo],
        result: &BatchResult,
    ) -> Result<(), DeviceError> {
        let bad = u64::from(result.status[status::BAD_STEP]);
        let mut events = result.events.iter().peekable();
        let sampled = steps.iter().filter(|s| s.slot.is_some());
        for (info, words) in sampled.zip(&result.samples) {
            if info.index >= bad || self.record.is_over_uninterrupted() {
                break;
            }
            while let Some(event) = events.next_if(|e| e.step <= info.index) {
                self.record.add_failures(std::slice::from_ref(event));
            }
            self.sample(stepper, state, case, info, words)?;
            self.record.run.steps = info.index + 1;
        }
        if self.record.is_over_uninterrupted() {
            return Ok(());
        }
        let done = steps.last().map_or(self.record.run.steps, |s| s.index + 1);
        self.record.run.steps = done.min(bad.saturating_add(1));
        events.for_each(|event| self.record.add_failures(std::slice::from_ref(event)));
        check_room(stepper, &result.status)?;
        if bad < u64::from(layout::NONE) {
            self.download(stepper, state, bad)?;
            self.record.diagnose(&self.model, state, ("kinetic energy", f64::NAN));
        }
        Ok(())
    }

    /// Reads the state after `steps` steps.
    pub(super) fn download(
        &self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        steps: u64,
    ) -> Result<(), DeviceError> {
        state.step = steps;
        stepper.download(self.number, &self.model, state)
    }

    /// Makes one row of the history of one sample.
    fn sample(
        &mut self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        case: &Case,
        info: &StepInfo,
        words: &[u32],
    ) -> Result<(), DeviceError> {
        let (sums, rest) = words.split_at(stepper.body_at());
        let (body, counters) = rest.split_at(BODY_WORDS);
        let (sums, count) = (WorkgroupSums(sums), self.model.plies.len());
        let origin = layout::device_origin(&self.model);
        let body = self.model.projectile.as_ref().map(|start| layout::read_body(body, start, &origin));
        self.take_counts(info.index, &sums, counters);
        self.take_energies(&sums, body.as_ref());
        let plies = (0..count).map(|ply| sums.ply(ply, count)).map(|sums| PlyMoment {
            kinetic: sums.add(sum::KINETIC_NOW),
            stored: sums.add(sum::STORED),
            deflection: sums.largest(sum::DEFLECTION),
        });
        self.record.balance.plies = plies.collect();
        let flight = body.as_ref().map(|record| (&record.body, record.before));
        let covered = |_: &RigidBody, ply: usize| sums.ply(ply, count).add(sum::COVERED) > 0.5;
        if self.record.sample(case, info.index as f64 * self.model.dt, flight, covered) {
            // This step is the last one that the device has done.
            self.download(stepper, state, info.index + 1)?;
            self.record.look(case, &self.model, state);
        }
        let kinetic = sums.add(sum::KINETIC) + solver::energy_balance::flying(body.as_ref().map(|record| &record.body));
        if let Some(excess) = solver::energy_balance::excess(&self.record.balance, kinetic, true) {
            // The place is looked for in the state as it is now, at most two batches later.
            if let Err(error) = self.download(stepper, state, info.index + 1) {
                self.record.run.lost = Some(error.to_string());
            }
            self.record.diagnose(&self.model, state, excess);
        }
        Ok(())
    }

    /// Takes over the counts of a sample after a step.
    fn take_counts(&mut self, step: u64, sums: &WorkgroupSums<'_>, counters: &[u32]) {
        let float = |word: usize| f64::from(f32::from_bits(counters[word]));
        self.record.evaluations[0] += sums.add(sum::EVALUATIONS);
        self.record.evaluations[1] += sums.add(sum::SOLVED);
        let run = &mut self.record.run;
        run.newton.unconverged = u64::from(counters[status::UNCONVERGED]);
        run.newton.max_residual = float(status::RESIDUAL);
        run.max_ply_penetration = float(status::PLY_DEPTH);
        // Without a projectile everything moves, or nothing ever does.
        run.element_steps_computed = match self.model.projectile {
            Some(_) => u64::from(counters[status::COMPUTED]) + (u64::from(counters[status::COMPUTED + 1]) << 32),
            None => (step + 1) * self.model.elements() as u64,
        };
        self.record.eroded = u64::from(counters[status::ERODED]);
    }

    /// Takes over the energies and momenta of a sample.
    fn take_energies(&mut self, sums: &WorkgroupSums<'_>, body: Option<&BodyRecord>) {
        let balance = &mut self.record.balance;
        balance.work += sums.add(sum::WORK);
        balance.viscous += sums.add(sum::VISCOUS);
        balance.released[0] += sums.add(sum::RELEASED);
        balance.released[1] += sums.add(sum::RELEASED_HOURGLASS);
        let separation = sums.add(sum::PLY_SEPARATION_WORK);
        balance.contact += sums.add(sum::PLY_LOSS) - sums.add(sum::PLY_RUBBED);
        balance.separation += separation;
        balance.friction += sums.add(sum::PLY_RUBBED);
        balance.work += separation;
        (balance.stored, balance.hourglass) = (sums.add(sum::STORED), sums.add(sum::HOURGLASS_NOW));
        (balance.max_tension, balance.max_load) = (sums.largest(sum::TENSION), sums.largest(sum::LOAD));
        (balance.law_energy, balance.kinetic) = (sums.add(sum::LAW), sums.add(sum::KINETIC_NOW));
        balance.momentum = [0, 1, 2].map(|a| sums.add(sum::MOMENTUM + a));
        for a in 0..3 {
            balance.support[a] += sums.add(sum::SUPPORT + a);
        }
        if let Some(b) = body {
            self.record.run.max_penetration = b.penetration;
            balance.contact += b.energy[0];
            balance.friction += b.energy[1];
            balance.external += b.energy[2];
            for a in 0..3 {
                balance.support[a] += b.support[a];
                balance.contact_impulse[a] -= b.impulse[a];
            }
            balance.sample_body(&b.body);
        }
    }
}

/// Checks that there was room for all that the projectile met.
fn check_room(stepper: &DeviceStepper<'_>, counters: &[u32; STATUS_WORDS]) -> Result<(), DeviceError> {
    let (adapter, sizes) = (stepper.device.name().to_owned(), stepper.sizes());
    match [status::OVERFLOW, status::OVERFLOW_EDGES].map(|at| counters[at]) {
        [0, 0] => Ok(()),
        [0, found] => Err(DeviceError::CrowdedEdge { adapter, found, room: sizes.constraints }),
        [found, _] => Err(DeviceError::Crowded { adapter, found, room: sizes.points }),
    }
}

#[cfg(test)]
#[path = "device_shot_tests.rs"]
mod tests;
