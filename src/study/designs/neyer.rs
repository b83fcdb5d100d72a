//! Neyer's D-optimal design (1994), as in MIL-STD-331.

use super::d_optimal::{clipped, d_optimal};
use crate::study::outcomes::{Outcomes, Shot};

/// What the guess of σ is multiplied with after each shot that was to give overlap.
const SHRINK: f64 = 0.8;

/// Guesses it starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neyer {
    /// Lower guess of V50.
    pub low: f64,
    /// Upper guess of V50.
    pub high: f64,
    /// Guess of σ.
    pub sigma: f64,
}

impl Neyer {
    /// Velocity of the next shot.
    pub fn next(&self, shots: &[Shot]) -> f64 {
        let seen: Outcomes = shots.iter().collect();
        let [slowest, fastest] = seen.range();
        let Some(gap) = seen.gap() else {
            return match shots.last() {
                None => 0.5 * (self.low + self.high),
                Some(shot) if shot.perforated => {
                    (0.5 * (self.low + slowest)).min(slowest - 2.0 * self.sigma).min(2.0 * slowest - fastest)
                }
                Some(_) => (0.5 * (self.high + fastest)).max(fastest + 2.0 * self.sigma).max(2.0 * fastest - slowest),
            };
        };
        if gap < 0.0 {
            let [mu, sigma] = clipped(&seen);
            return d_optimal(&seen, mu, sigma);
        }
        let middle = seen.fastest_stop().map_or(f64::NAN, |stop| stop + 0.5 * gap);
        let sigma = self.sigma_after(shots);
        if wider(gap, sigma, shots) { middle } else { d_optimal(&seen, middle, sigma.min(fastest - slowest)) }
    }

    /// The guess of σ once these shots are known: less after each that was placed with it.
    fn sigma_after(&self, shots: &[Shot]) -> f64 {
        (0..shots.len()).fold(self.sigma, |sigma, before| {
            let seen: Outcomes = shots[..before].iter().collect();
            let placed = seen.gap().is_some_and(|gap| gap >= 0.0 && !wider(gap, sigma, shots));
            if placed { SHRINK * sigma } else { sigma }
        })
    }
}

/// Whether a gap exceeds σ, by more than rounding of the velocities.
fn wider(gap: f64, sigma: f64, shots: &[Shot]) -> bool {
    let largest = shots.iter().map(|shot| shot.velocity.abs()).fold(0.0, f64::max);
    gap > sigma + 1e-12 * largest
}
