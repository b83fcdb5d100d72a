//! Ballistic limit of binary outcomes: P(perforation) = F((v − μ)/σ) with the normal distribution F, fitted by maximum
//! likelihood.
//!
//! The fit runs over η = α + β u with the velocity u from its mean and over its spread; the log-likelihood is concave in (α, β). Without
//! overlap it has no maximum: β grows without bound. Firth's penalty, half the logarithm of the information's determinant in (α, β),
//! gives a finite estimate there (Kosmidis & Firth 2021).

use nalgebra::{Matrix2, Vector2};

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

    /// Mean velocities of perforations and of stops; NaN where there are none.
    pub fn means(&self) -> [f64; 2] {
        let mean = |of: fn(&Group) -> u64| {
            let sum: f64 = self.groups.iter().map(|group| of(group) as f64 * group.velocity).sum();
            sum / self.groups.iter().map(of).sum::<u64>() as f64
        };
        [mean(|group| group.perforated), mean(|group| group.stopped)]
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
    refuse(outcomes)?;
    let problem = Problem::new(outcomes);
    let firth = !outcomes.overlap();
    let line = problem.maximise(firth)?;
    if line.y <= 0.0 {
        return Err(INVERTED);
    }
    let (mu, sigma) = (problem.centre - line.x / line.y * problem.scale, problem.scale / line.y);
    Ok(Estimate { mu, sigma, log_likelihood: problem.log_likelihood(line), firth })
}

/// Refusal of shots that no method can mend.
fn refuse(outcomes: &Outcomes) -> Result<(), &'static str> {
    let [perforations, stops] = outcomes.means();
    match (outcomes.counts(), outcomes.groups().len()) {
        ([0, 0], _) => Err(NO_SHOTS),
        ([0, _], _) => Err(ALL_STOPPED),
        ([_, 0], _) => Err(ALL_PERFORATED),
        (_, 1) => Err(ONE_VELOCITY),
        // Owen & Roediger 2014: the sign of the slope is that of the difference of the means.
        _ if perforations <= stops => Err(INVERTED),
        _ => Ok(()),
    }
}

/// w \[1 z; z z²\].
fn moments(w: f64, z: f64) -> Matrix2<f64> {
    Matrix2::new(w, w * z, w * z, w * z * z)
}

/// Inverse of a matrix; `None` where there is none.
fn inverse(m: Matrix2<f64>) -> Option<Matrix2<f64>> {
    m.try_inverse().filter(|inverse| inverse.iter().all(|value| value.is_finite()))
}

/// Linear predictor η = α + β u as (α, β).
pub(super) type LinearPredictor = Vector2<f64>;

/// Shots of one standardised velocity u.
#[derive(Clone, Copy, Debug)]
pub(super) struct StandardizedShots {
    pub(super) u: f64,
    pub(super) perforated: f64,
    pub(super) stopped: f64,
}

/// Shots to fit, in velocities from their mean and over their spread.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) points: Vec<StandardizedShots>,
    /// Mean and spread of the velocities.
    pub(super) centre: f64,
    pub(super) scale: f64,
}

impl Problem {
    pub(super) fn new(outcomes: &Outcomes) -> Self {
        let groups = outcomes.groups();
        let count: f64 = groups.iter().map(|group| group.count() as f64).sum();
        let centre = groups.iter().map(|group| group.count() as f64 * group.velocity).sum::<f64>() / count;
        let square =
            groups.iter().map(|group| group.count() as f64 * (group.velocity - centre).powi(2)).sum::<f64>() / count;
        let scale = if square > 0.0 { square.sqrt() } else { 1.0 };
        let point = |group: &Group| StandardizedShots {
            u: (group.velocity - centre) / scale,
            perforated: group.perforated as f64,
            stopped: group.stopped as f64,
        };
        Self { points: groups.iter().map(point).collect(), centre, scale }
    }

    /// Logarithm of the likelihood.
    pub(super) fn log_likelihood(&self, line: LinearPredictor) -> f64 {
        let term = |point: &StandardizedShots| {
            let eta = line.x + line.y * point.u;
            let of = |count: f64, eta: f64| if count > 0.0 { count * normal::ln_probability(eta) } else { 0.0 };
            of(point.perforated, eta) + of(point.stopped, -eta)
        };
        self.points.iter().map(term).sum()
    }

    /// Logarithm of the likelihood, with Firth's penalty if wanted.
    pub(super) fn height(&self, line: LinearPredictor, penalty: bool) -> f64 {
        self.log_likelihood(line) + if penalty { 0.5 * self.information(line).determinant().ln() } else { 0.0 }
    }

    /// Expected information on (α, β).
    fn information(&self, line: LinearPredictor) -> Matrix2<f64> {
        let of = |point: &StandardizedShots| {
            let w = (point.perforated + point.stopped) * normal::information(line.x + line.y * point.u);
            moments(w, point.u)
        };
        self.points.iter().map(of).sum()
    }

    /// Derivatives of the logarithm of the likelihood, with the penalty's if wanted.
    fn gradient(&self, line: LinearPredictor, penalty: bool) -> Option<Vector2<f64>> {
        let covariance = if penalty { inverse(self.information(line))? } else { Matrix2::zeros() };
        let of = |point: &StandardizedShots| {
            let (eta, u) = (line.x + line.y * point.u, point.u);
            let mut slope = point.perforated * normal::slope(eta) - point.stopped * normal::slope(-eta);
            if penalty {
                let variance = covariance.m11 + u * (2.0 * covariance.m12 + u * covariance.m22);
                let leverage = (point.perforated + point.stopped) * normal::information(eta) * variance;
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
