//! Options of a run, and the reasons why one may not start.

use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::gpu::{Device, DeviceError};
use crate::model::ModelError;
use crate::num::scalar::Scalar;
use crate::run::checkpoint::{Checkpoint, CheckpointError};
use crate::run::{Observer, Run, run};

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
        match self {
            Self::F64 => f64::NAME,
            Self::F32 => f32::NAME,
        }
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
    /// As [`crate::run::run`].
    pub fn run(self, case: &Case) -> Result<Run, RunError> {
        self.observe(case, &mut ())
    }

    /// Runs a case with an observer.
    ///
    /// # Errors
    /// As [`crate::run::run`].
    pub fn observe(self, case: &Case, observer: &mut dyn Observer) -> Result<Run, RunError> {
        run(case, self, &AtomicBool::new(false), observer)
    }
}

impl Case {
    /// Runs the case on all cores of the processor.
    ///
    /// # Errors
    /// As [`crate::run::run`].
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
    Model(#[from] ModelError),
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
    Checkpoint(#[from] CheckpointError),
}
