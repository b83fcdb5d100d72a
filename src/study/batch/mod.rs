//! Many shots of one case, each on a thread of its own, or many at a time on a device.
//!
//! ```text
//! case, seed ──► orders ──► fire ──► rows ──► log ──► table
//! ```
//!
//! A shot is a function of case, seed, number and velocity: it does not depend on which others run. Its row is written before the next one
//! begins, and a row that is there is not computed again.

pub(in crate::study) mod fire;
mod log;
mod on_device;
mod page;
mod plan;
mod row;

use std::sync::atomic::{AtomicBool, Ordering};

pub use fire::{fire, order_case};
pub use log::ShotLog;
pub(in crate::study) use on_device::DeviceRunner;
pub use page::html;
pub use plan::BatchPlan;
pub use row::{ShotRow, columns};

use crate::gpu::{Device, DeviceError};
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

/// How shots are computed. None of it changes a result but precision and device.
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
    /// The graphics processor that shots are computed on, many at a time; `None`: the processor.
    pub device: Option<&'a Device>,
    /// Raised: the shots under way are given up.
    pub interrupt: &'a AtomicBool,
}

impl BatchOptions<'_> {
    /// Whether the user has asked for the end.
    fn stopped(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }
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
    /// The device was lost; rows so far are written.
    #[error(transparent)]
    Device(DeviceError),
    /// The user has ended it; rows so far are written.
    #[error("interrupted")]
    Interrupted,
}
