//! `ripstop sweep`: shots or a V50 at each point of a grid, or at Sobol's points, of any keys of a case.
//!
//! ```text
//! --over ──► points ──► a batch in a folder of its own for each ──► table, page
//! ```
//!
//! - [`factor`] reads what is varied, [`sobol`] gives points that fill a box evenly.
//! - `campaign` runs the points; [`effects`] is what the page and the terminal make of them; `page` is `sweep.html`.

mod campaign;
pub mod effects;
pub mod factor;
mod page;
pub mod sobol;

pub use campaign::{PointResult, SweepOf, SweepRequest, run, table};
pub use page::html;

/// Every file that is written; batches lie in `points`.
pub const FILES: [&str; 3] = ["plan.json", "sweep.csv", "sweep.html"];
