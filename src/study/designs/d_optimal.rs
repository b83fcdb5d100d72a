//! The velocity that adds most to the information's determinant.

use crate::num::link::Link;
use crate::study::binary_response::{fit, information};
use crate::study::outcomes::Outcomes;
use crate::study::search::highest;

/// Farther from μ, in σ, no shot tells anything.
const FARTHEST: f64 = 6.0;
/// Places tried before the search narrows.
const PLACES: usize = 240;

/// Velocity μ + z σ that maximises w(z) (I₀₀ z² − 2 I₀₁ z + I₁₁).
pub fn d_optimal(outcomes: &Outcomes, mu: f64, sigma: f64) -> f64 {
    let [[i00, i01], [_, i11]] = information(Link::Probit, outcomes, mu, sigma);
    let gain = |z: f64| Link::Probit.information(z) * (z * (i00 * z - 2.0 * i01) + i11);
    mu + sigma * highest(gain, -FARTHEST, FARTHEST, PLACES, 1e-7).0
}

/// Estimate that a design goes on with: μ within the range of the shots, σ no larger than it. Where σ is infinite, the middle of the mixed
/// results and that range.
pub(super) fn clipped(outcomes: &Outcomes) -> [f64; 2] {
    let [low, high] = outcomes.range();
    let mixed = [outcomes.slowest_perforation(), outcomes.fastest_stop()];
    let middle = 0.5 * mixed.map(|velocity| velocity.unwrap_or(0.5 * (low + high))).iter().sum::<f64>();
    let [mu, sigma] = fit(Link::Probit, outcomes).map_or([middle, high - low], |found| [found.mu, found.sigma]);
    [mu.clamp(low, high), sigma.min(high - low)]
}
