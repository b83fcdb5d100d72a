//! Runs on a device in a build without the feature `gpu`: there is no device.

use std::sync::atomic::AtomicBool;

use crate::case::Case;
use crate::gpu::Device;
use crate::run::checkpoint::LoopClock;
use crate::run::{Observer, Options, Run, RunError};

/// Runs a case on a device.
pub(super) fn run(
    _: &Case,
    device: &Device,
    _: &Options<'_>,
    _: &LoopClock,
    _: &AtomicBool,
    _: &mut dyn Observer,
) -> Result<Run, RunError> {
    match *device {}
}
