//! How to run a case, and why a run may not start.

use serde::{Deserialize, Serialize};

use crate::gpu::{self, DeviceError};
use crate::math::scalar::Scalar;
use crate::model::ModelError;
use crate::run::checkpoint::{Checkpoint, CheckpointError};

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
