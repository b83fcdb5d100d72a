//! Studies: many runs of a case, and the ballistic limit that shots give, computed or fired at a range.
//!
//! ```text
//! case ──► batch ──► shot_table ──► fit or threshold ──► limit ──► report
//! ```
//!
//! - [`batch`] computes shots of a case, on the processor or on a device, and keeps their rows.
//! - [`shots`] is `ripstop shots`, [`v50`] is `ripstop v50`, [`sweep`] runs either at many points, [`fit`] is `ripstop fit`.
//! - [`outcomes`] counts what became of shots; [`link`](crate::num::link) is how the chance of a perforation grows with velocity.
//! - [`binary_response`] fits V50 and scatter, [`interval`] gives their confidence, [`residual_fit`] the limit from residual velocities.
//! - [`report`] holds a result in words, tables and figures, for the terminal and the page.
//!
//! Velocities have the unit of the shots; [`outcomes::RULES`] are in m/s.

pub mod batch;
pub mod bench;
pub mod binary_response;
pub mod fit;
pub mod interval;
pub mod limit;
mod on_device;
pub mod outcomes;
pub mod report;
pub mod residual_fit;
pub mod shot_table;
pub mod shots;
pub mod sweep;
pub mod threshold;
pub mod v50;
pub mod v50_result;
pub mod verify;

/// Table, curve or option that a study cannot be made with.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("error: {place}\n  expected: {expected}\n  found: {found}\n  help: {help}")]
pub struct StudyError {
    /// File, with line and column where there are some; or option.
    pub place: String,
    /// Values that may stand there.
    pub expected: String,
    /// Value that stands there.
    pub found: String,
    /// Remedy.
    pub help: String,
}

impl StudyError {
    fn new(
        place: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self { place: place.into(), expected: expected.into(), found: found.into(), help: help.into() }
    }
}
