//! Result of `ripstop v50`: from thresholds to V50 and its interval, as JSON, words, tables and drawings.

use serde_json::{Value, json};

use super::interval::Bounds;
use super::limit::{Limit, QUANTILES, Quantile, quantile_row};
use super::outcomes::{Outcomes, Shot};
use super::report::{Report, ReportTable, headline, residual_panel, threshold_panel};
use super::residual_fit::Passed;
use super::shots;
use super::threshold::{FoundThreshold, Refinement, ThresholdSample, middle};
use super::v50::V50Request;
use crate::case::{Accuracy, Case, Numerics, case_hash};
use crate::output::number::short;
use crate::run::batch::DeviceUse;

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

/// Half the width of the interval of V50 by where it comes from [m/s].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct V50Width {
    /// Few realisations; `None` where the interval has no end.
    pub sampling: Option<f64>,
    /// Mesh and time step.
    pub numerical: f64,
    /// Brackets of thresholds.
    pub bracket: f64,
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
    /// Limit by every method; the arithmetic V50 is of an up-and-down through the thresholds.
    pub limit: Limit,
    /// Brackets of thresholds [m/s], or why there is none.
    pub thresholds: Vec<Result<[f64; 2], String>>,
    /// Shift of the thresholds by the converged mesh, where it was asked for; V50 and [`V50Result::middles`] hold it.
    pub refinement: Option<Refinement>,
    /// Shots on that mesh.
    pub refined_shots: usize,
    /// Sample of the thresholds.
    pub sample: Option<ThresholdSample>,
    /// Realisations whose outcome turned more than once.
    pub non_monotone: Vec<usize>,
    /// Number of shots.
    pub shots: usize,
    /// Shots without an outcome.
    pub failed: usize,
    /// Use of the device.
    pub device: DeviceUse,
}

impl V50Result {
    /// Middles of the brackets as the converged mesh moves them, in the order of realisations [m/s].
    pub fn middles(&self) -> Vec<f64> {
        let factor = self.refinement.map_or(1.0, |refinement| refinement.factor());
        self.thresholds.iter().filter_map(|found| Some(factor * middle(*found.as_ref().ok()?))).collect()
    }

    /// Estimate from thresholds. `passed`: shots that perforated.
    pub(super) fn with_thresholds(
        self,
        found: &[FoundThreshold],
        passed: Vec<Passed>,
        case: &Case,
        request: &V50Request,
    ) -> Self {
        let level = request.level;
        let pair = |found: &FoundThreshold| Some([middle(found.bracket.clone().ok()?), middle(found.refined?)]);
        let pairs: Vec<[f64; 2]> = found.iter().filter_map(pair).collect();
        let turned = found.iter().enumerate().filter(|(_, found)| !found.monotone);
        let mut result = Self {
            thresholds: found.iter().map(|found| found.bracket.clone()).collect(),
            refinement: Refinement::new(&pairs),
            non_monotone: turned.map(|(realisation, _)| realisation).collect(),
            ..self
        };
        let middles = result.middles();
        let brackets = result.thresholds.iter().filter_map(|found| found.as_ref().ok());
        let count = middles.len().max(1) as f64;
        let width = brackets.map(|[low, high]| high - low).sum::<f64>() / count;
        let Some(sample) = ThresholdSample::new(&middles, width) else {
            result.limit = Limit::new(Vec::new(), &Outcomes::default(), passed, level);
            return result;
        };
        // A single threshold of a case in which nothing varies is no sample.
        let chances = if sample.count == 1 { &[0.5][..] } else { &QUANTILES };
        let quantile =
            |p: &f64| Quantile { p: *p, value: Some(sample.quantile(*p)), bounds: sample.interval(*p, level) };
        let shots = up_and_down(&middles, sample.mean, sample.sigma.max(width));
        result.limit = Limit::new(chances.iter().map(quantile).collect(), &shots.iter().collect(), passed, level);
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
        let range = self.sample.map(|sample| sample.range);
        let assumed = case.fields.iter().filter(|field| field.assumed).map(|field| field.pointer.as_str());
        let [quantiles, arithmetic, residual] = self.limit.json();
        json!({
            "v50_m_s": self.v50,
            "low_m_s": self.bounds.low,
            "high_m_s": self.bounds.high,
            "level": request.level,
            "sigma_m_s": self.sigma,
            "v10_m_s": quantile(0.1),
            "v90_m_s": quantile(0.9),
            "half_width_m_s": {
                "sampling": self.width.sampling, "numerical": self.width.numerical, "bracket": self.width.bracket,
            },
            "refinement": self.refinement.map(|found| json!({
                "realisations": found.count, "ratio": found.ratio, "factor": found.factor(), "sigma": found.sigma,
                "shots": self.refined_shots,
            })),
            "realisations": self.thresholds.len(),
            "shots": self.shots,
            "failed": self.failed,
            "non_monotone": self.non_monotone.len(),
            "non_monotone_realisations": self.non_monotone,
            "slowest_threshold_m_s": range.map(|range| range[0]),
            "fastest_threshold_m_s": range.map(|range| range[1]),
            "quantiles": quantiles,
            "arithmetic_of": "an up-and-down of one shot at each realisation, its outcome known from the threshold",
            "arithmetic": arithmetic,
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

    /// Sentences that a reader should know before the numbers are used.
    pub fn notes(&self, case: &Case) -> Vec<String> {
        let mut notes = Vec::new();
        if case.varies() {
            notes.extend(shots::notes(case));
        } else {
            notes.push(
                "nothing varies from shot to shot: this is one threshold, and its interval holds mesh, time step and bracket alone. \
                 Give the case a variability for V10, V90 and an interval of many shots"
                    .to_owned(),
            );
        }
        notes.push(match self.refinement {
            Some(found) => format!(
                "elements half as long move the limit by {} %, measured on {} realisation{}; V50 holds one and a half times that, \
                 thresholds and residual velocities in the tables do not",
                short(100.0 * (found.ratio - 1.0), 2),
                found.count,
                plural(found.count)
            ),
            None => "the part of mesh and time step was measured on S-720 and is assumed for other fabrics".to_owned(),
        });
        if !self.non_monotone.is_empty() {
            let numbers: Vec<String> = self.non_monotone.iter().map(ToString::to_string).collect();
            notes.push(format!(
                "{} of {} realisations are not monotone, a faster shot was stopped: {}",
                numbers.len(),
                self.thresholds.len(),
                numbers.join(", ")
            ));
        }
        if self.failed > 0 {
            notes.push(format!("{} of {} shots have no outcome: see v50.csv", self.failed, self.shots));
        }
        notes
    }

    /// Result in words, tables and drawings.
    pub fn report(&self, case: &Case, request: &V50Request) -> Report {
        let known = self.thresholds.iter().filter(|found| found.is_ok()).count();
        let of = self.thresholds.len();
        let finer = match self.refined_shots {
            0 => String::new(),
            count => format!(", {count} on the converged mesh"),
        };
        let counts = format!(
            "{known} threshold{} of {of} realisation{}, {} shots{finer}",
            plural(known),
            plural(of),
            self.shots
        );
        let mut tables = Vec::new();
        if self.sample.is_some_and(|sample| sample.count > 1) {
            tables.push(self.quantile_table(request.level));
            tables.push(self.limit.arithmetic_table("of an up-and-down of one shot at each realisation"));
        }
        tables.push(self.limit.residual_table());
        let mut panels: Vec<_> = self.sample.map(|sample| threshold_panel(self, &sample)).into_iter().collect();
        panels.extend(residual_panel(&self.limit));
        Report {
            title: case.title.clone(),
            counts: vec![counts],
            answer: self.answer(request.level),
            notes: self.notes(case),
            tables,
            page_tables: vec![self.threshold_table()],
            panels,
        }
    }

    /// V50, σ, and the parts of the interval.
    fn answer(&self, level: f64) -> Vec<String> {
        let Some(v50) = self.v50 else { return vec!["no V50".to_owned()] };
        let metres = |width: f64| format!("± {} m/s", short(width, 2));
        let sampling = match self.width.sampling {
            Some(0.0) => "none".to_owned(),
            sampling => sampling.map_or_else(|| "no end".to_owned(), metres),
        };
        let [numerical, bracket] = [self.width.numerical, self.width.bracket].map(metres);
        let mut lines = vec![headline(v50, level, self.bounds.words())];
        lines.extend(self.sigma.map(|sigma| format!("σ {} m/s", short(sigma, 3))));
        lines.push(format!("of that: sampling {sampling}, mesh and time step {numerical}, brackets {bracket}"));
        lines
    }

    fn quantile_table(&self, level: f64) -> ReportTable {
        let seen = |name: &str, end: usize| {
            let velocity = self.sample.map(|sample| short(sample.range[end], 4));
            vec![name.to_owned(), velocity.unwrap_or_default(), String::new(), String::new()]
        };
        let mut rows = vec![seen("V0, slowest seen", 0)];
        rows.extend(self.limit.quantiles.iter().map(|of| quantile_row(format!("V{}", short(100.0 * of.p, 3)), of)));
        rows.push(seen("V100, fastest seen", 1));
        let foot = format!("{} % intervals of the sampling alone, likelihood ratio", short(100.0 * level, 3));
        ReportTable::new("velocity by chance of a perforation", &["", "m/s", "low", "high"], 1, rows).foot(&foot)
    }

    fn threshold_table(&self) -> ReportTable {
        let row = |(realisation, found): (usize, &Result<[f64; 2], String>)| {
            let turned = if self.non_monotone.contains(&realisation) { "not monotone" } else { "" };
            let [low, high, mark] = match found {
                Ok([low, high]) => [short(*low, 6), short(*high, 6), turned.to_owned()],
                Err(reason) => [String::new(), String::new(), reason.clone()],
            };
            vec![realisation.to_string(), low, high, mark]
        };
        let heads = ["realisation", "highest stop m/s", "lowest perforation m/s", ""];
        ReportTable::new("thresholds", &heads, 0, self.thresholds.iter().enumerate().map(row))
    }
}

/// Ending of a word for a count.
fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// Shots that an up-and-down of one shot at each realisation would see: with known thresholds none has to be fired.
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
