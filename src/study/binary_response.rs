//! Ballistic limit of binary outcomes: P(perforation) = F((v − μ)/σ) with the normal distribution F, fitted by maximum
//! likelihood.
//!
//! The fit runs over η = α + β u with the velocity u from its mean and over its spread; the log-likelihood is concave in (α, β). Without
//! overlap it has no maximum: β grows without bound. Firth's penalty, half the logarithm of the information's determinant in (α, β),
//! gives a finite estimate there (Kosmidis & Firth 2021).
//!
//! Intervals of the velocity at which the chance of a perforation is p are those of the likelihood ratio: all velocities t with max over σ of
//! ℓ(t − z_p σ, σ) ≥ ℓ̂ − ½ χ²₁. Along η = z_p + β (v − t) the log-likelihood is concave in β, and the set is an interval. It may have no end
//! on a side: then a chance that does not depend on velocity explains the shots well enough. Where the estimate is Firth's, the likelihood has
//! the same penalty.

use nalgebra::{Matrix2, Vector2};

use super::limit::{Bounds, QUANTILES, Quantile, highest, outer_end, peak, student_t};
use crate::num::random::normal;

/// Steps of a fit at most. From these starts 5 to 20 are needed.
const STEPS: usize = 500;
/// Newton decrement below which heights differ by rounding only: the log-likelihood is then within half of it.
const CLOSE: f64 = 1e-10;
/// Newton decrement of steps that move no digit.
const NOTHING: f64 = 1e-28;
/// Share of a step that must lead upwards.
const SHORTEST: f64 = 1e-9;

/// Reasons why shots give no estimate.
pub const NO_SHOTS: &str = "there are no shots";
/// One outcome is missing.
pub const ALL_PERFORATED: &str = "every shot perforated: the limit lies lower, by how much is unknown";
/// One outcome is missing.
pub const ALL_STOPPED: &str = "every shot was stopped: the limit lies higher, by how much is unknown";
/// Velocity was not varied.
pub const ONE_VELOCITY: &str = "all shots have one velocity: how the chance grows with velocity is unknown";
/// Scatter is infinite or negative.
pub const INVERTED: &str = "perforations are no faster than stops on the mean: velocity does not explain the outcomes";
/// The search did not end.
const UNSETTLED: &str = "the fit did not converge";

/// Shots of one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Impact velocity.
    pub velocity: f64,
    /// Shots that perforated.
    pub perforated: u64,
    /// Shots that were stopped.
    pub stopped: u64,
}

impl Group {
    /// Number of shots.
    pub fn count(&self) -> u64 {
        self.perforated + self.stopped
    }
}

/// Shots by velocity, ascending; every velocity once, none without a shot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcomes {
    groups: Vec<Group>,
}

impl Outcomes {
    /// Outcomes of groups, those of the same velocity put together.
    pub fn new(groups: impl IntoIterator<Item = Group>) -> Self {
        let mut all: Vec<Group> = groups.into_iter().filter(|group| group.count() > 0).collect();
        all.sort_by(|a, b| a.velocity.total_cmp(&b.velocity));
        all.dedup_by(|next, group| {
            let same = next.velocity == group.velocity;
            if same {
                group.perforated += next.perforated;
                group.stopped += next.stopped;
            }
            same
        });
        Self { groups: all }
    }

    /// Groups by velocity.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Numbers of perforations and of stops.
    pub fn counts(&self) -> [u64; 2] {
        let sum = |of: fn(&Group) -> u64| self.groups.iter().map(of).sum();
        [sum(|group| group.perforated), sum(|group| group.stopped)]
    }

    /// Velocity of the slowest perforation.
    pub fn slowest_perforation(&self) -> Option<f64> {
        self.groups.iter().find(|group| group.perforated > 0).map(|group| group.velocity)
    }

    /// Velocity of the fastest stop.
    pub fn fastest_stop(&self) -> Option<f64> {
        self.groups.iter().rev().find(|group| group.stopped > 0).map(|group| group.velocity)
    }

    /// Whether the fastest stop lies above the slowest perforation. Only then has the likelihood one maximum.
    pub fn overlap(&self) -> bool {
        let ends = self.slowest_perforation().zip(self.fastest_stop());
        ends.is_some_and(|(perforation, stop)| perforation < stop)
    }
}

/// Ballistic limit and scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// V50, in the unit of the velocities.
    pub mu: f64,
    /// Standard deviation of the distribution.
    pub sigma: f64,
    /// Logarithm of the likelihood, each shot by itself, without a penalty.
    pub log_likelihood: f64,
    /// Whether it is the maximum with Firth's penalty, for there is no overlap, and not that of the likelihood.
    pub firth: bool,
}

impl Estimate {
    /// −2 ln L; each shot by itself, so that a perfect model has none.
    pub fn deviance(&self) -> f64 {
        -2.0 * self.log_likelihood
    }

    /// Velocity at which the chance of a perforation is `p`.
    pub fn velocity(&self, p: f64) -> f64 {
        self.mu + normal::quantile(p) * self.sigma
    }

    /// Chance of a perforation at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        normal::probability((velocity - self.mu) / self.sigma)
    }
}

/// Fit of μ and σ.
///
/// # Errors
/// Where the shots do not determine them.
pub fn fit(outcomes: &Outcomes) -> Result<Estimate, &'static str> {
    // Mean velocity; NaN where there is no shot.
    let mean = |of: fn(&Group) -> u64| {
        let sum: f64 = outcomes.groups.iter().map(|group| of(group) as f64 * group.velocity).sum();
        sum / outcomes.groups.iter().map(of).sum::<u64>() as f64
    };
    match (outcomes.counts(), outcomes.groups.len()) {
        ([0, 0], _) => return Err(NO_SHOTS),
        ([0, _], _) => return Err(ALL_STOPPED),
        ([_, 0], _) => return Err(ALL_PERFORATED),
        (_, 1) => return Err(ONE_VELOCITY),
        // Owen & Roediger 2014: the sign of the slope is that of the difference of the means.
        _ if mean(|group| group.perforated) <= mean(|group| group.stopped) => return Err(INVERTED),
        _ => {}
    }
    let problem = Problem::new(outcomes);
    let firth = !outcomes.overlap();
    let line = problem.maximise(firth)?;
    if line.y <= 0.0 {
        return Err(INVERTED);
    }
    let (mu, sigma) = (problem.centre - line.x / line.y * problem.scale, problem.scale / line.y);
    Ok(Estimate { mu, sigma, log_likelihood: problem.log_likelihood(line), firth })
}

/// Inverse of a matrix; `None` where there is none.
fn inverse(m: Matrix2<f64>) -> Option<Matrix2<f64>> {
    m.try_inverse().filter(|inverse| inverse.iter().all(|value| value.is_finite()))
}

/// Linear predictor η = α + β u as (α, β).
type LinearPredictor = Vector2<f64>;

/// Shots to fit.
#[derive(Clone, Debug)]
struct Problem {
    /// Shots with velocities u from the mean and over the spread.
    points: Vec<Group>,
    /// Mean and spread of the velocities.
    centre: f64,
    scale: f64,
}

impl Problem {
    fn new(outcomes: &Outcomes) -> Self {
        let groups = outcomes.groups();
        let count: f64 = groups.iter().map(|group| group.count() as f64).sum();
        let centre = groups.iter().map(|group| group.count() as f64 * group.velocity).sum::<f64>() / count;
        let square =
            groups.iter().map(|group| group.count() as f64 * (group.velocity - centre).powi(2)).sum::<f64>() / count;
        let scale = if square > 0.0 { square.sqrt() } else { 1.0 };
        let point = |group: &Group| Group { velocity: (group.velocity - centre) / scale, ..*group };
        Self { points: groups.iter().map(point).collect(), centre, scale }
    }

    /// Logarithm of the likelihood.
    fn log_likelihood(&self, line: LinearPredictor) -> f64 {
        let term = |point: &Group| {
            let eta = line.x + line.y * point.velocity;
            let of = |count: u64, eta: f64| if count > 0 { count as f64 * normal::ln_probability(eta) } else { 0.0 };
            of(point.perforated, eta) + of(point.stopped, -eta)
        };
        self.points.iter().map(term).sum()
    }

    /// Logarithm of the likelihood, with Firth's penalty if wanted.
    fn height(&self, line: LinearPredictor, penalty: bool) -> f64 {
        self.log_likelihood(line) + if penalty { 0.5 * self.information(line).determinant().ln() } else { 0.0 }
    }

    /// Expected information on (α, β).
    fn information(&self, line: LinearPredictor) -> Matrix2<f64> {
        let of = |point: &Group| {
            let (w, u) = (point.count() as f64 * normal::information(line.x + line.y * point.velocity), point.velocity);
            Matrix2::new(w, w * u, w * u, w * u * u)
        };
        self.points.iter().map(of).sum()
    }

    /// Derivatives of the logarithm of the likelihood, with the penalty's if wanted.
    fn gradient(&self, line: LinearPredictor, penalty: bool) -> Option<Vector2<f64>> {
        let covariance = if penalty { inverse(self.information(line))? } else { Matrix2::zeros() };
        let of = |point: &Group| {
            let u = point.velocity;
            let eta = line.x + line.y * u;
            let mut slope = point.perforated as f64 * normal::slope(eta) - point.stopped as f64 * normal::slope(-eta);
            if penalty {
                let variance = covariance.m11 + u * (2.0 * covariance.m12 + u * covariance.m22);
                let leverage = point.count() as f64 * normal::information(eta) * variance;
                slope += 0.5 * leverage * normal::ln_information_slope(eta);
            }
            Vector2::new(slope, slope * u)
        };
        Some(self.points.iter().map(of).sum())
    }

    /// Fisher scoring. Each step is halved until it leads upwards; close to the maximum, where heights no longer differ, it is taken as it is
    /// for as long as steps get shorter.
    fn maximise(&self, penalty: bool) -> Result<LinearPredictor, &'static str> {
        let mut line = LinearPredictor::new(0.0, 1.0);
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let gradient = self.gradient(line, penalty).ok_or(UNSETTLED)?;
            let step = inverse(self.information(line)).ok_or(UNSETTLED)? * gradient;
            // Twice the rise that the step promises.
            let decrement = step.dot(&gradient);
            let close = decrement < CLOSE;
            if decrement < NOTHING || (close && decrement >= last) {
                return Ok(line);
            }
            last = decrement;
            let (mut share, height) = (1.0, self.height(line, penalty));
            while !close && self.height(line + share * step, penalty) < height {
                share *= 0.5;
                if share < SHORTEST {
                    return Err(UNSETTLED);
                }
            }
            line += share * step;
        }
        Err(UNSETTLED)
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
        let [low, high] = [problem.points.first()?.velocity, problem.points.last()?.velocity];
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

    /// Largest log-likelihood at t, of η = z + β (u − t). It is concave in β; the penalised one may have several maxima.
    fn height(&self, t: f64) -> f64 {
        // Logarithms of β per spread of the velocities: from a chance that hardly changes to a step.
        let (low, high, places) = if self.penalty { (-12.0, 8.0, 16) } else { (-12.0, 21.0, 1) };
        let at = |log: f64| {
            let beta = log.exp();
            let height = self.problem.height(LinearPredictor::new(self.z - beta * t, beta), self.penalty);
            if height.is_finite() { height } else { f64::NEG_INFINITY }
        };
        highest(at, low, high, places, 1e-5).1
    }
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

    /// Velocities by chance with their intervals; of a single threshold, which is no sample, V50 alone.
    pub(super) fn quantiles(&self, level: f64) -> Vec<Quantile> {
        let chances = if self.count == 1 { &[0.5][..] } else { &QUANTILES };
        let quantile = |p: &f64| Quantile { p: *p, value: Some(self.quantile(*p)), bounds: self.interval(*p, level) };
        chances.iter().map(quantile).collect()
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
    use super::*;

    #[test]
    fn the_interval_of_the_mean_is_students() {
        let thresholds = [181.0, 184.5, 190.2, 186.1, 179.4, 188.8, 185.0];
        let Some(sample) = ThresholdSample::new(&thresholds, 0.0) else { unreachable!("there are thresholds") };
        let half = student_t(0.9, 6) * sample.sigma / 7.0_f64.sqrt();
        let bounds = sample.interval(0.5, 0.9);
        let off = |end: Option<f64>, expected: f64| end.is_none_or(|end| (end - expected).abs() > 1e-5);
        assert!(!off(bounds.low, sample.mean - half) && !off(bounds.high, sample.mean + half), "{bounds:?} {half}");
        assert!(sample.interval(0.9, 0.9).high > bounds.high && sample.interval(0.5, 0.99).low < bounds.low);
    }

    #[test]
    fn brackets_alone_are_no_scatter() {
        let sample = ThresholdSample::new(&[99.5, 100.5, 99.5, 100.5], 2.0 * 3.0_f64.sqrt());
        assert!(sample.is_some_and(|sample| sample.sigma < 0.6));
        assert!(ThresholdSample::new(&[], 1.0).is_none());
        let one = ThresholdSample::new(&[100.0], 1.0);
        assert!(one.is_some_and(|one| one.interval(0.5, 0.9) == Bounds::default() && one.probability(101.0) == 1.0));
    }
}
