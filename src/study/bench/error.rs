//! Differences of a run to the reference.

use crate::output::{csv, velocity_left};
use crate::run::outcome::Outcome;
use crate::run::{Run, Sample};

/// Differences between a run and the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Root mean square of the velocity difference over the time that both cover, over the velocity the reference lost in that time
    /// [-]; `None` where it lost none.
    pub velocity: Option<f64>,
    /// Velocity left when the run ends, as `summary.json` has it, less the reference's [m/s].
    pub residual_velocity: f64,
    /// Time at which the projectile came to rest, less the reference's [s]; `None` unless both did.
    pub stop_time: Option<f64>,
    /// Size of that difference: of the stop time over the reference's, else of the velocity left over the velocity that the reference
    /// lost in all [-]; `None` where that is zero.
    pub end: Option<f64>,
}

/// Velocity along the line of flight at a time [s], where the history covers it [m/s].
fn velocity_at(history: &[Sample], time: f64) -> Option<f64> {
    csv::between(history, time, |row| row.time, |row| row.projectile_velocity)
}

/// Differences of a run; `None` where the histories have no time in common.
pub(super) fn errors(reference: &Run, run: &Run) -> Option<Errors> {
    let residual_velocity = velocity_left(run)? - velocity_left(reference)?;
    let stop_time = reference.stop_time.zip(run.stop_time).map(|(expected, got)| got - expected);
    let lost = reference.history.first()?.projectile_velocity - velocity_left(reference)?;
    let end = match (stop_time, reference.stop_time) {
        (Some(difference), Some(expected)) => Some(difference.abs() / expected),
        _ => (lost > 0.0).then(|| residual_velocity.abs() / lost),
    };
    Some(Errors { velocity: velocity_error(&reference.history, &run.history)?, residual_velocity, stop_time, end })
}

/// Error of the velocity history [-], `None` within where the reference loses no velocity; `None` where there is no common time.
fn velocity_error(reference: &[Sample], run: &[Sample]) -> Option<Option<f64>> {
    let span = reference.last()?.time.min(run.last()?.time);
    let lost = velocity_at(reference, 0.0)? - velocity_at(reference, span)?;
    let squared = mean_square(reference, run, span)?;
    Some((lost > 0.0).then(|| squared.sqrt() / lost))
}

/// Mean square of the velocity difference over the rows of a run up to `span` [s], trapezoidal in time [m²/s²].
fn mean_square(reference: &[Sample], run: &[Sample], span: f64) -> Option<f64> {
    let times = run.iter().map(|row| row.time).filter(|time| *time < span).chain([span]);
    let mut last: Option<(f64, f64)> = None;
    let mut integral = 0.0;
    for time in times {
        let difference = velocity_at(run, time)? - velocity_at(reference, time)?;
        let square = difference * difference;
        if let Some((before, start)) = last {
            integral += 0.5 * (start + square) * (time - before);
        }
        last = Some((time, square));
    }
    (span > 0.0).then(|| integral / span)
}

/// Whether a run has the reference's outcome. One that went on after its projectile came to rest may have seen it
/// thrown back, which the reference did not wait for.
pub(super) fn same_outcome(reference: &Run, run: &Run) -> bool {
    let waited = run.history.last().is_some_and(|row| reference.history.last().is_some_and(|end| row.time > end.time));
    let thrown_back = (reference.outcome, run.outcome) == (Outcome::Stopped, Outcome::Rebounded) && waited;
    reference.outcome == run.outcome || thrown_back
}

#[cfg(test)]
#[path = "error_tests.rs"]
mod tests;
