//! Two curves over time, held against each other.
//!
//! Between its points a curve is straight. So the difference of two is straight between the times of both, taken together: its largest
//! magnitude lies at one of them, and the integral of its square is exact.

use crate::output::history::between;

/// Points of a curve: time and value, times ascending.
pub type Points = Vec<[f64; 2]>;

/// How one curve differs from another where both are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveDifference {
    /// First and last time that both cover.
    pub span: [f64; 2],
    /// The difference of largest magnitude, other less first.
    pub largest: f64,
    /// When that is, for the first time.
    pub at: f64,
    /// Root of the mean square over the span.
    pub rms: f64,
    /// Largest magnitude of the first curve in the span, what shares are taken of; 1 of what is a share already.
    pub scale: f64,
    /// When the difference first exceeds the share asked for.
    pub parts_at: Option<f64>,
}

impl CurveDifference {
    /// Largest magnitude over the scale; `None` where the first curve is zero and the other is not.
    pub fn share(&self) -> Option<f64> {
        share(self.largest.abs(), self.scale)
    }

    /// Root mean square over the scale.
    pub(crate) fn rms_share(&self) -> Option<f64> {
        share(self.rms, self.scale)
    }

    /// Whether the curves are the same, digit for digit.
    pub fn is_zero(&self) -> bool {
        self.largest == 0.0
    }
}

/// A difference over a scale; nothing over nothing is nothing.
pub(super) fn share(difference: f64, scale: f64) -> Option<f64> {
    match scale.abs() {
        _ if difference == 0.0 => Some(0.0),
        0.0 => None,
        scale => Some(difference / scale),
    }
}

/// A curve at a time, linear between its points; `None` outside them.
pub fn at(points: &[[f64; 2]], time: f64) -> Option<f64> {
    between(points, time, |point| point[0], |point| point[1])
}

/// Compares two curves. `part`: share of the scale from which on they count as parted.
///
/// `None` where no time is covered by both.
pub fn difference(first: &[[f64; 2]], other: &[[f64; 2]], part: f64) -> Option<CurveDifference> {
    scaled(first, other, part, None)
}

/// The same with a given scale, where there is one.
pub(super) fn scaled(first: &[[f64; 2]], other: &[[f64; 2]], part: f64, scale: Option<f64>) -> Option<CurveDifference> {
    let span = [first.first()?[0].max(other.first()?[0]), first.last()?[0].min(other.last()?[0])];
    let mut times: Vec<f64> =
        [first, other].into_iter().flatten().map(|p| p[0]).filter(|t| (span[0]..=span[1]).contains(t)).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let values: Vec<[f64; 3]> = times
        .iter()
        .map(|time| {
            let (a, b) = (at(first, *time)?, at(other, *time)?);
            Some([*time, a, b - a])
        })
        .collect::<Option<_>>()?;
    let start = *values.first()?;
    let worst = values.iter().fold(start, |worst, v| if v[2].abs() > worst[2].abs() { *v } else { worst });
    let scale = scale.unwrap_or_else(|| values.iter().map(|v| v[1].abs()).fold(0.0, f64::max));
    // The square of what is straight between d and e has the mean (d² + de + e²)/3.
    let mean_square = |[d, e]: [f64; 2]| (d * d + d * e + e * e) / 3.0;
    let integral: f64 = values.windows(2).map(|v| (v[1][0] - v[0][0]) * mean_square([v[0][2], v[1][2]])).sum();
    let length = span[1] - span[0];
    let rms = if length > 0.0 { (integral / length).sqrt() } else { start[2].abs() };
    let limit = part * scale;
    Some(CurveDifference { span, largest: worst[2], at: worst[0], rms, scale, parts_at: parts_at(&values, limit) })
}

/// When the magnitude of the difference first exceeds a limit. `values`: time, first, difference.
fn parts_at(values: &[[f64; 3]], limit: f64) -> Option<f64> {
    let beyond = values.iter().position(|v| v[2].abs() > limit)?;
    let [time, _, difference] = values[beyond];
    let Some([before, _, last]) = beyond.checked_sub(1).map(|n| values[n]) else { return Some(time) };
    let share = (limit.copysign(difference) - last) / (difference - last);
    Some(before + share * (time - before))
}

#[cfg(test)]
#[path = "curve_tests.rs"]
mod tests;
