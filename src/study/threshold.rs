//! Thresholds: the velocity at which one realisation (same fabric, same hit) turns from stopped to perforated, and what many of them give.
//!
//! Velocities lie on a ladder whose rungs are a given part apart, so that a threshold does not depend on where its search began. The
//! search goes up or down in steps that double until it has both outcomes, then halves. Two shots beside the bracket check that the
//! outcome turns once only. The search on a finer mesh begins where that on the mesh of the case ended.
//!
//! A search is replayed from its begin whenever another outcome is known; the first one that is not is what it wants next.

use super::batch::ShotOrder;
use super::interval::{Bounds, outer_end, peak, student_t};
use super::outcomes::Shot;
use crate::num::link::Link;

/// Rungs from the bracket at which the outcome is checked again.
const BESIDE: i32 = 3;
/// Velocities that are searched [m/s].
const SEARCHED: [f64; 2] = [2.0, 4900.0];
/// First step of a search on the finer mesh, over the threshold on the coarser one.
const REFINED_STEP: f64 = 0.02;
/// Realisations that are shot further above their thresholds too, for the residual velocities, and where, over the threshold.
const FURTHER: (u32, &[f64]) = (8, &[1.15, 1.4]);
/// Range of ln(σ/σ̂) that is searched.
const SPREAD: f64 = 6.0;

/// Velocities that are tried: powers of 1 + width, rounded to mm/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rungs {
    /// Distance of neighbours over the lower one [-].
    pub width: f64,
}

impl Rungs {
    /// Velocity of a rung [m/s].
    pub fn velocity(&self, rung: i32) -> f64 {
        ((1.0 + self.width).powi(rung) * 1e3).round() / 1e3
    }

    /// Rung nearest to a velocity [m/s].
    pub fn nearest(&self, velocity: f64) -> i32 {
        (velocity.ln() / self.width.ln_1p()).round() as i32
    }
}

/// Threshold in a bracket [m/s]: its geometric mean, for rungs are powers.
pub fn middle([low, high]: [f64; 2]) -> f64 {
    (low * high).sqrt()
}

/// End of a search before its threshold is known.
#[derive(Clone, Debug, PartialEq)]
pub enum SearchEnd {
    /// Shot whose outcome is not known yet: number of the mesh, and order.
    Wanted(usize, ShotOrder),
    /// Reason why there is no threshold.
    Failed(String),
}

/// Rungs of the highest stop and the lowest perforation around a threshold, by a search from a rung on in steps of at least `step`.
///
/// # Errors
/// The first error of `passes`, or that no velocity changes the outcome.
pub fn bracket(
    rungs: Rungs,
    begin: i32,
    step: i32,
    mut passes: impl FnMut(i32) -> Result<bool, SearchEnd>,
) -> Result<[i32; 2], SearchEnd> {
    let [lowest, highest] = SEARCHED.map(|velocity| rungs.nearest(velocity));
    let (mut at, mut step) = (begin.clamp(lowest, highest), step.max(1));
    let first = passes(at)?;
    let beyond = loop {
        // A long step ends where the search does.
        let next = if first { at - step } else { at + step }.clamp(lowest, highest);
        if next == at {
            return Err(SearchEnd::Failed("no velocity from 2 to 4900 m/s changes the outcome".to_owned()));
        }
        if passes(next)? != first {
            break next;
        }
        at = next;
        step *= 2;
    };
    let [mut low, mut high] = if first { [beyond, at] } else { [at, beyond] };
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if passes(middle)? { high = middle } else { low = middle }
    }
    Ok([low, high])
}

/// Threshold of a realisation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FoundThreshold {
    /// Highest stop below it and lowest perforation above it [m/s]; or why there is none.
    pub(super) bracket: Result<[f64; 2], String>,
    /// Whether the outcome turned once only.
    pub(super) monotone: bool,
    /// Bracket on the finer mesh [m/s], where it was looked for and found.
    pub(super) refined: Option<[f64; 2]>,
}

/// Velocity where a search begins [m/s], and its first step in rungs.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub(super) velocity: f64,
    pub(super) step: i32,
}

/// Threshold of a realisation on the mesh of its case, then on the finer one where `is_refined`. `outcome`: of a shot on a mesh, where
/// it is known.
///
/// # Errors
/// Mesh and order of the next shot to fire.
pub(super) fn threshold(
    realisation: u32,
    rungs: Rungs,
    start: Start,
    is_refined: bool,
    outcome: impl Fn(usize, ShotOrder) -> Option<Result<Shot, String>>,
) -> Result<FoundThreshold, (usize, ShotOrder)> {
    let passes = |mesh: usize, rung: i32| {
        let order = ShotOrder { shot: realisation, velocity: Some(rungs.velocity(rung)) };
        let shot = outcome(mesh, order).ok_or(SearchEnd::Wanted(mesh, order))?.map_err(SearchEnd::Failed)?;
        Ok(shot.perforated)
    };
    let wanted = |end: SearchEnd| match end {
        SearchEnd::Wanted(mesh, order) => Err((mesh, order)),
        SearchEnd::Failed(reason) => Ok(reason),
    };
    let velocities = |ends: [i32; 2]| ends.map(|rung| rungs.velocity(rung));
    let (mut last_stop, mut first_perforation) = (i32::MIN, i32::MAX);
    let mut seen = |rung: i32| {
        let perforated = passes(0, rung)?;
        if perforated {
            first_perforation = first_perforation.min(rung)
        } else {
            last_stop = last_stop.max(rung)
        }
        Ok(perforated)
    };
    let mut search = || {
        let [low, high] = bracket(rungs, rungs.nearest(start.velocity), start.step, &mut seen)?;
        let further = if realisation < FURTHER.0 { FURTHER.1 } else { &[] };
        let further = further.iter().map(|part| rungs.nearest(rungs.velocity(high) * part));
        [low - BESIDE, high + BESIDE].into_iter().chain(further).try_for_each(|rung| seen(rung).map(drop))?;
        Ok([low, high])
    };
    let found = match search() {
        Ok(ends) => velocities(ends),
        Err(end) => {
            return Ok(FoundThreshold { bracket: Err(wanted(end)?), monotone: true, refined: None });
        }
    };
    let step = (REFINED_STEP / rungs.width).round() as i32;
    let refined = match is_refined.then(|| bracket(rungs, rungs.nearest(middle(found)), step, |rung| passes(1, rung))) {
        Some(Err(end)) => wanted(end).map(|_| None)?,
        Some(Ok(ends)) => Some(velocities(ends)),
        None => None,
    };
    Ok(FoundThreshold { bracket: Ok(found), monotone: last_stop < first_perforation, refined })
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
    /// Least and largest threshold.
    pub range: [f64; 2],
}

impl ThresholdSample {
    /// Sample of thresholds, each the middle of a bracket of this width; `None` of none.
    pub fn new(thresholds: &[f64], bracket: f64) -> Option<Self> {
        let n = thresholds.len() as f64;
        let mean = thresholds.iter().sum::<f64>() / n;
        let squares: f64 = thresholds.iter().map(|threshold| (threshold - mean).powi(2)).sum();
        let variance = if n > 1.0 { squares / (n - 1.0) } else { 0.0 };
        let range = thresholds.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], threshold| {
            [low.min(*threshold), high.max(*threshold)]
        });
        // Sheppard: a value rounded to a width scatters by that width over √12 more.
        let sigma = (variance - bracket * bracket / 12.0).max(0.0).sqrt();
        (!thresholds.is_empty()).then_some(Self { count: thresholds.len(), mean, sigma, range })
    }

    /// Threshold that a part `p` of the realisations lies below.
    pub fn quantile(&self, p: f64) -> f64 {
        self.mean + self.sigma * Link::Probit.quantile(p)
    }

    /// Part of the realisations that are perforated at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        match self.sigma {
            sigma if sigma > 0.0 => Link::Probit.probability((velocity - self.mean) / sigma),
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
        let z = Link::Probit.quantile(p);
        // Log-likelihood over its part that does not change, with the best σ.
        let height = |q: f64| {
            let at = |log: f64| {
                let sigma = self.sigma * log.exp();
                let off = self.mean - q + z * sigma;
                -n * log - 0.5 * n * (most_likely + off * off) / (sigma * sigma)
            };
            peak(at, -SPREAD, SPREAD, 1e-9).1
        };
        let best = -0.5 * n * (1.0 - 1.0 / n).ln() - 0.5 * n;
        let above = |q: f64| height(q) - (best - fall);
        let step = 0.5 * self.sigma / n.sqrt();
        let end = |side: f64| outer_end(above, value, side * step, side * f64::INFINITY, 1e-9 * self.sigma);
        Bounds { low: end(-1.0), high: end(1.0) }
    }
}

/// Thresholds of a few realisations on a finer mesh over those on the mesh of the case.
///
/// The mesh moves all thresholds by much the same part, so the mean ratio of a few pairs corrects the mean of all. Elements half as long
/// move a limit by a part d. If the finer mesh is converged, d is all; if the error falls as the length of an element, as much again is to
/// come. The correction is the middle, 1.5 d, and may be off by 0.5 d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refinement {
    /// Pairs of thresholds.
    pub count: usize,
    /// Mean ratio [-].
    pub ratio: f64,
    /// Standard deviation of the ratio [-]; 0 for one pair.
    pub sigma: f64,
}

impl Refinement {
    /// Refinement from pairs of thresholds, on the mesh of the case and on the finer one, in one unit; `None` without a pair.
    pub fn new(pairs: &[[f64; 2]]) -> Option<Self> {
        let count = pairs.len() as f64;
        let ratios = || pairs.iter().map(|[coarse, fine]| fine / coarse);
        let ratio = ratios().sum::<f64>() / count;
        let squares: f64 = ratios().map(|each| (each - ratio).powi(2)).sum();
        let sigma = if pairs.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 };
        (!pairs.is_empty()).then_some(Self { count: pairs.len(), ratio, sigma })
    }

    /// Factor of limits on the mesh of the case [-].
    pub fn factor(&self) -> f64 {
        1.0 + 1.5 * (self.ratio - 1.0)
    }

    /// Error of the factor at most, either way [-].
    pub fn open(&self) -> f64 {
        0.5 * (self.ratio - 1.0).abs()
    }

    /// Half the width of the interval of the mean factor [-], with this two-sided confidence: Student's; 0 for one pair.
    pub fn half_width(&self, level: f64) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        1.5 * student_t(level, self.count as u64 - 1) * self.sigma / (self.count as f64).sqrt()
    }
}

#[cfg(test)]
#[path = "threshold_tests.rs"]
mod tests;
