//! `ripstop shots`: realisations of a case at velocities spread over a range, and the table of any batch: what was drawn for each shot and
//! what became of it, appended row by row, sorted at the end.

use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File};
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use csv::StringRecord;
use serde_json::json;

use super::batch::{self, Batch, BatchError, BatchOptions, ShotOrder, StudyProgress, notes};
use super::fit::{Fit, FitRow, RangeData, fit};
use super::report::{Report, ReportTable, all_shots, drawn_panels};
use crate::case::{Case, CaseError, Drawn, RANGE_STREAM};
use crate::num::random::DrawKey;
use crate::output::checks::{Level, advice, checks};
use crate::output::csv::{number, quoted};
use crate::output::{Breakage, Folder, absorbed_energy, residual_velocity};
use crate::run::Run;
use crate::run::outcome::Outcome;

/// Name of the table.
const TABLE: &str = "shots.csv";
/// Every file that is written.
pub const FILES: &[&str] = &["plan.json", TABLE, "shots.html", "shots.json"];
/// Fraction by which the place in the range moves on from shot to shot: the golden ratio fills a range evenly, whatever the count.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Columns before those of what was drawn, and after them; last come trust and reason.
const FIRST: [&str; 3] = ["shot", "asked_velocity_m_s", "velocity_m_s"];
const OUTCOME: [&str; 4] = ["outcome", "perforated", "count", "residual_velocity_m_s"];
/// Column of a number of a run: its name, and how it is read.
type RunNumber = (&'static str, fn(&Case, &Run) -> f64);
/// Columns of numbers of a run between them.
const NUMBERS: [RunNumber; 10] = [
    ("impact_energy_j", |_, run| run.impact_energy),
    ("absorbed_energy_j", |_, run| absorbed_energy(run)),
    ("energy_gained", |_, run| run.energy_gained),
    ("energy_error", |_, run| run.energy_error),
    ("max_deflection_mm", |_, run| run.deflection() * 1e3),
    ("failed_warp", |_, run| failed(run)[0]),
    ("failed_weft", |_, run| failed(run)[1]),
    ("torn_off", |case, run| f64::from(u8::from(Breakage::of(case, run).is_torn_off()))),
    ("end_time_us", |case, _| case.solver.end_time * 1e6),
    ("steps", |_, run| run.steps as f64),
];
/// A shot that is undecided is fired again with an end so many times as late, up to so many times that of its case.
const LATER: [f64; 2] = [4.0, 64.0];

/// Request of shots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotsRequest {
    /// Number of shots.
    pub count: u32,
    /// Range of the velocities [m/s]; `None`: that of the case.
    pub velocity: Option<[f64; 2]>,
    /// Two-sided confidence of intervals.
    pub level: f64,
}

/// Result of a batch.
#[derive(Clone, Debug)]
pub struct ShotsResult {
    /// Rows by number.
    pub rows: Vec<ShotRow>,
    /// Limit fitted to them.
    pub fit: Fit,
}

/// Order of a shot.
pub fn order(request: &ShotsRequest, seed: u32, shot: u32) -> ShotOrder {
    let velocity = request.velocity.map(|[low, high]| {
        let key = DrawKey { seed: u64::from(seed), shot: 0, ply: DrawKey::WHOLE, yarn: RANGE_STREAM, element: 0 };
        let [start, ..] = key.uniform();
        low + (high - low) * (start + GOLDEN * f64::from(shot)).fract()
    });
    ShotOrder { shot, velocity }
}

/// Begins a batch, or goes on with the one that is there.
///
/// # Errors
/// When the disk refuses, another batch lies in the folder, or more shots than are asked for: some would be lost.
pub(super) fn begin<'a>(
    case: &Case,
    request: &ShotsRequest,
    options: &BatchOptions<'a>,
    folder: &Folder,
) -> Result<Batch<'a>, BatchError> {
    let last = rows_in(folder, TABLE).last_key_value().map_or(0, |((shot, _), _)| shot + 1);
    if last > request.count {
        let (expected, found) = (format!("--count {last} or more: shots so far"), format!("--count {}", request.count));
        let help = "or choose another folder with --out DIR";
        return Err(CaseError::of_path(&folder.path().join(TABLE), expected, found, help).into());
    }
    // A longer batch may go on where a shorter one ended: the count is no part of the plan.
    let parts = json!({ "velocity_m_s": request.velocity });
    batch::begin("shots", case, options, parts, (folder, FILES))?;
    Batch::open(case.clone(), options, folder, TABLE)
}

/// Orders of the shots that have no row yet.
pub(super) fn missing(table: &ShotTable, request: &ShotsRequest, seed: u32) -> Vec<ShotOrder> {
    (0..request.count).map(|shot| order(request, seed, shot)).filter(|order| table.find(*order).is_none()).collect()
}

/// Writes the table and the page of a batch whose shots are all there.
///
/// # Errors
/// When the disk refuses.
pub(super) fn end(batch: Batch<'_>, request: &ShotsRequest, folder: &Folder) -> Result<ShotsResult, BatchError> {
    let case = &batch.case;
    let table = batch.table().text(request.count);
    let rows: Vec<ShotRow> = batch.table().rows(request.count).cloned().collect();
    let data = RangeData { rows: rows.iter().filter_map(ShotRow::fit_row).collect(), ..RangeData::default() };
    let fit = fit(&data, request.level, None);
    let result = ShotsResult { rows, fit };
    let page = result.report(case).html(&format!("Shots: {}", case.title), "shots.csv");
    let json = format!("{:#}\n", result.fit.json());
    // The table last: what is beside it is of it.
    folder.put(&[("shots.json", json), ("shots.html", page), (TABLE, table)], &[])?;
    batch.table().close()?;
    Ok(result)
}

/// Fires the shots that are not there yet and writes the table and the page.
///
/// # Errors
/// See [`BatchError`]; rows so far stay.
pub fn run(
    case: &Case,
    request: &ShotsRequest,
    options: &BatchOptions<'_>,
    folder: &Folder,
) -> Result<ShotsResult, BatchError> {
    let batch = begin(case, request, options, folder)?;
    let missing = missing(&batch.table(), request, options.seed);
    let done = AtomicU32::new(request.count - missing.len() as u32);
    batch.fire(&missing, options.threads, &|table| {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (options.progress)(StudyProgress { done, of: request.count, shots: 0, ..table.progress() });
    })?;
    end(batch, request, folder)
}

impl ShotsResult {
    /// Result in words, tables and drawings.
    pub fn report(&self, case: &Case) -> Report {
        let mut report = Report { title: case.title.clone(), ..self.fit.report("shots") };
        let trusted = self.rows.iter().filter(|row| row.trust == "trust").count();
        report.counts.push(format!("trust: {trusted} of {} shots", self.rows.len()));
        let failed: Vec<&ShotRow> = self.rows.iter().filter(|row| row.perforated().is_none()).collect();
        let reason = failed.first().map(|row| format!("shot {}: {}", row.order.shot, row.reason));
        report.notes.extend(reason.map(|reason| format!("{} shots without an outcome; {reason}", failed.len())));
        report.notes.extend(notes(case));
        report.panels.extend(drawn_panels(&self.rows));
        let foot =
            "A number leads to the report of that shot, once this command with --only and the number has run it alone.";
        let links = self.rows.iter().map(|row| format!("shot-{}/report.html", row.order.shot)).collect();
        report.tables.push(ReportTable { links, ..all_shots(&self.rows, foot) });
        report
    }
}

/// One shot.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotRow {
    /// Order of the shot.
    pub order: ShotOrder,
    /// Impact velocity [m/s]; that asked for where the shot could not be set up.
    pub velocity: f64,
    /// Values that were drawn.
    pub drawn: Vec<Drawn>,
    /// Outcome; `None`: the shot failed.
    pub outcome: Option<Outcome>,
    /// Residual velocity [m/s].
    pub residual: Option<f64>,
    /// Numbers of the run; empty without one.
    numbers: Vec<f64>,
    /// Trust in the result, in a word.
    pub trust: String,
    /// Reason why there is no outcome, else empty.
    pub reason: String,
}

impl ShotRow {
    /// Row of a shot that ran.
    pub(super) fn of_run(order: ShotOrder, case: &Case, run: &Run) -> Self {
        let reason = match (&run.divergence, &run.lost, run.outcome) {
            (Some(found), ..) => format!(
                "unstable: {} in {} at step {}; lower /solver/courant",
                found.quantity, found.kernel, found.step
            ),
            (None, Some(lost), _) => one_line(lost),
            (None, None, Outcome::Running) => "undecided at the end of the run; raise /solver/end_time_us".to_owned(),
            _ => String::new(),
        };
        Self {
            outcome: (run.divergence.is_none() && run.lost.is_none()).then_some(run.outcome),
            residual: residual_velocity(case, run).filter(|_| reason.is_empty()),
            numbers: NUMBERS.iter().map(|(_, number)| number(case, run)).collect(),
            trust: advice(&checks(case, run)).0.advice().to_owned(),
            ..Self::of_failure(order, case, &reason)
        }
    }

    /// Row of a shot that did not run, and why.
    pub(super) fn of_failure(order: ShotOrder, case: &Case, reason: &str) -> Self {
        Self {
            order,
            velocity: case.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity),
            drawn: case.drawn.clone(),
            outcome: None,
            residual: None,
            numbers: Vec::new(),
            trust: Level::Bad.advice().to_owned(),
            reason: one_line(reason),
        }
    }

    /// Whether the projectile passed; `None` without a decision.
    pub fn perforated(&self) -> Option<bool> {
        match self.outcome? {
            Outcome::Perforated => Some(true),
            Outcome::Stopped | Outcome::Rebounded => Some(false),
            Outcome::Running => None,
        }
    }

    /// Whether the pack was perforated, or has torn off its frame whatever became of the projectile; `None` without a decision.
    pub(super) fn defeats(&self) -> Option<bool> {
        self.perforated().max((self.is_torn_off() && self.outcome.is_some()).then_some(true))
    }

    /// Whether the pack has torn off its frame before it broke at the hit.
    pub(super) fn is_torn_off(&self) -> bool {
        self.number("torn_off") == Some(1.0)
    }

    /// End of the run with which an undecided shot is fired again [s]; `None` where it is decided, or has run for long enough.
    pub(super) fn later_end(&self, case: &Case) -> Option<f64> {
        let is_open = self.outcome == Some(Outcome::Running) && self.defeats().is_none();
        let end = LATER[0] * 1e-6 * self.number("end_time_us").filter(|_| is_open)?;
        (end <= 1.001 * LATER[1] * case.solver.end_time).then_some(end)
    }

    /// Kinetic energy that the projectile has lost [J].
    pub fn absorbed_energy(&self) -> Option<f64> {
        self.number("absorbed_energy_j")
    }

    /// Number of the run by its column.
    fn number(&self, column: &str) -> Option<f64> {
        self.numbers.get(NUMBERS.iter().position(|(name, _)| *name == column)?).copied()
    }

    /// Row as `ripstop fit` reads it.
    pub(super) fn fit_row(&self) -> Option<FitRow> {
        let perforated = self.perforated()?;
        let passed = |residual: &f64| perforated && (0.0..=self.velocity).contains(residual);
        Some(FitRow { velocity: self.velocity, perforated, count: 1, residual: self.residual.filter(passed) })
    }

    /// Line of the table with these drawn columns.
    fn line(&self, drawn: &[String]) -> String {
        let value = |name: &String| self.drawn.iter().find(|drawn| drawn.column == *name).map(|drawn| drawn.value);
        let text = |value: Option<f64>| value.map(number).unwrap_or_default();
        let passed = self.perforated() == Some(true);
        let mut cells = vec![self.order.shot.to_string(), text(self.order.velocity), number(self.velocity)];
        cells.extend(drawn.iter().map(|name| text(value(name))));
        cells.push(self.outcome.map_or("failed", Outcome::word).to_owned());
        cells.extend([passed, self.perforated().is_some()].map(|is| u8::from(is).to_string()));
        // A shot that was stopped has no residual velocity in a table that `ripstop fit` reads.
        cells.push(text(self.residual.filter(|_| passed)));
        cells.extend((0..NUMBERS.len()).map(|n| text(self.numbers.get(n).copied())));
        cells.extend([self.trust.clone(), quoted(&self.reason)]);
        cells.join(",") + "\n"
    }

    /// Row of a record of the table; `None` where it is none.
    fn parse(header: &StringRecord, record: &StringRecord) -> Option<Self> {
        let cells: HashMap<&str, &str> = header.iter().zip(record).collect();
        let value = |name: &str| cells.get(name).and_then(|cell| cell.parse::<f64>().ok());
        let text = |name: &str| cells.get(name).map(|cell| (*cell).to_owned());
        let drawn = header.iter().take_while(|name| *name != OUTCOME[0]).skip(FIRST.len());
        let drawn = drawn.filter_map(|name| Some(Drawn { column: name.to_owned(), value: value(name)? })).collect();
        let outcomes = [Outcome::Perforated, Outcome::Stopped, Outcome::Rebounded, Outcome::Running];
        let mut row = Self {
            order: ShotOrder { shot: cells.get("shot")?.parse().ok()?, velocity: value("asked_velocity_m_s") },
            velocity: value("velocity_m_s")?,
            drawn,
            outcome: outcomes.into_iter().find(|outcome| Some(&outcome.word()) == cells.get("outcome")),
            residual: value("residual_velocity_m_s"),
            numbers: NUMBERS.iter().map_while(|(name, _)| value(name)).collect(),
            trust: text("trust")?,
            reason: text("reason")?,
        };
        if row.perforated() == Some(false) {
            row.residual = Some(0.0);
        }
        Some(row)
    }
}

/// Warp and weft yarns that had failed at the end of a run.
fn failed(run: &Run) -> [f64; 2] {
    run.history.last().map_or([0.0; 2], |last| last.failed.map(|count| count as f64))
}

/// Text on one line.
fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Number of the shot and bits of its velocity, by which rows are sorted and found again.
type ShotKey = (u32, u64);

fn key(order: ShotOrder) -> ShotKey {
    // Velocities are above zero: their bits are in their order.
    (order.shot, order.velocity.unwrap_or(0.0).to_bits())
}

/// Rows of a batch, and the file that they are appended to.
#[derive(Debug)]
pub struct ShotTable {
    drawn: Vec<String>,
    path: PathBuf,
    file: File,
    rows: BTreeMap<ShotKey, ShotRow>,
}

impl ShotTable {
    /// Table that begins, or goes on with the rows that are there; `drawn`: its columns of what is drawn.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn open(folder: &Folder, name: &str, drawn: Vec<String>) -> Result<Self, BatchError> {
        let partial = batch::partial(name);
        let (path, rows) = (folder.path().join(&partial), rows_in(folder, name));
        // Replaced as a whole: a kill here loses no row.
        folder.put(&[(&*partial, text(&drawn, rows.values()))], &[])?;
        let file = File::options().append(true).open(&path);
        let file = file.map_err(|error| CaseError::unwritten(&path, &error))?;
        Ok(Self { drawn, file, rows, path })
    }

    /// Adds a row; it is on the disk when this returns.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn add(&mut self, row: ShotRow) -> Result<(), BatchError> {
        let line = row.line(&self.drawn);
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        written.map_err(|error| CaseError::unwritten(&self.path, &error))?;
        self.rows.insert(key(row.order), row);
        Ok(())
    }

    /// Row of a shot, if it was fired.
    pub fn find(&self, order: ShotOrder) -> Option<&ShotRow> {
        self.rows.get(&key(order))
    }

    /// Rows of the shots below `count`, by shot and velocity.
    pub fn rows(&self, count: u32) -> impl Iterator<Item = &ShotRow> {
        self.rows.range(..(count, 0)).map(|(_, row)| row)
    }

    /// Shots so far, and the limit between them.
    pub(super) fn progress(&self) -> StudyProgress {
        let shots = |passed: bool| self.rows.values().filter(move |row| row.defeats() == Some(passed));
        let stop = shots(false).map(|row| row.velocity).reduce(f64::max);
        let perforation = shots(true).map(|row| row.velocity).reduce(f64::min);
        // Results may be mixed between them.
        let limit = match (stop, perforation) {
            (Some(stop), Some(perforation)) => [stop.min(perforation), stop.max(perforation)].map(Some),
            alone => alone.into(),
        };
        StudyProgress { shots: self.rows.len(), limit, ..StudyProgress::default() }
    }

    /// Sorted table of the shots below `count`.
    pub(super) fn text(&self, count: u32) -> String {
        text(&self.drawn, self.rows(count))
    }

    /// Removes the appended table.
    pub(super) fn close(&self) -> Result<(), BatchError> {
        Ok(fs::remove_file(&self.path).map_err(|error| CaseError::unwritten(&self.path, &error))?)
    }
}

/// Table with these drawn columns.
fn text<'a>(drawn: &[String], rows: impl Iterator<Item = &'a ShotRow>) -> String {
    let columns = FIRST.into_iter().chain(drawn.iter().map(String::as_str)).chain(OUTCOME);
    let columns = columns.chain(NUMBERS.map(|(name, _)| name)).chain(["trust", "reason"]);
    rows.fold(columns.collect::<Vec<_>>().join(",") + "\n", |text, row| text + &row.line(drawn))
}

/// Rows of the table of this name: appended so far, or sorted by a batch that had ended, where a longer one begins.
fn rows_in(folder: &Folder, name: &str) -> BTreeMap<ShotKey, ShotRow> {
    let [partial, whole] = [&batch::partial(name), name].map(|name| fs::read(folder.path().join(name)));
    let bytes = partial.or(whole).unwrap_or_default();
    // The last line may be cut.
    let end = bytes.iter().rposition(|byte| *byte == b'\n').unwrap_or(0);
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(&bytes[..end]);
    let Ok(header) = reader.headers().cloned() else { return BTreeMap::new() };
    let records = reader.records().filter_map(Result::ok).filter(|record| record.len() == header.len());
    let rows = records.filter_map(|record| ShotRow::parse(&header, &record));
    rows.map(|row| (key(row.order), row)).collect()
}
