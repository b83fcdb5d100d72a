//! `ripstop sweep`: shots or a V50 at each point of a grid over any keys of a case.
//!
//! ```text
//! --over ──► points ──► a batch in a folder of its own for each ──► table, page
//! ```
//!
//! - [`factor`] reads what is varied and makes the grid.
//! - `campaign` runs the points; `places` puts them together for the page.
//! - `page` is `sweep.html`, `json` is `sweep.json`.

mod campaign;
pub mod factor;
mod json;
mod page;
mod places;

pub use campaign::{PointResult, SweepOf, SweepRequest, SweepResult, run, table};
pub use json::json;
pub use page::html;

/// Every file that is written; batches lie in `points`.
pub const FILES: &[&str] = &["plan.json", "sweep.csv", "sweep.html", "sweep.json"];
