//! `ripstop sweep`: shots or a V50 at every point of a grid over keys of a case.
//!
//! Each point is a batch in a folder of its own; one that has ended is read, not computed again.

use std::collections::BTreeMap;
use std::iter;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Map, Value, json};

use super::batch::{self, BatchError, BatchOptions, StudyProgress};
use super::report::{Report, ReportTable, ends, roomy};
use super::shots::{self, ShotRow, ShotsRequest};
use super::v50::{self, V50Request};
use crate::case::{Case, CaseError, in_words};
use crate::output::Folder;
use crate::output::csv::{self, number};
use crate::output::number::short;
use crate::output::plot::{Figure, Plot};

/// Every file that is written; batches lie in `points`.
pub const FILES: &[&str] = &["plan.json", "sweep.csv", "sweep.html", "sweep.json"];
/// Points of a sweep at most.
const MAX_POINTS: usize = 10_000;
/// Points whose shots are fired together: their tables are open meanwhile.
const TOGETHER: usize = 64;
/// Colours of lines.
const COLOURS: usize = 9;

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
    pub fn parse(text: &str) -> Result<Self, CaseError> {
        let values = |text: &str| match text.split_once("..") {
            Some((low, rest)) => steps(low, rest),
            None => Some(split(text)),
        };
        let parts = text.split_once('=').filter(|(pointer, _)| pointer.starts_with('/'));
        let parts = parts.and_then(|(pointer, text)| Some((pointer, values(text)?)));
        let found = parts.filter(|(_, values)| !values.is_empty());
        found.map(|(pointer, values)| Self { pointer: pointer.to_owned(), values }).ok_or_else(|| {
            let expected = format!("/json/pointer=values: a list, or a range A..B:STEP of at most {MAX_POINTS} values");
            let help = "for example --over /pack/plies=1,2,4,8 or --over /projectile/velocity_m_s=100..300:20";
            CaseError::new("--over", "", expected, text, help)
        })
    }
}

/// Values of a range, as the case file would have them; `None` where it is none.
fn steps(low: &str, rest: &str) -> Option<Vec<String>> {
    let (high, step) = rest.split_once(':')?;
    let parse = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let [low, high, step] = [parse(low)?, parse(high)?, parse(step)?];
    let count = ((high - low) / step + 1e-9).floor();
    // Rounding of a sum of steps has no place in a case.
    let at = |n: usize| format!("{:.12e}", low + step * n as f64).parse().map(number).unwrap_or_default();
    (step > 0.0 && count >= 1.0 && count < MAX_POINTS as f64).then(|| (0..=count as usize).map(at).collect())
}

/// Values apart at commas, as JSON where they all are that, else words.
fn split(text: &str) -> Vec<String> {
    match serde_json::from_str::<Vec<Value>>(&format!("[{text}]")) {
        Ok(values) => values.iter().map(Value::to_string).collect(),
        Err(_) => text.split(',').map(|word| word.trim().to_owned()).filter(|word| !word.is_empty()).collect(),
    }
}

/// All combinations of the values, the last factor fastest; each point has a value of every factor, as the case file would have it.
///
/// # Errors
/// When there are too many.
pub fn grid(factors: &[Factor]) -> Result<Vec<Vec<String>>, CaseError> {
    let mut points = vec![Vec::new()];
    for Factor { pointer, values } in factors {
        let count = points.len() * values.len();
        if count > MAX_POINTS {
            let expected = format!("at most {MAX_POINTS} points");
            return Err(CaseError::new("--over", pointer, expected, format!("{count} of them"), "take longer steps"));
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

/// Result of a sweep: cells by point. They are the values of the factors, numbers by column, and the reason why there is none, else empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SweepResult {
    /// Cells by point.
    pub points: Vec<Vec<Value>>,
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
    batch::begin("sweep", first, options, parts, (folder, FILES))?;
    let result = Sweep { request, options, folder: &folder.path().join("points") }.run()?;
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
}

impl<'a> Sweep<'a> {
    fn run(&self) -> Result<SweepResult, BatchError> {
        let numbers: Vec<usize> = (0..self.request.points.len()).collect();
        let mut points = Vec::with_capacity(numbers.len());
        for numbers in numbers.chunks(TOGETHER) {
            match &self.request.of {
                SweepOf::Shots(of) => self.shots(of, numbers, &mut points)?,
                SweepOf::V50(of) => self.limits(of, numbers, &mut points)?,
            }
        }
        Ok(SweepResult { points })
    }

    fn show(&self, done: usize) {
        let of = self.request.points.len() as u32;
        (self.options.progress)(StudyProgress { done: done as u32, of, ..StudyProgress::default() });
    }

    /// Case, folder and options of a point.
    fn batch(&self, number: usize, files: &[&str]) -> Result<(&'a Case, Folder, BatchOptions<'a>), BatchError> {
        let path = self.folder.join(format!("{number:04}"));
        let folder = Folder::prepare_for(&path, files, &[])?;
        let options = BatchOptions { resume: false, progress: &|_| {}, ..*self.options };
        Ok((&self.request.points[number].1, folder, options))
    }

    /// Fires the shots of points together, and adds the cells of each.
    fn shots(&self, of: &ShotsRequest, numbers: &[usize], points: &mut Vec<Vec<Value>>) -> Result<(), BatchError> {
        let mut begun = Vec::with_capacity(numbers.len());
        for number in numbers {
            let (case, folder, options) = self.batch(*number, shots::FILES)?;
            begun.push((shots::begin(case, of, &options, &folder)?, folder));
        }
        let mut wanted = Vec::new();
        for (batch, _) in &begun {
            let missing = shots::missing(&batch.table(), of, self.options.seed);
            wanted.extend(missing.into_iter().map(|order| (batch, order)));
        }
        let fired = AtomicUsize::new(0);
        batch::fire(&wanted, self.options.threads, &|_| {
            let fired = fired.fetch_add(1, Ordering::Relaxed) + 1;
            self.show(numbers[0] + numbers.len() * fired / wanted.len());
        })?;
        for (number, (batch, folder)) in numbers.iter().zip(begun) {
            points.push(self.point(*number, shots_cells(&shots::end(batch, of, &folder)?.rows)));
        }
        Ok(())
    }

    /// Finds the limit of each point, and adds the cells of each.
    fn limits(&self, of: &V50Request, numbers: &[usize], points: &mut Vec<Vec<Value>>) -> Result<(), BatchError> {
        for number in numbers {
            let (case, folder, options) = self.batch(*number, v50::FILES)?;
            let found = v50::run(case, of, &options, &folder)?;
            let result = found.json(case, of, options.seed);
            let cells = self.request.of.columns().iter().map(|column| result[*column].clone());
            let reason = json!(found.reason().map_or("", String::as_str));
            points.push(self.point(*number, cells.chain([reason])));
        }
        Ok(())
    }

    /// Values of the factors at a point that has ended, and the cells of its result.
    fn point(&self, number: usize, cells: impl IntoIterator<Item = Value>) -> Vec<Value> {
        self.show(number + 1);
        let value = |text: &String| serde_json::from_str(text).unwrap_or_else(|_| text.as_str().into());
        self.request.points[number].0.iter().map(value).chain(cells).collect()
    }
}

/// Means over the shots with an outcome, the numbers of shots, and a reason.
fn shots_cells(rows: &[ShotRow]) -> [Value; 6] {
    let decided: Vec<&ShotRow> = rows.iter().filter(|row| row.perforated().is_some()).collect();
    let mean = |of: &dyn Fn(&&ShotRow) -> Option<f64>| {
        let values: Vec<f64> = decided.iter().filter_map(of).collect();
        json!((!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64))
    };
    let reason = rows.iter().find(|row| row.perforated().is_none()).map(|row| row.reason.as_str());
    [
        mean(&|row| row.residual),
        mean(&|row| row.perforated().map(|passed| f64::from(u8::from(passed)))),
        mean(&|row| row.absorbed_energy()),
        json!(rows.len()),
        json!(rows.len() - decided.len()),
        json!(reason.unwrap_or_default()),
    ]
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
        let mut table = ReportTable::new("", &heads, 0).rows(self.points.iter().map(row), "");
        let page = if matches!(request.of, SweepOf::V50(_)) { "v50.html" } else { "shots.html" };
        table.links = (0..self.points.len()).map(|number| format!("points/{number:04}/{page}")).collect();
        let response = in_words(names[keys]);
        let effects: Vec<f64> = (0..keys).map(|factor| self.main_effect(keys, factor)).collect();
        let mut counts = vec![format!("points: {}", self.points.len())];
        let effect =
            |(name, effect): (&&str, &f64)| format!("{name}: {}, main effect on {response}", short(*effect, 3));
        counts.extend(names.iter().zip(&effects).map(effect));
        let panels = self.lines(request, &names).into_iter().chain(bars(&names, &effects, &response)).collect();
        Report { title: title.to_owned(), counts, tables: vec![table], panels, ..Report::default() }
    }

    /// Main effect of a factor of `keys`: largest less least mean response over its values.
    fn main_effect(&self, keys: usize, factor: usize) -> f64 {
        let mut levels: BTreeMap<String, (f64, f64)> = BTreeMap::new();
        for cells in &self.points {
            if let Some(response) = cells[keys].as_f64() {
                let (sum, count) = levels.entry(cells[factor].to_string()).or_default();
                (*sum, *count) = (*sum + response, *count + 1.0);
            }
        }
        let [low, high] = ends(levels.values().map(|(sum, count)| sum / count));
        if low.is_finite() { high - low } else { 0.0 }
    }

    /// Response over the first factor, a line for each combination of the others; nothing without a response.
    fn lines(&self, request: &SweepRequest, names: &[&str]) -> Option<Figure> {
        let keys = request.factors.len();
        // A word by its number.
        let place = |cell: &Value| {
            let at = || request.factors[0].values.iter().position(|other| *other == text(cell, number, ""));
            cell.as_f64().unwrap_or_else(|| at().unwrap_or(0) as f64)
        };
        let mut groups: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
        for cells in &self.points {
            let others: Vec<String> = cells[1..keys].iter().map(|cell| text(cell, number, "")).collect();
            let point = cells[keys].as_f64().map(|response| [place(&cells[0]), response]);
            groups.entry(others.join(", ")).or_default().extend(point);
        }
        let [x, y] = [0, 1].map(|axis| roomy(ends(groups.values().flatten().map(|point| point[axis])), 0.05, 1e-3));
        let [across, up] = [names[0], names[keys]].map(in_words);
        let mut plot = Plot::new(x, y, [&across, &up]);
        for (n, (group, points)) in groups.iter_mut().enumerate() {
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let class = format!("k{}", n % COLOURS);
            plot.line(&class, group, points);
            points.iter().for_each(|point| plot.dot(&class, *point, 3.5, &short(point[1], 4)));
        }
        let caption = if keys > 1 { format!("Lines: {}.", names[1..keys].join(", ")) } else { String::new() };
        let title =
            [names[keys], names[0]].map(|name| in_words(name).split(" [").next().unwrap_or_default().to_owned());
        let title = title.join(" over ");
        groups.values().any(|points| !points.is_empty()).then(|| Figure::new("lines", &title, caption, Some(plot)))
    }
}

/// Bars of the main effects; nothing of a single factor.
fn bars(names: &[&str], effects: &[f64], response: &str) -> Option<Figure> {
    let [_, longest] = ends(effects.iter().copied());
    let mut plot = Plot::new([0.0, 1.05 * longest], [0.0, effects.len() as f64], [response, "factor"]);
    for (n, (name, effect)) in names.iter().zip(effects).enumerate() {
        let at = effects.len() as f64 - n as f64 - 0.7;
        plot.bar(&format!("k{}", n % COLOURS), [*effect, at], &format!("{name}: {}", short(*effect, 3)));
    }
    let caption = "Largest less least mean of the response over the values of a factor.";
    (effects.len() > 1).then(|| Figure::new("effects", "Main effects", caption, Some(plot)))
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
        for wrong in ["a=1", "/a", "/a=", "/a=3..1:1", "/a=1..3:0", "/a=1..x", "/a=1..3", "/a=1..3:5"] {
            assert!(Factor::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_grid_holds_every_combination_the_last_factor_fastest() {
        let factors = |texts: &[&str]| texts.iter().filter_map(|text| Factor::parse(text).ok()).collect::<Vec<_>>();
        let points = grid(&factors(&["/a=1,2", "/b=x,y"])).unwrap_or_default();
        assert_eq!(points.iter().map(|point| point.join("")).collect::<String>(), "1x1y2x2y");
        let error = grid(&factors(&["/a=1..5000:1", "/b=1,2,3"])).map_err(|error| error.to_string());
        assert!(error.is_err_and(|error| error.contains("--over: /b") && error.contains("15000 of them")));
    }
}
