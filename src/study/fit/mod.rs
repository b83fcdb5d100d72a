//! `ripstop fit`: from shots to a ballistic limit.
//!
//! ```text
//! table ──► fit ──► text, draw, page
//! CSV               JSON, SVG, HTML
//! ```

mod computed;
pub(in crate::study) mod draw;
mod page;
mod table;
mod text;

pub use computed::ComputedLimit;
pub use draw::svg;
pub use page::html;
pub(in crate::study) use page::sections;
pub use table::{FitRow, outcomes, parse, passed, read};
pub(in crate::study) use text::{arithmetic_json, quantile_json, residual_json};
pub use text::{json, notes, refusal, rule, too_few};

use super::arithmetic_v50::{self, Arithmetic, RULES, Refusal, Rule};
use super::binary_response::{self, Estimate, NoEstimate};
use super::interval::{Bounds, Interval, interval};
use super::outcomes::Outcomes;
use super::residual_fit::{Passed, ResidualFit, ResidualModel, TooFew, residual_fit};
use crate::num::link::Link;

/// Chances of a perforation at which velocities are given.
pub const QUANTILES: [f64; 5] = [0.1, 0.25, 0.5, 0.75, 0.9];

/// How it is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRequest {
    /// Distribution of the thresholds.
    pub link: Link,
    /// Two-sided confidence of intervals.
    pub level: f64,
    /// How they are made.
    pub interval: Interval,
}

/// Velocity of one chance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantile {
    /// Chance of a perforation.
    pub p: f64,
    /// Velocity [m/s]; none without an estimate.
    pub value: Option<f64>,
    /// Its interval [m/s].
    pub bounds: Bounds,
}

/// What shots tell of the limit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// How it was fitted.
    pub request: FitRequest,
    /// The shots.
    pub outcomes: Outcomes,
    /// Those whose residual velocity was measured.
    pub passed: Vec<Passed>,
    /// μ and σ, or why there are none.
    pub estimate: Result<Estimate, NoEstimate>,
    /// Velocities at [`QUANTILES`].
    pub quantiles: Vec<Quantile>,
    /// The arithmetic V50 of each rule.
    pub arithmetic: Vec<(Rule, Result<Arithmetic, Refusal>)>,
    /// Curves through the residual velocities; none where none was measured.
    pub residual: Vec<(ResidualModel, Result<ResidualFit, TooFew>)>,
    /// A computed limit to hold them against.
    pub computed: Option<ComputedLimit>,
}

impl Fit {
    /// The V50 and its interval.
    pub fn v50(&self) -> Option<&Quantile> {
        self.quantiles.iter().find(|quantile| quantile.p == 0.5)
    }
}

/// Fits all that shots allow.
pub fn fit(rows: &[FitRow], request: FitRequest) -> Fit {
    let (outcomes, passed) = (outcomes(rows), passed(rows));
    let estimate = binary_response::fit(request.link, &outcomes);
    let found = estimate.as_ref().ok();
    let quantile = |p: f64| {
        let bounds = interval(request.interval, request.link, &outcomes, found, p, request.level);
        Quantile { p, value: found.map(|found| found.velocity(p)), bounds }
    };
    let curves = if passed.is_empty() { &[][..] } else { &[ResidualModel::RechtIpson, ResidualModel::LambertJonas] };
    Fit {
        request,
        estimate,
        quantiles: QUANTILES.map(quantile).to_vec(),
        arithmetic: RULES.map(|rule| (rule, arithmetic_v50::arithmetic_v50(&outcomes, &rule))).to_vec(),
        residual: curves.iter().map(|curve| (*curve, residual_fit(*curve, &passed, request.level))).collect(),
        outcomes,
        passed,
        computed: None,
    }
}
