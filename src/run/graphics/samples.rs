//! One shot on a device: what a batch of steps left behind of it becomes rows of its history.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::case::Case;
use crate::gpu::DeviceError;
use crate::gpu::layout::{self, BODY_WORDS, BodyRecord, STATUS_WORDS, StepInfo, WorkgroupSums, status, sum};
use crate::gpu::stepper::DeviceStepper;
use crate::gpu::submission::BatchResult;
use crate::model::Model;
use crate::run::record::{RunRecord, SampleInput};
use crate::run::{Observer, View, outcome, pieces, profile};
use crate::solver::energy_balance::{EnergyBalance, PlyMoment};
use crate::solver::state::Given;
use crate::solver::state::State;
use crate::solver::{divergence, state as solver_state};

/// A shot in progress.
pub(crate) struct DeviceShot {
    pub(crate) model: Arc<Model<f32>>,
    pub(crate) balance: EnergyBalance,
    pub(crate) record: RunRecord,
    given: Given,
    /// Its place on the device.
    number: usize,
    /// Steps whose results are known.
    pub(crate) step: u64,
    pub(super) ended: bool,
}

impl DeviceShot {
    /// A shot that begins from a state, at a place on the device.
    pub(super) fn new(number: usize, model: Arc<Model<f32>>, state: &State<f32>) -> Self {
        Self {
            balance: EnergyBalance::of_part(model.planes),
            record: RunRecord::new(&model, state.body.as_ref()),
            given: solver_state::given(&model, state),
            number,
            step: 0,
            ended: false,
            model,
        }
    }

    /// Ends the run where the device gave up.
    pub(super) fn unless_lost(&mut self, done: Result<(), DeviceError>) {
        if let Err(error) = done {
            self.record.lost = Some(error.to_string());
            self.ended = true;
        }
    }

    /// Whether its state has to be read before the step from `time` [s].
    pub(super) fn state_due(&self, case: &Case, time: f64, dt: f64) -> bool {
        self.record.profile_due(case, time, dt) || self.record.deflection_due(case, time, dt)
    }

    /// Takes what is due of the state before a step, the first that was not sent off, from the positions at `time` [s].
    pub(super) fn read_state(
        &mut self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        case: &Case,
        watch: &mut dyn Observer,
        (step, time): (u64, f64),
    ) -> Result<(), DeviceError> {
        let (model, dt) = (&self.model, self.model.dt);
        let [profile, watched] = [self.record.profile_due(case, time, dt), watch.snapshot_due(time, dt)];
        // Fabric that has not failed hangs together; nobody needs to see it for that.
        if profile || watched || self.record.has_failures() {
            self.download(stepper, state, step)?;
        }
        if profile {
            self.record.profiles.push(profile::take(model, state, case, time));
        }
        if self.record.deflection_due(case, time, dt) {
            self.record.look_at_deflection(case, time, dt, |ply| pieces::hanging(model, state, ply));
        }
        if watched {
            watch.on_snapshot(&View::Single(model, state));
        }
        Ok(())
    }

    /// Takes over what a batch of steps left behind, sample by sample, up to the end of the run.
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
            if info.index >= bad || self.record.over_but_interrupted() {
                break;
            }
            while let Some(event) = events.next_if(|e| e.step <= info.index) {
                self.record.add_failures(std::slice::from_ref(event));
            }
            self.sample(stepper, state, case, info, words)?;
            self.step = info.index + 1;
        }
        if self.record.over_but_interrupted() {
            return Ok(());
        }
        self.step = steps.last().map_or(self.step, |s| s.index + 1).min(bad.saturating_add(1));
        events.for_each(|event| self.record.add_failures(std::slice::from_ref(event)));
        check_room(stepper, &result.status)?;
        if bad < u64::from(layout::NONE) {
            self.download(stepper, state, bad)?;
            self.diagnose(state, ("kinetic energy", f64::NAN));
        }
        Ok(())
    }

    /// Reads the state after so many steps.
    fn download(&self, stepper: &DeviceStepper<'_>, state: &mut State<f32>, steps: u64) -> Result<(), DeviceError> {
        stepper.download(self.number, &self.model, state)?;
        state.step = steps;
        Ok(())
    }

    fn diagnose(&mut self, state: &State<f32>, excess: (&str, f64)) {
        let available = self.balance.accounted_energy();
        self.record.divergence = Some(divergence::diagnose(&self.model, state, excess, available));
    }

    /// One row of the history from one sample.
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
        let sums = WorkgroupSums(sums);
        let body =
            self.model.projectile.as_ref().map(|p| layout::read_body(body, p, &layout::device_origin(&self.model)));
        self.take_counts(info.index, &sums, counters);
        self.take_energies(&sums, body.as_ref());
        let (record, ledger) = (&mut self.record, &mut self.balance);
        if record.history.is_empty() {
            ledger.begin(self.given);
        }
        let count = self.model.plies.len();
        let plies: Vec<PlyMoment> = (0..count)
            .map(|ply| sums.ply(ply, count))
            .map(|sums| PlyMoment {
                kinetic: sums.add(sum::KINETIC_NOW),
                stored: sums.add(sum::STORED),
                deflection: sums.largest(sum::DEFLECTION),
            })
            .collect();
        let moment = SampleInput {
            time: info.index as f64 * self.model.dt,
            dt: self.model.dt,
            balance: ledger.balance(),
            plies: &plies,
            impulse: Vector3::from(std::mem::take(&mut ledger.contact_impulse)),
            body: body.as_ref().map(|b| (&b.body, b.before)),
        };
        let in_doubt = record.sample(case, &moment, |_, ply| sums.ply(ply, count).add(sum::COVERED) > 0.5);
        if in_doubt {
            self.look(stepper, state, case, info.index)?;
        }
        let kinetic = sums.add(sum::KINETIC) + divergence::flying(body.as_ref().map(|b| &b.body));
        if let Some(excess) = divergence::excess(&self.balance, kinetic, true) {
            // The place is looked for in the state as it is now, at most two batches later.
            state.step = info.index + 1;
            if let Err(error) = stepper.download(self.number, &self.model, state) {
                self.record.lost = Some(error.to_string());
            }
            self.diagnose(state, excess);
        }
        Ok(())
    }

    /// Takes over the counts of a sample after a step.
    fn take_counts(&mut self, step: u64, sums: &WorkgroupSums<'_>, counters: &[u32]) {
        let record = &mut self.record;
        record.newton[0] += sums.add(sum::EVALUATIONS);
        record.newton[1] += sums.add(sum::SOLVED);
        record.unconverged = u64::from(counters[status::UNCONVERGED]);
        record.max_residual = f64::from(f32::from_bits(counters[status::RESIDUAL]));
        record.eroded = u64::from(counters[status::ERODED]);
        record.max_penetration[1] = f64::from(f32::from_bits(counters[status::PLY_DEPTH]));
        // Without a projectile everything moves, or nothing ever does.
        record.computed = match self.model.projectile {
            Some(_) => u64::from(counters[status::COMPUTED]) + (u64::from(counters[status::COMPUTED + 1]) << 32),
            None => (step + 1) * self.model.elements() as u64,
        };
    }

    /// Takes over its energies and momenta.
    fn take_energies(&mut self, sums: &WorkgroupSums<'_>, body: Option<&BodyRecord>) {
        let ledger = &mut self.balance;
        ledger.work += sums.add(sum::WORK);
        ledger.viscous += sums.add(sum::VISCOUS);
        ledger.released[0] += sums.add(sum::RELEASED);
        ledger.released[1] += sums.add(sum::RELEASED_HOURGLASS);
        let separation = sums.add(sum::PLY_SEPARATION_WORK);
        ledger.contact += sums.add(sum::PLY_LOSS) - sums.add(sum::PLY_RUBBED);
        ledger.separation += separation;
        ledger.friction += sums.add(sum::PLY_RUBBED);
        ledger.work += separation;
        ledger.elements_are(sums.add(sum::STORED), sums.add(sum::HOURGLASS_NOW), sums.largest(sum::TENSION));
        ledger.cells_are(sums.add(sum::LAW), sums.largest(sum::LOAD));
        ledger.nodes_are(sums.add(sum::KINETIC_NOW), [0, 1, 2].map(|a| sums.add(sum::MOMENTUM + a)));
        for a in 0..3 {
            ledger.support[a] += sums.add(sum::SUPPORT + a);
        }
        if let Some(b) = body {
            self.record.max_penetration[0] = b.penetration;
            ledger.contact += b.energy[0];
            ledger.friction += b.energy[1];
            ledger.external += b.energy[2];
            for a in 0..3 {
                ledger.support[a] += b.support[a];
                ledger.contact_impulse[a] -= b.impulse[a];
            }
            ledger.sample_body(&b.body);
        }
    }

    /// A closer look at what covers the projectile after a step, the last one the device has done.
    fn look(
        &mut self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        case: &Case,
        step: u64,
    ) -> Result<(), DeviceError> {
        self.download(stepper, state, step + 1)?;
        if let Some(body) = &state.body {
            self.record.look(case, body, |ply, speed| outcome::is_held(&self.model, state, body, ply, speed));
        }
        Ok(())
    }
}

/// Whether there was room for all that the projectile met.
fn check_room(stepper: &DeviceStepper<'_>, counters: &[u32; STATUS_WORDS]) -> Result<(), DeviceError> {
    let (adapter, sizes) = (stepper.device.name().to_owned(), stepper.sizes());
    match [status::OVERFLOW, status::OVERFLOW_EDGES].map(|at| counters[at]) {
        [0, 0] => Ok(()),
        [0, found] => Err(DeviceError::CrowdedEdge { adapter, found, room: sizes.constraints }),
        [found, _] => Err(DeviceError::Crowded { adapter, found, room: sizes.points }),
    }
}
