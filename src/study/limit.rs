//! Ballistic limit from shots or from thresholds, as far as both have it alike: velocities by chance, residual velocities.
//!
//! Residual over impact velocity is Vr = a (Vs^p − V₀^p)^(1/p) above the limit V₀, 0 below, by least squares in Vr. Recht and Ipson (1963):
//! a = 1, p = 2, for a projectile that keeps its shape and pushes no plug. Lambert and Jonas (1976): both free, 0 < a ≤ 1, p ≥ 1. The curve
//! rises from V₀ with an infinite slope, so intervals of V₀ are those of its profile: all V₀ at which the sum of squares is at most
//! S (1 + t²/ν), the others chosen best.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use serde::Serialize;
use serde_json::{Value, json};

use super::fit::VelocityUnit;
use super::report::ReportTable;
use crate::output::number::short;

/// Chances of a perforation at which velocities are given.
pub const QUANTILES: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 0.9];
/// Exponents p that are tried.
const EXPONENTS: [f64; 2] = [1.0, 10.0];
/// Places tried before a search narrows: limits, exponents.
const PLACES: [usize; 2] = [40, 8];
/// Steps of a search for a root or a peak at most.
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

/// Velocity of one chance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quantile {
    /// Chance of a perforation.
    pub p: f64,
    /// Velocity; none without an estimate.
    pub value: Option<f64>,
    /// Interval of it.
    #[serde(flatten)]
    pub bounds: Bounds,
}

/// Ballistic limit by every method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limit {
    /// Unit of all velocities.
    pub unit: VelocityUnit,
    /// Velocities by chance; their intervals are of the sampling alone.
    pub quantiles: Vec<Quantile>,
    /// Shots that perforated with a known residual velocity.
    pub passed: Vec<Passed>,
    /// Curves through residual velocities; none where none is known.
    pub residual: Vec<(ResidualModel, Result<ResidualFit, String>)>,
}

impl Limit {
    /// Limit with these velocities by chance; `level`: confidence of intervals.
    pub(super) fn new(unit: VelocityUnit, quantiles: Vec<Quantile>, passed: Vec<Passed>, level: f64) -> Self {
        let curves =
            [ResidualModel::RechtIpson, ResidualModel::LambertJonas].into_iter().filter(|_| !passed.is_empty());
        Self {
            unit,
            quantiles,
            residual: curves.map(|curve| (curve, residual_fit(curve, &passed, level))).collect(),
            passed,
        }
    }

    /// Velocity of a chance that is among [`QUANTILES`].
    pub fn quantile(&self, p: f64) -> Option<&Quantile> {
        self.quantiles.iter().find(|quantile| quantile.p == p)
    }

    /// V50 with the interval of its sampling.
    pub fn v50(&self) -> Option<(f64, Bounds)> {
        self.quantile(0.5).and_then(|quantile| Some((quantile.value?, quantile.bounds)))
    }

    /// Curves that could be fitted.
    pub(super) fn fitted(&self) -> impl Iterator<Item = &ResidualFit> {
        self.residual.iter().filter_map(|(_, found)| found.as_ref().ok())
    }

    /// Quantiles and residual fits in JSON.
    pub(super) fn json(&self) -> [Value; 2] {
        let residual = |(curve, found): &(ResidualModel, Result<ResidualFit, String>)| match found {
            Ok(found) => json!({
                "curve": curve.words(), "limit": found.limit, "low": found.bounds.low, "high": found.bounds.high,
                "a": found.factor, "p": found.exponent, "scatter": found.scatter, "shots": found.count, "refused": null,
            }),
            Err(few) => json!({ "curve": curve.words(), "limit": null, "refused": few }),
        };
        [json!(self.quantiles), self.residual.iter().map(residual).collect()]
    }

    /// Tables of the velocities by chance and of the curves.
    pub(super) fn tables(&self, level: f64) -> [ReportTable; 2] {
        let unit = self.unit.symbol();
        let quantile = |quantile: &Quantile| {
            let value = quantile.value.map_or_else(|| "-".to_owned(), |value| short(value, 4));
            let [low, high] = quantile.bounds.words();
            vec![format!("{} %", short(100.0 * quantile.p, 3)), value, low, high]
        };
        let curve = |found: &ResidualFit| {
            let [low, high] = found.bounds.words();
            let [factor, exponent] = [found.factor, found.exponent].map(|parameter| short(parameter, 3));
            let (limit, scatter) = (short(found.limit, 4), short(found.scatter, 2));
            vec![found.curve.words().to_owned(), limit, low, high, factor, exponent, scatter]
        };
        let refused = self.residual.iter().filter_map(|(curve, found)| Some((curve, found.as_ref().err()?)));
        let mut curves_foot: Vec<String> = refused.map(|(curve, few)| format!("{}: {few}", curve.words())).collect();
        curves_foot.extend((!self.residual.is_empty()).then(|| "Vr = a (Vs^p - V0^p)^(1/p)".to_owned()));
        let foot = format!("{} % intervals, likelihood ratio", short(100.0 * level, 3));
        let [limit, scatter] = ["limit", "scatter"].map(|of| format!("{of} {unit}"));
        let curve_heads = ["", &limit, "low", "high", "a", "p", &scatter];
        [
            ReportTable::new("velocity by chance of a perforation", &["chance", unit, "low", "high"], 0)
                .rows(self.quantiles.iter().map(quantile), &foot),
            ReportTable::new("residual velocity", &curve_heads, 1)
                .rows(self.fitted().map(curve), &curves_foot.join("\n")),
        ]
    }
}

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

/// Model of the curve, by the number of its free parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResidualModel {
    /// Limit alone.
    RechtIpson = 1,
    /// Limit, factor a and exponent p.
    LambertJonas = 3,
}

impl ResidualModel {
    /// Name in JSON and in tables.
    pub fn words(self) -> &'static str {
        match self {
            Self::RechtIpson => "Recht-Ipson",
            Self::LambertJonas => "Lambert-Jonas",
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
    let (have, need) = (velocities.len() as u64, curve as u64 + 1);
    if have < need {
        return Err(format!("needs {need} different velocities of shots that passed, there are {have}"));
    }
    let fastest = velocities.last().copied().unwrap_or(1.0);
    let unit = |shot: &Passed| Passed { impact: shot.impact / fastest, residual: shot.residual / fastest, ..*shot };
    let squares = Squares { curve, shots: shots.iter().map(unit).collect() };
    let (limit, least) = highest(|limit| -squares.least(limit)[0], 0.0, 1.0, PLACES[0], 1e-9);
    let [sum, factor, exponent] = squares.least(limit);
    let count: u64 = shots.iter().map(|shot| shot.count).sum();
    let degrees = count - curve as u64;
    let t = student_t(level, degrees);
    let most = -least * (1.0 + t * t / degrees as f64);
    // Limits around the best one at which the sum of squares is `most`.
    let inside = |limit: f64| most - squares.least(limit)[0];
    let end = |step: f64, last: f64| outer_end(inside, limit, step, last, 1e-9).map(|end| end * fastest);
    Ok(ResidualFit {
        curve,
        limit: limit * fastest,
        bounds: Bounds { low: end(-1e-3, 0.0), high: end(1e-3, 1.0) },
        factor,
        exponent,
        scatter: fastest * (sum / degrees as f64).sqrt(),
        count,
    })
}

/// Sum of squares to be minimised; velocities over the fastest.
#[derive(Clone, Debug)]
struct Squares {
    curve: ResidualModel,
    shots: Vec<Passed>,
}

impl Squares {
    /// Least sum of squares with this limit, and the factor and the exponent that give it.
    fn least(&self, limit: f64) -> [f64; 3] {
        match self.curve {
            ResidualModel::RechtIpson => [self.sum(limit, 1.0, 2.0), 1.0, 2.0],
            ResidualModel::LambertJonas => {
                let [low, high] = EXPONENTS.map(f64::ln);
                let at = |log: f64| self.with_exponent(limit, log.exp());
                let (log, _) = highest(|log| -at(log)[0], low, high, PLACES[1], 1e-7);
                at(log)
            }
        }
    }

    /// Least sum of squares with this limit and this exponent: the sum of squares is a parabola of the factor.
    fn with_exponent(&self, limit: f64, exponent: f64) -> [f64; 3] {
        let (mut above, mut below) = (0.0, 0.0);
        for shot in &self.shots {
            let f = shape(shot.impact, limit, exponent);
            above += shot.count as f64 * f * shot.residual;
            below += shot.count as f64 * f * f;
        }
        let factor = if below > 0.0 { (above / below).min(1.0) } else { 1.0 };
        [self.sum(limit, factor, exponent), factor, exponent]
    }

    fn sum(&self, limit: f64, factor: f64, exponent: f64) -> f64 {
        let square =
            |shot: &Passed| shot.count as f64 * (shot.residual - factor * shape(shot.impact, limit, exponent)).powi(2);
        self.shots.iter().map(square).sum()
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
