//! Run on the processor.

use std::borrow::Cow;
use std::io::{self, Write};
use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

use super::checkpoint::{self, BackendId, Checkpoint, Checkpointable, Header};
use super::record::RunRecord;
use super::{Backend, Observer, Options, Run, RunError, RunScalar, Skips, outcome, set_up};
use crate::case::{Case, CaseError};
use crate::model::Model;
use crate::physics::rigid_body::RigidBody;
use crate::solver::state::{ActiveRegion, State};
use crate::solver::{self, Phase, Stepper, StepperState, Stopwatch};

/// A run in progress on the processor.
pub struct Simulation<S: RunScalar> {
    /// Constant; of the part of the scene that is computed.
    pub model: Arc<Model<S>>,
    /// Varies; of the same part.
    pub state: State<S>,
    stepper: Stepper<S>,
    record: RunRecord,
    /// The last step was sampled.
    sampled: bool,
}

impl<S: RunScalar> Simulation<S> {
    /// Sets the whole scene of a case up.
    ///
    /// # Errors
    /// When the case cannot become a model, or the projectile starts inside the fabric.
    pub fn new(case: &Case) -> Result<Self, CaseError> {
        Self::with_skips(case, Skips::WHOLE)
    }

    /// Sets a case up with these skips.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn with_skips(case: &Case, skips: Skips) -> Result<Self, CaseError> {
        let (model, state) = set_up(case, skips)?;
        let (stepper, record) = (Stepper::new(&model), RunRecord::new(&model, state.body.as_ref(), skips));
        Ok(Self { stepper, record, model, state, sampled: false })
    }

    /// A run that begins, or goes on from a checkpoint.
    pub(super) fn open(case: &Case, options: &Options<'_>) -> Result<Self, RunError> {
        match options.from {
            Some(checkpoint) => Self::resume(case, checkpoint),
            None => Ok(Self::with_skips(case, options.skips)?),
        }
    }

    /// Time of the positions [s].
    pub fn time(&self) -> f64 {
        self.state.step as f64 * self.model.dt
    }

    /// Whether the run is over: the last step taken was a sample, so that the history ends at the end.
    pub fn finished(&self, case: &Case) -> bool {
        let time_up = self.state.step > 0 && self.time() - self.model.dt >= case.solver.end_time;
        self.sampled && (self.record.run.interrupted || self.record.is_over() || time_up)
    }

    /// One step; true if it was sampled.
    pub fn advance(&mut self, case: &Case) -> bool {
        pollster::block_on(Backend::advance(self, case, &mut ()))
    }

    /// Results. `loop_seconds`: time spent in the loop [s].
    pub fn into_run(self, loop_seconds: f64) -> Run {
        Run {
            backend: "cpu",
            threads: rayon::current_num_threads(),
            precision: S::NAME,
            kernel_seconds: self.stepper.stopwatch.seconds(),
            ..self.record.finish(&self.model, loop_seconds)
        }
    }
}

impl<S: RunScalar> Backend for Simulation<S> {
    fn is_finished(&self, case: &Case) -> bool {
        self.finished(case)
    }

    fn record(&mut self) -> &mut RunRecord {
        &mut self.record
    }

    async fn advance(&mut self, case: &Case, observer: &mut dyn Observer) -> bool {
        let time = self.time();
        self.record.read_state(&self.model, &self.state, case, observer, time);
        let sample = self.record.sample_due(case, time);
        let before = self.state.body.as_ref().map(|b| (b.velocity, b.position));
        if self.state.step == 0 {
            self.record.given = solver::state::given(&self.model, &self.state);
        }
        let totals = self.stepper.step(&self.model, &mut self.state, &mut self.record.balance, sample);
        self.record.add_step(&totals, &self.stepper.failures);
        self.record.run.steps = self.state.step;
        if sample {
            let (model, state) = (&self.model, &self.state);
            let covered = |body: &RigidBody, ply: usize| outcome::covered(model, state, body, ply);
            if self.record.sample(case, time, state.body.as_ref().zip(before), covered) {
                self.record.look(case, model, state);
            }
        }
        self.sampled = sample;
        // Numbers that are no longer finite, or energy that was never put in, end the run: kinetic, or at a sample of all kinds.
        let excess = self.record.balance.excess(totals.kinetic, self.state.body.as_ref(), sample);
        if let Some(excess) = excess.filter(|_| self.record.run.divergence.is_none()) {
            self.record.diagnose(&self.model, &self.state, excess);
        }
        self.stepper.stopwatch.lap(Phase::Record);
        sample
    }

    fn ready_for_checkpoint(&mut self, _: &Case) -> bool {
        self.state.step > 0
    }

    async fn show_end(&mut self, observer: &mut dyn Observer) {
        observer.on_end(&S::view(&self.model, &self.state));
    }

    fn finish(self, loop_seconds: f64) -> Run {
        self.into_run(loop_seconds)
    }
}

/// Everything that varies during a run on the processor.
#[derive(Serialize, Deserialize)]
#[serde(bound(serialize = "S: Serialize", deserialize = "S: Deserialize<'de>"))]
struct SimulationState<'a, S: Clone> {
    record: Cow<'a, RunRecord>,
    stepper: StepperState,
    stopwatch: Cow<'a, Stopwatch>,
    body: Option<BodyMotion>,
    active: Cow<'a, [ActiveRegion]>,
    nodes: Cow<'a, [S]>,
    elements: Cow<'a, [S]>,
    over: Cow<'a, [u32]>,
}

/// Position [m], orientation (i, j, k, w), velocity [m/s] and angular momentum [kg·m²/s] of the projectile.
type BodyMotion = ([f64; 3], [f64; 4], [f64; 3], [f64; 3]);

impl<S: RunScalar> Checkpointable for Simulation<S> {
    fn clock(&self) -> [f64; 2] {
        [self.time(), self.model.dt]
    }

    fn save(&self, header: &Header, observer: &[u8], to: &mut dyn Write) -> io::Result<()> {
        let header = Header { step: self.state.step, time: self.time(), time_step: self.model.dt, ..header.clone() };
        let motion = self.state.body.as_ref().map(|body| {
            (body.position.into(), body.orientation.coords.into(), body.velocity.into(), body.angular_momentum.into())
        });
        let state = SimulationState {
            record: Cow::Borrowed(&self.record),
            stepper: self.stepper.memory(),
            stopwatch: Cow::Borrowed(&self.stepper.stopwatch),
            body: motion,
            active: Cow::Borrowed(&self.state.active),
            nodes: Cow::Borrowed(&self.state.nodes.data),
            elements: Cow::Borrowed(&self.state.elements.data),
            over: Cow::Borrowed(&self.state.over),
        };
        checkpoint::write(to, &header, observer, &state)
    }
}

impl<S: RunScalar> Simulation<S> {
    /// A run that goes on from a checkpoint, bit by bit as the one that wrote it.
    ///
    /// # Errors
    /// When the case cannot become a model, or the checkpoint is not one of it.
    pub fn resume(case: &Case, checkpoint: &Checkpoint) -> Result<Self, RunError> {
        let from: SimulationState<'_, S> = checkpoint.state(case, &BackendId::Cpu(S::PRECISION))?;
        let mut simulation = Self::with_skips(case, checkpoint.header.skips)?;
        let Self { model, state, stepper, record, .. } = &mut simulation;
        *record = from.record.into_owned();
        stepper.remember(model, from.stepper);
        stepper.stopwatch = from.stopwatch.into_owned();
        if let (Some(body), Some((position, orientation, velocity, angular_momentum))) = (&mut state.body, from.body) {
            body.position = position.into();
            // As it was, to the last bit: it is not brought to unit length again.
            body.orientation = UnitQuaternion::new_unchecked(Quaternion::from(orientation));
            (body.velocity, body.angular_momentum) = (velocity.into(), angular_momentum.into());
        }
        state.step = checkpoint.header.step;
        state.active = from.active.into_owned();
        state.nodes.data.copy_from_slice(&from.nodes);
        state.elements.data.copy_from_slice(&from.elements);
        state.over = from.over.into_owned();
        Ok(simulation)
    }
}
