//! `ripstop shots`: realisations of a case at velocities spread over a range.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::json;

use super::batch::{self, Batch, BatchError, BatchOptions, BatchProgress, ShotOrder, locked};
use super::fit::{Fit, FitRequest, FitRow, fit};
use super::report::{Report, ReportTable};
use super::shot_table::{ShotRow, ShotTable};
use crate::case::{Case, RANGE_STREAM, Variability};
use crate::num::random::DrawKey;
use crate::output::Folder;
use crate::output::number::short;
use crate::run::batch::DeviceUse;

/// Name of the table.
const TABLE: &str = "shots.csv";
/// Every file that is written.
pub const FILES: &[&str] = &["plan.json", TABLE, "shots.html", "shots.json"];
/// Fraction by which the place in the range moves on from shot to shot: the golden ratio fills a range evenly, whatever the count.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Shots between checks whether the interval is narrow enough.
const BETWEEN_CHECKS: u32 = 10;

/// Request of shots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotsRequest {
    /// Number of shots at most.
    pub count: u32,
    /// Range of the velocities [m/s]; `None`: that of the case.
    pub velocity: Option<[f64; 2]>,
    /// Half the width of the interval of V50 over V50 at which to stop early.
    pub until_width: Option<f64>,
    /// Fit of the limit.
    pub fit: FitRequest,
}

/// Result of a batch.
#[derive(Clone, Debug)]
pub struct ShotsResult {
    /// Rows by number.
    pub rows: Vec<ShotRow>,
    /// Limit fitted to them.
    pub fit: Fit,
    /// Whether the interval was narrow enough before all were fired.
    pub early: bool,
    /// Use of the device.
    pub device: DeviceUse,
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
/// When the disk refuses, or another batch lies in the folder.
pub(super) fn begin<'a>(
    case: &Case,
    request: &ShotsRequest,
    options: &BatchOptions<'a>,
    folder: &Folder,
) -> Result<Batch<'a>, BatchError> {
    // A longer batch may go on where a shorter one ended: the count is no part of the plan.
    let parts = json!({ "velocity_m_s": request.velocity });
    batch::begin("shots", case, options, parts, (folder, FILES))?;
    Batch::open(case.clone(), options, folder, TABLE)
}

/// Orders of the first shots that have no row yet.
pub(super) fn missing(table: &ShotTable, request: &ShotsRequest, seed: u32, count: u32) -> Vec<ShotOrder> {
    (0..count).map(|shot| order(request, seed, shot)).filter(|order| table.find(*order).is_none()).collect()
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
    let fitted = |table: &ShotTable, count: u32| {
        let rows: Vec<FitRow> = table.rows(count).filter_map(ShotRow::fit_row).collect();
        fit(&rows, request.fit)
    };
    let step = if request.until_width.is_some() { BETWEEN_CHECKS } else { request.count };
    let (mut wanted, mut early) = (0, false);
    while wanted < request.count && !early {
        wanted = (wanted + step).min(request.count);
        let missing = missing(&batch.table(), request, options.seed, wanted);
        let (done, last) = (AtomicU32::new(wanted - missing.len() as u32), Mutex::new(None));
        batch.fire(&missing, options.threads, &|table| {
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            let mut last = locked(&last);
            // An estimate for every row of a thousand would be most of the work.
            if done.is_multiple_of(BETWEEN_CHECKS) || done == wanted {
                *last = fitted(table, request.count).limit.v50();
            }
            (options.progress)(BatchProgress { done, of: request.count, v50: *last });
        })?;
        let is_narrow = |width: f64| {
            let v50 = fitted(&batch.table(), wanted).limit.v50();
            v50.is_some_and(|(v50, bounds)| bounds.is_narrow(Some(v50), width))
        };
        early = wanted < request.count && request.until_width.is_some_and(is_narrow);
    }
    let table = batch.table().text(wanted);
    let rows: Vec<ShotRow> = batch.table().rows(wanted).cloned().collect();
    let fit = fitted(&batch.table(), wanted);
    let result = ShotsResult { rows, fit, early, device: batch.device_use() };
    let page = result.report(case, request).html(&format!("Shots: {}", case.title), "shots.csv");
    let json = format!("{:#}\n", result.fit.json());
    // The table last: what is beside it is of it.
    folder.put(&[("shots.json", json), ("shots.html", page), (TABLE, table)], &[])?;
    batch.close()?;
    Ok(result)
}

impl ShotsResult {
    /// Result in words, tables and drawings.
    pub fn report(&self, case: &Case, request: &ShotsRequest) -> Report {
        let mut report = Report { title: case.title.clone(), ..self.fit.report("shots") };
        let count = self.rows.len();
        let trusted = self.rows.iter().filter(|row| row.trust == "trust").count();
        report.counts.push(format!("trust: {trusted} of {count} shots"));
        if self.early {
            let width = short(100.0 * request.until_width.unwrap_or_default(), 3);
            let of = request.count;
            report.counts.push(format!("stopped after {count} of {of} shots: the interval is within ± {width} %"));
        }
        let failed: Vec<&ShotRow> = self.rows.iter().filter(|row| row.perforated().is_none()).collect();
        let reason = failed.first().map(|row| format!("shot {}: {}", row.order.shot, row.reason));
        report.notes.extend(reason.map(|reason| format!("{} shots without an outcome; {reason}", failed.len())));
        report.notes.extend(notes(case));
        let row = |row: &&ShotRow| vec![row.order.shot.to_string(), short(row.velocity, 5), row.reason.clone()];
        let heads = ["shot", "velocity m/s", ""];
        report.page_tables.push(ReportTable::new("shots without an outcome", &heads, 0, failed.iter().map(row)));
        report
    }
}

/// Sentences on what varies from shot to shot, and what of it is assumed.
pub(super) fn notes(case: &Case) -> Vec<String> {
    let mut notes = Vec::new();
    if !case.variability.as_ref().is_some_and(Variability::varies) {
        notes.push("nothing varies from shot to shot but the velocity: the case has no variability".to_owned());
    }
    let assumed = case.fields.iter().filter(|field| field.assumed && field.pointer.starts_with("/variability"));
    // Once each: not its distribution and its scatter apart.
    let section = |pointer: &str| pointer.split('/').take(3).collect::<Vec<_>>().join("/");
    let mut assumed: Vec<String> =
        assumed.map(|field| section(&field.pointer)).filter(|pointer| pointer != "/variability/seed").collect();
    assumed.dedup();
    if !assumed.is_empty() {
        notes.push(format!("assumed: {}", assumed.join(", ")));
    }
    notes
}
