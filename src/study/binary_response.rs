//! Ballistic limit of binary outcomes: P(perforation) = F((v − μ)/σ), fitted by maximum likelihood.
//!
//! The fit runs over η = α + β u with the velocity u from its mean and over its spread; the log-likelihood is concave in (α, β). Without
//! overlap it has no maximum: β grows without bound. Firth's penalty, half the logarithm of the information's determinant in (α, β),
//! gives a finite estimate there (Kosmidis & Firth 2021).

use super::outcomes::{Group, Outcomes};
use crate::num::link::Link;

/// Steps of a fit at most. From these starts 5 to 20 are needed.
const STEPS: usize = 500;
/// Newton decrement below which heights differ by rounding only: the log-likelihood is then within half of it.
const CLOSE: f64 = 1e-10;
/// Newton decrement of steps that move no digit.
const NOTHING: f64 = 1e-28;
/// Step of the differences that give the curvature of the penalty.
const DIFFERENCE: f64 = 1e-4;
/// Share of a step that must lead upwards.
const SHORTEST: f64 = 1e-9;

/// Method of an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Maximum of the likelihood.
    MaximumLikelihood,
    /// Maximum of the likelihood with Firth's penalty: there is no overlap.
    Firth,
}

impl Method {
    /// Words in JSON.
    pub fn words(self) -> &'static str {
        match self {
            Self::MaximumLikelihood => "maximum likelihood",
            Self::Firth => "Firth's penalised likelihood",
        }
    }
}

/// Reason why shots give no estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoEstimate {
    /// No shot.
    #[error("there are no shots")]
    NoShots,
    /// One outcome is missing.
    #[error("every shot perforated: the limit lies lower, by how much is unknown")]
    AllPerforated,
    /// One outcome is missing.
    #[error("every shot was stopped: the limit lies higher, by how much is unknown")]
    AllStopped,
    /// One velocity alone.
    #[error("all shots have one velocity: how the chance grows with velocity is unknown")]
    OneVelocity,
    /// Scatter that is infinite or negative.
    #[error("perforations are no faster than stops on the mean: velocity does not explain the outcomes")]
    Inverted,
    /// Search without an end.
    #[error("the fit did not converge")]
    Unsettled,
}

/// Ballistic limit and scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Distribution of the thresholds.
    pub link: Link,
    /// V50, in the unit of the velocities.
    pub mu: f64,
    /// Scale of the distribution: for the normal one its standard deviation.
    pub sigma: f64,
    /// Logarithm of the likelihood, each shot by itself, without a penalty.
    pub log_likelihood: f64,
    /// Covariance of (μ, σ): inverse of the expected information.
    pub covariance: [[f64; 2]; 2],
    /// Method of the estimate.
    pub method: Method,
}

impl Estimate {
    /// −2 ln L; each shot by itself, so that a perfect model has none.
    pub fn deviance(&self) -> f64 {
        -2.0 * self.log_likelihood
    }

    /// Velocity at which the chance of a perforation is `p`.
    pub fn velocity(&self, p: f64) -> f64 {
        self.mu + self.link.quantile(p) * self.sigma
    }

    /// Chance of a perforation at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        self.link.probability((velocity - self.mu) / self.sigma)
    }

    /// Standard error of [`Estimate::velocity`], from the expected information.
    pub fn standard_error(&self, p: f64) -> f64 {
        let z = self.link.quantile(p);
        let [[mu, both], [_, sigma]] = self.covariance;
        (mu + z * (2.0 * both + z * sigma)).sqrt()
    }
}

/// Fit of μ and σ.
///
/// # Errors
/// Where the shots do not determine them.
pub fn fit(link: Link, outcomes: &Outcomes) -> Result<Estimate, NoEstimate> {
    refuse(outcomes)?;
    let problem = Problem::new(link, outcomes);
    let method = if outcomes.overlap() { Method::MaximumLikelihood } else { Method::Firth };
    let line = problem.maximise(method == Method::Firth)?;
    if line.beta <= 0.0 {
        return Err(NoEstimate::Inverted);
    }
    let (mu, sigma) = (problem.centre - line.alpha / line.beta * problem.scale, problem.scale / line.beta);
    let covariance = inverse(information(link, outcomes, mu, sigma))
        .ok_or(NoEstimate::Unsettled)?
        .map(|row| row.map(|c| c * sigma * sigma));
    Ok(Estimate { link, mu, sigma, log_likelihood: problem.log_likelihood(line), covariance, method })
}

/// Refusal of shots that no method can mend.
fn refuse(outcomes: &Outcomes) -> Result<(), NoEstimate> {
    let [perforations, stops] = outcomes.means();
    match (outcomes.counts(), outcomes.groups().len()) {
        ([0, 0], _) => Err(NoEstimate::NoShots),
        ([0, _], _) => Err(NoEstimate::AllStopped),
        ([_, 0], _) => Err(NoEstimate::AllPerforated),
        (_, 1) => Err(NoEstimate::OneVelocity),
        // Owen & Roediger 2014: the sign of the slope is that of the difference of the means.
        _ if perforations <= stops => Err(NoEstimate::Inverted),
        _ => Ok(()),
    }
}

/// Expected information on (μ, σ) times σ²: Σ w \[1 z; z z²\].
fn information(link: Link, outcomes: &Outcomes, mu: f64, sigma: f64) -> [[f64; 2]; 2] {
    let mut sum = [[0.0; 2]; 2];
    for group in outcomes.groups() {
        let z = (group.velocity - mu) / sigma;
        let w = group.count() as f64 * link.information(z);
        add(&mut sum, w, z);
    }
    sum
}

fn add(sum: &mut [[f64; 2]; 2], w: f64, z: f64) {
    sum[0][0] += w;
    sum[0][1] += w * z;
    sum[1][0] += w * z;
    sum[1][1] += w * z * z;
}

/// Determinant of a matrix.
fn determinant(m: [[f64; 2]; 2]) -> f64 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

/// Inverse of a matrix; `None` where there is none.
pub(super) fn inverse(m: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let d = determinant(m);
    let found = [[m[1][1] / d, -m[0][1] / d], [-m[1][0] / d, m[0][0] / d]];
    found.as_flattened().iter().all(|value| value.is_finite()).then_some(found)
}

/// η = α + β u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LinearPredictor {
    pub(super) alpha: f64,
    pub(super) beta: f64,
}

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
    pub(super) link: Link,
    pub(super) points: Vec<StandardizedShots>,
    /// Mean and spread of the velocities.
    pub(super) centre: f64,
    pub(super) scale: f64,
}

impl Problem {
    pub(super) fn new(link: Link, outcomes: &Outcomes) -> Self {
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
        Self { link, points: groups.iter().map(point).collect(), centre, scale }
    }

    /// Logarithm of the likelihood.
    pub(super) fn log_likelihood(&self, line: LinearPredictor) -> f64 {
        let term = |point: &StandardizedShots| {
            let eta = line.alpha + line.beta * point.u;
            let of = |count: f64, eta: f64| if count > 0.0 { count * self.link.ln_probability(eta) } else { 0.0 };
            of(point.perforated, eta) + of(point.stopped, -eta)
        };
        self.points.iter().map(term).sum()
    }

    /// The same with Firth's penalty.
    pub(super) fn penalised(&self, line: LinearPredictor) -> f64 {
        self.log_likelihood(line) + 0.5 * determinant(self.information(line)).ln()
    }

    /// Expected information on (α, β).
    fn information(&self, line: LinearPredictor) -> [[f64; 2]; 2] {
        let mut sum = [[0.0; 2]; 2];
        for point in &self.points {
            let w = (point.perforated + point.stopped) * self.link.information(line.alpha + line.beta * point.u);
            add(&mut sum, w, point.u);
        }
        sum
    }

    /// Derivatives of the logarithm of the likelihood, with the penalty's if wanted.
    fn gradient(&self, line: LinearPredictor, penalty: bool) -> Option<[f64; 2]> {
        let covariance = if penalty { inverse(self.information(line))? } else { [[0.0; 2]; 2] };
        let [[aa, ab], [_, bb]] = covariance;
        let mut sum = [0.0; 2];
        for point in &self.points {
            let eta = line.alpha + line.beta * point.u;
            let mut slope = point.perforated * self.link.slope(eta) - point.stopped * self.link.slope(-eta);
            if penalty {
                let count = point.perforated + point.stopped;
                let leverage = count * self.link.information(eta) * (aa + point.u * (2.0 * ab + point.u * bb));
                slope += 0.5 * leverage * self.link.ln_information_slope(eta);
            }
            sum[0] += slope;
            sum[1] += slope * point.u;
        }
        Some(sum)
    }

    /// Second derivatives, their sign turned. Those of the penalty are differences of its gradient.
    fn curvature(&self, line: LinearPredictor, penalty: bool) -> Option<[[f64; 2]; 2]> {
        if penalty {
            let column = |alpha: f64, beta: f64| {
                let at = |sign: f64| {
                    let moved = LinearPredictor { alpha: line.alpha + sign * alpha, beta: line.beta + sign * beta };
                    self.gradient(moved, penalty)
                };
                let ([a0, b0], [a1, b1]) = (at(-1.0)?, at(1.0)?);
                Some([(a0 - a1) / (2.0 * DIFFERENCE), (b0 - b1) / (2.0 * DIFFERENCE)])
            };
            return Some([column(DIFFERENCE, 0.0)?, column(0.0, DIFFERENCE)?]);
        }
        let mut sum = [[0.0; 2]; 2];
        for point in &self.points {
            let eta = line.alpha + line.beta * point.u;
            for (count, eta) in [(point.perforated, eta), (point.stopped, -eta)] {
                if count > 0.0 {
                    add(&mut sum, count * self.link.slope_and_curvature(eta)[1], point.u);
                }
            }
        }
        Some(sum)
    }

    /// Newton's method, or Fisher scoring where the curvature is no bowl. Each step is halved until it leads upwards; close to the maximum,
    /// where heights no longer differ, it is taken as it is for as long as steps get shorter.
    fn maximise(&self, penalty: bool) -> Result<LinearPredictor, NoEstimate> {
        let objective = |line: LinearPredictor| if penalty { self.penalised(line) } else { self.log_likelihood(line) };
        let mut line = LinearPredictor { alpha: 0.0, beta: 1.0 };
        let mut last = f64::INFINITY;
        for _ in 0..STEPS {
            let step = self.step(line, penalty).ok_or(NoEstimate::Unsettled)?;
            let close = step.decrement < CLOSE;
            if step.decrement < NOTHING || (close && step.decrement >= last) {
                return Ok(line);
            }
            last = step.decrement;
            let (mut share, height) = (1.0, objective(line));
            while !close && objective(step.from(line, share)) < height {
                share *= 0.5;
                if share < SHORTEST {
                    return Err(NoEstimate::Unsettled);
                }
            }
            line = step.from(line, share);
        }
        Err(NoEstimate::Unsettled)
    }

    fn step(&self, line: LinearPredictor, penalty: bool) -> Option<Step> {
        let gradient = self.gradient(line, penalty)?;
        let curvature = self.curvature(line, penalty).filter(|m| m[0][0] > 0.0 && determinant(*m) > 0.0);
        let inverse = inverse(curvature.unwrap_or_else(|| self.information(line)))?;
        let [alpha, beta] = inverse.map(|[a, b]| a * gradient[0] + b * gradient[1]);
        Some(Step { alpha, beta, decrement: alpha * gradient[0] + beta * gradient[1] })
    }
}

/// A step of the search, and twice the rise that it promises.
#[derive(Clone, Copy, Debug)]
struct Step {
    alpha: f64,
    beta: f64,
    decrement: f64,
}

impl Step {
    fn from(self, line: LinearPredictor, share: f64) -> LinearPredictor {
        LinearPredictor { alpha: line.alpha + share * self.alpha, beta: line.beta + share * self.beta }
    }
}
