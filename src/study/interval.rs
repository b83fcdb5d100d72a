//! Confidence intervals of the velocity at which the chance of a perforation is p, by the likelihood ratio.
//!
//! They hold all velocities t with max over σ of ℓ(t − z_p σ, σ) ≥ ℓ̂ − ½ χ²₁. Along η = z_p + β (v − t) the log-likelihood is concave in β,
//! and the set is an interval. It may have no end on a side: then a chance that does not depend on velocity explains the shots well enough.
//! Where the estimate is Firth's, the likelihood has the same penalty.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use serde::Serialize;

use super::binary_response::{Estimate, LinearPredictor, Outcomes, Problem};
use crate::num::random::normal;
use crate::output::number::short;

/// Newton steps, and halvings of a bracket, at most.
const STEPS: usize = 200;
/// Part of the larger side that golden sections keep.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Ends of an interval; `None` where it has no end on that side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bounds {
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl Bounds {
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
pub fn interval(outcomes: &Outcomes, estimate: Option<&Estimate>, p: f64, level: f64) -> Bounds {
    let z = normal::quantile(0.5 + 0.5 * level);
    ProfileLikelihood::new(outcomes, estimate, p, 0.5 * z * z).map_or_else(Bounds::default, |profile| profile.bounds())
}

/// Log-likelihood over the velocity t of one chance, σ chosen best at each. Velocities are those of the [`Problem`].
struct ProfileLikelihood {
    problem: Problem,
    /// η at that chance.
    z: f64,
    penalty: bool,
    /// Least height inside.
    cut: f64,
    /// A velocity inside, and the step from there to look for the ends.
    inside: f64,
    step: f64,
}

impl ProfileLikelihood {
    /// `None` where every velocity is inside.
    fn new(outcomes: &Outcomes, estimate: Option<&Estimate>, p: f64, below: f64) -> Option<Self> {
        let problem = Problem::new(outcomes);
        let z = normal::quantile(p);
        if let Some(estimate @ Estimate { mu, sigma, firth, .. }) = estimate {
            let (centre, scale) = (problem.centre, problem.scale);
            let height = problem.height(LinearPredictor::new((centre - mu) / sigma, scale / sigma), *firth);
            let inside = (estimate.velocity(p) - centre) / scale;
            // About the standard error of V50.
            let step = sigma / (scale * (outcomes.counts().iter().sum::<u64>() as f64).sqrt());
            return Some(Self { problem, z, penalty: *firth, cut: height - below, inside, step });
        }
        // A step beyond all shots explains one outcome without a rest.
        let [low, high] = [problem.points.first()?.u, problem.points.last()?.u];
        let inside = match outcomes.counts() {
            [0, _] => high + 1.0,
            [_, 0] => low - 1.0,
            _ => return None,
        };
        Some(Self { problem, z, penalty: false, cut: -below, inside, step: 0.5 })
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
        let height = |alpha: f64| self.problem.height(LinearPredictor::new(alpha, 0.0), self.penalty);
        let [low, high] = if side > 0.0 { [self.z - 20.0, self.z] } else { [self.z, self.z + 20.0] };
        peak(height, low, high, 1e-5).1
    }

    /// η = z + β (u − t).
    fn line(&self, t: f64, beta: f64) -> LinearPredictor {
        LinearPredictor::new(self.z - beta * t, beta)
    }

    /// Largest log-likelihood at t. It is concave in β; the penalised one may have several maxima.
    fn height(&self, t: f64) -> f64 {
        // Logarithms of β per spread of the velocities: from a chance that hardly changes to a step.
        let (low, high, places) = if self.penalty { (-12.0, 8.0, 16) } else { (-12.0, 21.0, 1) };
        let at = |log: f64| Some(self.problem.height(self.line(t, log.exp()), self.penalty));
        let at = |log: f64| at(log).filter(|height| height.is_finite()).unwrap_or(f64::NEG_INFINITY);
        highest(at, low, high, places, 1e-5).1
    }
}

/// Root of a function between `a` and `b`, to within `tolerance`: regula falsi (Illinois), halved where that is slow.
fn root(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64, tolerance: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    for step in 0..STEPS {
        let middle = if step % 3 == 2 { 0.5 * (a + b) } else { (a * fb - b * fa) / (fb - fa) };
        let x = if middle > a.min(b) && middle < a.max(b) { middle } else { 0.5 * (a + b) };
        let fx = f(x);
        if fx == 0.0 || (b - a).abs() <= tolerance {
            return x;
        }
        if (fx > 0.0) == (fb > 0.0) {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (x, fx);
    }
    b
}

/// End of an interval around `inside`: the place where a function, positive inside, becomes negative. The search takes steps that double,
/// the first with the sign of the side, up to `last`; `None`: there is no end before it.
pub(super) fn outer_end(f: impl Fn(f64) -> f64, inside: f64, step: f64, last: f64, tolerance: f64) -> Option<f64> {
    let (mut inside, mut step) = (inside, step);
    for _ in 0..STEPS {
        let next = if step > 0.0 { (inside + step).min(last) } else { (inside + step).max(last) };
        if f(next) < 0.0 {
            return Some(root(f, inside, next, tolerance));
        }
        if next == last {
            return None;
        }
        inside = next;
        step *= 2.0;
    }
    None
}

/// Place, to within `tolerance`, and height of the maximum of a function with one, by golden sections.
pub(super) fn peak(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64, tolerance: f64) -> (f64, f64) {
    let inner = |low: f64, high: f64| [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..STEPS {
        if high - low <= tolerance {
            break;
        }
        if fa < fb {
            (low, a, fa) = (a, b, fb);
            b = inner(low, high)[1];
            fb = f(b);
        } else {
            (high, b, fb) = (b, a, fa);
            a = inner(low, high)[0];
            fa = f(a);
        }
    }
    if fa < fb { (b, fb) } else { (a, fa) }
}

/// Place and height of the largest of several maxima: first the best of evenly spaced places.
pub(super) fn highest(f: impl Fn(f64) -> f64, low: f64, high: f64, count: usize, tolerance: f64) -> (f64, f64) {
    let width = (high - low) / count as f64;
    let at = |n: usize| low + width * n as f64;
    let best = (0..=count)
        .map(|n| (at(n), f(at(n))))
        .fold((low, f64::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best });
    let found = peak(&f, (best.0 - width).max(low), (best.0 + width).min(high), tolerance);
    if found.1 > best.1 { found } else { best }
}

/// Student's t with P(|T| ≤ t) = `level`.
pub(super) fn student_t(level: f64, degrees: u64) -> f64 {
    let root_of_degrees = (degrees as f64).sqrt();
    root_of_degrees * root(|angle| within(angle, degrees) - level, 0.0, FRAC_PI_2, 1e-15).tan()
}

/// P(|T| ≤ √ν tan θ) as a finite sum (Abramowitz & Stegun 26.7.3, 26.7.4).
fn within(angle: f64, degrees: u64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let odd = degrees % 2;
    let mut term = if odd == 1 { cosine } else { 1.0 };
    let mut sum = 0.0;
    let mut n = 2 + odd;
    while n <= degrees {
        sum += term;
        term *= cosine * cosine * (n - 1) as f64 / n as f64;
        n += 2;
    }
    if odd == 1 { FRAC_2_PI * (angle + sine * sum) } else { sine * sum }
}

/// Thresholds as a normal sample.
///
/// The interval of a quantile q is that of the likelihood ratio, with σ chosen best at each q. It ends where the log-likelihood has fallen
/// by ½ n ln\[1 + t²/(n − 1)\] with Student's t, so that the interval of the mean is exact for normal thresholds, whatever their number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThresholdSample {
    /// Number of thresholds.
    pub count: usize,
    /// Mean: V50, in the unit of the thresholds.
    pub mean: f64,
    /// Standard deviation, without what the width of the brackets adds.
    pub sigma: f64,
}

impl ThresholdSample {
    /// Sample of thresholds, each the middle of a bracket of this width; `None` of none.
    pub fn new(thresholds: &[f64], bracket: f64) -> Option<Self> {
        let n = thresholds.len() as f64;
        let mean = thresholds.iter().sum::<f64>() / n;
        let squares: f64 = thresholds.iter().map(|threshold| (threshold - mean).powi(2)).sum();
        let variance = if n > 1.0 { squares / (n - 1.0) } else { 0.0 };
        // Sheppard: a value rounded to a width scatters by that width over √12 more.
        let sigma = (variance - bracket * bracket / 12.0).max(0.0).sqrt();
        (!thresholds.is_empty()).then_some(Self { count: thresholds.len(), mean, sigma })
    }

    /// Threshold that a part `p` of the realisations lies below.
    pub fn quantile(&self, p: f64) -> f64 {
        self.mean + self.sigma * normal::quantile(p)
    }

    /// Part of the realisations that are perforated at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        match self.sigma {
            sigma if sigma > 0.0 => normal::probability((velocity - self.mean) / sigma),
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
        let t = student_t(level, self.count as u64 - 1);
        let fall = 0.5 * n * (t * t / (n - 1.0)).ln_1p();
        let most_likely = (1.0 - 1.0 / n) * self.sigma * self.sigma;
        let z = normal::quantile(p);
        // Log-likelihood over its part that does not change, with the best σ.
        let height = |q: f64| {
            let off = self.mean - q;
            let sigma = 0.5 * (off * z + (off * off * (z * z + 4.0) + 4.0 * most_likely).sqrt());
            -n * (sigma / self.sigma).ln() - 0.5 * n * (most_likely + (off + z * sigma).powi(2)) / (sigma * sigma)
        };
        let best = -0.5 * n * (1.0 - 1.0 / n).ln() - 0.5 * n;
        let above = |q: f64| height(q) - (best - fall);
        let step = 0.5 * self.sigma / n.sqrt();
        let end = |side: f64| outer_end(above, value, side * step, side * f64::INFINITY, 1e-9 * self.sigma);
        Bounds { low: end(-1.0), high: end(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::student_t;

    /// Table of Abramowitz & Stegun, 26.10: P(|T| ≤ t).
    #[test]
    fn quantiles_of_students_t_are_the_printed_ones() {
        for (level, degrees, expected) in
            [(0.9, 1, 6.314), (0.9, 2, 2.920), (0.9, 30, 1.697), (0.95, 5, 2.571), (0.99, 120, 2.617)]
        {
            let got = student_t(level, degrees);
            assert!((got - expected).abs() < 6e-4, "{level} {degrees}: {got} instead of {expected}");
        }
    }
}
