//! Run of a case: the host loop, the same for every backend, its options, observers and results.
//!
//! - [`run`] takes a case to a [`Run`] by [`Options`].
//! - A backend takes the steps: [`Simulation`] on the processor, `device` on a graphics processor, where `batch` computes many shots at a
//!   time. Both keep the same `record`.
//! - [`outcome`] decides what became of the projectile, `attachment` which fabric still holds; a [`DeflectionProfile`] shows waves along
//!   a yarn.
//! - An [`Observer`] follows a run: progress, [`frame`]s, [`checkpoint`]s.

mod attachment;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod batch;
pub mod checkpoint;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod device;
pub mod frame;
#[doc(hidden)]
pub mod outcome;
mod processor;
mod record;
mod result;
mod snapshot;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use serde::{Deserialize, Serialize, de::DeserializeOwned};
use web_time::Instant;

use crate::case::{Case, CaseError};
use crate::gpu::{Device, DeviceError};
use crate::model::Model;
use crate::num::scalar::Scalar;
pub use crate::physics::rigid_body::MirrorPlanes;
use crate::solver;
pub use crate::solver::energy_balance::{Balance, PlyMoment};
use crate::solver::state::State;
use crate::solver::sweep::KernelScalar;
pub use crate::solver::{Divergence, FailureEvent};
pub(crate) use attachment::attached;
use checkpoint::{Checkpoint, Checkpointable};
pub use outcome::Outcome;
#[doc(hidden)]
pub use processor::Simulation;
use record::RunRecord;
pub(crate) use record::interval_over;
pub use result::{DeflectionProfile, NewtonStatistics, PlySample, ProfilePoint, Run, Sample};
pub use snapshot::Snapshot;

/// Number type of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
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
        [f64::NAME, f32::NAME][self as usize]
    }
}

/// Parts of a run that are left out because they cannot change what is asked for; all of them by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skips {
    /// Fabric that nothing has reached is at rest and is not computed.
    pub wavefront: bool,
    /// Nothing is computed after the outcome, or a rebound, is known where the case asks for no more.
    pub outcome: bool,
    /// A scene that is its own mirror image, and whose case allows it, is computed by a half or a quarter.
    pub symmetry: bool,
}

impl Skips {
    /// Nothing is left out.
    pub const NONE: Self = Self { wavefront: false, outcome: false, symmetry: false };
    /// The whole scene is computed; nothing else is.
    pub const WHOLE: Self = Self { wavefront: true, outcome: true, symmetry: false };

    /// Kinds that are switched off.
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

/// Options of a run.
///
/// ```
/// # let case = ripstop::Case::builder("a ply").fabric(ripstop::BuiltInFabric::S720).size_mm(15.0, 15.0)
/// #     .sphere_mm(6.0).mass_g(1.0).velocity_m_s(50.0).end_time_us(3.0).build()?;
/// use ripstop::{Options, run::Precision};
///
/// let run = Options::default().threads(1).precision(Precision::F32).run(&case)?;
/// # assert_eq!((run.threads, run.precision), (1, "f32"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
#[must_use]
pub struct Options<'a> {
    /// Worker threads; `None` takes all cores.
    pub threads: Option<usize>,
    /// Number type of the processor; a graphics processor computes in `f32`.
    pub precision: Precision,
    /// The graphics processor to run on; `None` takes the processor.
    pub device: Option<&'a Device>,
    /// Skips of the run.
    pub skips: Skips,
    /// The checkpoint that the run goes on from; `None` begins at the beginning.
    pub from: Option<&'a Checkpoint>,
}

impl<'a> Options<'a> {
    /// On this number of worker threads; `None`: all cores.
    pub fn threads(self, threads: impl Into<Option<usize>>) -> Self {
        Self { threads: threads.into(), ..self }
    }

    /// In this number type; a graphics processor computes in `f32`.
    pub fn precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// On a graphics processor; `None`: on the processor.
    pub fn device(self, device: impl Into<Option<&'a Device>>) -> Self {
        Self { device: device.into(), ..self }
    }

    /// With these skips.
    pub fn skips(self, skips: Skips) -> Self {
        Self { skips, ..self }
    }

    /// From a checkpoint on.
    pub fn resume(self, checkpoint: &'a Checkpoint) -> Self {
        Self { from: Some(checkpoint), ..self }
    }

    /// Runs a case.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(self, case: &Case) -> Result<Run, RunError> {
        self.observe(case, &mut ())
    }

    /// Runs a case with an observer.
    ///
    /// # Errors
    /// As [`run`].
    pub fn observe(self, case: &Case, observer: &mut dyn Observer) -> Result<Run, RunError> {
        run(case, self, &AtomicBool::new(false), observer)
    }
}

impl Case {
    /// Runs the case on all cores of the processor.
    ///
    /// # Errors
    /// As [`run`].
    pub fn run(&self) -> Result<Run, RunError> {
        Options::default().run(self)
    }
}

/// Reason why a run did not start.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The case cannot become a model.
    #[error(transparent)]
    Model(#[from] CaseError),
    /// The thread pool could not be made.
    #[error("cannot start {threads} worker threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// Words of the system.
        reason: String,
    },
    /// The device cannot hold the case.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The checkpoint is of another run.
    #[error(transparent)]
    Checkpoint(CaseError),
}

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Progress {
    /// Time of the positions [s].
    pub time: f64,
    /// End of the run [s].
    pub end_time: f64,
    /// Velocity of the projectile along its line of flight [m/s].
    pub velocity: f64,
    /// Yarns failed.
    pub failed: u64,
    /// Steps done.
    pub steps: u64,
    /// Elements.
    pub elements: usize,
}

/// Observer of a run. It is called on the thread that drives the run, so whatever takes long belongs on another.
///
/// A closure that takes [`Progress`] follows progress alone, `()` nothing at all.
pub trait Observer: Send {
    /// Called when rows of the history have been added.
    fn on_progress(&mut self, _progress: &Progress) {}
    /// Whether it wants the state at `time` [s], `dt` [s] after the last. Nothing but time may decide, and the states it has taken: it is also
    /// asked about times to come.
    fn snapshot_due(&self, _time: f64, _dt: f64) -> bool {
        false
    }
    /// Called with the state at a time that is due, before the next step.
    fn on_snapshot(&mut self, _view: &View<'_>) {}
    /// Called with the state after the last step. A device that has run past the end of the run has none.
    fn on_end(&mut self, _view: &View<'_>) {}
    /// Whether it wants to save the run before the step from `time` [s], `dt` [s] long. Nothing but time may decide, and what it has saved.
    fn checkpoint_due(&self, _time: f64, _dt: f64) -> bool {
        false
    }
    /// Called with the run at a time when it wants to save it, or before the user ends it. `loop_seconds`: time in the loop so far [s].
    fn on_checkpoint(&mut self, _run: &dyn Checkpointable, _loop_seconds: f64) {}
}

/// Model and state, for an observer to look at. Its contents may change with any release: a
/// [`FrameCollector`](crate::FrameCollector) makes frames of it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum View<'a> {
    /// In double precision.
    #[doc(hidden)]
    Double(&'a Arc<Model<f64>>, &'a State<f64>),
    /// In single precision, which a graphics processor always computes in.
    #[doc(hidden)]
    Single(&'a Arc<Model<f32>>, &'a State<f32>),
}

impl View<'_> {
    /// Steps done.
    pub fn step(&self) -> u64 {
        match self {
            Self::Double(_, state) => state.step,
            Self::Single(_, state) => state.step,
        }
    }

    /// Time of the positions, and of a step [s].
    pub fn clock(&self) -> [f64; 2] {
        let dt = match self {
            Self::Double(model, _) => model.dt,
            Self::Single(model, _) => model.dt,
        };
        [self.step() as f64 * dt, dt]
    }
}

/// Precision of runs on the processor.
pub trait RunScalar: KernelScalar + Serialize + DeserializeOwned {
    /// Precision.
    const PRECISION: Precision;

    /// View of a state.
    fn view<'a>(model: &'a Arc<Model<Self>>, state: &'a State<Self>) -> View<'a>;
}

impl RunScalar for f64 {
    const PRECISION: Precision = Precision::F64;

    fn view<'a>(model: &'a Arc<Model<Self>>, state: &'a State<Self>) -> View<'a> {
        View::Double(model, state)
    }
}

impl RunScalar for f32 {
    const PRECISION: Precision = Precision::F32;

    fn view<'a>(model: &'a Arc<Model<Self>>, state: &'a State<Self>) -> View<'a> {
        View::Single(model, state)
    }
}

impl Observer for () {}

impl<F: FnMut(&Progress) + Send> Observer for F {
    fn on_progress(&mut self, progress: &Progress) {
        self(progress);
    }
}

/// Runs a case, until its end or until `interrupt` is raised. [`Case::run`] and [`Options::run`] are shorter.
///
/// # Errors
/// When the case cannot become a model, or the device cannot hold it. A run that becomes unstable is a [`Run`] with
/// `divergence`, one whose device was lost a [`Run`] with `lost`.
pub fn run(
    case: &Case,
    options: Options<'_>,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Run, RunError> {
    let threads = options.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|e| RunError::Threads { threads, reason: e.to_string() })?;
    pool.install(|| pollster::block_on(run_here(case, options, interrupt, observer)))
}

/// Runs a case on the threads at hand. While a device computes, nothing blocks: the page of a browser allows neither more threads nor that.
///
/// # Errors
/// As [`run`], but for threads.
pub async fn run_here(
    case: &Case,
    options: Options<'_>,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Run, RunError> {
    let (start, before) = (Instant::now(), options.from.map_or(0.0, |from| from.header.loop_seconds));
    // Time in the loop so far, of all parts of the run [s].
    let seconds = || before + start.elapsed().as_secs_f64();
    Ok(match (options.device, options.precision) {
        #[cfg(feature = "gpu")]
        (Some(device), _) => {
            let simulation = device::DeviceSimulation::open(case, device, &options)?;
            drive(simulation, case, &seconds, interrupt, observer).await
        }
        #[cfg(not(feature = "gpu"))]
        (Some(device), _) => match *device {},
        (None, Precision::F64) => {
            drive(Simulation::<f64>::open(case, &options)?, case, &seconds, interrupt, observer).await
        }
        (None, Precision::F32) => {
            drive(Simulation::<f32>::open(case, &options)?, case, &seconds, interrupt, observer).await
        }
    })
}

/// Model and state of a case: of the part that is computed with these skips.
///
/// # Errors
/// When the case cannot become a model, or the projectile starts inside the fabric.
fn set_up<S: Scalar>(case: &Case, skips: Skips) -> Result<(Arc<Model<S>>, State<S>), CaseError> {
    let (model, mut state) = solver::state::set_up(case, skips.symmetry)?;
    if !skips.wavefront {
        state.reach_everything(&model);
    }
    Ok((Arc::new(model), state))
}

/// A run in progress, as the host loop drives it.
trait Backend: Checkpointable {
    /// Whether the last step taken ends the run.
    fn is_finished(&self, case: &Case) -> bool;
    /// Record of the run so far.
    fn record(&mut self) -> &mut RunRecord;
    /// Takes one step, or a batch of them. The observer sees the state before a step where that is due. True where there is progress to show.
    async fn advance(&mut self, case: &Case, observer: &mut dyn Observer) -> bool;
    /// Takes over what is on its way, to be saved. False where there is nothing to save: the run has not begun, or its end is on the way.
    fn ready_for_checkpoint(&mut self, case: &Case) -> bool;
    /// Shows the observer the state after the last step.
    async fn show_end(&mut self, observer: &mut dyn Observer);
    /// Results. `loop_seconds`: time spent in the loop [s].
    fn finish(self, loop_seconds: f64) -> Run;
}

/// Host loop: steps, until the run is over or the user ends it.
async fn drive(
    mut backend: impl Backend,
    case: &Case,
    seconds: &dyn Fn() -> f64,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> Run {
    while !backend.is_finished(case) {
        let [time, dt] = backend.clock();
        let ends = interrupt.load(Ordering::Relaxed) && !backend.record().run.interrupted;
        if (ends || observer.checkpoint_due(time, dt)) && backend.ready_for_checkpoint(case) {
            observer.on_checkpoint(&backend, seconds());
        }
        backend.record().run.interrupted |= ends;
        if backend.advance(case, observer).await {
            observer.on_progress(&backend.record().progress(case));
        }
    }
    backend.show_end(observer).await;
    backend.finish(seconds())
}
