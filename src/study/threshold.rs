//! Thresholds: the velocity at which one realisation (same fabric, same hit) turns from stopped to perforated, and what many of them give.
//!
//! Velocities lie on a ladder whose rungs are a given part apart, so that a threshold does not depend on where its search began. The
//! search goes up or down in steps that double until it has both outcomes, then halves. Two shots beside the bracket check that the
//! outcome turns once only. The search on a finer mesh begins where that on the mesh of the case ended.

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

/// Search for one threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdSearch {
    rungs: Rungs,
    /// Rung where it begins, and first step away from there.
    begin: i32,
    step: i32,
    /// Shots once the bracket is known.
    further: FurtherShots,
    /// Outcomes by rung.
    seen: Vec<(i32, bool)>,
    /// Highest stop and lowest perforation of the search itself.
    low: Option<i32>,
    high: Option<i32>,
}

/// Shots of a search besides those that find its bracket.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FurtherShots {
    /// Two beside the bracket, to check that the outcome turns once only.
    pub beside: bool,
    /// At these velocities over the threshold, for residual velocities [-].
    pub beyond: &'static [f64],
}

/// Next wish of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// Shot at a rung.
    Shot(i32),
    /// Nothing: the bracket is one rung wide.
    Nothing,
    /// Nothing: no velocity that can be shot changes the outcome.
    NoThreshold,
}

impl ThresholdSearch {
    /// Search from a velocity [m/s] on, in steps of at least `step` rungs.
    pub fn new(rungs: Rungs, velocity: f64, step: i32, further: FurtherShots) -> Self {
        let begin = rungs.nearest(velocity);
        Self { rungs, begin, step: step.max(1), further, seen: Vec::new(), low: None, high: None }
    }

    /// Next shot.
    pub fn wanted(&self) -> Wanted {
        let is_seen = |rung: i32| self.seen.iter().any(|(seen, _)| *seen == rung);
        let next = match (self.low, self.high) {
            (None, None) => self.begin,
            (Some(low), None) => low + self.step,
            (None, Some(high)) => high - self.step,
            (Some(low), Some(high)) if high - low > 1 => low + (high - low) / 2,
            (Some(low), Some(high)) => {
                let beyond = self.further.beyond.iter();
                let beyond = beyond.map(|part| self.rungs.nearest(self.rungs.velocity(high) * part));
                let beside = [low - BESIDE, high + BESIDE].into_iter().filter(|_| self.further.beside);
                return beside.chain(beyond).find(|rung| !is_seen(*rung)).map_or(Wanted::Nothing, Wanted::Shot);
            }
        };
        // A long step ends where the search does.
        let [lowest, highest] = SEARCHED.map(|velocity| self.rungs.nearest(velocity));
        let next = next.clamp(lowest, highest);
        if is_seen(next) { Wanted::NoThreshold } else { Wanted::Shot(next) }
    }

    /// Records an outcome.
    pub fn see(&mut self, rung: i32, perforated: bool) {
        self.seen.push((rung, perforated));
        if matches!((self.low, self.high), (Some(low), Some(high)) if high - low <= 1) {
            return;
        }
        let found = if perforated { &mut self.high } else { &mut self.low };
        let first_of_both = found.is_none() && self.seen.len() > 1;
        *found = Some(rung);
        if self.seen.len() > 1 && !first_of_both {
            self.step *= 2;
        }
    }

    /// Velocities of the highest stop and the lowest perforation around the threshold [m/s].
    pub fn bracket(&self) -> Option<[f64; 2]> {
        Some([self.rungs.velocity(self.low?), self.rungs.velocity(self.high?)])
    }

    /// Whether no stop that was seen lies above a perforation.
    fn is_monotone(&self) -> bool {
        let of = |wanted: bool| self.seen.iter().filter(move |(_, passed)| *passed == wanted).map(|(rung, _)| *rung);
        of(false).max().zip(of(true).min()).is_none_or(|(stop, perforation)| stop < perforation)
    }
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

/// Search for the thresholds of a realisation on the mesh of its case, then on the finer one where that is asked for.
pub(super) struct RealisationSearch {
    realisation: u32,
    rungs: Rungs,
    search: ThresholdSearch,
    /// Mesh of the search: 0 is that of the case, 1 the finer one.
    mesh: usize,
    /// Number of meshes.
    meshes: usize,
    found: FoundThreshold,
}

impl RealisationSearch {
    pub(super) fn new(realisation: u32, rungs: Rungs, start: Start, meshes: usize) -> Self {
        let beyond = if realisation < FURTHER.0 { FURTHER.1 } else { &[] };
        let search = ThresholdSearch::new(rungs, start.velocity, start.step, FurtherShots { beside: true, beyond });
        let found = FoundThreshold { bracket: Err("no bracket".to_owned()), monotone: true, refined: None };
        Self { realisation, rungs, search, mesh: 0, meshes, found }
    }

    /// Mesh of the next shot, and the shot; `None` once the search is over.
    pub(super) fn wanted(&mut self) -> Option<(usize, ShotOrder)> {
        while self.mesh < self.meshes {
            match self.search.wanted() {
                Wanted::Shot(rung) => {
                    let velocity = Some(self.rungs.velocity(rung));
                    return Some((self.mesh, ShotOrder { shot: self.realisation, velocity }));
                }
                Wanted::Nothing => self.end(self.search.bracket().ok_or_else(|| "no bracket".to_owned())),
                Wanted::NoThreshold => self.end(Err("no velocity from 2 to 4900 m/s changes the outcome".to_owned())),
            }
        }
        None
    }

    /// Records the outcome of the shot that was wanted; or why it has none, which ends the search on its mesh.
    pub(super) fn see(&mut self, outcome: Result<Shot, String>) {
        match (outcome, self.search.wanted()) {
            (Ok(shot), Wanted::Shot(rung)) => self.search.see(rung, shot.perforated),
            (Ok(_), _) => {}
            (Err(reason), _) => self.end(Err(reason)),
        }
    }

    /// Ends the search on its mesh.
    fn end(&mut self, bracket: Result<[f64; 2], String>) {
        if self.mesh == 1 {
            self.found.refined = bracket.ok();
        } else {
            self.found.monotone = bracket.is_err() || self.search.is_monotone();
            match &bracket {
                Ok(bracket) => {
                    let step = (REFINED_STEP / self.rungs.width).round() as i32;
                    self.search = ThresholdSearch::new(self.rungs, middle(*bracket), step, FurtherShots::default());
                }
                Err(_) => self.meshes = 1,
            }
            self.found.bracket = bracket;
        }
        self.mesh += 1;
    }

    pub(super) fn found(self) -> FoundThreshold {
        self.found
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
