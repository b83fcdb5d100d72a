//! A run: the host loop, the same for every backend, and what it measures on the way.
//!
//! - [`run`] takes a case to a [`Run`]. `options` says how, `result` what comes out.
//! - A backend computes: `processor`, or `graphics` on a device. It takes steps, shows its state, and saves itself.
//! - `record` is what a run has produced so far, and when the next record is due; [`outcome`] decides what became of the
//!   projectile, `pieces` and `deflection` what fabric hangs on, [`profile`] reads deflection and waves along a yarn.
//! - [`Observer`] is who follows a run: progress, [`frame`]s, [`checkpoint`]s.

mod backend;
pub mod checkpoint;
mod deflection;
mod due;
pub mod frame;
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod graphics;
#[cfg(not(feature = "gpu"))]
#[path = "graphics/absent.rs"]
mod graphics;
mod observer;
mod options;
#[doc(hidden)]
pub mod outcome;
pub(crate) mod pieces;
mod processor;
pub mod profile;
mod record;
mod result;

use std::sync::atomic::{AtomicBool, Ordering};

use tracing::info_span;

use crate::case::Case;
pub use crate::model::ModelError;
pub use crate::model::features::Features;
pub use crate::physics::mirror_planes::MirrorPlanes;
use crate::run::checkpoint::LoopClock;
pub use crate::solver::energy_balance::{Balance, PlyMoment};
pub use crate::solver::{Divergence, FailureEvent};
use backend::Backend;
#[doc(hidden)]
pub use observer::RunScalar;
pub use observer::{Observer, View};
pub use options::{Options, Precision, RunError, Skips};
pub use outcome::Outcome;
#[doc(hidden)]
pub use processor::Simulation;
pub use result::{NewtonStatistics, PlySample, Progress, Run, Sample};

/// Runs a case, until its end or until `interrupt` is raised; `watch` follows it. [`Case::run`] and [`Options::run`] are shorter.
///
/// # Errors
/// When the case cannot become a model, or the device cannot hold it. A run that becomes unstable is a [`Run`] with
/// `trouble`, one whose device was lost a [`Run`] with `lost`.
pub fn run(
    case: &Case,
    options: Options<'_>,
    interrupt: &AtomicBool,
    watch: &mut dyn Observer,
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
        let clock = options.from.map_or_else(LoopClock::default, LoopClock::after);
        Ok(match (options.device, options.precision) {
            (Some(device), _) => graphics::run(case, device, &options, &clock, interrupt, watch)?,
            (None, Precision::F64) => drive(Simulation::<f64>::open(case, &options)?, case, &clock, interrupt, watch),
            (None, Precision::F32) => drive(Simulation::<f32>::open(case, &options)?, case, &clock, interrupt, watch),
        })
    };
    pool.install(|| span.in_scope(run))
}

/// The host loop: steps, until the run is over or the user ends it.
fn drive(
    mut backend: impl Backend,
    case: &Case,
    clock: &LoopClock,
    interrupt: &AtomicBool,
    watch: &mut dyn Observer,
) -> Run {
    while !backend.is_finished(case) {
        let ends = interrupt.load(Ordering::Relaxed) && !backend.record().interrupted;
        if ends || watch.checkpoint_due(backend.next_time(), backend.time_step()) {
            backend.keep(case, watch, clock.seconds());
        }
        backend.record().interrupted |= ends;
        if backend.advance(case, watch) {
            watch.on_progress(&backend.progress(case));
        }
    }
    backend.show_end(watch);
    backend.finish(clock.seconds())
}
