//! `ripstop shots`: realisations of a case at velocities spread over a range.

use serde_json::json;

use super::batch::{self, BatchError, BatchOptions, BatchPlan, ShotLog, ShotOrder, ShotRow, fire, order_case};
use super::fit::{self, Fit, FitRequest};
use crate::case::{Case, RANGE_STREAM};
use crate::num::random::DrawKey;
use crate::output::Folder;
use crate::run::graphics::DeviceUse;

/// Name of the table.
const TABLE: &str = "shots.csv";
/// Every file that is written.
pub const FILES: &[&str] = &["plan.json", TABLE, "shots.html", "shots.json"];
/// Fraction by which the place in the range moves on from shot to shot: the golden ratio fills a range evenly, whatever the count.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// Shots after each of which it is looked whether the interval is narrow enough.
const BETWEEN_LOOKS: u32 = 10;
/// Shots without an outcome of one setting from which on none is tried any more to learn the columns.
const TRIES: u32 = 16;

/// What shots are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotsRequest {
    /// How many at most.
    pub count: u32,
    /// Range of the velocities [m/s]; `None`: that of the case.
    pub velocity: Option<[f64; 2]>,
    /// Half the width of the interval of V50 over V50 at which to stop early.
    pub until_width: Option<f64>,
    /// How the limit is fitted.
    pub fit: FitRequest,
}

/// What a batch is at.
#[derive(Clone, Copy, Debug)]
pub struct BatchProgress<'a> {
    /// Shots that are there.
    pub done: u32,
    /// Shots wanted, at most.
    pub of: u32,
    /// The last estimate, where there is one.
    pub fit: Option<&'a Fit>,
}

/// A finished batch.
#[derive(Clone, Debug)]
pub struct ShotsResult {
    /// Rows by number.
    pub rows: Vec<ShotRow>,
    /// What they tell of the limit.
    pub fit: Fit,
    /// Whether the interval was narrow enough before all were fired.
    pub early: bool,
    /// What was taken of a device.
    pub device: DeviceUse,
}

/// The order of a shot.
pub fn order(request: &ShotsRequest, seed: u32, shot: u32) -> ShotOrder {
    let velocity = request.velocity.map(|[low, high]| {
        let key = DrawKey { seed: u64::from(seed), shot: 0, ply: DrawKey::WHOLE, yarn: RANGE_STREAM, element: 0 };
        let [start, ..] = key.uniform();
        low + (high - low) * (start + GOLDEN * f64::from(shot)).fract()
    });
    ShotOrder { shot, velocity }
}

/// Columns of what a case draws.
pub(super) fn drawn_columns(case: &Case, seed: u32, orders: impl Iterator<Item = ShotOrder>) -> Vec<String> {
    let shots = orders.take(TRIES as usize).filter_map(|order| order_case(case, seed, order).ok());
    let drawn = |shot: Case| shot.drawn.into_iter().map(|drawn| drawn.column).collect();
    shots.map(drawn).next().unwrap_or_default()
}

/// The plan of a batch.
pub fn plan(case: &Case, request: &ShotsRequest, options: &BatchOptions<'_>) -> BatchPlan {
    // A longer batch may go on where a shorter one ended: the count is no part of what a row is.
    BatchPlan::new("shots", case, options, json!({ "velocity_m_s": request.velocity }))
}

/// Begins a batch, or goes on with the one that is there.
///
/// # Errors
/// When the disk refuses, or another batch lies in the folder.
pub(super) fn begin(
    case: &Case,
    request: &ShotsRequest,
    options: &BatchOptions<'_>,
    folder: &Folder,
    resume: bool,
) -> Result<ShotLog, BatchError> {
    let drawn = drawn_columns(case, options.seed, (0..request.count).map(|shot| order(request, options.seed, shot)));
    plan(case, request, options).begin(folder, FILES, resume)?;
    ShotLog::open(folder, TABLE, drawn, resume)
}

/// Which of the first shots have no row yet.
pub(super) fn missing(log: &ShotLog, request: &ShotsRequest, seed: u32, count: u32) -> Vec<ShotOrder> {
    (0..count).map(|shot| order(request, seed, shot)).filter(|order| log.find(*order).is_none()).collect()
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
    resume: bool,
    progress: &mut dyn FnMut(BatchProgress<'_>),
) -> Result<ShotsResult, BatchError> {
    let mut log = begin(case, request, options, folder, resume)?;
    let step = if request.until_width.is_some() { BETWEEN_LOOKS } else { request.count };
    let mut wanted = 0;
    let mut early = false;
    let mut device = DeviceUse::default();
    while wanted < request.count && !early {
        wanted = (wanted + step).min(request.count);
        let missing = missing(&log, request, options.seed, wanted);
        let mut done = wanted - missing.len() as u32;
        let mut last = None;
        let used = fire(case, &missing, options, &mut |row| {
            log.add(row)?;
            done += 1;
            // An estimate for every row of a thousand would be most of the work.
            if done.is_multiple_of(BETWEEN_LOOKS) || done == wanted {
                last = Some(estimate(&log, request));
            }
            progress(BatchProgress { done, of: request.count, fit: last.as_ref() });
            Ok(())
        })?;
        device = device.with(used);
        early = wanted < request.count
            && request.until_width.is_some_and(|width| is_narrow(&first(&log, wanted), request, width));
    }
    Ok(ShotsResult { early, device, ..finish(case, request, folder, log, wanted)? })
}

/// Rows of the first shots.
fn first(log: &ShotLog, count: u32) -> Vec<&ShotRow> {
    log.rows().filter(|row| row.order.shot < count).collect()
}

fn fitted(rows: &[&ShotRow], request: &ShotsRequest) -> Fit {
    let rows: Vec<fit::FitRow> = rows.iter().filter_map(|row| row.as_fit_row()).collect();
    fit::fit(&rows, request.fit)
}

fn estimate(log: &ShotLog, request: &ShotsRequest) -> Fit {
    fitted(&first(log, request.count), request)
}

/// Whether the interval of V50 is narrow enough.
fn is_narrow(rows: &[&ShotRow], request: &ShotsRequest, width: f64) -> bool {
    fitted(rows, request).v50().is_some_and(|v50| v50.bounds.is_narrow(v50.value, width))
}

fn finish(
    case: &Case,
    request: &ShotsRequest,
    folder: &Folder,
    log: ShotLog,
    count: u32,
) -> Result<ShotsResult, BatchError> {
    let table = log.table(|row| row.order.shot < count);
    let rows: Vec<&ShotRow> = first(&log, count);
    let fit = fitted(&rows, request);
    let page = batch::html(&case.title, &rows, &fit, &notes(case));
    let json = format!("{:#}\n", fit::json(&fit));
    let rows = rows.into_iter().cloned().collect();
    // The table last: what is beside it is of it.
    folder.put(&[("shots.json", json), ("shots.html", page), (TABLE, table)], &[])?;
    log.close()?;
    Ok(ShotsResult { rows, fit, early: false, device: DeviceUse::default() })
}

/// What a reader should know of a batch.
pub fn notes(case: &Case) -> Vec<String> {
    let mut notes = Vec::new();
    let varies = case.variability.as_ref().is_some_and(crate::case::Variability::varies);
    if !varies {
        notes.push("nothing varies from shot to shot but the velocity: the case has no variability".to_owned());
    }
    let assumed = case.fields.iter().filter(|field| field.assumed && field.pointer.starts_with("/variability"));
    // What varies, once each: not its distribution and its scatter apart.
    let section = |pointer: &str| pointer.split('/').take(3).collect::<Vec<_>>().join("/");
    let mut assumed: Vec<String> =
        assumed.map(|field| section(&field.pointer)).filter(|pointer| pointer != "/variability/seed").collect();
    assumed.dedup();
    if !assumed.is_empty() {
        notes.push(format!("assumed: {}", assumed.join(", ")));
    }
    notes
}
