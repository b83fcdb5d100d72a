//! `ripstop sweep`: shots or a V50 at each point of a grid, or at Sobol's points, of any keys of a case.
//!
//! ```text
//! --over ──► points ──► a batch in a folder of its own for each ──► table, page
//! ```
//!
//! - [`factor`] reads what is varied, [`design`] chooses the points, [`sobol`] fills a box evenly.
//! - `campaign` runs the points; [`effects`] and [`indices`] say what each key does, `places` puts the points together for them.
//! - `page` is `sweep.html`, `json` is `sweep.json`.

mod campaign;
pub mod design;
pub mod effects;
pub mod factor;
pub mod indices;
mod json;
mod page;
mod places;
pub mod sobol;

pub use campaign::{PointResult, SweepOf, SweepRequest, SweepResult, run, table};
pub use json::json;
pub use page::{html, variance_parts};
pub use places::KeyEffect;
pub(crate) use places::key_effects;

/// Every file that is written; batches lie in `points`.
pub const FILES: &[&str] = &["plan.json", "sweep.csv", "sweep.html", "sweep.json"];
