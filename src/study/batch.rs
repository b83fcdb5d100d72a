//! Batches: shots of a case, on the processor a thread each, on a device many at a time.
//!
//! A shot is a function of case, seed, number and velocity; it does not depend on which others run. Its row is on the disk before the
//! next one begins, and a row that is there is not computed again.

use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

use serde_json::{Value, json};

use super::StudyError;
use super::interval::Bounds;
use super::on_device::DeviceRunner;
use super::shot_table::{ShotRow, ShotTable};
use crate::case::{self, Case, CaseError, case_hash};
use crate::gpu::{Device, DeviceError};
use crate::output::{Folder, OutputError};
use crate::run::batch::DeviceUse;
use crate::run::{self, Options, Precision};

/// Name of the file that says what a batch is of.
const PLAN: &str = "plan.json";
/// Shots tried for the names of the columns that a case draws: some cannot be set up.
const TRIES: u32 = 16;

/// One shot that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotOrder {
    /// Number of the draw.
    pub shot: u32,
    /// Impact velocity before its scatter [m/s]; `None`: that of the case.
    pub velocity: Option<f64>,
}

/// Progress of a study.
#[derive(Clone, Copy, Debug)]
pub struct BatchProgress {
    /// Shots, realisations or points that are done.
    pub done: u32,
    /// Number wanted at most.
    pub of: u32,
    /// V50 and its interval as far as they are known [m/s].
    pub v50: Option<(f64, Bounds)>,
}

/// Ways to compute shots. Only precision and device change results.
#[derive(Clone, Copy)]
pub struct BatchOptions<'a> {
    /// Seed of all draws.
    pub seed: u32,
    /// Shots at a time.
    pub threads: usize,
    /// Threads of a shot, where fewer shots than threads can run.
    pub threads_per_shot: usize,
    /// Number type.
    pub precision: Precision,
    /// Graphics processor that computes many shots at a time; `None`: the processor.
    pub device: Option<&'a Device>,
    /// Raised: the shots under way are given up.
    pub interrupt: &'a AtomicBool,
    /// Whether rows that lie in the folder are kept.
    pub resume: bool,
    /// Receiver of the progress.
    pub progress: &'a (dyn Fn(BatchProgress) + Sync),
}

impl BatchOptions<'_> {
    /// Whether the user has asked for the end.
    pub(super) fn stopped(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }
}

/// Reason why a batch did not end.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BatchError {
    /// Results that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Request or folder that cannot be used.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// Device that was lost; rows so far are written.
    #[error(transparent)]
    Device(DeviceError),
    /// End that the user has asked for; rows so far are written.
    #[error("interrupted")]
    Interrupted,
}

/// Case of a shot, as `ripstop run` would run it.
///
/// # Errors
/// When something was drawn that its key does not allow.
pub fn order_case(case: &Case, seed: u32, order: ShotOrder) -> Result<Case, CaseError> {
    case::realisation(case, seed, order.shot, order.velocity)
}

/// Shots of a case: the table of their rows, and the device that computes them.
pub struct Batch<'a> {
    /// Nominal case.
    pub case: Case,
    options: BatchOptions<'a>,
    table: Mutex<ShotTable>,
    device: Option<Mutex<DeviceRunner<'a>>>,
}

impl<'a> Batch<'a> {
    /// Batch with the rows that lie in the folder, where it goes on. `name`: of the table.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn open(case: Case, options: &BatchOptions<'a>, folder: &Folder, name: &str) -> Result<Self, BatchError> {
        let orders = (0..TRIES).map(|shot| ShotOrder { shot, velocity: None });
        let first = orders.filter_map(|order| order_case(&case, options.seed, order).ok()).next();
        let drawn = first.into_iter().flat_map(|shot| shot.drawn).map(|drawn| drawn.column).collect();
        let table = Mutex::new(ShotTable::open(folder, name, drawn, options.resume)?);
        Ok(Self { case, options: *options, table, device: DeviceRunner::new(options).map(Mutex::new) })
    }

    /// Rows so far; a shot that ends waits for their release.
    pub fn table(&self) -> MutexGuard<'_, ShotTable> {
        locked(&self.table)
    }

    /// Fires shots on threads, or on the device, and keeps their rows; `fired` sees the rows after each.
    ///
    /// # Errors
    /// The first of: a disk that refuses, the end that the user has asked for, a lost device. Shots under way are given up then.
    pub fn fire(
        &self,
        orders: &[ShotOrder],
        threads: usize,
        fired: &(dyn Fn(&ShotTable) + Sync),
    ) -> Result<(), BatchError> {
        let add = |row| {
            let mut table = self.table();
            table.add(row)?;
            fired(&table);
            Ok(())
        };
        if let Some(device) = &self.device {
            return locked(device).fire(orders.iter().map(|order| (&self.case, *order)), &mut |_, row| add(row));
        }
        let shoot = |number: usize, given_up: &AtomicBool| {
            let row = shoot(&self.case, orders[number], &self.options, given_up);
            row.ok_or(BatchError::Interrupted).and_then(add)
        };
        in_threads(threads, 0..orders.len(), shoot).map(drop)
    }

    /// Use of the device so far.
    pub fn device_use(&self) -> DeviceUse {
        self.device.as_ref().map(|device| locked(device).device_use()).unwrap_or_default()
    }

    /// Removes the appended table, once the sorted one is there.
    pub(super) fn close(self) -> Result<(), BatchError> {
        self.table.into_inner().unwrap_or_else(PoisonError::into_inner).close()
    }
}

/// Case of a shot without output that a row does not need; or the row of one that cannot be drawn.
pub(super) fn ready(case: &Case, order: ShotOrder, seed: u32) -> Result<Case, Box<ShotRow>> {
    let mut shot = order_case(case, seed, order).map_err(|error| {
        let mut row = ShotRow::of_failure(order, case, &error.to_string());
        row.velocity = order.velocity.unwrap_or(row.velocity);
        row.drawn.clear();
        Box::new(row)
    })?;
    // None of these changes the outcome.
    shot.output.frames = 0;
    shot.output.profile_times.clear();
    shot.expect.clear();
    Ok(shot)
}

/// Row of a shot on the processor; `None` where it was given up.
fn shoot(case: &Case, order: ShotOrder, options: &BatchOptions<'_>, given_up: &AtomicBool) -> Option<ShotRow> {
    if options.stopped() {
        return None;
    }
    let shot = match ready(case, order, options.seed) {
        Ok(shot) => shot,
        Err(row) => return Some(*row),
    };
    let failure = |reason: &str| Some(ShotRow::of_failure(order, &shot, reason));
    let run_options =
        Options { threads: Some(options.threads_per_shot), precision: options.precision, ..Options::default() };
    let run = || run::run(&shot, run_options, options.interrupt, &mut ());
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(run)) if run.interrupted || given_up.load(Ordering::Relaxed) => None,
        Ok(Ok(run)) => Some(ShotRow::of_run(order, &shot, &run)),
        Ok(Err(error)) => failure(&error.to_string()),
        Err(_) => failure("a fault of ripstop: the computation ended in a panic; please report it"),
    }
}

/// Begins a study in a folder whose `files` are of an earlier one, or goes on with the one that is there. `parts`: all else that decides
/// its rows.
///
/// # Errors
/// When the disk refuses, or the plan in the folder is missing or another one.
pub(super) fn begin(
    command: &str,
    case: &Case,
    options: &BatchOptions<'_>,
    mut parts: Value,
    (folder, files): (&Folder, &[&str]),
) -> Result<(), BatchError> {
    parts["precision"] = json!(options.precision.name());
    parts["backend"] = json!(if options.device.is_some() { "gpu" } else { "cpu" });
    if let Some(device) = options.device {
        parts["adapter"] = json!(device.name());
    }
    let plan = json!({
        "command": command,
        "version": env!("CARGO_PKG_VERSION"),
        "case": case.as_run,
        "case_hash": case_hash(&case.as_run),
        "seed": options.seed,
        "options": parts,
    });
    if options.resume {
        return Ok(check_plan(&plan, folder.path())?);
    }
    folder.put(&[(PLAN, format!("{plan:#}\n"))], files)?;
    Ok(())
}

/// Whether a study was begun in a folder.
pub(super) fn is_begun(folder: &Path) -> bool {
    folder.join(PLAN).is_file()
}

/// Check that the plan in a folder is this one.
fn check_plan(plan: &Value, folder: &Path) -> Result<(), StudyError> {
    let path = folder.join(PLAN);
    let place = path.display().to_string();
    let help = "leave --resume out to begin anew, or give the same case and options as before";
    let text = fs::read_to_string(&path)
        .map_err(|error| StudyError::new(&place, "the plan of a batch that was begun here", error.to_string(), help))?;
    let found: Value = serde_json::from_str(&text)
        .map_err(|error| StudyError::new(&place, "the plan of a batch", error.to_string(), help))?;
    let Some(name) =
        ["version", "command", "seed", "options", "case"].into_iter().find(|name| found[*name] != plan[*name])
    else {
        return Ok(());
    };
    let [expected, found] = match name {
        "case" => ["the case of this batch", "another case"].map(str::to_owned),
        _ => [(plan, &found), (&found, plan)]
            .map(|(one, other)| format!("{name} {}", differing(&one[name], &other[name]))),
    };
    Err(StudyError::new(&place, expected, found, help))
}

/// Value, or the members of an object that another one lacks or has otherwise.
fn differing(one: &Value, other: &Value) -> Value {
    let Value::Object(members) = one else { return one.clone() };
    let differing = members.iter().filter(|(name, value)| other.get(name.as_str()) != Some(*value));
    differing.map(|(name, value)| (name.clone(), value.clone())).collect()
}

/// Results of `work` for every number, in their order, on at most `threads` threads. The second argument of `work` is raised once one of
/// them has failed.
///
/// # Errors
/// The first in time: failures that follow from it do not hide it.
pub(super) fn in_threads<T: Send, E: Send>(
    threads: usize,
    numbers: Range<usize>,
    work: impl Fn(usize, &AtomicBool) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let (next, given_up) = (AtomicUsize::new(numbers.start), AtomicBool::new(false));
    let (done, first) = (Mutex::new(Vec::new()), Mutex::new(None));
    let worker = || {
        while !given_up.load(Ordering::Relaxed) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= numbers.end {
                return;
            }
            match work(number, &given_up) {
                Ok(result) => locked(&done).push((number, result)),
                Err(error) => {
                    locked(&first).get_or_insert(error);
                    given_up.store(true, Ordering::Relaxed);
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads.min(numbers.len()) {
            scope.spawn(worker);
        }
    });
    if let Some(error) = first.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(number, _)| *number);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}

/// Access to a value, also after a panic elsewhere.
pub(super) fn locked<T>(inside: &Mutex<T>) -> MutexGuard<'_, T> {
    inside.lock().unwrap_or_else(PoisonError::into_inner)
}
