//! What a checkpoint says of its run before anything else.

use serde::{Deserialize, Serialize};

use super::CheckpointFault;
use crate::case::{Case, case_hash};
use crate::run::{Options, Precision, Skips};

/// Steps, and worker threads, of any run at most.
const MAX_STEPS: u64 = 1_000_000_000;
const MAX_THREADS: usize = 1024;

/// The run, and how far it has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Of the program.
    pub version: String,
    /// Name of the case.
    pub case: String,
    /// Fingerprint of what it computes.
    pub case_hash: String,
    /// What computes.
    pub backend: BackendId,
    /// What is left out.
    pub skips: Skips,
    /// Worker threads asked for; results do not depend on it.
    pub threads: Option<usize>,
    /// Simulated time between checkpoints [s].
    pub every: f64,
    /// Files that not every run writes.
    pub extras: Extras,
    /// Steps done.
    pub step: u64,
    /// Time of the positions [s].
    pub time: f64,
    /// Time step [s].
    pub time_step: f64,
    /// Time it took.
    pub spent: Spent,
}

/// What computes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BackendId {
    /// The processor.
    Cpu(Precision),
    /// The graphics adapter of this name.
    Gpu(String),
}

impl BackendId {
    fn words(&self) -> String {
        match self {
            Self::Cpu(precision) => format!("cpu, {}", precision.name()),
            Self::Gpu(adapter) => format!("gpu, {adapter}"),
        }
    }
}

/// Files that were asked for beside those of every run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Extras {
    /// `report.html`
    pub report: bool,
}

/// Time that the parts of a run have taken so far [s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spent {
    /// Since the command began.
    pub wall: f64,
    /// In the loop.
    pub r#loop: f64,
    /// Of that, waiting for the device.
    pub waited: f64,
}

impl Header {
    /// A run that has not begun. `every`: simulated time between checkpoints [s].
    pub fn new(case: &Case, options: &Options<'_>, every: f64) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            case: case.name.clone(),
            case_hash: case_hash(&case.as_run),
            backend: Self::backend_of(options),
            skips: options.skips,
            threads: options.threads,
            every,
            extras: Extras::default(),
            step: 0,
            time: 0.0,
            time_step: 0.0,
            spent: Spent::default(),
        }
    }

    fn backend_of(options: &Options<'_>) -> BackendId {
        options.device.map_or(BackendId::Cpu(options.precision), |device| BackendId::Gpu(device.name().to_owned()))
    }

    /// Whether the run was one of this case.
    pub(super) fn check_case(&self, case: &Case) -> Result<(), CheckpointFault> {
        let hash = case_hash(&case.as_run);
        if hash != self.case_hash {
            return Err(CheckpointFault::Case { checkpoint: self.case_hash.clone(), case: hash });
        }
        if self.is_possible() { Ok(()) } else { Err(CheckpointFault::Contents("steps and times of the head")) }
    }

    /// Whether a run can have come so far: who goes on counts through all steps that were done.
    fn is_possible(&self) -> bool {
        let of_steps = self.step as f64 * self.time_step;
        let lengths = [self.every, self.time_step].iter().all(|length| length.is_finite() && *length > 0.0);
        lengths
            && self.step <= MAX_STEPS
            && (self.time - of_steps).abs() <= self.time_step
            && self.threads.is_none_or(|threads| threads <= MAX_THREADS)
    }

    /// Whether the run had these options, as far as they matter.
    pub(super) fn check_options(&self, options: &Options<'_>) -> Result<(), CheckpointFault> {
        let backend = Self::backend_of(options);
        if backend == self.backend { Ok(()) } else { Err(CheckpointFault::Backend(backend.words())) }
    }
}
