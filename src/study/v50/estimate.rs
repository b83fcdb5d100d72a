//! From thresholds to V50, its interval, and what the interval is made of.

use super::V50Request;
use super::realisation::FoundThreshold;
use super::refinement::Refinement;
use super::sample::ThresholdSample;
use super::threshold::middle;
use crate::case::{Accuracy, Case, Numerics};
use crate::run::batch::DeviceUse;
use crate::study::arithmetic_v50::{Arithmetic, RULES, Refusal, Rule, arithmetic_v50};
use crate::study::batch::ShotRow;
use crate::study::fit::{self, FitRow, QUANTILES, Quantile};
use crate::study::interval::Bounds;
use crate::study::outcomes::{Outcomes, Shot};
use crate::study::residual_fit::{Passed, ResidualFit, ResidualModel, TooFew, residual_fit};

/// What mesh and time step may make of a limit, over the limit \[-\]: twice what half as long elements do to the README's ply
/// (0.25 %), and no less than this, for they move limits of cylinders, spheres and fragments on two fabrics by up to
/// this (docs/src/objectivity.md).
const NUMERICAL: f64 = 0.0175;
/// The same of the converged mesh: what half as long elements did (docs/src/objectivity.md).
const NUMERICAL_CONVERGED: f64 = 0.0125;
/// The same with the paper's numerics.
const NUMERICAL_PAPER: f64 = 0.115;
/// What is left once a finer mesh has corrected a limit: place of the mesh and time step, the largest spread (docs/src/objectivity.md).
const NUMERICAL_REST: f64 = 0.005;
/// Bands of impact velocity for which residual velocities are summed up.
const BANDS: usize = 5;

/// Half the width of the interval of V50 by where it comes from [m/s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct V50Width {
    /// Realisations are few; `None` where the interval has no end.
    pub sampling: Option<f64>,
    /// Mesh and time step.
    pub numerical: f64,
    /// Brackets of thresholds.
    pub bracket: f64,
}

/// Residual velocities of a band of impact velocities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualBand {
    /// Impact velocities [m/s].
    pub impact: [f64; 2],
    /// Shots that perforated.
    pub count: usize,
    /// Mean, least and largest residual velocity [m/s].
    pub mean: f64,
    /// See `mean`.
    pub range: [f64; 2],
}

/// All that a campaign tells.
#[derive(Clone, Debug)]
pub struct V50Result {
    /// V50 [m/s]; `None` without an estimate.
    pub v50: Option<f64>,
    /// Its interval, of everything together.
    pub bounds: Bounds,
    /// What it is made of.
    pub width: V50Width,
    /// Standard deviation of thresholds [m/s].
    pub sigma: Option<f64>,
    /// Velocities by chance; their intervals are of the sampling alone.
    pub quantiles: Vec<Quantile>,
    /// Brackets of thresholds [m/s], or why there is none.
    pub thresholds: Vec<Result<[f64; 2], String>>,
    /// What the converged mesh moves them by, where it was asked; it is in [`V50Result::middles`] and all that follows.
    pub refinement: Option<Refinement>,
    /// Shots on that mesh.
    pub refined_shots: usize,
    /// Their sample.
    pub sample: Option<ThresholdSample>,
    /// Realisations whose outcome turned more than once.
    pub non_monotone: Vec<usize>,
    /// Shots that the arithmetic V50 is of.
    pub ranged: Vec<Shot>,
    /// The arithmetic V50 of each rule.
    pub arithmetic: Vec<(Rule, Result<Arithmetic, Refusal>)>,
    /// Curves through residual velocities.
    pub residual: Vec<(ResidualModel, Result<ResidualFit, TooFew>)>,
    /// Shots that perforated.
    pub passed: Vec<Passed>,
    /// Residual velocities by impact velocity.
    pub bands: Vec<ResidualBand>,
    /// Shots, and those without an outcome.
    pub shots: usize,
    /// See `shots`.
    pub failed: usize,
    /// What was taken of a device.
    pub device: DeviceUse,
}

impl V50Result {
    /// Whether half the interval is at most this part of V50.
    pub fn is_within(&self, width: f64) -> bool {
        self.bounds.is_narrow(self.v50, width)
    }

    /// Middles of the brackets as the converged mesh moves them, in the order of realisations [m/s].
    pub fn middles(&self) -> Vec<f64> {
        let factor = self.refinement.map_or(1.0, |refinement| refinement.factor());
        self.thresholds.iter().filter_map(|found| Some(factor * middle(*found.as_ref().ok()?))).collect()
    }

    /// Chance of a perforation at a velocity.
    pub fn probability(&self, velocity: f64) -> Option<f64> {
        self.sample.map(|sample| sample.probability(velocity))
    }
}

/// What rows and thresholds tell.
pub(super) fn estimate<'a>(
    case: &Case,
    request: &V50Request,
    found: &[FoundThreshold],
    rows: impl Iterator<Item = &'a ShotRow>,
    refined_shots: usize,
) -> V50Result {
    let rows: Vec<&ShotRow> = rows.collect();
    let fit_rows: Vec<FitRow> = rows.iter().filter_map(|row| row.as_fit_row()).collect();
    let passed = fit::passed(&fit_rows);
    let level = request.level;
    let thresholds: Vec<_> = found.iter().map(|found| found.bracket.clone()).collect();
    let mut result = V50Result {
        v50: None,
        bounds: Bounds::default(),
        width: V50Width { sampling: None, numerical: 0.0, bracket: 0.0 },
        sigma: None,
        quantiles: Vec::new(),
        refinement: Refinement::new(&pairs(found)),
        refined_shots,
        sample: None,
        non_monotone: found.iter().enumerate().filter(|(_, found)| !found.monotone).map(|(n, _)| n).collect(),
        ranged: Vec::new(),
        arithmetic: Vec::new(),
        residual: [ResidualModel::RechtIpson, ResidualModel::LambertJonas]
            .map(|curve| (curve, residual_fit(curve, &passed, level)))
            .to_vec(),
        bands: bands(&passed),
        passed,
        shots: rows.len(),
        failed: rows.len() - fit_rows.len(),
        device: DeviceUse::default(),
        thresholds,
    };
    of_thresholds(&mut result, request);
    let ranged: Outcomes = result.ranged.iter().collect();
    result.arithmetic = RULES.map(|rule| (rule, arithmetic_v50(&ranged, &rule))).to_vec();
    combine(&mut result, case, level);
    result
}

/// Middles of the brackets of realisations on both meshes [m/s].
fn pairs(found: &[FoundThreshold]) -> Vec<[f64; 2]> {
    let pair = |found: &FoundThreshold| Some([middle(found.bracket.clone().ok()?), middle(found.refined?)]);
    found.iter().filter_map(pair).collect()
}

fn of_thresholds(result: &mut V50Result, request: &V50Request) {
    let middles = result.middles();
    let brackets = result.thresholds.iter().filter_map(|found| found.as_ref().ok());
    let count = middles.len().max(1) as f64;
    let width = brackets.map(|[low, high]| high - low).sum::<f64>() / count;
    let Some(sample) = ThresholdSample::new(&middles, width) else { return };
    result.sample = Some(sample);
    result.v50 = Some(sample.mean);
    result.sigma = (sample.count > 1).then_some(sample.sigma);
    // The middle of a bracket is off by half of it at most; the mean of many by less.
    let refined = result.refinement.map_or(0.0, |refinement| 1.0 / refinement.count as f64);
    result.width.bracket = 0.5 * width * (1.0 / count + refined).sqrt();
    let level = request.level;
    result.quantiles =
        QUANTILES.map(|p| Quantile { p, value: Some(sample.quantile(p)), bounds: sample.interval(p, level) }).to_vec();
    // A single threshold of a case in which nothing varies is no sample.
    if sample.count == 1 {
        result.quantiles.retain(|quantile| quantile.p == 0.5);
    }
    result.ranged = up_and_down(&middles, sample.mean, sample.sigma.max(width));
}

/// What an up-and-down of one shot at each realisation would see: with known thresholds no shot is needed for it.
fn up_and_down(thresholds: &[f64], start: f64, step: f64) -> Vec<Shot> {
    thresholds.iter().fold(Vec::new(), |mut shots: Vec<Shot>, threshold| {
        let velocity = match shots.last() {
            None => start,
            Some(shot) if shot.perforated => shot.velocity - step,
            Some(shot) => shot.velocity + step,
        };
        shots.push(Shot { velocity, perforated: velocity > *threshold });
        shots
    })
}

/// What mesh and time step may make of a limit, over the limit \[-\].
fn numerical(case: &Case, refinement: Option<&Refinement>, level: f64) -> f64 {
    if let Some(found) = refinement {
        return found.open().hypot(found.half_width(level)).hypot(NUMERICAL_REST);
    }
    match (case.solver.numerics, case.solver.accuracy) {
        (Numerics::Paper, _) => NUMERICAL_PAPER,
        (Numerics::Default, Accuracy::Converged) => NUMERICAL_CONVERGED,
        (Numerics::Default, Accuracy::Default) => NUMERICAL,
    }
}

/// The interval of everything: its parts are independent, their squares add up.
fn combine(result: &mut V50Result, case: &Case, level: f64) {
    let Some(v50) = result.v50 else { return };
    result.width.numerical = v50 * numerical(case, result.refinement.as_ref(), level);
    let single = result.sample.is_some_and(|sample| sample.count == 1);
    let own = if single {
        Bounds { low: Some(v50), high: Some(v50) }
    } else {
        let median = result.quantiles.iter().find(|quantile| quantile.p == 0.5);
        median.map_or_else(Bounds::default, |quantile| quantile.bounds)
    };
    result.width.sampling = own.low.zip(own.high).map(|(low, high)| 0.5 * (high - low));
    let other = result.width.numerical.hypot(result.width.bracket);
    result.bounds = Bounds {
        low: own.low.map(|low| v50 - (v50 - low).hypot(other)),
        high: own.high.map(|high| v50 + (high - v50).hypot(other)),
    };
}

/// Shots that perforated, in bands of as many each.
fn bands(passed: &[Passed]) -> Vec<ResidualBand> {
    let mut passed: Vec<&Passed> = passed.iter().collect();
    passed.sort_by(|a, b| a.impact.total_cmp(&b.impact));
    let size = passed.len().div_ceil(BANDS).max(2);
    let band = |shots: &[&Passed]| {
        let residual = shots.iter().map(|shot| shot.residual);
        ResidualBand {
            impact: [shots[0].impact, shots[shots.len() - 1].impact],
            count: shots.len(),
            mean: residual.clone().sum::<f64>() / shots.len() as f64,
            range: [residual.clone().fold(f64::INFINITY, f64::min), residual.fold(0.0, f64::max)],
        }
    };
    passed.chunks(size).map(band).collect()
}
