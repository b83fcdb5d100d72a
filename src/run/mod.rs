//! Run of a case: the host loop, the same for every backend, and its results.
//!
//! - [`run`] takes a case to a [`Run`]. `options` and `result` are what goes in and what comes out.
//! - A backend takes the steps: [`Simulation`] on the processor, `device` on a graphics processor, where `batch` computes many shots at a
//!   time. Both keep the same `record`.
//! - [`outcome`] decides what became of the projectile, `attachment` which fabric still holds; [`profile`] reads deflection and waves along
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
#[cfg(feature = "gpu")]
mod device_shot;
pub mod frame;
mod observer;
mod options;
#[doc(hidden)]
pub mod outcome;
mod processor;
pub mod profile;
mod record;
mod result;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use tracing::info_span;

use crate::case::Case;
pub use crate::model::ModelError;
pub use crate::physics::rigid_body::MirrorPlanes;
pub use crate::solver::energy_balance::{Balance, PlyMoment};
pub use crate::solver::{Divergence, FailureEvent};
pub(crate) use attachment::attached;
#[doc(hidden)]
pub use observer::RunScalar;
pub use observer::{Observer, Progress, View};
pub use options::{Options, Precision, RunError, Skips};
pub use outcome::Outcome;
#[doc(hidden)]
pub use processor::Simulation;
use record::RunRecord;
pub use result::{NewtonStatistics, PlySample, Run, Sample};

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
    if let Some(checkpoint) = options.from {
        checkpoint.check_case(case)?;
        checkpoint.check_options(&options)?;
    }
    let span = info_span!("run", case = case.name.as_str());
    let run = || {
        let (start, before) = (Instant::now(), options.from.map_or(0.0, |from| from.header().spent.r#loop));
        // Time in the loop so far, of all parts of the run [s].
        let seconds = || before + start.elapsed().as_secs_f64();
        Ok(match (options.device, options.precision) {
            #[cfg(feature = "gpu")]
            (Some(device), _) => {
                let simulation = device::DeviceSimulation::open(case, device, &options)?;
                drive(simulation, case, &seconds, interrupt, observer)
            }
            #[cfg(not(feature = "gpu"))]
            (Some(device), _) => match *device {},
            (None, Precision::F64) => {
                drive(Simulation::<f64>::open(case, &options)?, case, &seconds, interrupt, observer)
            }
            (None, Precision::F32) => {
                drive(Simulation::<f32>::open(case, &options)?, case, &seconds, interrupt, observer)
            }
        })
    };
    pool.install(|| span.in_scope(run))
}

/// A run in progress, as the host loop drives it.
trait Backend {
    /// Whether the last step taken ends the run.
    fn is_finished(&self, case: &Case) -> bool;
    /// Time of the positions that the next step begins from, and time step [s].
    fn clock(&self) -> [f64; 2];
    /// Record of the run so far.
    fn record(&mut self) -> &mut RunRecord;
    /// Takes one step, or a batch of them. The observer sees the state before a step where that is due. True where there is progress to show.
    fn advance(&mut self, case: &Case, observer: &mut dyn Observer) -> bool;
    /// Lets the observer save the run, unless it has not begun or its end is on the way. `loop_seconds`: time in the loop so far [s].
    fn offer_checkpoint(&mut self, case: &Case, observer: &mut dyn Observer, loop_seconds: f64);
    /// Shows the observer the state after the last step.
    fn show_end(&mut self, observer: &mut dyn Observer);
    /// Progress of the run.
    fn progress(&self, case: &Case) -> Progress;
    /// Results. `loop_seconds`: time spent in the loop [s].
    fn finish(self, loop_seconds: f64) -> Run;
}

/// Host loop: steps, until the run is over or the user ends it.
fn drive(
    mut backend: impl Backend,
    case: &Case,
    seconds: &dyn Fn() -> f64,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> Run {
    while !backend.is_finished(case) {
        let [time, dt] = backend.clock();
        let ends = interrupt.load(Ordering::Relaxed) && !backend.record().run.interrupted;
        if ends || observer.checkpoint_due(time, dt) {
            backend.offer_checkpoint(case, observer, seconds());
        }
        backend.record().run.interrupted |= ends;
        if backend.advance(case, observer) {
            observer.on_progress(&backend.progress(case));
        }
    }
    backend.show_end(observer);
    backend.finish(seconds())
}
