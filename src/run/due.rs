//! When the next record of a run is due. Time alone decides, so that every backend records the same samples.

use crate::case::Case;

/// Whether positions at `time` belong into the history, whose last row is at `last` [s].
pub(super) fn sample_due(case: &Case, last: Option<f64>, time: f64, dt: f64) -> bool {
    let next = last.map_or(0.0, |last| {
        // The next multiple of the interval after the last row.
        let rows = (last / case.output.history_interval + 1e-9).floor() + 1.0;
        rows * case.output.history_interval
    });
    time >= next - SLACK * dt || time_up(case, time, dt)
}

/// Least time between two looks at what fabric hangs on, which take the whole state [s].
const LOOKS: f64 = 10e-6;

/// Whether a sample at `time`, the last one at `last` [s], is the first after a multiple of [`LOOKS`], or the last of all: time alone
/// decides, so that every backend looks at the same samples.
pub(super) fn look_due(case: &Case, last: Option<f64>, time: f64, dt: f64) -> bool {
    let count = |time: f64| (time / LOOKS + 1e-9).floor();
    time_up(case, time, dt) || last.is_none_or(|last| count(time) > count(last))
}

/// Whether the run's time ends with positions at `time` [s].
pub(super) fn time_up(case: &Case, time: f64, dt: f64) -> bool {
    time >= case.solver.end_time - SLACK * dt
}

/// Rounding allowed in comparing times, in steps.
pub(super) const SLACK: f64 = 1e-6;
