//! `ripstop v50`: the velocity at which half of all shots perforate, from a case.
//!
//! ```text
//! case ──► thresholds of realisations ──► estimate ──► json, page
//! ```
//!
//! - [`threshold`] finds one threshold, `realisation` those of a realisation on both meshes, `campaign` those of many.
//! - [`refinement`] is what the converged mesh moves thresholds by.
//! - [`sample`] is the estimate from thresholds.
//! - `report` is `v50.json` and what is said in words, `page` is `v50.html`.

mod campaign;
mod estimate;
mod page;
mod realisation;
pub mod refinement;
mod report;
pub mod sample;
pub mod threshold;

pub use campaign::{V50Progress, run};
pub use estimate::{ResidualBand, V50Result, V50Width};
pub use page::html;
pub use refinement::Refinement;
pub use report::{json, notes};

/// Name of the table.
pub(super) const TABLE: &str = "v50.csv";
/// Name of the table of shots on the converged mesh.
pub(super) const REFINED_TABLE: &str = "v50-refined.csv";
/// Every file that is written.
pub const FILES: &[&str] = &["plan.json", TABLE, REFINED_TABLE, "v50.html", "v50.json"];
/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct V50Request {
    /// Realisations at most.
    pub count: u32,
    /// Half the width of the interval over V50 at which to stop early.
    pub until_width: Option<f64>,
    /// Width of the bracket of a threshold, over its lower end.
    pub bracket: f64,
    /// Realisations whose threshold is looked for on the converged mesh too, by which V50 is corrected.
    pub refined: u32,
    /// Two-sided confidence of all intervals.
    pub level: f64,
}
