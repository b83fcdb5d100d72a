//! Files of a run: `summary.json`, `history.csv`, `events.csv`, `profiles.csv`, `shot.svg`, `report.html`, the case as run and, on
//! request, frames for ParaView.
//!
//! Every file is written beside its place, flushed to the disk and renamed, and nothing is renamed before all files
//! are complete: a folder holds the whole result of one run, never half of one.

mod animation;
mod breakage;
pub mod checks;
pub mod csv;
pub mod expect;
mod figures;
mod folder;
#[cfg(feature = "frames")]
pub mod frames;
#[doc(hidden)]
pub mod plot;
#[cfg(feature = "report")]
pub mod report;
mod summary;
mod surface;
pub mod warnings;

pub use animation::{AnimatedPly, Animation, Keyframe};
pub use breakage::Breakage;
pub use expect::check;
#[doc(hidden)]
pub use figures::{behind, held};
pub use folder::{CHECKPOINT, CheckpointWriter, Folder, StagedFrames, write_whole};
pub use summary::{
    Energies, Verdict, absorbed_energy, areal_density, costs, margins, residual_velocity, summary, verdict,
};
#[doc(hidden)]
pub use summary::{place, reached, symmetry};
#[doc(hidden)]
pub use warnings::{element_step, run_time, sheet};

/// Numbers in words.
#[doc(hidden)]
pub mod number {
    pub use crate::case::bytes;

    /// At least `digits` significant digits, trailing zeros of a fraction left out; very large and small with an exponent.
    pub fn short(value: f64, digits: i32) -> String {
        if value == 0.0 || !value.is_finite() {
            return format!("{value}");
        }
        let magnitude = value.abs().log10().floor() as i32;
        if !(-4..7).contains(&magnitude) {
            return format!("{value:.*e}", (digits - 1).max(0) as usize);
        }
        let decimals = (digits - 1 - magnitude).max(0) as usize;
        let text = format!("{value:.decimals$}");
        if decimals > 0 { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }

    /// A fixed number of decimals, without a sign on zero.
    pub fn fixed(value: f64, decimals: usize) -> String {
        let text = format!("{value:.decimals$}");
        match text.strip_prefix('-') {
            Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
            _ => text,
        }
    }

    /// A fraction in percent, or with an exponent where percent would say nothing.
    pub fn fraction(value: f64) -> String {
        match value.abs() {
            0.0 => "0".to_owned(),
            size if size >= 1e-4 => format!("{:.2} %", value * 100.0),
            _ => format!("{value:.1e}"),
        }
    }

    /// A time [s] in µs without rounding noise.
    pub fn us(time: f64) -> String {
        format!("{} µs", short(time * 1e6, 5))
    }

    /// A whole number in groups of three.
    pub fn grouped(count: u64) -> String {
        let digits = count.to_string();
        let groups = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy);
        groups.collect::<Vec<_>>().join(" ")
    }
}
