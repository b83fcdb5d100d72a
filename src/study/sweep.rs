//! `ripstop sweep`: shots or a V50 at every point of a grid over keys of a case.
//!
//! Each point is a batch in a folder of its own; one that has ended is read, not computed again.

use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::{fs, iter};

use serde_json::{Map, Value, json};

use super::StudyError;
use super::batch::{self, Batch, BatchError, BatchOptions, BatchProgress, ShotOrder, in_threads, is_begun};
use super::on_device::DeviceRunner;
use super::report::{Report, ReportTable, lines_panel};
use super::shot_table::ShotRow;
use super::shots::{self, ShotsRequest};
use super::v50::{self, V50Request};
use super::v50_result::V50Result;
use crate::case::Case;
use crate::output::csv::{self, number};
use crate::output::number::short;
use crate::output::{Folder, OutputError};
use crate::run::batch::DeviceUse;

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
    fn columns(&self) -> &'static [&'static str] {
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

impl SweepRequest {
    /// Columns of the table: pointers of the factors, numbers, and a reason.
    fn columns(&self) -> impl Iterator<Item = &str> {
        let pointers = self.factors.iter().map(|factor| factor.pointer.as_str());
        pointers.chain(self.of.columns().iter().copied()).chain(["reason"])
    }
}

/// Result of a sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepResult {
    /// Cells by point: values of the factors, numbers by column, and the reason why there is none, else empty.
    pub points: Vec<Vec<Value>>,
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
    let result = Sweep { request, options, folder: &points, shown: AtomicU32::new(0) }.run()?;
    let page = result.report(request, title).html(&format!("Sweep: {title}"), "sweep.json");
    let texts = [
        ("sweep.json", format!("{:#}\n", result.json(request))),
        ("sweep.html", page),
        ("sweep.csv", result.table(request)),
    ];
    folder.put(&texts, &[])?;
    Ok(result)
}

/// Sweep under way.
struct Sweep<'a> {
    request: &'a SweepRequest,
    options: &'a BatchOptions<'a>,
    /// Folder of the batches.
    folder: &'a Path,
    /// Points shown as done.
    shown: AtomicU32,
}

impl<'a> Sweep<'a> {
    fn run(&self) -> Result<SweepResult, BatchError> {
        let count = self.request.points.len();
        let mut runner = DeviceRunner::new(self.options);
        let at_a_time = if runner.is_some() { AHEAD } else { count };
        // On a device one point after another. Else points beside each other, and shots of a point where there are fewer points than threads.
        let workers = if runner.is_some() { 1 } else { self.options.threads.min(count).max(1) };
        let threads = self.options.threads.div_ceil(workers);
        let ended = AtomicU32::new(0);
        let mut results = Vec::with_capacity(count);
        for first in (0..count).step_by(at_a_time) {
            let numbers = first..(first + at_a_time).min(count);
            if let (Some(runner), SweepOf::Shots(of)) = (&mut runner, &self.request.of) {
                self.fire_ahead(of, numbers.clone(), runner)?;
            }
            results.extend(in_threads(workers, numbers, |number, _| {
                let result = self.point(number, threads)?;
                self.show(ended.fetch_add(1, Ordering::Relaxed) + 1);
                Ok::<_, BatchError>(result)
            })?);
        }
        let ahead = runner.map(|runner| runner.device_use()).unwrap_or_default();
        let (points, used): (Vec<_>, Vec<_>) = results.into_iter().unzip();
        Ok(SweepResult { points, device: used.into_iter().fold(ahead, DeviceUse::with) })
    }

    fn show(&self, done: u32) {
        let done = self.shown.fetch_max(done, Ordering::Relaxed).max(done);
        (self.options.progress)(BatchProgress { done, of: self.request.points.len() as u32, v50: None });
    }

    /// Case, folder and options of a point.
    fn batch(&self, number: usize, files: &[&str]) -> Result<(&'a Case, Folder, BatchOptions<'a>), BatchError> {
        let path = self.folder.join(format!("{number:04}"));
        let folder = Folder::prepare_for(&path, files, &[])?;
        let options = BatchOptions { resume: is_begun(&path), progress: &|_| {}, ..*self.options };
        Ok((&self.request.points[number].1, folder, options))
    }

    /// Fires the shots of points on a device, in one batch where they go together: their rows are there once their points are computed.
    fn fire_ahead(
        &self,
        of: &ShotsRequest,
        numbers: Range<usize>,
        runner: &mut DeviceRunner<'_>,
    ) -> Result<(), BatchError> {
        // Where shots end early, each batch of them depends on those before.
        if of.until_width.is_some() {
            return Ok(());
        }
        let (first, count) = (numbers.start, numbers.len());
        let open = |number| {
            let (case, folder, options) = self.batch(number, shots::FILES)?;
            Ok((shots::begin(case, of, &options, &folder)?, folder))
        };
        let batches: Vec<(Batch<'_>, Folder)> = numbers.map(open).collect::<Result<_, BatchError>>()?;
        let missing = |at: usize| shots::missing(&batches[at].0.table(), of, self.options.seed, of.count);
        let wanted = (0..count).flat_map(|at| missing(at).into_iter().map(move |order| (at, order)));
        let wanted: Vec<(usize, ShotOrder)> = wanted.collect();
        let mut fired = 0;
        runner.fire(wanted.iter().map(|(at, order)| (&batches[*at].0.case, *order)), &mut |shot, row| {
            fired += 1;
            self.show((first + count * fired / wanted.len()) as u32);
            batches[wanted[shot].0].0.table().add(row)
        })
    }

    /// Cells of a point, and its use of the device.
    fn point(&self, number: usize, threads: usize) -> Result<(Vec<Value>, DeviceUse), BatchError> {
        let (cells, device) = match &self.request.of {
            SweepOf::Shots(request) => {
                let (case, folder, options) = self.batch(number, shots::FILES)?;
                let found = shots::run(case, request, &BatchOptions { threads, ..options }, &folder)?;
                (shots_cells(&found.rows), found.device)
            }
            SweepOf::V50(request) => {
                let (case, folder, options) = self.batch(number, v50::FILES)?;
                let found = v50::run(case, request, &BatchOptions { threads, ..options }, &folder)?;
                (v50_cells(&found), found.device)
            }
        };
        let value = |text: &String| serde_json::from_str(text).unwrap_or_else(|_| text.as_str().into());
        Ok((self.request.points[number].0.iter().map(value).chain(cells).collect(), device))
    }
}

/// Means over the shots with an outcome, the numbers of shots, and a reason.
fn shots_cells(rows: &[ShotRow]) -> Vec<Value> {
    let decided: Vec<&ShotRow> = rows.iter().filter(|row| row.perforated().is_some()).collect();
    let mean = |of: &dyn Fn(&&ShotRow) -> Option<f64>| {
        let values: Vec<f64> = decided.iter().filter_map(of).collect();
        json!((!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64))
    };
    let reason = rows.iter().find(|row| row.perforated().is_none()).map(|row| row.reason.as_str());
    vec![
        mean(&|row| row.residual),
        mean(&|row| row.perforated().map(|passed| f64::from(u8::from(passed)))),
        mean(&|row| row.absorbed_energy()),
        json!(rows.len()),
        json!(rows.len() - decided.len()),
        json!(reason.unwrap_or_default()),
    ]
}

fn v50_cells(found: &V50Result) -> Vec<Value> {
    let numbers = [found.v50, found.bounds.low, found.bounds.high, found.sigma].map(Value::from);
    let counts = [found.shots, found.failed, found.non_monotone.len()].map(Value::from);
    let reason = found.thresholds.iter().find_map(|found| found.as_ref().err());
    numbers.into_iter().chain(counts).chain([reason.map_or("", String::as_str).into()]).collect()
}

/// Text of a cell: a number in the given form, nothing of none.
fn text(cell: &Value, number: impl Fn(f64) -> String, none: &str) -> String {
    match cell {
        Value::Null => none.to_owned(),
        Value::String(text) => text.clone(),
        cell => cell.as_f64().map_or_else(|| cell.to_string(), number),
    }
}

impl SweepResult {
    /// `sweep.csv`: a row for each point; columns of factors are their pointers.
    pub fn table(&self, request: &SweepRequest) -> String {
        let row = |(n, cells): (usize, &Vec<Value>)| {
            iter::once(n.to_string()).chain(cells.iter().map(|cell| text(cell, number, ""))).collect()
        };
        csv::table(iter::once("point").chain(request.columns()), self.points.iter().enumerate().map(row))
    }

    /// `sweep.json`.
    pub fn json(&self, request: &SweepRequest) -> Value {
        let point = |cells: &Vec<Value>| {
            request.columns().map(str::to_owned).zip(cells.iter().cloned()).collect::<Map<String, Value>>()
        };
        let points: Vec<Map<String, Value>> = self.points.iter().map(point).collect();
        json!({ "response": request.of.columns()[0], "level": request.level, "points": points })
    }

    /// Result in a table and a drawing. `title`: of the nominal case.
    pub fn report(&self, request: &SweepRequest, title: &str) -> Report {
        let keys = request.factors.len();
        let names: Vec<&str> = request.columns().map(|name| name.rsplit('/').next().unwrap_or_default()).collect();
        let mut heads = names.clone();
        heads[names.len() - 1] = "";
        let row = |cells: &Vec<Value>| {
            let digits = |column: usize| move |value| if column < keys { number(value) } else { short(value, 4) };
            cells.iter().enumerate().map(|(column, cell)| text(cell, digits(column), "-")).collect()
        };
        let table = ReportTable::new("", &heads, 0, self.points.iter().map(row));
        let point = |cells: &Vec<Value>| {
            let at = |name: &str| names.iter().position(|column| *column == name).and_then(|at| cells[at].as_f64());
            let value = text(&cells[0], number, "");
            let place = || request.factors[0].values.iter().position(|other| *other == value).unwrap_or(0) as f64;
            let others: Vec<String> = cells[1..keys].iter().map(|cell| text(cell, number, "")).collect();
            Some(SweepPoint {
                x: cells[0].as_f64().unwrap_or_else(place),
                others: others.join(", "),
                response: cells[keys].as_f64()?,
                bounds: at("low_m_s").zip(at("high_m_s")).map(|(low, high)| [low, high]),
            })
        };
        let points: Vec<SweepPoint> = self.points.iter().filter_map(point).collect();
        let panels = lines_panel(&names[..keys], &points, names[keys]).into_iter().collect();
        Report { title: title.to_owned(), tables: vec![table], panels, ..Report::default() }
    }
}

/// Point of a sweep as the drawing takes it.
pub(super) struct SweepPoint {
    /// Value of the first factor; a word by its number.
    pub(super) x: f64,
    /// Values of the others.
    pub(super) others: String,
    /// Response, and the ends of its interval, where it has one.
    pub(super) response: f64,
    pub(super) bounds: Option<[f64; 2]>,
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
