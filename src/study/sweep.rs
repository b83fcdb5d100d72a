//! `ripstop sweep`: shots or a V50 at every point of a grid over keys of a case.
//!
//! Each point is a batch in a folder of its own; one that has ended is read, not computed again.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::{fs, iter};

use serde_json::{Map, Value, json};

use super::StudyError;
use super::batch::{self, Batch, BatchError, BatchOptions, BatchProgress, in_threads, is_begun};
use super::on_device::DeviceRunner;
use super::page::lines_panel;
use super::report::{Report, ReportTable};
use super::shot_table::ShotRow;
use super::shots::{self, ShotsRequest, ShotsResult};
use super::v50::{self, V50Request};
use super::v50_result::V50Result;
use crate::case::Case;
use crate::output::csv::{header, number, quoted, row};
use crate::output::number::short;
use crate::output::{Folder, OutputError};
use crate::run::graphics::DeviceUse;

/// Every file that is written; batches lie in `points`.
pub const FILES: &[&str] = &["plan.json", "sweep.csv", "sweep.html", "sweep.json"];
/// Points of a sweep at most.
const MAX_POINTS: usize = 10_000;
/// Points whose shots go on a device together: their tables are open meanwhile.
const AHEAD: usize = 64;

/// Key that a sweep varies: `/pointer=1,2,4,8` or `/pointer=100..300:20` (from, to, step).
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// JSON pointer.
    pub pointer: String,
    /// Values, as the case file would have them.
    pub values: Vec<String>,
}

impl Factor {
    /// Factor in its text form.
    ///
    /// # Errors
    /// When it has another form, or a range is none.
    pub fn parse(text: &str) -> Result<Self, StudyError> {
        let wrong = |expected: &str, found: &str| {
            let help = "for example --over /pack/plies=1,2,4,8 or --over /projectile/velocity_m_s=100..300:20";
            StudyError::new(format!("--over {text}"), expected, format!("{found:?}"), help)
        };
        let Some((pointer, values)) = text.split_once('=').filter(|(pointer, _)| pointer.starts_with('/')) else {
            return Err(wrong("/json/pointer=values", text));
        };
        let pointer = pointer.to_owned();
        let Some((low, rest)) = values.split_once("..") else {
            let values: Vec<String> = split(values).into_iter().filter(|value| !value.is_empty()).collect();
            return if values.is_empty() { Err(wrong("values after =", "")) } else { Ok(Self { pointer, values }) };
        };
        let (high, step) = rest.split_once(':').map_or((rest, None), |(high, step)| (high, Some(step)));
        let parse = |text: &str| {
            let parsed = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
            parsed.ok_or_else(|| wrong("a number", text))
        };
        let [low, high] = [parse(low)?, parse(high)?];
        if high <= low {
            return Err(wrong("a range from a lower to a higher number", values));
        }
        let Some(step) = step else {
            let place = format!("--over {pointer}");
            let help = "write /pointer=A..B:STEP";
            return Err(StudyError::new(place, "values, or a range with a step", "a range without a step", help));
        };
        let step = parse(step)?;
        let count = ((high - low) / step + 1e-9).floor();
        if !(step > 0.0 && count < MAX_POINTS as f64) {
            return Err(wrong("a step above 0 that makes fewer than 10 000 values", values));
        }
        // Rounding of a sum of steps has no place in a case.
        let at = |n: usize| format!("{:.12e}", low + step * n as f64).parse().map(number).unwrap_or_default();
        Ok(Self { pointer, values: (0..=count as usize).map(at).collect() })
    }

    /// Last part of the pointer.
    pub fn name(&self) -> &str {
        self.pointer.rsplit('/').next().unwrap_or_default()
    }
}

/// Values apart at commas, but for those inside brackets and quotes.
fn split(text: &str) -> Vec<String> {
    let (mut depth, mut is_quoted) = (0_i32, false);
    let at_comma = |c: char| {
        match c {
            '"' => is_quoted = !is_quoted,
            '[' | '{' if !is_quoted => depth += 1,
            ']' | '}' if !is_quoted => depth -= 1,
            _ => {}
        }
        c == ',' && depth == 0 && !is_quoted
    };
    text.split(at_comma).map(|part| part.trim().to_owned()).collect()
}

/// All combinations of the values, the last factor fastest; each point has a value of every factor, as the case file would have it.
///
/// # Errors
/// When there are too many.
pub fn grid(factors: &[Factor]) -> Result<Vec<Vec<String>>, StudyError> {
    let mut points = vec![Vec::new()];
    for Factor { pointer, values } in factors {
        let count = points.len() * values.len();
        if count > MAX_POINTS {
            let expected = format!("at most {MAX_POINTS} points");
            return Err(StudyError::new(
                "--over",
                expected,
                format!("{count} of them at {pointer}"),
                "take longer steps",
            ));
        }
        let with = |point: Vec<String>| values.iter().map(move |value| [point.clone(), vec![value.clone()]].concat());
        points = points.into_iter().flat_map(with).collect();
    }
    Ok(points)
}

/// Computation at each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepOf {
    /// Shots.
    Shots(ShotsRequest),
    /// V50.
    V50(V50Request),
}

impl SweepOf {
    /// Columns of the table; the first is the response.
    pub fn columns(&self) -> &'static [&'static str] {
        match self {
            Self::Shots(_) => &["residual_velocity_m_s", "perforated_part", "absorbed_energy_j", "shots", "failed"],
            Self::V50(_) => &["v50_m_s", "low_m_s", "high_m_s", "sigma_m_s", "shots", "failed", "non_monotone"],
        }
    }
}

/// Request of a sweep.
#[derive(Clone, Debug)]
pub struct SweepRequest {
    /// Keys that are varied.
    pub factors: Vec<Factor>,
    /// Confidence of the intervals.
    pub level: f64,
    /// Computation at each point.
    pub of: SweepOf,
    /// Values at each point, as the case file would have them, and the case there.
    pub points: Vec<(Vec<String>, Case)>,
}

/// Result of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointResult {
    /// Numbers by column; none where the point failed.
    pub numbers: Vec<Option<f64>>,
    /// Reason why there is no result, else empty.
    pub reason: String,
}

/// Result of a sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepResult {
    /// Results by point.
    pub points: Vec<PointResult>,
    /// Use of the device.
    pub device: DeviceUse,
}

/// Runs the points that have not ended yet and writes the table and the page. `title`: of the nominal case.
///
/// # Errors
/// See [`BatchError`]; what has ended stays.
pub fn run(
    request: &SweepRequest,
    options: &BatchOptions<'_>,
    folder: &Folder,
    title: &str,
) -> Result<SweepResult, BatchError> {
    let Some((_, first)) = request.points.first() else { return Ok(SweepResult::default()) };
    let factors: Vec<&str> = request.factors.iter().map(|factor| factor.pointer.as_str()).collect();
    let values: Vec<&Vec<String>> = request.points.iter().map(|(values, _)| values).collect();
    let parts = json!({ "over": factors, "points": values, "of": format!("{:?}", request.of) });
    let points = folder.path().join("points");
    if !options.resume && points.exists() {
        fs::remove_dir_all(&points).map_err(|error| OutputError::unwritten(&points, &error))?;
    }
    batch::begin("sweep", first, options, parts, (folder, FILES))?;
    let result = compute(request, options, &points)?;
    let page = result.report(request, title).html(&format!("Sweep: {title}"), "sweep.json");
    let texts = [
        ("sweep.json", format!("{:#}\n", result.json(request))),
        ("sweep.html", page),
        ("sweep.csv", result.table(request)),
    ];
    folder.put(&texts, &[])?;
    Ok(result)
}

/// Results of every point; `folder`: of their batches.
fn compute(request: &SweepRequest, options: &BatchOptions<'_>, folder: &Path) -> Result<SweepResult, BatchError> {
    let count = request.points.len();
    let place = |number: usize| folder.join(format!("{number:04}"));
    let mut runner = DeviceRunner::new(options);
    let at_a_time = if runner.is_some() { AHEAD } else { count };
    // On a device one point after another. Else points beside each other, and shots of a point where there are fewer points than threads.
    let workers = if runner.is_some() { 1 } else { options.threads.min(count).max(1) };
    let inner = BatchOptions { threads: options.threads.div_ceil(workers), progress: &|_| {}, ..*options };
    let (ended, shown) = (AtomicU32::new(0), AtomicU32::new(0));
    let progress = |done: usize| {
        let done = shown.fetch_max(done as u32, Ordering::Relaxed).max(done as u32);
        (options.progress)(BatchProgress { done, of: count as u32, v50: None });
    };
    let mut results = Vec::with_capacity(count);
    for first in (0..count).step_by(at_a_time) {
        let numbers = first..(first + at_a_time).min(count);
        if let (Some(runner), SweepOf::Shots(of)) = (&mut runner, &request.of) {
            fire_ahead(request, of, numbers.clone(), &inner, runner, &place, &progress)?;
        }
        results.extend(in_threads(workers, numbers, |number, _| {
            let result = point(&request.points[number].1, &request.of, &inner, &place(number))?;
            progress(ended.fetch_add(1, Ordering::Relaxed) as usize + 1);
            Ok::<_, BatchError>(result)
        })?);
    }
    let ahead = runner.map(|runner| runner.device_use()).unwrap_or_default();
    let (points, used): (Vec<_>, Vec<_>) = results.into_iter().unzip();
    Ok(SweepResult { points, device: used.into_iter().fold(ahead, DeviceUse::with) })
}

/// Fires the shots of points on a device, in one batch where they go together: their rows are there once their points are computed.
fn fire_ahead(
    request: &SweepRequest,
    of: &ShotsRequest,
    numbers: std::ops::Range<usize>,
    options: &BatchOptions<'_>,
    runner: &mut DeviceRunner<'_>,
    place: &dyn Fn(usize) -> PathBuf,
    progress: &dyn Fn(usize),
) -> Result<(), BatchError> {
    // Where shots end early, each batch of them depends on those before.
    if of.until_width.is_some() {
        return Ok(());
    }
    let (first, count) = (numbers.start, numbers.len());
    let mut batches: Vec<(Batch<'_>, Folder)> = Vec::new();
    for number in numbers {
        let path = place(number);
        let folder = Folder::prepare_for(&path, shots::FILES, &[])?;
        let options = BatchOptions { resume: is_begun(&path), ..*options };
        batches.push((shots::begin(&request.points[number].1, of, &options, &folder)?, folder));
    }
    let missing = |batch: &Batch<'_>| shots::missing(&batch.table(), of, options.seed, of.count);
    let wanted: Vec<(usize, _)> =
        (0..count).flat_map(|at| missing(&batches[at].0).into_iter().map(move |order| (at, order))).collect();
    let mut fired = 0;
    runner.fire(wanted.iter().map(|(at, order)| (&batches[*at].0.case, *order)), &mut |shot, row| {
        fired += 1;
        progress(first + count * fired / wanted.len());
        batches[wanted[shot].0].0.table().add(row)
    })
}

/// Result of a point, and its use of the device.
fn point(
    case: &Case,
    of: &SweepOf,
    options: &BatchOptions<'_>,
    path: &Path,
) -> Result<(PointResult, DeviceUse), BatchError> {
    let options = &BatchOptions { resume: is_begun(path), ..*options };
    match of {
        SweepOf::Shots(request) => {
            let folder = Folder::prepare_for(path, shots::FILES, &[])?;
            let found = shots::run(case, request, options, &folder)?;
            Ok((PointResult::of_shots(&found), found.device))
        }
        SweepOf::V50(request) => {
            let folder = Folder::prepare_for(path, v50::FILES, &[])?;
            let found = v50::run(case, request, options, &folder)?;
            Ok((PointResult::of_v50(&found), found.device))
        }
    }
}

impl PointResult {
    fn of_shots(found: &ShotsResult) -> Self {
        let decided: Vec<_> = found.rows.iter().filter(|row| row.perforated().is_some()).collect();
        let mean = |of: &dyn Fn(&&ShotRow) -> Option<f64>| {
            let values: Vec<f64> = decided.iter().filter_map(of).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let undecided = found.rows.iter().find(|row| row.perforated().is_none());
        Self {
            numbers: vec![
                mean(&|row| row.residual),
                mean(&|row| row.perforated().map(|passed| f64::from(u8::from(passed)))),
                mean(&|row| row.absorbed_energy()),
                Some(found.rows.len() as f64),
                Some((found.rows.len() - decided.len()) as f64),
            ],
            reason: undecided.map(|row| row.reason.clone()).unwrap_or_default(),
        }
    }

    fn of_v50(found: &V50Result) -> Self {
        let counts = [found.shots, found.failed, found.non_monotone.len()].map(|count| Some(count as f64));
        let numbers = [found.v50, found.bounds.low, found.bounds.high, found.sigma];
        let reason = found.thresholds.iter().find_map(|found| found.as_ref().err().cloned());
        Self { numbers: numbers.into_iter().chain(counts).collect(), reason: reason.unwrap_or_default() }
    }
}

/// Point of a sweep as the drawing takes it.
pub(super) struct SweepPoint<'a> {
    /// Value of the first factor; a word by its number.
    pub(super) x: f64,
    /// Values of the others.
    pub(super) others: &'a [String],
    /// Response, and the ends of its interval, where it has one.
    pub(super) response: f64,
    pub(super) bounds: Option<[f64; 2]>,
}

impl SweepResult {
    /// `sweep.csv`: a row for each point; columns of factors are their pointers.
    pub fn table(&self, request: &SweepRequest) -> String {
        let factors: Vec<String> = request.factors.iter().map(|factor| quoted(&factor.pointer)).collect();
        let heads = factors.iter().map(String::as_str).chain(request.of.columns().iter().copied());
        let mut text = header(iter::once("point").chain(heads).chain(["reason"]));
        for (n, ((values, _), result)) in request.points.iter().zip(&self.points).enumerate() {
            let numbers = result.numbers.iter().map(|cell| cell.map(number).unwrap_or_default());
            let cells = values.iter().map(|value| quoted(value)).chain(numbers);
            row(&mut text, iter::once(n.to_string()).chain(cells).chain([quoted(&result.reason)]));
        }
        text
    }

    /// `sweep.json`.
    pub fn json(&self, request: &SweepRequest) -> Value {
        let columns = request.of.columns();
        let point = |((values, _), result): (&(Vec<String>, Case), &PointResult)| {
            let value = |text: &String| serde_json::from_str(text).unwrap_or_else(|_| text.as_str().into());
            let factors =
                request.factors.iter().zip(values).map(|(factor, text)| (factor.pointer.clone(), value(text)));
            let numbers = columns.iter().zip(&result.numbers).map(|(name, number)| ((*name).to_owned(), json!(number)));
            let reason = ("reason".to_owned(), json!(result.reason));
            factors.chain(numbers).chain([reason]).collect::<Map<_, _>>()
        };
        let points: Vec<Map<_, _>> = request.points.iter().zip(&self.points).map(point).collect();
        json!({ "response": columns[0], "level": request.level, "points": points })
    }

    /// Result in a table and drawings. `title`: of the nominal case.
    pub fn report(&self, request: &SweepRequest, title: &str) -> Report {
        let names: Vec<&str> = request.factors.iter().map(Factor::name).collect();
        let heads: Vec<&str> = names.iter().chain(request.of.columns()).copied().chain([""]).collect();
        let cell = |number: &Option<f64>| number.map_or_else(|| "-".to_owned(), |number| short(number, 4));
        let row = |((values, _), result): (&(Vec<String>, Case), &PointResult)| {
            let numbers = result.numbers.iter().map(cell);
            values.iter().cloned().chain(numbers).chain([result.reason.clone()]).collect()
        };
        let table = ReportTable::new("", &heads, 0, request.points.iter().zip(&self.points).map(row));
        let of = request.of.columns();
        let at = |result: &PointResult, name: &str| {
            of.iter().position(|column| *column == name).and_then(|at| result.numbers[at])
        };
        let mut points = Vec::new();
        for ((values, _), result) in request.points.iter().zip(&self.points) {
            let (Some((value, others)), Some(response)) = (values.split_first(), result.numbers[0]) else { continue };
            let place = || request.factors[0].values.iter().position(|other| other == value).unwrap_or(0) as f64;
            let x = value.parse().unwrap_or_else(|_| place());
            let bounds = at(result, "low_m_s").zip(at(result, "high_m_s")).map(|(low, high)| [low, high]);
            points.push(SweepPoint { x, others, response, bounds });
        }
        let panels = lines_panel(&names, &points, of[0]).into_iter().collect();
        Report { title: title.to_owned(), tables: vec![table], panels, ..Report::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Option<Vec<String>> {
        Factor::parse(text).ok().map(|factor| factor.values)
    }

    #[test]
    fn lists_ranges_and_json_are_read() {
        assert_eq!(list("/pack/plies=1, 2,8"), Some(["1", "2", "8"].map(str::to_owned).to_vec()));
        assert_eq!(list("/a=0.1..0.3:0.1"), Some(["0.1", "0.2", "0.3"].map(str::to_owned).to_vec()));
        assert_eq!(list("/a=100..290:50").map(|values| values.len()), Some(4));
        assert_eq!(list("/a=[0,1],[2,3]"), Some(["[0,1]", "[2,3]"].map(str::to_owned).to_vec()));
        for wrong in ["a=1", "/a", "/a=", "/a=3..1:1", "/a=1..3:0", "/a=1..x", "/a=1..3"] {
            assert!(Factor::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_grid_holds_every_combination_the_last_factor_fastest() {
        let factors = |texts: &[&str]| texts.iter().filter_map(|text| Factor::parse(text).ok()).collect::<Vec<_>>();
        let points = grid(&factors(&["/a=1,2", "/b=x,y,z"])).unwrap_or_default();
        assert_eq!(points.iter().map(|point| point.join("")).collect::<Vec<_>>(), ["1x", "1y", "1z", "2x", "2y", "2z"]);
        let error = grid(&factors(&["/a=1..5000:1", "/b=1,2,3"])).map_err(|error| error.to_string());
        assert!(
            error.is_err_and(|error| error.contains("at most 10000 points") && error.contains("15000 of them at /b"))
        );
    }
}
