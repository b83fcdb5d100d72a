//! Studies: many runs of a case, and the ballistic limit that shots give, computed or fired at a range.
//!
//! ```text
//! case ──► batch ──► table of shots ──► fit or thresholds ──► limit ──► report
//! ```
//!
//! - [`batch`] computes shots of a case, on the processor or on a device, and keeps their rows.
//! - [`shots`] is `ripstop shots`, [`v50`] is `ripstop v50`, [`sweep`] runs either at many points, [`fit`] is `ripstop fit`,
//!   [`bench`](mod@bench) is `ripstop bench`.
//! - [`binary_response`] counts what became of shots and fits V50 and scatter with their confidence,
//!   [`normal`](crate::num::random::normal) is how the chance of a perforation grows with velocity.
//! - [`limit`] has what a fit and thresholds have alike: quantiles, and the limit from residual velocities.
//! - [`report`] holds a result in words, tables and figures, for the terminal and the page.
//!
//! Velocities are in m/s; of a table of shots, which [`fit`] reads, in the unit of its heading.

pub mod batch;
pub mod bench;
pub mod binary_response;
pub mod fit;
pub mod limit;
pub mod report;
pub mod shots;
pub mod sweep;
pub mod v50;
pub mod v50_result;
