//! The points of a sweep, each a batch in a folder of its own: what has ended there is read, not computed again.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::design::SweepDesign;
use super::factor::Factor;
use super::{KeyEffect, html, json, key_effects};
use crate::case::Case;
use crate::output::Folder;
use crate::output::csv::{header, number, quoted, row};
use crate::study::batch::{BatchError, BatchOptions, BatchPlan, ShotRow};
use crate::study::shots::{self, ShotsRequest};
use crate::study::threads::in_threads;
use crate::study::v50::{self, V50Request};

/// What is computed at each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepOf {
    /// Shots.
    Shots(ShotsRequest),
    /// A V50.
    V50(V50Request),
}

/// A sweep.
#[derive(Clone, Debug)]
pub struct SweepRequest {
    /// What is varied.
    pub factors: Vec<Factor>,
    /// Which points.
    pub design: SweepDesign,
    /// Confidence of the intervals.
    pub level: f64,
    /// The values at each point, as the case file would have them.
    pub points: Vec<Vec<String>>,
    /// The case at each point, and what is computed there.
    pub cases: Vec<(Case, SweepOf)>,
}

impl SweepRequest {
    /// Columns of the table behind the keys; none without points.
    pub fn columns(&self) -> &'static [&'static str] {
        self.cases.first().map_or(&[], |(_, of)| of.columns())
    }
}

/// What a point gave.
#[derive(Clone, Debug, PartialEq)]
pub struct PointResult {
    /// Numbers by column; none where the point failed.
    pub numbers: Vec<Option<f64>>,
    /// Why there is no result, else empty.
    pub reason: String,
}

/// What a sweep gave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepResult {
    /// By point.
    pub points: Vec<PointResult>,
    /// By key.
    pub effects: Vec<KeyEffect>,
}

impl SweepOf {
    /// Columns of the table; the first is what the page shows.
    pub fn columns(&self) -> &'static [&'static str] {
        match self {
            Self::Shots(_) => &["residual_velocity_m_s", "perforated_part", "absorbed_energy_j", "shots", "failed"],
            Self::V50(_) => &["v50_m_s", "low_m_s", "high_m_s", "sigma_m_s", "shots", "failed", "non_monotone"],
        }
    }
}

/// Runs the points that have not ended yet and writes the table and the page. `progress` gets the points done.
///
/// # Errors
/// See [`BatchError`]; what has ended stays.
pub fn run(
    request: &SweepRequest,
    options: &BatchOptions<'_>,
    folder: &Folder,
    resume: bool,
    title: &str,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<SweepResult, BatchError> {
    let Some((first, of)) = request.cases.first() else { return Ok(SweepResult::default()) };
    let factors: Vec<&str> = request.factors.iter().map(|factor| factor.pointer.as_str()).collect();
    let parts = serde_json::json!({
        "over": factors, "points": request.points, "of": format!("{of:?}"), "precision": options.precision.name(),
    });
    let plan = BatchPlan::new("sweep", first, options.seed, parts);
    let points = folder.path().join("points");
    if !resume && points.exists() {
        std::fs::remove_dir_all(&points).map_err(|error| crate::output::OutputError::unwritten(&points, &error))?;
    }
    plan.begin(folder, super::FILES, resume)?;
    let points = all(request, options, folder.path(), progress)?;
    let results = SweepResult { effects: key_effects(request, &points), points };
    let table = table(request, &results.points);
    #[cfg(feature = "parquet")]
    crate::output::parquet::put(folder, super::PARQUET, &table)?;
    let texts = [
        ("sweep.json", format!("{:#}\n", json(request, &results))),
        ("sweep.html", html(request, &results, title)),
        ("sweep.csv", table),
    ];
    folder.put(&texts, &[])?;
    Ok(results)
}

fn all(
    request: &SweepRequest,
    options: &BatchOptions<'_>,
    folder: &Path,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<PointResult>, BatchError> {
    let count = request.cases.len();
    let workers = options.threads.min(count).max(1);
    // Points beside each other, and shots of a point where there are fewer points than threads.
    let inner = BatchOptions { threads: options.threads.div_ceil(workers), ..*options };
    let done = AtomicUsize::new(0);
    in_threads(workers, 0..count, |number, _| {
        let (case, of) = &request.cases[number];
        let result = point(case, of, &inner, &folder.join("points").join(format!("{number:04}")))?;
        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        Ok(result)
    })
}

fn point(case: &Case, of: &SweepOf, options: &BatchOptions<'_>, path: &Path) -> Result<PointResult, BatchError> {
    let resume = BatchPlan::is_in(path);
    match of {
        SweepOf::Shots(request) => {
            let folder = Folder::prepare_for(path, shots::FILES, &[])?;
            Ok(of_shots(&shots::run(case, request, options, &folder, resume, &mut |_| {})?))
        }
        SweepOf::V50(request) => {
            let folder = Folder::prepare_for(path, v50::FILES, &[])?;
            Ok(of_v50(&v50::run(case, request, options, &folder, resume, &mut |_| {})?))
        }
    }
}

fn of_shots(found: &shots::ShotsResult) -> PointResult {
    let decided: Vec<_> = found.rows.iter().filter(|row| row.perforated().is_some()).collect();
    let failed = found.rows.len() - decided.len();
    let mean = |of: &dyn Fn(&&ShotRow) -> Option<f64>| {
        let values: Vec<f64> = decided.iter().filter_map(of).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let reason = found.rows.iter().find(|row| row.perforated().is_none()).map(|row| row.reason.clone());
    PointResult {
        numbers: vec![
            mean(&|row| row.residual),
            mean(&|row| row.perforated().map(|passed| f64::from(u8::from(passed)))),
            mean(&|row| row.absorbed_energy()),
            Some(found.rows.len() as f64),
            Some(failed as f64),
        ],
        reason: reason.unwrap_or_default(),
    }
}

fn of_v50(found: &v50::V50Result) -> PointResult {
    let reason = found.thresholds.iter().find_map(|found| found.as_ref().err().cloned()).unwrap_or_default();
    let count = |n: usize| Some(n as f64);
    PointResult {
        numbers: vec![
            found.v50,
            found.bounds.low,
            found.bounds.high,
            found.sigma,
            count(found.shots),
            count(found.failed),
            count(found.non_monotone.len()),
        ],
        reason,
    }
}

/// `sweep.csv`: a row for each point. Columns of what is varied are its pointers.
pub fn table(request: &SweepRequest, results: &[PointResult]) -> String {
    let numbers = request.columns();
    let factors: Vec<String> = request.factors.iter().map(|factor| quoted(&factor.pointer)).collect();
    let heads = factors.iter().map(String::as_str).chain(numbers.iter().copied());
    let mut text = header(std::iter::once("point").chain(heads).chain(["reason"]));
    for (n, (values, result)) in request.points.iter().zip(results).enumerate() {
        let cells = values
            .iter()
            .map(|value| quoted(value))
            .chain(result.numbers.iter().map(|cell| cell.map(number).unwrap_or_default()));
        row(&mut text, std::iter::once(n.to_string()).chain(cells).chain([quoted(&result.reason)]));
    }
    text
}
