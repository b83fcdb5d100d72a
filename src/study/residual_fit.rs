//! Residual over impact velocity: Vr = a (Vs^p − V₀^p)^(1/p) above the limit V₀, 0 below, by least squares in Vr.
//!
//! Recht and Ipson (1963): a = 1, p = 2, for a projectile that keeps its shape and pushes no plug. Lambert and Jonas (1976): both free,
//! 0 < a ≤ 1, p ≥ 1. The curve rises from V₀ with an infinite slope, so intervals of V₀ are those of its profile: all V₀ at which the sum
//! of squares is at most S (1 + t²/ν), the others chosen best.

use super::interval::{Bounds, highest, outer_end, student_t};

/// Exponents p that are tried.
const EXPONENTS: [f64; 2] = [1.0, 10.0];
/// Places tried before a search narrows: limits, exponents.
const PLACES: [usize; 2] = [40, 8];

/// A shot that passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passed {
    /// Impact velocity.
    pub impact: f64,
    /// Residual velocity.
    pub residual: f64,
    /// Number of such shots.
    pub count: u64,
}

/// Model of the curve by its free parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResidualModel {
    /// Limit alone.
    RechtIpson,
    /// Limit, factor a and exponent p.
    LambertJonas,
}

impl ResidualModel {
    /// Name in JSON and in tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::RechtIpson => "Recht-Ipson",
            Self::LambertJonas => "Lambert-Jonas",
        }
    }

    /// Free parameters.
    pub fn parameters(self) -> u64 {
        match self {
            Self::RechtIpson => 1,
            Self::LambertJonas => 3,
        }
    }
}

/// A fitted curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualFit {
    /// Model of the curve.
    pub curve: ResidualModel,
    /// Limit V₀, in the unit of the velocities.
    pub limit: f64,
    /// Interval of the limit; no end where the sum of squares does not rise enough.
    pub bounds: Bounds,
    /// Factor a \[-\].
    pub factor: f64,
    /// Exponent p \[-\].
    pub exponent: f64,
    /// Standard deviation of residual velocities from the curve.
    pub scatter: f64,
    /// Shots.
    pub count: u64,
}

impl ResidualFit {
    /// Residual velocity at an impact velocity.
    pub fn residual(&self, impact: f64) -> f64 {
        self.factor * shape(impact, self.limit, self.exponent)
    }
}

/// (Vs^p − V₀^p)^(1/p), 0 below the limit.
fn shape(impact: f64, limit: f64, exponent: f64) -> f64 {
    if impact <= limit {
        return 0.0;
    }
    impact * (1.0 - (limit / impact).powf(exponent)).powf(1.0 / exponent)
}

/// Curve fitted to shots that passed; `level` of the interval. One more velocity than free parameters is needed.
///
/// # Errors
/// Where there are fewer: the reason.
pub fn residual_fit(curve: ResidualModel, shots: &[Passed], level: f64) -> Result<ResidualFit, String> {
    let mut velocities: Vec<f64> = shots.iter().filter(|shot| shot.count > 0).map(|shot| shot.impact).collect();
    velocities.sort_by(f64::total_cmp);
    velocities.dedup();
    let (have, need) = (velocities.len() as u64, curve.parameters() + 1);
    if have < need {
        return Err(format!("needs {need} different velocities of shots that passed, there are {have}"));
    }
    let fastest = velocities.last().copied().unwrap_or(1.0);
    let unit = |shot: &Passed| Passed { impact: shot.impact / fastest, residual: shot.residual / fastest, ..*shot };
    let squares = Squares { curve, shots: shots.iter().map(unit).collect() };
    let (limit, least) = highest(|limit| -squares.least(limit).sum, 0.0, 1.0, PLACES[0], 1e-9);
    let found = squares.least(limit);
    let count: u64 = shots.iter().map(|shot| shot.count).sum();
    let degrees = count - curve.parameters();
    let t = student_t(level, degrees);
    let most = -least * (1.0 + t * t / degrees as f64);
    let bounds = squares.bounds(limit, most);
    let scale = |end: Option<f64>| end.map(|end| end * fastest);
    Ok(ResidualFit {
        curve,
        limit: limit * fastest,
        bounds: Bounds { low: scale(bounds.low), high: scale(bounds.high) },
        factor: found.factor,
        exponent: found.exponent,
        scatter: fastest * (found.sum / degrees as f64).sqrt(),
        count,
    })
}

/// Sum of squares, and the parameters that give it.
#[derive(Clone, Copy, Debug)]
struct Least {
    sum: f64,
    factor: f64,
    exponent: f64,
}

/// Sum of squares to be minimised; velocities over the fastest.
#[derive(Clone, Debug)]
struct Squares {
    curve: ResidualModel,
    shots: Vec<Passed>,
}

impl Squares {
    /// Least sum of squares with this limit.
    fn least(&self, limit: f64) -> Least {
        match self.curve {
            ResidualModel::RechtIpson => Least { sum: self.sum(limit, 1.0, 2.0), factor: 1.0, exponent: 2.0 },
            ResidualModel::LambertJonas => {
                let [low, high] = EXPONENTS.map(f64::ln);
                let at = |log: f64| self.with_exponent(limit, log.exp());
                let (log, _) = highest(|log| -at(log).sum, low, high, PLACES[1], 1e-7);
                at(log)
            }
        }
    }

    /// Least sum of squares with this limit and this exponent: the sum of squares is a parabola of the factor.
    fn with_exponent(&self, limit: f64, exponent: f64) -> Least {
        let (mut above, mut below) = (0.0, 0.0);
        for shot in &self.shots {
            let f = shape(shot.impact, limit, exponent);
            above += shot.count as f64 * f * shot.residual;
            below += shot.count as f64 * f * f;
        }
        let factor = if below > 0.0 { (above / below).min(1.0) } else { 1.0 };
        Least { sum: self.sum(limit, factor, exponent), factor, exponent }
    }

    fn sum(&self, limit: f64, factor: f64, exponent: f64) -> f64 {
        let square =
            |shot: &Passed| shot.count as f64 * (shot.residual - factor * shape(shot.impact, limit, exponent)).powi(2);
        self.shots.iter().map(square).sum()
    }

    /// Limits around the best one at which the sum of squares is `most`.
    fn bounds(&self, limit: f64, most: f64) -> Bounds {
        let inside = |limit: f64| most - self.least(limit).sum;
        let end = |step: f64, last: f64| outer_end(inside, limit, step, last, 1e-9);
        Bounds { low: end(-1e-3, 0.0), high: end(1e-3, 1.0) }
    }
}
