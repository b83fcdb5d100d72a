//! The points of a sweep, each a batch in a folder of its own: what has ended there is read, not computed again.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::factor::Factor;
use super::{html, json};
use crate::case::Case;
use crate::output::Folder;
use crate::output::csv::{header, number, quoted, row};
use crate::run::batch::DeviceUse;
use crate::study::batch::{BatchError, BatchOptions, BatchPlan, DeviceRunner, ShotRow};
use crate::study::shots::{self, ShotsRequest};
use crate::study::threads::in_threads;
use crate::study::v50::{self, V50Request};

/// Points whose shots go on a device together: their tables are open meanwhile.
const AHEAD: usize = 64;

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
    /// What was taken of a device.
    pub device: DeviceUse,
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
        "over": factors, "points": request.points, "of": format!("{of:?}"),
    });
    let plan = BatchPlan::new("sweep", first, options, parts);
    let points = folder.path().join("points");
    if !resume && points.exists() {
        std::fs::remove_dir_all(&points).map_err(|error| crate::output::OutputError::unwritten(&points, &error))?;
    }
    plan.begin(folder, super::FILES, resume)?;
    let (points, device) = all(request, options, &folder.path().join("points"), progress)?;
    let results = SweepResult { points, device };
    let table = table(request, &results.points);
    let texts = [
        ("sweep.json", format!("{:#}\n", json(request, &results))),
        ("sweep.html", html(request, &results, title)),
        ("sweep.csv", table),
    ];
    folder.put(&texts, &[])?;
    Ok(results)
}

/// Every point; `folder`: where theirs are.
fn all(
    request: &SweepRequest,
    options: &BatchOptions<'_>,
    folder: &Path,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<(Vec<PointResult>, DeviceUse), BatchError> {
    let count = request.cases.len();
    let place = |number: usize| folder.join(format!("{number:04}"));
    let mut runner = DeviceRunner::new(options);
    let at_a_time = if runner.is_some() { AHEAD } else { count };
    // On a device one point after another. Else points beside each other, and shots of a point where there are fewer points than threads.
    let workers = if runner.is_some() { 1 } else { options.threads.min(count).max(1) };
    let inner = BatchOptions { threads: options.threads.div_ceil(workers), ..*options };
    let (ended, told) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let tell = |points: usize| progress(told.fetch_max(points, Ordering::Relaxed).max(points));
    let mut results = Vec::with_capacity(count);
    for first in (0..count).step_by(at_a_time) {
        let numbers = first..(first + at_a_time).min(count);
        if let Some(runner) = &mut runner {
            fire_ahead(request, numbers.clone(), options, runner, &place, &tell)?;
        }
        results.extend(in_threads(workers, numbers, |number, _| {
            let (case, of) = &request.cases[number];
            point(case, of, &inner, &place(number)).inspect(|_| tell(ended.fetch_add(1, Ordering::Relaxed) + 1))
        })?);
    }
    let ahead = runner.map(|runner| runner.device_use()).unwrap_or_default();
    let (points, used): (Vec<_>, Vec<_>) = results.into_iter().unzip();
    Ok((points, used.into_iter().fold(ahead, DeviceUse::with)))
}

/// Fires the shots of points on a device, in one batch where they go together: their rows are there once their points are looked at.
fn fire_ahead(
    request: &SweepRequest,
    numbers: std::ops::Range<usize>,
    options: &BatchOptions<'_>,
    runner: &mut DeviceRunner<'_>,
    place: &dyn Fn(usize) -> PathBuf,
    tell: &dyn Fn(usize),
) -> Result<(), BatchError> {
    let (first, mut tables, mut wanted) = (numbers.start, Vec::new(), Vec::new());
    for number in numbers {
        let (case, SweepOf::Shots(of)) = &request.cases[number] else { continue };
        // Where shots end early, each batch of them hangs on those before.
        if of.until_width.is_some() {
            continue;
        }
        let (path, at) = (place(number), tables.len());
        let folder = Folder::prepare_for(&path, shots::FILES, &[])?;
        let log = shots::begin(case, of, options, &folder, BatchPlan::is_in(&path))?;
        wanted.extend(shots::missing(&log, of, options.seed, of.count).into_iter().map(|order| (at, case, order)));
        tables.push((log, folder));
    }
    let shots = wanted.iter().map(|(_, case, order)| (*case, *order));
    let (points, mut fired) = (tables.len(), 0);
    runner.fire(shots, &mut |shot, row| {
        fired += 1;
        tell(first + points * fired / wanted.len());
        tables[wanted[shot].0].0.add(row)
    })
}

/// What a point gave, and what it took of a device.
fn point(
    case: &Case,
    of: &SweepOf,
    options: &BatchOptions<'_>,
    path: &Path,
) -> Result<(PointResult, DeviceUse), BatchError> {
    let resume = BatchPlan::is_in(path);
    match of {
        SweepOf::Shots(request) => {
            let folder = Folder::prepare_for(path, shots::FILES, &[])?;
            let found = shots::run(case, request, options, &folder, resume, &mut |_| {})?;
            Ok((of_shots(&found), found.device))
        }
        SweepOf::V50(request) => {
            let folder = Folder::prepare_for(path, v50::FILES, &[])?;
            let found = v50::run(case, request, options, &folder, resume, &mut |_| {})?;
            Ok((of_v50(&found), found.device))
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
