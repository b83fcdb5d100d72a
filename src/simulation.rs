//! The host loop: drives the steps, samples history, watches the numbers, decides when a run ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tracing::{info, info_span};

use crate::case::Case;
use crate::checkpoint::{Checkpoint, CheckpointError, Clock};
use crate::gpu::{self, DeviceError};
use crate::kernels::rigid_body::RigidBody;
use crate::ledger::{Balance, Ledger, PlyMoment};
use crate::model::{MirrorPlanes, Model, ModelError, Terms};
use crate::number::Scalar;
use crate::outcome::{self, Outcome};
use crate::pieces;
use crate::profile::{self, Profile};
use crate::record::{Machine, Moment, Record};
use crate::state::State;
use crate::step::{self, FailureEvent, Phase, Stepper, Trouble};
pub use crate::watch::{View, Viewed, Watch};

/// Number type of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Precision {
    /// Double, the reference.
    #[default]
    F64,
    /// Single.
    F32,
}

impl Precision {
    /// `f64` or `f32`.
    pub fn name(self) -> &'static str {
        match self {
            Self::F64 => f64::NAME,
            Self::F32 => f32::NAME,
        }
    }
}

/// What a run leaves out because it cannot change what is asked for; everything by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skips {
    /// What nothing has reached is at rest and is not computed.
    pub wavefront: bool,
    /// Where the case asks for the outcome, or for a rebound, nothing is computed after it is known.
    pub outcome: bool,
    /// Of a scene that is its own mirror image, and whose case allows it, a half or a quarter is computed.
    pub symmetry: bool,
}

impl Skips {
    /// Nothing is left out.
    pub const NONE: Self = Self { wavefront: false, outcome: false, symmetry: false };
    /// The whole scene is computed; nothing else is.
    pub const WHOLE: Self = Self { wavefront: true, outcome: true, symmetry: false };

    /// The kinds that are switched off.
    pub fn switched_off(self) -> Vec<&'static str> {
        let kinds = [("wavefront", self.wavefront), ("outcome", self.outcome), ("symmetry", self.symmetry)];
        kinds.into_iter().filter(|(_, on)| !on).map(|(name, _)| name).collect()
    }
}

impl Default for Skips {
    fn default() -> Self {
        Self { wavefront: true, outcome: true, symmetry: true }
    }
}

/// How to run a case.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options<'a> {
    /// Worker threads; `None` takes all cores.
    pub threads: Option<usize>,
    /// Number type of the processor; a graphics processor computes in `f32`.
    pub precision: Precision,
    /// The graphics processor to run on; `None` takes the processor.
    pub device: Option<&'a gpu::Device>,
    /// What is left out.
    pub skips: Skips,
    /// The checkpoint that the run goes on from; `None` begins at the beginning.
    pub from: Option<&'a Checkpoint>,
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
    /// The device cannot hold the case.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The checkpoint is of another run.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}

/// One row of the history, at a time of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// The same of the last ply [m].
    pub last_deflection: f64,
    /// Plies with failures and no whole element left ahead of the projectile.
    pub perforated_plies: u32,
}

/// One ply at a time of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlySample {
    /// [s]
    pub time: f64,
    /// Counted from the struck side.
    pub ply: usize,
    /// Energies and deflection.
    pub moment: PlyMoment,
    /// Warp and weft failures so far.
    pub failed: [u64; 2],
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
    /// Speed away from the pack, along its normal, of a projectile that flew back in a run that went on after it stopped [m/s].
    pub rebound_velocity: Option<f64>,
    /// History, ascending in time; the last row is the last state.
    pub history: Vec<Sample>,
    /// Yarn failures in order of step, ply, row, column.
    pub events: Vec<FailureEvent>,
    /// Deflection profiles asked for.
    pub profiles: Vec<Profile>,
    /// Every ply of a pack of several, time by time.
    pub ply_history: Vec<PlySample>,
    /// Kinetic energy the projectile came with [J]; the first row of the history is after first contact.
    pub impact_energy: f64,
    /// Largest penetration of a node into the projectile [m].
    pub max_penetration: f64,
    /// Largest penetration of a node into a neighbouring ply [m].
    pub max_ply_penetration: f64,
    /// Largest |energy error| of the work ledger [-].
    pub energy_error: f64,
    /// Energy by state functions that nothing accounts for, where it was largest, over the initial energy [-].
    pub energy_gained: f64,
    /// Largest momentum error [-].
    pub momentum_error: f64,
    /// Largest hourglass energy over the largest internal energy [-].
    pub hourglass_fraction: f64,
    /// Unit-cell solver.
    pub newton: NewtonStatistics,
    /// Plies.
    pub plies: usize,
    /// Largest deflection of each ply, of fabric that hangs on something [m].
    pub deflections: Vec<f64>,
    /// Elements of the whole scene.
    pub elements: usize,
    /// Mirror planes that the scene was cut at: one part was computed, everything here is of the whole.
    pub planes: MirrorPlanes,
    /// Steps done.
    pub steps: u64,
    /// Elements times steps computed; mirror images and what was known to be at rest are left out.
    pub element_steps_computed: u64,
    /// What was left out.
    pub skips: Skips,
    /// [s]
    pub time_step: f64,
    /// What set it.
    pub step_set_by: &'static str,
    /// Terms of the model that the scene has.
    pub terms: Terms,
    /// Time in the loop [s].
    pub loop_seconds: f64,
    /// Part of it in which the host did not wait for the device [s]; `None` on the processor.
    pub host_seconds: Option<f64>,
    /// Kernels and other phases of the loop by name, and how long each took [s]; what is missing from `loop_seconds` went elsewhere.
    pub kernel_seconds: Vec<(&'static str, f64)>,
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// Name of the graphics adapter.
    pub adapter: Option<String>,
    /// Worker threads.
    pub threads: usize,
    /// `f64` or `f32`.
    pub precision: &'static str,
    /// What went wrong, if the run became unstable.
    pub trouble: Option<Trouble>,
    /// What the device said when it was lost in mid-run; results end there.
    pub lost: Option<String>,
    /// Stopped by the user.
    pub interrupted: bool,
    /// The last checkpoint that could not be written, and why.
    pub unkept: Option<String>,
}

impl Run {
    /// Largest deflection of any ply, of fabric that hangs on something [m].
    pub fn deflection(&self) -> f64 {
        self.deflections.iter().copied().fold(0.0, f64::max)
    }
}

/// Runs a case.
///
/// # Errors
/// When the case cannot become a model, or the device cannot hold it. A run that becomes unstable is a [`Run`] with
/// `trouble`, one whose device was lost a [`Run`] with `lost`.
pub fn run(case: &Case, options: Options<'_>, interrupt: &AtomicBool, watch: &mut dyn Watch) -> Result<Run, RunError> {
    let threads = options.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| RunError::Threads { threads, reason: e.to_string() })?;
    if let Some(checkpoint) = options.from {
        checkpoint.check_case(case)?;
        checkpoint.check_options(&options)?;
    }
    let span = info_span!("run", case = case.name.as_str());
    let run = || match (options.device, options.precision) {
        (Some(device), _) => gpu::run(case, device, &options, interrupt, watch),
        (None, Precision::F64) => run_as::<f64>(case, &options, interrupt, watch),
        (None, Precision::F32) => run_as::<f32>(case, &options, interrupt, watch),
    };
    pool.install(|| span.in_scope(run))
}

fn run_as<S: Scalar>(
    case: &Case,
    options: &Options<'_>,
    interrupt: &AtomicBool,
    watch: &mut dyn Watch,
) -> Result<Run, RunError> {
    let (mut simulation, clock) = match options.from {
        Some(checkpoint) => (Simulation::<S>::resume(case, checkpoint)?, Clock::after(checkpoint)),
        None => (Simulation::<S>::with_skips(case, options.skips)?, Clock::default()),
    };
    while !simulation.finished(case) {
        let ends = interrupt.load(Ordering::Relaxed) && !simulation.record.interrupted;
        if simulation.state.step > 0 && (ends || watch.keeps(simulation.time(), simulation.model.dt)) {
            watch.keep(&simulation, clock.seconds());
        }
        simulation.record.interrupted |= ends;
        if watch.is_due(simulation.time(), simulation.model.dt) {
            watch.look(&simulation.view());
        }
        if simulation.advance(case) {
            watch.progress(&simulation.progress(case));
        }
    }
    watch.end(&simulation.view());
    Ok(simulation.into_run(clock.seconds()))
}

/// A run in progress on the processor.
pub struct Simulation<S: Scalar> {
    /// Constant; of the part of the scene that is computed.
    pub model: Arc<Model<S>>,
    /// Varies; as the model.
    pub state: State<S>,
    pub(crate) stepper: Stepper<S>,
    pub(crate) ledger: Ledger,
    pub(crate) record: Record,
    sampled: bool,
}

impl<S: Scalar> Simulation<S> {
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
        let mut record = Record::new(&model, state.body.as_ref());
        record.skips = skips;
        Ok(Self {
            stepper: Stepper::new(&model),
            record,
            ledger: Ledger::of_part(model.planes),
            model: Arc::new(model),
            state,
            sampled: false,
        })
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
        let given = if self.state.step == 0 { given(&self.model, &self.state) } else { (0.0, Vector3::zeros()) };
        let totals = self.stepper.step(&self.model, &mut self.state, &mut self.ledger, sample);
        self.record.add_step(&totals, &self.stepper.failures);
        if self.record.history.is_empty() {
            self.ledger.begin(given.0, given.1);
        }
        if sample {
            let impulse = Vector3::from(std::mem::take(&mut self.ledger.contact_impulse));
            let moment = Moment {
                time,
                dt: self.model.dt,
                balance: self.ledger.balance(),
                impulse,
                plies: self.ledger.plies(),
                body: self.state.body.as_ref().zip(before),
            };
            let (model, state) = (&self.model, &self.state);
            let in_doubt = self.record.sample(case, &moment, |body, ply| outcome::covered(model, state, body, ply));
            if let Some(body) = state.body.as_ref().filter(|_| in_doubt) {
                self.record.look(case, |ply| outcome::held(model, state, body, ply));
            }
        }
        self.sampled = sample;
        self.watch(&totals, sample);
        self.stepper.stopwatch.lap(Phase::Record);
        sample
    }

    /// Stops a run whose numbers are no longer finite or whose energy was never put in: kinetic, or at a sample of all kinds.
    fn watch(&mut self, totals: &step::StepTotals, sample: bool) {
        if self.record.trouble.is_some() {
            return;
        }
        let kinetic = totals.kinetic + flying(self.state.body.as_ref());
        let excess = excess(&self.ledger, kinetic, sample);
        let (model, state, available) = (&self.model, &self.state, self.ledger.available());
        self.record.trouble = excess.map(|excess| diagnose(model, state, excess, available));
    }

    fn progress(&self, case: &Case) -> Progress {
        self.record.progress(case, self.time(), self.state.step, self.model.whole_elements())
    }

    /// The result. `loop_seconds`: time spent in the loop.
    pub fn into_run(self, loop_seconds: f64) -> Run {
        let machine = Machine {
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

/// Model and state of a case: of the whole, or of the part that its mirror planes leave.
///
/// # Errors
/// When the case cannot become a model, or the projectile starts inside the fabric.
pub(crate) fn set_up<S: Scalar>(case: &Case, symmetry: bool) -> Result<(Model<S>, State<S>), ModelError> {
    let model = if symmetry { Model::<S>::part(case)? } else { Model::<S>::new(case)? };
    let state = State::new(case, &model);
    check_start(&model, &state)?;
    info!(
        plies = model.plies.len(),
        elements = model.whole_elements(),
        computed = model.elements(),
        mirrored = ?model.planes.names(),
        step_us = model.dt * 1e6,
        set_by = model.bound.set_by,
        numbers = state.nodes.data.len() + state.elements.data.len(),
        precision = S::NAME,
        "model built"
    );
    Ok((model, state))
}

/// Least energy that an error is measured against, over what rounding makes of the energy of a scene at rest [-].
pub(crate) const MEASURABLE: f64 = 1e3;

/// Kinetic energy, at least what rounding can be measured against, and momentum the scene starts with.
pub(crate) fn given<S: Scalar>(model: &Model<S>, state: &State<S>) -> (f64, Vector3<f64>) {
    let mut energy = 0.0;
    let mut momentum = Vector3::zeros();
    if model.sheets.iter().any(|sheet| sheet.initial_velocity != [0.0; 3]) {
        for [ply, row, column] in step::nodes(model) {
            let sheet = model.sheet(ply);
            let velocity = state.velocity(model.grid.first_node_row(ply) + row, column);
            let v = Vector3::from(sheet.mesh.to_pack(velocity));
            let m = sheet.row_mass(row).mass[column].to_f64();
            energy += 0.5 * m * v.norm_squared();
            momentum += v * m;
        }
    }
    if let Some(body) = state.body.as_ref() {
        energy += body.own_energy();
        momentum += body.velocity * if body.prescribed { 0.0 } else { body.mass };
    }
    (energy.max(MEASURABLE * rounding(model, state.body.as_ref())), momentum)
}

/// What rounding makes of the energy of a scene at rest [J].
pub(crate) fn rounding<S: Scalar>(model: &Model<S>, body: Option<&RigidBody>) -> f64 {
    let body = body.map_or(0.0, |body| {
        let moves = if body.prescribed { 0.0 } else { body.translation() };
        f64::EPSILON * moves + S::EPSILON * body.spin()
    });
    model.rounding() + body
}

/// Kinetic energy of a projectile that flies freely [J].
pub(crate) fn flying(body: Option<&RigidBody>) -> f64 {
    body.map_or(0.0, |b| if b.prescribed { 0.0 } else { b.kinetic_energy() })
}

/// What the diagnosis of energy out of nowhere says of it.
pub(crate) const NEVER_PUT_IN: &str = "was ever put in";

/// Energy that was never put in, or that is no number: its kind, and how much [J]. `sampled`: the ledger knows all kinds now.
pub(crate) fn excess(ledger: &Ledger, kinetic: f64, sampled: bool) -> Option<(&'static str, f64)> {
    let whole = ledger.available() + ledger.gained();
    if !(kinetic <= ledger.allowed() && ledger.work.is_finite()) {
        Some(("kinetic energy", kinetic))
    } else if sampled && whole > ledger.allowed() {
        Some(("energy by state functions", whole))
    } else {
        None
    }
}

/// What went wrong and where: a number that is not finite, or energy of some kind that nobody put in [J].
pub(crate) fn diagnose<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    (name, energy): (&str, f64),
    available: f64,
) -> Trouble {
    let mut trouble = step::find_trouble(model, state).unwrap_or_else(|| {
        let (place, speed) = step::fastest_node(model, state);
        let [energy, available] = [energy, available].map(|energy| energy * model.planes.copies() as f64);
        Trouble {
            step: state.step,
            kernel: "node_update",
            quantity: format!(
                "{name} {energy:.6e} J where at most {available:.6e} J {NEVER_PUT_IN}; fastest node {speed:.6e} m/s"
            ),
            place,
        }
    });
    trouble.place = model.place_in_whole(trouble.place);
    trouble
}

/// Initial penetration is an input error, not something contact may repair.
fn check_start<S: Scalar>(model: &Model<S>, state: &State<S>) -> Result<(), ModelError> {
    let Some(body) = &state.body else { return Ok(()) };
    let mut deepest: f64 = 0.0;
    for [ply, row, column] in step::nodes(model) {
        let (gap, _) = body.gap(&step::node_position(model, state, ply, row, column));
        deepest = deepest.max(-gap);
    }
    // Room for rounding of a touching start in the state's precision.
    let rounding = 16.0 * S::EPSILON * (body.body.reach + body.position.norm());
    if deepest > rounding {
        return Err(ModelError::InitialPenetration { depth_mm: deepest * 1e3 });
    }
    Ok(())
}
