//! Shots on a device, and batches of them: those that share mesh, constants and time step are computed together, each as if it were
//! alone. A shot makes rows of the history of the results of a batch of steps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use web_time::Instant;

use super::device::DeviceSimulation;
use super::record::RunRecord;
use super::{Run, Skips, set_up};
use crate::case::{Case, CaseError};
use crate::gpu::buffers::Sizes;
use crate::gpu::layout::{self, BODY_WORDS, BodyRecord, STATUS_WORDS, StepInfo, WorkgroupSums, status, sum};
use crate::gpu::shader::Kernel;
use crate::gpu::stepper::DeviceStepper;
use crate::gpu::submission::BatchResult;
use crate::gpu::{Device, DeviceError};
use crate::model::{Features, Model};
use crate::physics::rigid_body::RigidBody;
use crate::solver;
use crate::solver::contact::projectile_contact::ContactTotals;
use crate::solver::energy_balance::PlyMoment;
use crate::solver::state::State;

/// A shot that is ready to be computed.
#[derive(Debug)]
pub struct PreparedShot {
    /// Case of the shot.
    pub case: Case,
    model: Arc<Model<f32>>,
    /// Uniforms, features and times that all shots of a batch have in common.
    common: Vec<u8>,
}

impl PreparedShot {
    /// Sets a case up.
    ///
    /// # Errors
    /// When it cannot become a model.
    pub fn new(case: Case) -> Result<Self, CaseError> {
        let (model, _) = set_up::<f32>(&case, Skips::default())?;
        let sizes = Sizes::new(&model);
        let features: Vec<Features> = model.ply_types.chunks(1).map(|own| Features::new(&model, own)).collect();
        let times = [model.dt, case.solver.end_time, case.output.history_interval];
        let mut common = format!("{features:?} {times:?}").into_bytes();
        common.extend_from_slice(bytemuck::cast_slice(&layout::plies(&model)));
        common.extend_from_slice(bytemuck::cast_slice(&layout::lines(&model)));
        for (at, ply_type) in model.ply_types.iter().enumerate() {
            common.extend_from_slice(bytemuck::bytes_of(&layout::scene(&model, at, &sizes)));
            common.extend_from_slice(bytemuck::cast_slice(&layout::law_energy(ply_type)));
        }
        Ok(Self { case, model, common })
    }

    /// Whether it can be computed together with another.
    pub(crate) fn fits(&self, other: &Self) -> bool {
        self.common == other.common
    }

    /// Largest batch of such shots that a device holds in `memory` bytes.
    pub fn room(&self, device: &Device, memory: u64) -> u64 {
        Sizes::new(&self.model).most_shots(&device.limits(), memory)
    }
}

/// Pipelines and buffers for batches of shots that are computed together.
pub struct DeviceBatch<'a> {
    common: Vec<u8>,
    simulation: DeviceSimulation<'a>,
}

impl<'a> DeviceBatch<'a> {
    /// For `room` shots at a time like this one.
    ///
    /// # Errors
    /// When the device cannot hold them.
    pub fn new(device: &'a Device, shot: &PreparedShot, room: u64) -> Result<Self, DeviceError> {
        let stepper = DeviceStepper::with_sources(device, &shot.model, room, &Kernel::source)?;
        let state = State::new(&shot.case, &shot.model);
        Ok(Self { common: shot.common.clone(), simulation: DeviceSimulation::of(stepper, Vec::new(), state) })
    }

    /// Whether it has room for `count` shots like this one.
    pub fn takes(&self, shot: &PreparedShot, count: usize) -> bool {
        self.common == shot.common && count as u64 <= self.room()
    }

    /// Most shots that there is room for at a time.
    pub fn room(&self) -> u64 {
        self.simulation.stepper.sizes.shots
    }

    /// Memory that it takes on the device [bytes].
    pub fn bytes(&self) -> u64 {
        self.simulation.stepper.sizes.planned()
    }

    /// Computes shots that it takes. `ended` gets the run of each, with its place among them, as soon as it has ended; false ends the others,
    /// as does the user. True where all have ended.
    ///
    /// # Errors
    /// When the device was lost; a failure of a single shot is in its run.
    pub fn fire(
        &mut self,
        shots: &[PreparedShot],
        interrupt: &AtomicBool,
        ended: &mut dyn FnMut(usize, &Run) -> bool,
    ) -> Result<bool, DeviceError> {
        self.begin(shots)?;
        let cases: Vec<&Case> = shots.iter().map(|shot| &shot.case).collect();
        let start = Instant::now();
        let mut reported = vec![false; shots.len()];
        while reported.contains(&false) {
            if interrupt.load(Ordering::Relaxed) {
                return Ok(false);
            }
            pollster::block_on(self.simulation.advance_all(&cases, &mut ()))?;
            for (number, reported) in reported.iter_mut().enumerate() {
                if *reported || !self.simulation.shots[number].ended {
                    continue;
                }
                *reported = true;
                if !ended(number, &self.simulation.run_of(number, start.elapsed().as_secs_f64())) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Puts the states of shots on the device.
    fn begin(&mut self, shots: &[PreparedShot]) -> Result<(), DeviceError> {
        let stepper = &mut self.simulation.stepper;
        stepper.clear_shots();
        let mut begun = Vec::with_capacity(shots.len());
        for (number, shot) in shots.iter().enumerate() {
            let state = State::new(&shot.case, &shot.model);
            stepper.upload_shot(number, &shot.model, &state);
            // What is on its way lies in memory twice: not that of all shots at once.
            stepper.flush()?;
            begun.push(DeviceShot::new(number, Arc::clone(&shot.model), &state, Skips::default()));
        }
        stepper.set_running((0..shots.len()).collect());
        self.simulation.begin(begun);
        Ok(())
    }
}

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

    /// Takes the results of a batch of steps, sample by sample, up to the end of the run.
    pub(super) async fn take(
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
            if info.index >= bad || self.record.is_over() {
                break;
            }
            self.record.add_failures(std::iter::from_fn(|| events.next_if(|e| e.step <= info.index)));
            self.sample(stepper, state, case, info, words).await?;
            self.record.run.steps = info.index + 1;
        }
        if self.record.is_over() {
            return Ok(());
        }
        let done = steps.last().map_or(self.record.run.steps, |s| s.index + 1);
        self.record.run.steps = done.min(bad.saturating_add(1));
        self.record.add_failures(events);
        check_room(stepper.device.name(), &stepper.sizes, &result.status)?;
        if bad < u64::from(layout::NONE) {
            // The bad step wrote its slot, and no later one wrote the other.
            self.download(stepper, state, bad + 1).await?;
            state.step = bad;
            self.record.diagnose(&self.model, state, ("kinetic energy", f64::NAN));
        }
        Ok(())
    }

    /// Reads the state after `steps` steps.
    pub(super) async fn download(
        &self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        steps: u64,
    ) -> Result<(), DeviceError> {
        state.step = steps;
        stepper.download(self.number, &self.model, state).await
    }

    /// Makes one row of the history of one sample.
    async fn sample(
        &mut self,
        stepper: &DeviceStepper<'_>,
        state: &mut State<f32>,
        case: &Case,
        info: &StepInfo,
        words: &[u32],
    ) -> Result<(), DeviceError> {
        let (sums, rest) = words.split_at(stepper.sizes.sample_words() - STATUS_WORDS - BODY_WORDS);
        let (body, counters) = rest.split_at(BODY_WORDS);
        let (sums, count) = (WorkgroupSums(sums), self.model.plies.len());
        let origin = layout::device_origin(&self.model);
        let body = self.model.projectile.as_ref().map(|start| layout::read_body(body, start, &origin));
        self.take_counts(info.index, &sums, counters);
        self.take_energies(&sums, body.as_ref());
        let plies = (0..count).map(|ply| sums.ply(ply, count)).map(|sums| PlyMoment {
            kinetic: sums.add(sum::KINETIC) + sums.add(sum::HALF_STEP),
            stored: sums.add(sum::STORED),
            deflection: sums.largest(sum::DEFLECTION),
        });
        self.record.balance.plies = plies.collect();
        let flight = body.as_ref().map(|record| (&record.body, record.before));
        let covered = |_: &RigidBody, ply: usize| sums.ply(ply, count).add(sum::COVERED) > 0.5;
        if self.record.sample(case, info.index as f64 * self.model.dt, flight, covered) {
            // This step is the last one that the device has done.
            self.download(stepper, state, info.index + 1).await?;
            self.record.look(case, &self.model, state);
        }
        let body = body.as_ref().map(|record| &record.body);
        if let Some(excess) = self.record.balance.excess(sums.add(sum::KINETIC), body, true) {
            // The place is looked for in the state as it is now, at most two batches later.
            self.download(stepper, state, info.index + 1).await?;
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
        let [of_body, half_of_body] = body.map_or([0.0; 2], |record| record.work);
        let half_step = sums.add(sum::HALF_STEP) + half_of_body;
        balance.work += balance.half_step + sums.add(sum::WORK) + of_body - half_step;
        balance.half_step = half_step;
        balance.viscous += sums.add(sum::VISCOUS_WORK);
        balance.law_released += sums.add(sum::LAW_RELEASED);
        balance.released[0] += sums.add(sum::RELEASED);
        balance.released[1] += sums.add(sum::RELEASED_HOURGLASS);
        let separation = sums.add(sum::PLY_SEPARATION_WORK);
        balance.contact += sums.add(sum::PLY_LOSS) - sums.add(sum::PLY_FRICTION_WORK);
        balance.separation += separation;
        balance.friction += sums.add(sum::PLY_FRICTION_WORK);
        balance.work += separation;
        (balance.stored, balance.hourglass) = (sums.add(sum::STORED), sums.add(sum::HOURGLASS_NOW));
        (balance.max_tension, balance.max_load) = (sums.largest(sum::TENSION), sums.largest(sum::LOAD));
        (balance.law_energy, balance.kinetic) = (sums.add(sum::LAW_MADE), sums.add(sum::KINETIC) + half_step);
        balance.backing += sums.add(sum::CLAY_WORK);
        balance.crater = sums.largest(sum::CLAY_DEPTH);
        balance.momentum = [0, 1, 2].map(|a| sums.add(sum::MOMENTUM + a));
        for a in 0..3 {
            balance.support[a] += sums.add(sum::SUPPORT + a);
        }
        if let Some(b) = body {
            self.record.run.max_penetration = b.penetration;
            let [dissipation, friction, external] = b.energy;
            let (impulse, support) = (b.impulse, b.support);
            balance.add_contact(&ContactTotals { dissipation, friction, external, impulse, support });
            balance.sample_body(&b.body);
        }
    }
}

/// Points of the edge that met a ply when there was no room for them.
const EDGE_POINTS: &str = "points of the projectile's edge and a ply";

/// Checks that there was room for all that the projectile met.
fn check_room(adapter: &str, sizes: &Sizes, counters: &[u32; STATUS_WORDS]) -> Result<(), DeviceError> {
    let nodes = (counters[status::OVERFLOW], "nodes and the projectile", sizes.points);
    let edges = (counters[status::OVERFLOW_EDGES], EDGE_POINTS, sizes.constraints);
    match [nodes, edges].into_iter().find(|(found, ..)| *found > 0) {
        Some((found, what, room)) => Err(DeviceError::Crowded { adapter: adapter.to_owned(), what, found, room }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    #[test]
    fn what_has_no_room_is_said_by_name() -> Result<(), Box<dyn std::error::Error>> {
        let sizes = Sizes::new(&Model::new(&case::shipped(&["/solver/contact_sampling=edges"]))?);
        let [room, points] = [sizes.constraints, sizes.points];
        assert!(room > 20 && points > room);
        // Counters of a batch in which nothing else went wrong.
        let check = |found: [u32; 2]| {
            let mut counters = BatchResult::default().status;
            [counters[status::OVERFLOW], counters[status::OVERFLOW_EDGES]] = found;
            check_room("noop", &sizes, &counters)
        };
        let crowded = |what, found, room| Err(DeviceError::Crowded { adapter: "noop".into(), what, found, room });
        assert_eq!(check([0, 0]), Ok(()));
        assert_eq!(check([0, 999]), crowded(EDGE_POINTS, 999, room));
        assert_eq!(check([9999, 999]), crowded("nodes and the projectile", 9999, points));
        Ok(())
    }
}
