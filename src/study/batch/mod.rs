//! Many shots of one case, each on a thread of its own.
//!
//! ```text
//! case, seed ──► orders ──► fire ──► rows ──► log ──► table
//! ```
//!
//! A shot is a function of case, seed, number and velocity: it does not depend on which others run. Its row is written before the next one
//! begins, and a row that is there is not computed again.

pub(in crate::study) mod fire;
mod log;
mod page;
mod plan;
mod row;
mod threads;

use std::sync::atomic::AtomicBool;

pub use fire::{fire, order_case};
pub use log::ShotLog;
pub use page::{histograms, html};
pub use plan::BatchPlan;
pub use row::{ShotRow, columns};
pub(in crate::study) use threads::in_threads;

use crate::output::OutputError;
use crate::run::Precision;
use crate::study::StudyError;

/// One shot that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotOrder {
    /// Which of the draws.
    pub shot: u32,
    /// Impact velocity before its scatter [m/s]; `None`: that of the case.
    pub velocity: Option<f64>,
}

/// How shots are computed. None of it changes a result but the precision.
#[derive(Clone, Copy, Debug)]
pub struct BatchOptions<'a> {
    /// What all draws come from.
    pub seed: u32,
    /// Shots at a time.
    pub threads: usize,
    /// Threads of a shot, where fewer shots than threads can run.
    pub threads_per_shot: usize,
    /// Number type.
    pub precision: Precision,
    /// Raised: the shots under way are given up.
    pub interrupt: &'a AtomicBool,
}

/// Why a batch did not end.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BatchError {
    /// The results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// What was asked for, or what lies in the folder, cannot be used.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The user has ended it; rows so far are written.
    #[error("interrupted")]
    Interrupted,
}
