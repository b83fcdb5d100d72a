//! The quick part of the list of hard scenes: finite numbers, bounded energy, or a diagnosis.

use std::sync::atomic::AtomicBool;

use super::Row;
use super::stress::{self, Machine};
use crate::run::Options;

/// One row per hard scene. Rows after an interrupt are left out.
pub(super) fn rows(options: Options<'_>, interrupt: &AtomicBool, keep: &mut dyn FnMut(Row)) {
    let machine = options.device.map_or(Machine::Cpu(options.precision), Machine::Gpu);
    stress::quick("stability", machine, options.threads, interrupt).for_each(keep);
}
