//! V50 from the thresholds of realisations, each known by itself: a sample of the distribution of thresholds.
//!
//! Thresholds are taken as normal. The interval of a quantile q is that of the likelihood ratio, with σ chosen best at each q; what it may
//! fall by is ½ n ln\[1 + t²/(n − 1)\] with Student's t, so that the interval of the mean is exact for normal thresholds, whatever their number.

use crate::num::link::Link;
use crate::study::interval::Bounds;
use crate::study::search::{outer_end, peak};
use crate::study::student_t;

/// Range of ln(σ/σ̂) that is searched.
const SPREAD: f64 = 6.0;

/// Thresholds as a normal sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThresholdSample {
    /// How many.
    pub count: usize,
    /// Mean: V50, in the unit of the thresholds.
    pub mean: f64,
    /// Standard deviation, without what the width of the brackets adds.
    pub sigma: f64,
    /// Least and largest.
    pub range: [f64; 2],
}

impl ThresholdSample {
    /// The sample of these thresholds, each the middle of a bracket of this width; `None` of none.
    pub fn new(thresholds: &[f64], bracket: f64) -> Option<Self> {
        let n = thresholds.len() as f64;
        let mean = thresholds.iter().sum::<f64>() / n;
        let squares: f64 = thresholds.iter().map(|threshold| (threshold - mean).powi(2)).sum();
        let variance = if n > 1.0 { squares / (n - 1.0) } else { 0.0 };
        let range = thresholds.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], threshold| {
            [low.min(*threshold), high.max(*threshold)]
        });
        // Sheppard: a value rounded to a width scatters by that width over √12 more.
        let sigma = (variance - bracket * bracket / 12.0).max(0.0).sqrt();
        (!thresholds.is_empty()).then_some(Self { count: thresholds.len(), mean, sigma, range })
    }

    /// Threshold that a part `p` of the realisations lies below.
    pub fn quantile(&self, p: f64) -> f64 {
        self.mean + self.sigma * Link::Probit.quantile(p)
    }

    /// Part of the realisations that are perforated at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        match self.sigma {
            sigma if sigma > 0.0 => Link::Probit.probability((velocity - self.mean) / sigma),
            _ if velocity < self.mean => 0.0,
            _ => 1.0,
        }
    }

    /// Interval of [`ThresholdSample::quantile`] with this two-sided confidence; without ends of fewer than two thresholds.
    pub fn interval(&self, p: f64, level: f64) -> Bounds {
        let value = self.quantile(p);
        let n = self.count as f64;
        if self.count < 2 {
            return Bounds::default();
        }
        if self.sigma == 0.0 {
            return Bounds { low: Some(value), high: Some(value) };
        }
        let t = student_t::quantile(level, self.count as u64 - 1);
        let fall = 0.5 * n * (t * t / (n - 1.0)).ln_1p();
        let most_likely = (1.0 - 1.0 / n) * self.sigma * self.sigma;
        let z = Link::Probit.quantile(p);
        // Log-likelihood over its part that does not change, with the best σ.
        let height = |q: f64| {
            let at = |log: f64| {
                let sigma = self.sigma * log.exp();
                let off = self.mean - q + z * sigma;
                -n * log - 0.5 * n * (most_likely + off * off) / (sigma * sigma)
            };
            peak(at, -SPREAD, SPREAD, 1e-9).1
        };
        let best = -0.5 * n * (1.0 - 1.0 / n).ln() - 0.5 * n;
        let above = |q: f64| height(q) - (best - fall);
        let step = 0.5 * self.sigma / n.sqrt();
        let end = |side: f64| outer_end(above, value, side * step, side * f64::INFINITY, 1e-9 * self.sigma);
        Bounds { low: end(-1.0), high: end(1.0) }
    }
}

#[cfg(test)]
#[path = "sample_tests.rs"]
mod tests;
