//! What chance does to a residual velocity: shots at places closer to each other than the diameter of a fibre.
//!
//! Once yarns break, which one breaks next hangs on anything. A residual velocity is then a draw, and two of them say little about
//! what was varied between them; means of many do. Shots a nanometre apart still break alike for a while and understate it.

use crate::output::velocity_left;
use crate::run::Run;

/// Shots of one setting.
pub(super) const SHOTS: usize = 16;
/// Those of a quick look.
pub(super) const SHOTS_QUICK: usize = 4;
/// Farthest along warp and weft that they are off the place that is meant [mm]: half the diameter of an aramid fibre.
pub(crate) const OFF: f64 = 0.006;

/// Residual velocities of shots that differ by nothing one could set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Mean [m/s].
    pub mean: f64,
    /// Standard deviation of one shot [m/s].
    pub deviation: f64,
    /// The smallest and the largest [m/s].
    pub range: [f64; 2],
    /// Shots.
    pub shots: usize,
}

impl Scatter {
    /// Of two velocities [m/s] or more.
    pub fn of(velocities: &[f64]) -> Option<Self> {
        let shots = velocities.len();
        if shots < 2 {
            return None;
        }
        let mean = velocities.iter().sum::<f64>() / shots as f64;
        let squares: f64 = velocities.iter().map(|velocity| (velocity - mean).powi(2)).sum();
        let range = [f64::min, f64::max].map(|pick| velocities.iter().copied().reduce(pick).unwrap_or(mean));
        Some(Self { mean, deviation: (squares / (shots - 1) as f64).sqrt(), range, shots })
    }

    /// Standard error of the mean [m/s].
    pub fn error(&self) -> f64 {
        self.deviation / (self.shots as f64).sqrt()
    }
}

/// Shifts along warp and weft [mm], spread evenly over a square of twice [`OFF`]; none is a mirror image of another, none is zero.
pub(super) fn shifts(shots: usize) -> impl Iterator<Item = [f64; 2]> {
    // Multiples of 1/ρ and 1/ρ², ρ³ = ρ + 1, leave no gaps in a square (Roberts 2018).
    const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    (1..=shots).map(|shot| STEPS.map(|step| OFF * (2.0 * (shot as f64 * step).fract() - 1.0)))
}

/// The velocity left [m/s] of a shot that did not become unstable.
pub(super) fn left(run: &Run) -> Option<f64> {
    super::complete(run).then(|| velocity_left(run)).flatten()
}

#[cfg(test)]
#[path = "scatter_tests.rs"]
mod tests;
