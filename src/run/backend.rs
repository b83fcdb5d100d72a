//! What the host loop asks of whatever computes a run.

use super::record::RunRecord;
use super::{Observer, Progress, Run};
use crate::case::Case;

/// A run in progress.
pub(crate) trait Backend {
    /// Whether the last step taken ends the run.
    fn is_finished(&self, case: &Case) -> bool;
    /// Time of the positions that the next step begins from [s].
    fn next_time(&self) -> f64;
    /// [s]
    fn time_step(&self) -> f64;
    /// What the run has produced so far.
    fn record(&mut self) -> &mut RunRecord;
    /// One step, or a batch of them. The watcher sees the state before a step where that is due. True where there is news of progress.
    fn advance(&mut self, case: &Case, watch: &mut dyn Observer) -> bool;
    /// Lets the watcher save the run, unless it has not begun or its end is on the way. `loop_seconds`: time in the loop so far [s].
    fn keep(&mut self, case: &Case, watch: &mut dyn Observer, loop_seconds: f64);
    /// Shows the watcher the state after the last step.
    fn show_end(&mut self, watch: &mut dyn Observer);
    /// Where the run is.
    fn progress(&self, case: &Case) -> Progress;
    /// The result. `loop_seconds`: time spent in the loop [s].
    fn finish(self, loop_seconds: f64) -> Run;
}
