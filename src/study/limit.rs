//! Ballistic limit from shots or from thresholds, as far as both have it alike: velocities by chance, arithmetic V50, residual velocities.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::StudyError;
use super::interval::Bounds;
use super::outcomes::{ArithmeticV50, Outcomes, arithmetic_v50};
use super::report::ReportTable;
use super::residual_fit::{Passed, ResidualFit, ResidualModel, residual_fit};
use crate::num::link::Link;
use crate::output::number::short;

/// Chances of a perforation at which velocities are given.
pub const QUANTILES: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 0.9];

/// Velocity of one chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile {
    /// Chance of a perforation.
    pub p: f64,
    /// Velocity [m/s]; none without an estimate.
    pub value: Option<f64>,
    /// Interval of it [m/s].
    pub bounds: Bounds,
}

/// Ballistic limit by every method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limit {
    /// Velocities by chance; their intervals are of the sampling alone.
    pub quantiles: Vec<Quantile>,
    /// Arithmetic V50 of each rule.
    pub arithmetic: Vec<ArithmeticV50>,
    /// Shots that perforated with a known residual velocity.
    pub passed: Vec<Passed>,
    /// Curves through residual velocities; none where none is known.
    pub residual: Vec<(ResidualModel, Result<ResidualFit, String>)>,
}

impl Limit {
    /// Limit with these velocities by chance. `outcomes`: shots of the arithmetic V50; `level`: confidence of intervals.
    pub(super) fn new(quantiles: Vec<Quantile>, outcomes: &Outcomes, passed: Vec<Passed>, level: f64) -> Self {
        let curves = [ResidualModel::RechtIpson, ResidualModel::LambertJonas];
        let curves = if passed.is_empty() { &[][..] } else { &curves };
        Self {
            quantiles,
            arithmetic: arithmetic_v50(outcomes),
            residual: curves.iter().map(|curve| (*curve, residual_fit(*curve, &passed, level))).collect(),
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

    /// Quantiles, arithmetic V50 and residual fits in JSON.
    pub(super) fn json(&self) -> [Value; 3] {
        let quantile =
            |of: &Quantile| json!({ "p": of.p, "value": of.value, "low": of.bounds.low, "high": of.bounds.high });
        let residual = |(curve, found): &(ResidualModel, Result<ResidualFit, String>)| match found {
            Ok(found) => json!({
                "curve": curve.words(), "limit": found.limit, "low": found.bounds.low, "high": found.bounds.high,
                "a": found.factor, "p": found.exponent, "scatter": found.scatter, "shots": found.count, "refused": null,
            }),
            Err(few) => json!({ "curve": curve.words(), "limit": null, "refused": few }),
        };
        [
            self.quantiles.iter().map(quantile).collect(),
            json!(self.arithmetic),
            self.residual.iter().map(residual).collect(),
        ]
    }

    /// Table of the arithmetic V50. `of`: the shots that it is of, where they are not those that were fired.
    pub(super) fn arithmetic_table(&self, of: &str) -> ReportTable {
        let row = |found: &ArithmeticV50| {
            let metres = |value: Option<f64>, digits| value.map_or_else(String::new, |value| short(value, digits));
            let words = match &found.refused {
                Some(why) => format!("none: {why}"),
                None => format!("{} m/s, spread {} m/s", metres(found.value, 4), metres(found.spread, 3)),
            };
            vec![found.standard.to_owned(), found.rule.clone(), words]
        };
        ReportTable::new("arithmetic V50", &[], 3, self.arithmetic.iter().map(row)).foot(of)
    }

    /// Table of the curves through residual velocities.
    pub(super) fn residual_table(&self) -> ReportTable {
        let fitted = self.residual.iter().filter_map(|(curve, found)| Some((curve, found.as_ref().ok()?)));
        let row = |(curve, found): (&ResidualModel, &ResidualFit)| {
            let [low, high] = found.bounds.words();
            let [factor, exponent] = [found.factor, found.exponent].map(|parameter| short(parameter, 3));
            vec![curve.words().to_owned(), short(found.limit, 4), low, high, factor, exponent, short(found.scatter, 2)]
        };
        let heads = ["", "limit m/s", "low", "high", "a", "p", "scatter m/s"];
        let refused = self.residual.iter().filter_map(|(curve, found)| Some((curve, found.as_ref().err()?)));
        let mut foot: Vec<String> = refused.map(|(curve, few)| format!("{}: {few}", curve.words())).collect();
        foot.extend((!self.residual.is_empty()).then(|| "Vr = a (Vs^p - V0^p)^(1/p)".to_owned()));
        ReportTable::new("residual velocity", &heads, 1, fitted.map(row)).foot(&foot.join("\n"))
    }

    /// Notes on fits that lie at an end of what is tried.
    pub(super) fn notes(&self) -> Vec<String> {
        let fitted = self.residual.iter().filter_map(|(_, found)| found.as_ref().ok());
        let at_end = |found: &&ResidualFit| {
            found.curve == ResidualModel::LambertJonas && !(1.001..9.99).contains(&found.exponent)
        };
        let note =
            |found: &ResidualFit| format!("Lambert-Jonas: p = {} is an end of what is tried", short(found.exponent, 3));
        fitted.filter(at_end).map(note).collect()
    }
}

/// Row of a quantile under a name.
pub(super) fn quantile_row(name: String, quantile: &Quantile) -> Vec<String> {
    let value = quantile.value.map_or_else(|| "-".to_owned(), |value| short(value, 4));
    let [low, high] = quantile.bounds.words();
    vec![name, value, low, high]
}

/// Computed V50 to hold measured shots against: `v50.json` of `ripstop v50`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputedLimit {
    /// V50 [m/s].
    pub v50: f64,
    /// Interval of V50 [m/s].
    pub bounds: Bounds,
    /// Scatter of the thresholds [m/s]; `None` where nothing varied.
    pub sigma: Option<f64>,
}

impl ComputedLimit {
    /// Limit in a file.
    ///
    /// # Errors
    /// When it cannot be read, or holds no V50.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        let wrong = |found: String| {
            let help = "give the v50.json in the folder of a `ripstop v50`";
            StudyError::new(path.display().to_string(), "v50.json of `ripstop v50`", found, help)
        };
        let text = fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
        let found: Value = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let number = |name: &str| found[name].as_f64();
        let v50 = number("v50_m_s").filter(|v50| *v50 > 0.0).ok_or_else(|| wrong("no v50_m_s".to_owned()))?;
        let bounds = Bounds { low: number("low_m_s"), high: number("high_m_s") };
        Ok(Self { v50, bounds, sigma: number("sigma_m_s").filter(|sigma| *sigma > 0.0) })
    }

    /// Chance of a perforation at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        match self.sigma {
            Some(sigma) => Link::Probit.probability((velocity - self.v50) / sigma),
            None => f64::from(u8::from(velocity >= self.v50)),
        }
    }

    /// Comparison in words with a measured V50 and its interval.
    pub(super) fn words(&self, measured: Option<(f64, Bounds)>) -> String {
        let [low, high] = self.bounds.words();
        let computed = format!("computed V50 {} m/s, {low} to {high} m/s", short(self.v50, 4));
        let Some((value, bounds)) = measured else { return computed };
        let off = 100.0 * (self.v50 / value - 1.0);
        let below = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| a < b);
        let apart = below(self.bounds.high, bounds.low) || below(bounds.high, self.bounds.low);
        let overlap = if apart { "the intervals do not overlap" } else { "the intervals overlap" };
        format!("{computed}: {}{} % of the measured one; {overlap}", if off > 0.0 { "+" } else { "" }, short(off, 2))
    }
}
