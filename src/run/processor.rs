//! A run on the processor.

use std::sync::Arc;

use nalgebra::Vector3;

use super::backend::Backend;
use super::record::{Environment, RunRecord, SampleInput};
use super::{Observer, Options, Progress, Run, RunError, RunScalar, Skips, View, outcome, pieces, profile};
use crate::case::Case;
use crate::model::{Model, ModelError};
use crate::solver::divergence::{diagnose, excess, flying};
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::state::State;
use crate::solver::state::{Given, given, set_up};
use crate::solver::stopwatch::Phase;
use crate::solver::{StepTotals, Stepper};

/// A run in progress on the processor.
pub struct Simulation<S: RunScalar> {
    /// Constant; of the part of the scene that is computed.
    pub model: Arc<Model<S>>,
    /// Varies; as the model.
    pub state: State<S>,
    pub(crate) stepper: Stepper<S>,
    pub(crate) balance: EnergyBalance,
    pub(crate) record: RunRecord,
    sampled: bool,
}

impl<S: RunScalar> Simulation<S> {
    /// Sets the whole scene of a case up.
    ///
    /// # Errors
    /// When the case cannot become a model, or the projectile starts inside the fabric.
    pub fn new(case: &Case) -> Result<Self, ModelError> {
        Self::with_skips(case, Skips::WHOLE)
    }

    /// Sets a case up without what `skips` leaves out.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn with_skips(case: &Case, skips: Skips) -> Result<Self, ModelError> {
        let (model, mut state) = set_up::<S>(case, skips.symmetry)?;
        if !skips.wavefront {
            state.reach_everything(&model);
        }
        let mut record = RunRecord::new(&model, state.body.as_ref());
        record.skips = skips;
        Ok(Self {
            stepper: Stepper::new(&model),
            record,
            balance: EnergyBalance::of_part(model.planes),
            model: Arc::new(model),
            state,
            sampled: false,
        })
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

    /// What a watcher sees.
    pub fn view(&self) -> View<'_> {
        S::view(&self.model, &self.state)
    }

    /// Whether the run is over: the last step taken was a sample, so that the history ends at the end.
    pub fn finished(&self, case: &Case) -> bool {
        let time_up = self.state.step > 0 && self.time() - self.model.dt >= case.solver.end_time;
        self.sampled && (self.record.over() || time_up)
    }

    /// One step; true if it was sampled.
    pub fn advance(&mut self, case: &Case) -> bool {
        let time = self.time();
        if self.record.profile_due(case, time, self.model.dt) {
            self.record.profiles.push(profile::take(&self.model, &self.state, case, time));
        }
        if self.record.deflection_due(case, time, self.model.dt) {
            let (model, state) = (&self.model, &self.state);
            self.record.look_at_deflection(case, time, model.dt, |ply| pieces::hanging(model, state, ply));
        }
        let sample = self.record.sample_due(case, time, self.model.dt);
        let before = self.state.body.as_ref().map(|b| (b.velocity, b.position));
        let given = if self.state.step == 0 { given(&self.model, &self.state) } else { Given::default() };
        let totals = self.stepper.step(&self.model, &mut self.state, &mut self.balance, sample);
        self.record.add_step(&totals, &self.stepper.failures);
        if self.record.history.is_empty() {
            self.balance.begin(given);
        }
        if sample {
            let impulse = Vector3::from(std::mem::take(&mut self.balance.contact_impulse));
            let moment = SampleInput {
                time,
                dt: self.model.dt,
                balance: self.balance.balance(),
                impulse,
                plies: self.balance.plies(),
                body: self.state.body.as_ref().zip(before),
            };
            let (model, state) = (&self.model, &self.state);
            let in_doubt = self.record.sample(case, &moment, |body, ply| outcome::covered(model, state, body, ply));
            if let Some(body) = state.body.as_ref().filter(|_| in_doubt) {
                self.record.look(case, body, |ply, speed| outcome::is_held(model, state, body, ply, speed));
            }
        }
        self.sampled = sample;
        self.watch(&totals, sample);
        self.stepper.stopwatch.lap(Phase::Record);
        sample
    }

    /// Stops a run whose numbers are no longer finite or whose energy was never put in: kinetic, or at a sample of all kinds.
    fn watch(&mut self, totals: &StepTotals, sample: bool) {
        if self.record.divergence.is_some() {
            return;
        }
        let kinetic = totals.kinetic + flying(self.state.body.as_ref());
        let excess = excess(&self.balance, kinetic, sample);
        let (model, state, available) = (&self.model, &self.state, self.balance.accounted_energy());
        self.record.divergence = excess.map(|excess| diagnose(model, state, excess, available));
    }

    /// The result. `loop_seconds`: time spent in the loop [s].
    pub fn into_run(self, loop_seconds: f64) -> Run {
        let machine = Environment {
            backend: "cpu",
            adapter: None,
            threads: rayon::current_num_threads(),
            precision: S::NAME,
            loop_seconds,
            host_seconds: None,
            kernel_seconds: self.stepper.stopwatch.seconds(),
        };
        self.record.into_run(&self.model, self.state.step, machine)
    }
}

impl<S: RunScalar> Backend for Simulation<S> {
    fn is_finished(&self, case: &Case) -> bool {
        self.finished(case)
    }

    fn next_time(&self) -> f64 {
        self.time()
    }

    fn time_step(&self) -> f64 {
        self.model.dt
    }

    fn record(&mut self) -> &mut RunRecord {
        &mut self.record
    }

    fn advance(&mut self, case: &Case, watch: &mut dyn Observer) -> bool {
        if watch.snapshot_due(self.time(), self.model.dt) {
            watch.on_snapshot(&self.view());
        }
        Self::advance(self, case)
    }

    fn keep(&mut self, _: &Case, watch: &mut dyn Observer, loop_seconds: f64) {
        if self.state.step > 0 {
            watch.on_checkpoint(self, loop_seconds);
        }
    }

    fn show_end(&mut self, watch: &mut dyn Observer) {
        watch.on_end(&self.view());
    }

    fn progress(&self, case: &Case) -> Progress {
        self.record.progress(case, self.time(), self.state.step, self.model.whole_elements())
    }

    fn finish(self, loop_seconds: f64) -> Run {
        self.into_run(loop_seconds)
    }
}
