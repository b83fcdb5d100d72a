//! Confidence intervals of the velocity at which the chance of a perforation is p.
//!
//! - Likelihood ratio: all velocities t with max over σ of ℓ(t − z_p σ, σ) ≥ ℓ̂ − ½ χ²₁. Along η = z_p + β (v − t) the log-likelihood is
//!   concave in β, and the set is an interval. It may have no end on a side: then a chance that does not depend on velocity explains the
//!   shots well enough. Where the estimate is Firth's, the likelihood has the same penalty.
//! - Wald: estimate ± z × standard error of the expected information. It is symmetric and too short for few shots.

use super::binary_response::{Estimate, LinearPredictor, Method, Problem};
use super::outcomes::Outcomes;
use super::search::{highest, outer_end, peak};
use crate::num::link::Link;
use crate::output::number::short;

/// Newton steps at most.
const STEPS: usize = 200;
/// Slope β beyond which a fit is a step: shots are then explained without a rest.
const STEEPEST: f64 = 1e9;

/// How an interval is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interval {
    /// Likelihood ratio.
    #[default]
    Likelihood,
    /// Estimate and standard error.
    Wald,
}

impl Interval {
    /// The word in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Likelihood => "likelihood",
            Self::Wald => "wald",
        }
    }
}

/// Ends of an interval; `None` where it has no end on that side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl Bounds {
    /// Whether a value lies inside.
    pub fn holds(&self, value: f64) -> bool {
        self.low.is_none_or(|low| low <= value) && self.high.is_none_or(|high| value <= high)
    }

    /// Whether half the width is at most this part of a value.
    pub fn is_narrow(&self, value: Option<f64>, part: f64) -> bool {
        let ends = value.zip(self.low.zip(self.high));
        ends.is_some_and(|(value, (low, high))| 0.5 * (high - low) <= part * value)
    }

    /// Both ends to four digits, as people read them.
    pub fn words(&self) -> [String; 2] {
        [self.low, self.high].map(|end| end.map_or_else(|| "no end".to_owned(), |end| short(end, 4)))
    }
}

/// Interval of the velocity at chance `p` with two-sided confidence `level`. Without an estimate it ends on one side at most, where one
/// outcome is missing.
pub fn interval(
    kind: Interval,
    link: Link,
    outcomes: &Outcomes,
    estimate: Option<&Estimate>,
    p: f64,
    level: f64,
) -> Bounds {
    let z = Link::Probit.quantile(0.5 + 0.5 * level);
    match (kind, estimate) {
        (Interval::Wald, None) => Bounds::default(),
        (Interval::Wald, Some(estimate)) => {
            let (middle, half) = (estimate.velocity(p), z * estimate.standard_error(p));
            Bounds { low: Some(middle - half), high: Some(middle + half) }
        }
        (Interval::Likelihood, _) => ProfileLikelihood::new(link, outcomes, estimate, p, 0.5 * z * z)
            .map_or_else(Bounds::default, |profile| profile.bounds()),
    }
}

/// Log-likelihood over the velocity t of one chance, σ chosen best at each. Velocities are those of the [`Problem`].
struct ProfileLikelihood {
    problem: Problem,
    /// η at that chance.
    z: f64,
    penalty: bool,
    /// What it may not fall below.
    cut: f64,
    /// A velocity inside, and the step from there to look for the ends.
    inside: f64,
    step: f64,
}

impl ProfileLikelihood {
    /// `None` where every velocity is inside.
    fn new(link: Link, outcomes: &Outcomes, estimate: Option<&Estimate>, p: f64, below: f64) -> Option<Self> {
        let problem = Problem::new(link, outcomes);
        let z = link.quantile(p);
        let profile = |problem: Problem, penalty, cut, inside, step| Self { problem, z, penalty, cut, inside, step };
        if let Some(estimate) = estimate {
            let (centre, scale) = (problem.centre, problem.scale);
            let line = LinearPredictor { alpha: (centre - estimate.mu) / estimate.sigma, beta: scale / estimate.sigma };
            let penalty = estimate.method == Method::Firth;
            let height = if penalty { problem.penalised(line) } else { problem.log_likelihood(line) };
            let inside = (estimate.velocity(p) - centre) / scale;
            return Some(profile(problem, penalty, height - below, inside, estimate.standard_error(p) / scale));
        }
        // A step beyond all shots explains one outcome without a rest.
        let [low, high] = [problem.points.first()?.u, problem.points.last()?.u];
        let inside = match outcomes.counts() {
            [0, _] => high + 1.0,
            [_, 0] => low - 1.0,
            _ => return None,
        };
        Some(profile(problem, false, -below, inside, 0.5))
    }

    fn bounds(&self) -> Bounds {
        let end = |side: f64| {
            let above = |t: f64| self.height(t) - self.cut;
            let find = || outer_end(above, self.inside, side * self.step, side * f64::INFINITY, 1e-10 * self.step);
            let t = if self.flat(side) >= self.cut { None } else { find() }?;
            Some(self.problem.centre + self.problem.scale * t)
        };
        Bounds { low: end(-1.0), high: end(1.0) }
    }

    /// Supremum far out on a side, where the chance no longer depends on velocity: it is then at most p above all shots, at least p below.
    fn flat(&self, side: f64) -> f64 {
        let line = |alpha: f64| LinearPredictor { alpha, beta: 0.0 };
        if self.penalty {
            let [low, high] = if side > 0.0 { [self.z - 20.0, self.z] } else { [self.z, self.z + 20.0] };
            return peak(|alpha| self.problem.penalised(line(alpha)), low, high, 1e-5).1;
        }
        let sum =
            |of: fn(&super::binary_response::StandardizedShots) -> f64| self.problem.points.iter().map(of).sum::<f64>();
        let (perforated, stopped) = (sum(|point| point.perforated), sum(|point| point.stopped));
        let best = match perforated / (perforated + stopped) {
            0.0 => f64::NEG_INFINITY,
            1.0 => f64::INFINITY,
            share => self.problem.link.quantile(share),
        };
        let alpha = if side > 0.0 { best.min(self.z) } else { best.max(self.z) };
        if alpha.is_infinite() { 0.0 } else { self.problem.log_likelihood(line(alpha)) }
    }

    /// η = z + β (u − t).
    fn line(&self, t: f64, beta: f64) -> LinearPredictor {
        LinearPredictor { alpha: self.z - beta * t, beta }
    }

    /// The largest log-likelihood at t.
    fn height(&self, t: f64) -> f64 {
        if self.penalty {
            let at = |log: f64| self.problem.penalised(self.line(t, log.exp()));
            let at = |log: f64| Some(at(log)).filter(|height| height.is_finite()).unwrap_or(f64::NEG_INFINITY);
            return highest(at, -12.0, 8.0, 16, 1e-5).1;
        }
        self.problem.log_likelihood(self.line(t, self.steepness(t)))
    }

    /// The best β ≥ 0 at t: Newton's method between bounds.
    fn steepness(&self, t: f64) -> f64 {
        let link = self.problem.link;
        let slopes = |beta: f64| {
            let mut sum = [0.0; 2];
            for point in &self.problem.points {
                let d = point.u - t;
                let eta = self.z + beta * d;
                let [pass, stop] = [(point.perforated, eta, 1.0), (point.stopped, -eta, -1.0)];
                for (count, eta, sign) in [pass, stop] {
                    if count > 0.0 {
                        let [slope, curvature] = link.slope_and_curvature(eta);
                        sum[0] += sign * d * count * slope;
                        sum[1] += d * d * count * curvature;
                    }
                }
            }
            sum
        };
        if slopes(0.0)[0] <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        while slopes(high)[0] > 0.0 {
            low = high;
            high *= 4.0;
            if high > STEEPEST {
                return high;
            }
        }
        let mut beta = 0.5 * (low + high);
        for _ in 0..STEPS {
            let [slope, curvature] = slopes(beta);
            if slope > 0.0 {
                low = beta
            } else {
                high = beta
            }
            let next = beta + slope / curvature;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            // The height at the maximum is off by the square of this.
            if (next - beta).abs() <= 1e-7 * beta {
                return next;
            }
            beta = next;
        }
        beta
    }
}
