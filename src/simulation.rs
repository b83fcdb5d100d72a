//! The host loop: drives the steps, samples history, watches the numbers, decides when a run ends.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use nalgebra::Vector3;

use crate::case::{Case, RunUntil};
use crate::lanes::Lanes;
use crate::ledger::{Balance, Ledger};
use crate::model::{Model, ModelError};
use crate::number::Scalar;
use crate::outcome::{self, Outcome, Tracker};
use crate::profile::{self, Profile};
use crate::state::State;
use crate::step::{self, FailureEvent, Stepper, Trouble};

/// Number type of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Double, the reference.
    F64,
    /// Single.
    F32,
}

/// How to run a case.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Worker threads; `None` takes all cores.
    pub threads: Option<usize>,
    /// Number type.
    pub precision: Precision,
}

/// Why a run did not start.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RunError {
    /// The case cannot become a model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The thread pool could not be made.
    #[error("cannot start {threads} worker threads: {reason}")]
    Threads {
        /// Asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

/// One row of the history, at a time of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// [s]
    pub time: f64,
    /// Along the line of flight [m/s].
    pub projectile_velocity: f64,
    /// Along the line of flight [m].
    pub projectile_displacement: f64,
    /// Mean since the last row, along the line of flight [N].
    pub contact_force: f64,
    /// Energies.
    pub balance: Balance,
    /// Warp and weft failures so far.
    pub failed: [u64; 2],
    /// Elements eroded so far.
    pub eroded: u64,
    /// Largest |z displacement| of standing fabric [m].
    pub deflection: f64,
}

/// Where a run is, for the progress bar.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// [s]
    pub time: f64,
    /// [s]
    pub end_time: f64,
    /// [m/s]
    pub velocity: f64,
    /// Yarns failed.
    pub failed: u64,
    /// Steps done.
    pub steps: u64,
    /// Elements.
    pub elements: usize,
}

/// Newton statistics of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NewtonStatistics {
    /// Largest residual over the breaking tension of the weaker yarn [-].
    pub max_residual: f64,
    /// Residual evaluations per cell and step.
    pub mean_iterations: f64,
    /// Cells that did not meet the residual, summed over steps.
    pub unconverged: u64,
}

/// Everything a run produced.
#[derive(Clone, Debug)]
pub struct Run {
    /// Verdict.
    pub outcome: Outcome,
    /// When the projectile came to rest [s].
    pub stop_time: Option<f64>,
    /// History, ascending in time; the last row is the last state.
    pub history: Vec<Sample>,
    /// Yarn failures in order of step, ply, row, column.
    pub events: Vec<FailureEvent>,
    /// Deflection profiles asked for.
    pub profiles: Vec<Profile>,
    /// Kinetic energy the projectile came with [J]; the first row of the history is after first contact.
    pub impact_energy: f64,
    /// Largest penetration of a node into the projectile [m].
    pub max_penetration: f64,
    /// Largest |energy error| [-].
    pub energy_error: f64,
    /// Largest momentum error [-].
    pub momentum_error: f64,
    /// Largest hourglass energy over the largest internal energy [-].
    pub hourglass_fraction: f64,
    /// Unit-cell solver.
    pub newton: NewtonStatistics,
    /// Elements.
    pub elements: usize,
    /// Steps done.
    pub steps: u64,
    /// [s]
    pub time_step: f64,
    /// What set it.
    pub step_set_by: &'static str,
    /// Time in the loop [s].
    pub loop_seconds: f64,
    /// Worker threads.
    pub threads: usize,
    /// `f64` or `f32`.
    pub precision: &'static str,
    /// What went wrong, if the run became unstable.
    pub trouble: Option<Trouble>,
    /// Stopped by the user.
    pub interrupted: bool,
}

/// Runs a case on the CPU.
///
/// # Errors
/// When the case cannot become a model; a run that becomes unstable is a [`Run`] with `trouble`.
pub fn run(
    case: &Case,
    options: Options,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&Progress) + Send),
) -> Result<Run, RunError> {
    let threads = options.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| RunError::Threads { threads, reason: e.to_string() })?;
    pool.install(|| match options.precision {
        Precision::F64 => run_as::<f64>(case, interrupt, progress),
        Precision::F32 => run_as::<f32>(case, interrupt, progress),
    })
}

fn run_as<S: Scalar>(
    case: &Case,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&Progress) + Send),
) -> Result<Run, RunError> {
    let mut simulation = Simulation::<S>::new(case)?;
    let start = Instant::now();
    while !simulation.finished(case) {
        if interrupt.load(Ordering::Relaxed) {
            simulation.interrupted = true;
        }
        if simulation.advance(case) {
            progress(&simulation.progress(case));
        }
    }
    Ok(simulation.into_run(start.elapsed().as_secs_f64()))
}

/// Numbers processed at once by the kernels.
const WIDTH: usize = 4;

/// A run in progress.
pub struct Simulation<S: Scalar> {
    /// Constant.
    pub model: Model<S>,
    /// Varies.
    pub state: State<S>,
    stepper: Stepper<Lanes<S, WIDTH>>,
    ledger: Ledger,
    tracker: Option<Tracker>,
    history: Vec<Sample>,
    events: Vec<FailureEvent>,
    profiles: Vec<Profile>,
    newton: [f64; 2],
    unconverged: u64,
    max_residual: f64,
    failed: [u64; 2],
    eroded: u64,
    max_penetration: f64,
    momentum_error: f64,
    energy_error: f64,
    impact_energy: f64,
    sampled: bool,
    decided: bool,
    interrupted: bool,
    trouble: Option<Trouble>,
}

impl<S: Scalar> Simulation<S> {
    /// Sets a case up.
    ///
    /// # Errors
    /// When the case cannot become a model, or the projectile starts inside the fabric.
    pub fn new(case: &Case) -> Result<Self, ModelError> {
        let model = Model::<S>::new(case)?;
        let state = State::new(case, &model);
        check_start(&model, &state)?;
        let tracker = state.body.as_ref().map(|b| Tracker::new(b, case.fabric.areal_density));
        let impact_energy = state.body.as_ref().map_or(0.0, |b| b.kinetic_energy());
        Ok(Self {
            stepper: Stepper::new(&model),
            model,
            state,
            ledger: Ledger::default(),
            tracker,
            history: Vec::new(),
            events: Vec::new(),
            profiles: Vec::new(),
            newton: [0.0; 2],
            unconverged: 0,
            max_residual: 0.0,
            failed: [0; 2],
            eroded: 0,
            max_penetration: 0.0,
            momentum_error: 0.0,
            energy_error: 0.0,
            impact_energy,
            sampled: false,
            decided: false,
            interrupted: false,
            trouble: None,
        })
    }

    /// Time of the positions [s].
    pub fn time(&self) -> f64 {
        self.state.step as f64 * self.model.dt
    }

    /// Whether the run is over: the last step taken was a sample, so that the history ends at the end.
    pub fn finished(&self, case: &Case) -> bool {
        let over = self.trouble.is_some() || self.interrupted || self.decided;
        let time_up = self.state.step > 0 && self.time() - self.model.dt >= case.solver.end_time;
        self.sampled && (over || time_up)
    }

    /// One step; true if it was sampled.
    pub fn advance(&mut self, case: &Case) -> bool {
        let time = self.time();
        let profile = self.profile_due(case, time);
        let sample = self.sample_due(case, time);
        if profile {
            self.profiles.push(profile::take(&self.model, &self.state, case, time));
        }
        let before = self.state.body.as_ref().map(|b| (b.velocity, b.position));
        let energy = if self.state.step == 0 { self.given(case) } else { (0.0, Vector3::zeros()) };
        let totals = self.stepper.step(&self.model, &mut self.state, &mut self.ledger, sample);
        self.newton[0] += totals.iterations;
        self.newton[1] += totals.solved;
        self.unconverged += totals.unconverged;
        self.max_residual = self.max_residual.max(totals.max_residual);
        self.max_penetration = self.max_penetration.max(totals.penetration);
        self.eroded += totals.eroded;
        for f in &self.stepper.failures {
            self.failed[usize::from(f.yarn)] += 1;
        }
        self.events.extend_from_slice(&self.stepper.failures);
        if self.history.is_empty() {
            self.ledger.begin(energy.0, energy.1);
        }
        if sample {
            self.record(case, time, before);
        }
        self.sampled = sample;
        self.watch(&totals);
        sample
    }

    /// Kinetic energy and momentum the scene starts with.
    fn given(&self, case: &Case) -> (f64, Vector3<f64>) {
        let grid = &self.model.grid;
        let mut energy = 0.0;
        let mut momentum = Vector3::zeros();
        if case.pack.initial_velocity != [0.0; 3] {
            for row in 0..grid.node_rows() {
                let mass = self.model.row_mass(grid.node_row(row).1);
                for column in 0..=grid.columns {
                    let v = Vector3::from(self.state.velocity(row, column));
                    let m = mass.mass[column].to_f64();
                    energy += 0.5 * m * v.norm_squared();
                    momentum += v * m;
                }
            }
        }
        if let Some(body) = self.state.body.as_ref().filter(|b| !b.prescribed) {
            energy += body.kinetic_energy();
            momentum += body.velocity * body.mass;
        }
        (energy, momentum)
    }

    fn sample_due(&self, case: &Case, time: f64) -> bool {
        let next = self.history.last().map_or(0.0, |s| {
            // The next multiple of the interval after the last row.
            let rows = (s.time / case.output.history_interval + 1e-9).floor() + 1.0;
            rows * case.output.history_interval
        });
        let slack = 1e-6 * self.model.dt;
        let last = time >= case.solver.end_time - slack;
        time >= next - slack || last || self.interrupted || self.trouble.is_some()
    }

    fn profile_due(&self, case: &Case, time: f64) -> bool {
        let next = case.output.profile_times.get(self.profiles.len());
        next.is_some_and(|t| time >= t - 0.5 * self.model.dt)
    }

    fn record(&mut self, case: &Case, time: f64, before: Option<(Vector3<f64>, Vector3<f64>)>) {
        let balance = self.ledger.balance();
        let mut row = Sample {
            time,
            balance,
            failed: self.failed,
            eroded: self.eroded,
            deflection: self.stepper.max_deflection(),
            ..Sample::default()
        };
        let impulse = Vector3::from(std::mem::take(&mut self.ledger.contact_impulse));
        let since = time - self.history.last().map_or(0.0, |s| s.time);
        if let (Some(body), Some((velocity, position))) = (&self.state.body, before) {
            // The mean of the half-step velocities around this time; at the very start, the velocity given.
            let now = if self.history.is_empty() { velocity } else { (velocity + body.velocity) * 0.5 };
            row.projectile_velocity = now.dot(&body.flight);
            row.projectile_displacement = (position - body.start).dot(&body.flight);
            row.contact_force = impulse.dot(&body.flight) / if since > 0.0 { since } else { self.model.dt };
        }
        self.energy_error = self.energy_error.max(balance.error.abs());
        self.momentum_error = self.momentum_error.max(balance.momentum_error);
        self.history.push(row);
        if let (Some(tracker), Some(body)) = (&mut self.tracker, &self.state.body) {
            let failed = self.failed[0] + self.failed[1];
            let (model, state) = (&self.model, &self.state);
            let known = tracker.update(time, body, impulse.norm(), failed, || outcome::covered(model, state, body));
            self.decided |= known && case.solver.run_until == RunUntil::Outcome;
        }
    }

    /// Stops a run whose numbers are no longer finite or whose kinetic energy was never put in.
    fn watch(&mut self, totals: &step::StepTotals) {
        let body = self.state.body.as_ref();
        let flying = body.map_or(0.0, |b| if b.prescribed { 0.0 } else { b.kinetic_energy() });
        let kinetic = totals.kinetic + flying;
        let finite = kinetic.is_finite() && self.ledger.work.is_finite();
        let allowed = 1.5 * self.ledger.available() + 1e-9;
        if self.trouble.is_some() || (finite && kinetic <= allowed) {
            return;
        }
        self.trouble = step::find_trouble(&self.model, &self.state).or_else(|| {
            let (place, speed) = step::fastest_node(&self.model.grid, &self.state);
            Some(Trouble {
                step: self.state.step,
                kernel: "node_update",
                quantity: format!(
                    "kinetic energy {kinetic:.6e} J where at most {:.6e} J was ever put in; fastest node {speed:.6e} m/s",
                    self.ledger.available()
                ),
                place,
            })
        });
    }

    fn progress(&self, case: &Case) -> Progress {
        Progress {
            time: self.time(),
            end_time: case.solver.end_time,
            velocity: self.history.last().map_or(0.0, |s| s.projectile_velocity),
            failed: self.failed[0] + self.failed[1],
            steps: self.state.step,
            elements: self.model.grid.elements(),
        }
    }

    /// The result. `loop_seconds`: time spent in the loop.
    pub fn into_run(self, loop_seconds: f64) -> Run {
        let cell = &self.model.cell;
        let breaking = |i: usize| cell.yarn[i].stiffness * cell.yarn[i].failure_strain;
        let present = (0..2).filter(|i| self.model.present[*i]);
        let weakest = present.map(breaking).fold(f64::INFINITY, f64::min);
        let peak = |f: fn(&Balance) -> f64| self.history.iter().map(|s| f(&s.balance)).fold(0.0, f64::max);
        let internal = peak(|b| b.internal);
        Run {
            outcome: self.tracker.as_ref().map_or(Outcome::Running, |t| t.outcome),
            stop_time: self.tracker.as_ref().and_then(|t| t.stop_time),
            impact_energy: self.impact_energy,
            max_penetration: self.max_penetration,
            energy_error: self.energy_error,
            momentum_error: self.momentum_error,
            hourglass_fraction: if internal > 0.0 { peak(|b| b.hourglass) / internal } else { 0.0 },
            newton: NewtonStatistics {
                max_residual: self.max_residual / weakest,
                mean_iterations: self.newton[0] / self.newton[1].max(1.0),
                unconverged: self.unconverged,
            },
            elements: self.model.grid.elements(),
            steps: self.state.step,
            time_step: self.model.dt,
            step_set_by: self.model.bound.set_by,
            loop_seconds,
            threads: rayon::current_num_threads(),
            precision: S::NAME,
            trouble: self.trouble,
            interrupted: self.interrupted,
            history: self.history,
            events: self.events,
            profiles: self.profiles,
        }
    }
}

/// Initial penetration is an input error, not something contact may repair.
fn check_start<S: Scalar>(model: &Model<S>, state: &State<S>) -> Result<(), ModelError> {
    let Some(body) = &state.body else { return Ok(()) };
    let grid = &model.grid;
    let mut deepest: f64 = 0.0;
    for row in 0..grid.node_rows() {
        for column in 0..=grid.columns {
            let (gap, _) = body.gap(&step::node_position(grid, state, row, column));
            deepest = deepest.max(-gap);
        }
    }
    // Room for rounding of a touching start in the state's precision.
    let rounding = 16.0 * S::EPSILON * (body.body.reach + body.position.norm());
    if deepest > rounding {
        return Err(ModelError::InitialPenetration { depth_mm: deepest * 1e3 });
    }
    Ok(())
}
