//! The quick part of the list of hard scenes: finite numbers, bounded energy, or a diagnosis.

use std::sync::atomic::AtomicBool;

use super::Check;
use super::stress::{self, StressBackend};
use crate::run::Options;

/// One row per hard scene. Rows after an interrupt are left out.
pub(super) fn rows(options: Options<'_>, interrupt: &AtomicBool, keep: &mut dyn FnMut(Check)) {
    let machine = options.device.map_or(StressBackend::Cpu(options.precision), StressBackend::Gpu);
    stress::quick("stability", machine, options.threads, interrupt).for_each(keep);
}
