//! Result of `ripstop v50`: from thresholds to V50 and its interval, as JSON, words, tables and drawings.

use serde::Serialize;
use serde_json::{Value, json};

use super::batch::notes;
pub use super::binary_response::ThresholdSample;
use super::fit::{self, FitRow, VelocityUnit};
use super::limit::{Bounds, Limit, student_t};
use super::report::{
    Report, ReportTable, all_shots, drawn_panels, headline, residual_panel, shot_panel, threshold_panel,
};
use super::shots::ShotRow;
use super::v50::{AS_WOVEN, FoundThreshold, middle};
use crate::case::{Accuracy, Case, Numerics, case_hash};
use crate::output::number::short;

/// Part of mesh and time step in a limit, over the limit \[-\]: twice what half as long elements do to the README's ply
/// (0.25 %), and no less than this, for they move limits of cylinders, spheres and fragments on two fabrics by up to
/// this (docs/src/objectivity.md).
const NUMERICAL: f64 = 0.0175;
/// Part of the converged mesh: what half as long elements did (docs/src/objectivity.md).
const NUMERICAL_CONVERGED: f64 = 0.0125;
/// Part of the paper's numerics.
const NUMERICAL_PAPER: f64 = 0.115;
/// Part that is left once a finer mesh has corrected a limit: place of the mesh and time step, the largest spread (docs/src/objectivity.md).
const NUMERICAL_REST: f64 = 0.005;
/// Limits computed so far over measured ones, least and largest, by the part of strength that yarns keep: as published, as woven
/// (docs/src/validation.md).
pub const OVER_MEASURED: [(f64, [f64; 2]); 2] = [(1.0, [1.00, 1.68]), (AS_WOVEN[0], [0.85, 1.43])];

/// Note on the limit of one ply (docs/src/validation.md).
const FRAME: &str =
    "the limit of one clamped ply belongs to its frame too: S-720 in 150, 203 and 400 mm has 165, 183 and 221 m/s";

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
        let ratios: Vec<f64> = pairs.iter().map(|[coarse, fine]| fine / coarse).collect();
        let ThresholdSample { count, mean, sigma } = ThresholdSample::new(&ratios, 0.0)?;
        Some(Self { count, ratio: mean, sigma })
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

/// Half the width of the interval of V50 by where it comes from [m/s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct V50Width {
    /// Few realisations; `None` where the interval has no end.
    pub sampling: Option<f64>,
    /// Mesh and time step.
    pub numerical: f64,
    /// Brackets of thresholds.
    pub bracket: f64,
}

/// Request of a V50.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct V50Request {
    /// Realisations at most.
    pub count: u32,
    /// Half the width of the interval over V50 at which to stop early.
    pub until_width: Option<f64>,
    /// Width of the bracket of a threshold, over its lower end.
    pub bracket: f64,
    /// Realisations whose threshold is looked for on the converged mesh too, by which V50 is corrected.
    pub refined: u32,
    /// Two-sided confidence of all intervals.
    pub level: f64,
}

/// Result of a campaign.
#[derive(Clone, Debug, Default)]
pub struct V50Result {
    /// V50 [m/s]; `None` without an estimate.
    pub v50: Option<f64>,
    /// Interval of V50, of everything together.
    pub bounds: Bounds,
    /// Parts of that interval.
    pub width: V50Width,
    /// Standard deviation of thresholds [m/s].
    pub sigma: Option<f64>,
    /// Limit by every method but the arithmetic one, which is of shots.
    pub limit: Limit,
    /// Brackets of thresholds [m/s], or why there is none.
    pub thresholds: Vec<Result<[f64; 2], String>>,
    /// Shift of the thresholds by the converged mesh, where it was asked for; V50 and [`V50Result::middles`] hold it.
    pub refinement: Option<Refinement>,
    /// Shots on that mesh, and with yarns as woven.
    pub other_shots: [usize; 2],
    /// Limit with yarns as woven, where it was found, with its numerical error; V50 is that with yarns as published [m/s].
    pub as_woven: Option<[f64; 3]>,
    /// Sample of the thresholds.
    pub sample: Option<ThresholdSample>,
    /// Realisations whose outcome turned more than once.
    pub non_monotone: Vec<usize>,
    /// Shots without an outcome.
    pub failed: usize,
    /// Shots that were caught by cloth that had torn off its frame: no stops.
    pub torn_off: usize,
    /// Whether this is the one threshold of a case in which nothing varies: a ballistic limit, with a numerical error alone.
    pub is_alone: bool,
    /// Shots of the case that were fired in the search.
    pub rows: Vec<ShotRow>,
}

impl V50Result {
    /// Middles of the brackets as the converged mesh moves them, in the order of realisations [m/s].
    pub fn middles(&self) -> Vec<f64> {
        let factor = self.factor();
        self.thresholds.iter().filter_map(|found| Some(factor * middle(*found.as_ref().ok()?))).collect()
    }

    /// Factor by which the converged mesh moves limits [-].
    fn factor(&self) -> f64 {
        self.refinement.map_or(1.0, |refinement| refinement.factor())
    }

    /// Name of the limit: `V50` or `ballistic limit`.
    pub fn name(&self) -> &'static str {
        if self.is_alone { "ballistic limit" } else { "V50" }
    }

    /// Reason why there is no limit, and what to do; `None` where there is one.
    pub fn missing(&self) -> Option<String> {
        self.reason().filter(|_| self.v50.is_none()).map(|reason| format!("no {}: {reason}", self.name()))
    }

    /// First reason why a realisation has no threshold.
    pub(super) fn reason(&self) -> Option<&String> {
        self.thresholds.iter().find_map(|found| found.as_ref().err())
    }

    /// Estimate from thresholds, and from the shots of the search.
    pub(super) fn new(found: &[FoundThreshold], rows: Vec<ShotRow>, case: &Case, request: &V50Request) -> Self {
        let level = request.level;
        let decided: Vec<FitRow> = rows.iter().filter_map(ShotRow::fit_row).collect();
        let passed = fit::passed(&decided);
        let pair = |found: &FoundThreshold| Some([middle(found.bracket.clone().ok()?), middle(found.others[0]?)]);
        let pairs: Vec<[f64; 2]> = found.iter().filter_map(pair).collect();
        let turned = found.iter().enumerate().filter(|(_, found)| !found.monotone);
        let mut result = Self {
            is_alone: !case.varies(),
            thresholds: found.iter().map(|found| found.bracket.clone()).collect(),
            refinement: Refinement::new(&pairs),
            non_monotone: turned.map(|(realisation, _)| realisation).collect(),
            failed: rows.len() - decided.len(),
            torn_off: rows.iter().filter(|row| row.defeats() > row.perforated()).count(),
            rows,
            ..Self::default()
        };
        let middles = result.middles();
        let brackets = result.thresholds.iter().filter_map(|found| found.as_ref().ok());
        let count = middles.len().max(1) as f64;
        let width = brackets.map(|[low, high]| high - low).sum::<f64>() / count;
        let sample = ThresholdSample::new(&middles, width);
        let quantiles = sample.map_or_else(Vec::new, |sample| sample.quantiles(level));
        result.limit = Limit::new(VelocityUnit::default(), quantiles, passed, level);
        let Some(sample) = sample else { return result };
        // The middle of a bracket is off by half of it at most; the mean of many by less.
        let refined = result.refinement.map_or(0.0, |refinement| 1.0 / refinement.count as f64);
        let bracket = 0.5 * width * (1.0 / count + refined).sqrt();
        // The parts are independent: their squares add up.
        let v50 = sample.mean;
        let numerical = v50 * numerical(case, result.refinement.as_ref(), level);
        let own = match result.limit.v50() {
            Some((_, bounds)) if sample.count > 1 => bounds,
            _ => Bounds { low: Some(v50), high: Some(v50) },
        };
        let other = numerical.hypot(bracket);
        let woven = |ends: [f64; 2]| {
            let limit = result.factor() * middle(ends);
            let off = limit * other / v50;
            [limit, limit - off, limit + off]
        };
        let sampling = own.low.zip(own.high).map(|(low, high)| 0.5 * (high - low));
        Self {
            v50: Some(v50),
            bounds: Bounds {
                low: own.low.map(|low| v50 - (v50 - low).hypot(other)),
                high: own.high.map(|high| v50 + (high - v50).hypot(other)),
            },
            width: V50Width { sampling, numerical, bracket },
            sigma: (sample.count > 1).then_some(sample.sigma),
            sample: Some(sample),
            as_woven: found.first().and_then(|found| found.others[1]).map(woven),
            ..result
        }
    }

    /// Result in JSON; velocities in m/s.
    pub fn json(&self, case: &Case, request: &V50Request, seed: u32) -> Value {
        let quantile = |p: f64| self.limit.quantile(p).and_then(|quantile| quantile.value);
        let threshold = |(realisation, found): (usize, &Result<[f64; 2], String>)| match found {
            Ok([low, high]) => json!({ "realisation": realisation, "low_m_s": low, "high_m_s": high }),
            Err(reason) => json!({ "realisation": realisation, "low_m_s": null, "high_m_s": null, "reason": reason }),
        };
        let assumed = case.fields.iter().filter(|field| field.assumed).map(|field| field.pointer.as_str());
        let [quantiles, residual] = self.limit.json();
        json!({
            "quantity": self.name(),
            "v50_m_s": self.v50,
            "low_m_s": self.bounds.low,
            "high_m_s": self.bounds.high,
            "level": (!self.is_alone).then_some(request.level),
            "sigma_m_s": self.sigma,
            "v10_m_s": quantile(0.1),
            "v90_m_s": quantile(0.9),
            "half_width_m_s": self.width,
            "refinement": self.refinement.map(|found| json!({
                "realisations": found.count, "ratio": found.ratio, "factor": found.factor(), "sigma": found.sigma,
                "shots": self.other_shots[0],
            })),
            "as_woven": self.as_woven().map(|(retention, [v50, low, high], over_measured)| json!({
                "retention": retention, "v50_m_s": v50, "low_m_s": low, "high_m_s": high,
                "over_measured_so_far": over_measured,
            })).collect::<Vec<_>>(),
            "realisations": self.thresholds.len(),
            "shots": self.rows.len(),
            "failed": self.failed,
            "torn_off": self.torn_off,
            "non_monotone": self.non_monotone.len(),
            "non_monotone_realisations": self.non_monotone,
            "quantiles": quantiles,
            "residual": residual,
            "thresholds": self.thresholds.iter().enumerate().map(threshold).collect::<Vec<_>>(),
            "bracket": request.bracket,
            "seed": seed,
            "version": env!("CARGO_PKG_VERSION"),
            "case": case.name,
            "case_hash": case_hash(&case.as_run),
            "assumed": assumed.collect::<Vec<_>>(),
            "notes": self.notes(case),
        })
    }

    /// Rows of strength that yarns keep: the part, limit with its numerical error [m/s], and limits so far over measured ones. None where
    /// there is no limit as woven.
    fn as_woven(&self) -> impl Iterator<Item = (f64, [f64; 3], [f64; 2])> {
        let published = [self.v50, self.bounds.low, self.bounds.high].map(Option::unwrap_or_default);
        let rows = self.as_woven.map(|woven| [published, woven]).into_iter().flatten();
        rows.zip(OVER_MEASURED).map(|(limit, (retention, over))| (retention, limit, over))
    }

    /// Sentences that a reader should know before the numbers are used.
    pub fn notes(&self, case: &Case) -> Vec<String> {
        let mut notes = match case.varies() {
            true => notes(case),
            false => vec![
                "nothing varies from shot to shot: this is one threshold, and its numerical error is of mesh, time step and bracket alone. \
                 Give the case a variability for V10, V50, V90 and an interval of many shots"
                    .to_owned(),
            ],
        };
        notes.push(match self.refinement {
            Some(found) => format!(
                "elements half as long move the limit by {} %, measured on {} of the realisations; V50 holds one and a half times that, \
                 thresholds and residual velocities in the tables do not",
                short(100.0 * (found.ratio - 1.0), 2),
                found.count
            ),
            None => "the part of mesh and time step was measured on S-720 and is assumed for other fabrics".to_owned(),
        });
        if case.layers().iter().map(|layer| layer.plies).sum::<u32>() == 1 {
            notes.push(FRAME.to_owned());
        }
        if !self.non_monotone.is_empty() {
            let numbers: Vec<String> = self.non_monotone.iter().map(ToString::to_string).collect();
            notes.push(match self.is_alone {
                true => "a shot above the limit was stopped again: see the figure of shots".to_owned(),
                false => format!(
                    "in {} of {} realisations a faster shot was stopped: numbers {}",
                    numbers.len(),
                    self.thresholds.len(),
                    numbers.join(", ")
                ),
            });
        }
        let of = |count: usize, words: &str| (count > 0).then(|| format!("{count} of {} {words}", self.rows.len()));
        notes.extend(of(self.failed, "shots have no outcome: see v50.csv"));
        notes.extend(of(self.torn_off, "shots were caught by cloth that had torn off its frame, and are no stops"));
        notes
    }

    /// Result in words, tables and drawings.
    pub fn report(&self, case: &Case, request: &V50Request) -> Report {
        let known = self.thresholds.iter().filter(|found| found.is_ok()).count();
        let others = self.other_shots.into_iter().zip(["on the converged mesh", "with yarns as woven"]);
        let others: String =
            others.filter(|(count, _)| *count > 0).map(|(count, of)| format!(", {count} {of}")).collect();
        let counts = vec![
            format!("thresholds: {known} of {}", self.thresholds.len()),
            format!("shots: {}{others}", self.rows.len()),
        ];
        let row = |(retention, limit, over): (f64, [f64; 3], [f64; 2])| {
            let numbers = limit.map(|limit| short(limit, 4)).into_iter().chain(over.map(|over| format!("{over:.2}")));
            let yarns = if retention == 1.0 { "as published" } else { "as woven (assumed)" };
            [yarns.to_owned(), short(retention, 3)].into_iter().chain(numbers).collect()
        };
        let heads = ["yarns", "strength", "limit m/s", "low", "high", "over measured from", "to"];
        let yarns = ReportTable::new("strength of the yarns", &heads, 1).rows(self.as_woven().map(row), "");
        let [quantiles, residual] = self.limit.tables(request.level);
        let quantiles = Some(quantiles).filter(|_| self.sigma.is_some());
        let thresholds = self.sample.filter(|_| !self.is_alone).map(|sample| threshold_panel(self, &sample));
        let words = ["shots", "Shots of the search", if self.is_alone { "perforated [-]" } else { "realisation [-]" }];
        let value = |row: &ShotRow| match self.is_alone {
            true => row.perforated().map(|through| f64::from(u8::from(through))),
            false => Some(f64::from(row.order.shot)),
        };
        let shots = shot_panel(words, &self.rows, value);
        let drawn = drawn_panels(&self.rows);
        let velocity = "--set /projectile/velocity_m_s=V";
        let foot = match self.is_alone {
            true => format!("A shot at velocity V again, with its report: ripstop run of this case with {velocity}."),
            false => format!(
                "Shot N at velocity V again, with its report: ripstop shots of this case with {velocity} --set \
                 /variability/velocity=null --count {} --only N.",
                self.thresholds.len()
            ),
        };
        let all = all_shots(&self.rows, &foot);
        Report {
            title: case.title.clone(),
            counts,
            answer: self.answer(request.level),
            notes: self.notes(case),
            tables: [yarns].into_iter().chain(quantiles).chain([residual, all]).collect(),
            panels: thresholds.into_iter().chain(residual_panel(&self.limit)).chain(shots).chain(drawn).collect(),
        }
    }

    /// V50, σ, and the parts of the interval.
    fn answer(&self, level: f64) -> Vec<String> {
        let Some(v50) = self.v50 else { return vec![self.missing().unwrap_or_default()] };
        let metres = |width: f64| format!("± {} m/s", short(width, 2));
        let sampling = match self.width.sampling {
            Some(0.0) => "none".to_owned(),
            sampling => sampling.map_or_else(|| "no end".to_owned(), metres),
        };
        let [numerical, bracket] = [self.width.numerical, self.width.bracket].map(metres);
        if self.is_alone {
            let [low, high] = self.bounds.words();
            let limit = format!("ballistic limit {} m/s, numerical error: {low} to {high} m/s", short(v50, 4));
            return vec![limit, format!("of that: mesh and time step {numerical}, bracket {bracket}"), over_measured()];
        }
        let mut lines = vec![headline(v50, self.limit.unit, level, self.bounds.words())];
        lines.extend(self.sigma.map(|sigma| format!("σ {} m/s", short(sigma, 3))));
        lines.push(format!("of that: sampling {sampling}, mesh and time step {numerical}, brackets {bracket}"));
        lines.push(over_measured());
        lines
    }
}

/// Line on what is in no interval.
fn over_measured() -> String {
    let [(_, [from, to]), (part, [from_woven, to_woven])] = OVER_MEASURED;
    format!("limits so far {from:.2}-{to:.2} x measured (with {part}: {from_woven:.2}-{to_woven:.2})")
}

/// Part of mesh and time step in a limit, over the limit \[-\].
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_give_their_mean_ratio_and_students_interval_and_one_a_ratio_alone() {
        let pairs = [[100.0, 103.0], [200.0, 202.0], [50.0, 51.0], [80.0, 83.2]];
        let Some(found) = Refinement::new(&pairs) else { unreachable!("there are pairs") };
        assert!((found.ratio - 1.025).abs() < 1e-12 && found.count == 4);
        let sigma = ((0.005_f64.powi(2) * 2.0 + 0.015_f64.powi(2) * 2.0) / 3.0).sqrt();
        assert!((found.sigma - sigma).abs() < 1e-12, "{found:?}");
        // Student's t of three degrees of freedom at 90 %: 2.353.
        assert!((found.half_width(0.9) - 1.5 * 2.353_363 * sigma / 2.0).abs() < 1e-6, "{}", found.half_width(0.9));
        let found = Refinement::new(&[[180.0, 185.4]]);
        assert_eq!(found.map(|found| (found.count, found.half_width(0.9))), Some((1, 0.0)));
        // 180, 185.4, and 190.8 if the error is of first order: the middle of the last two, and half of what is between them.
        assert!(found.is_some_and(|found| (180.0 * found.factor() - 188.1).abs() < 1e-9));
        assert!(found.is_some_and(|found| (180.0 * found.open() - 2.7).abs() < 1e-9));
        assert_eq!(Refinement::new(&[]), None);
    }
}
