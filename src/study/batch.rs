//! Batches: shots of a case, on the processor a thread each, on a device many at a time.
//!
//! A shot is a function of case, seed, number and velocity; it does not depend on which others run. Its row is on the disk before the
//! next one begins, and a row that is there is not computed again.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fs, thread};

use serde_json::{Value, json};

use super::shots::{ShotRow, ShotTable};
use crate::case::{self, Case, CaseError, case_hash};
use crate::gpu::{Device, DeviceError};
use crate::output::Folder;
use crate::run::batch::{DeviceBatch, PreparedShot};
use crate::run::{self, Options, Precision, Run};

/// Name of the file that says what a batch is of.
const PLAN: &str = "plan.json";
/// Shots tried for the names of the columns that a case draws: some cannot be set up.
const TRIES: u32 = 16;
/// Device memory of a batch at most [bytes].
const MEMORY: u64 = 4 << 30;
/// Device memory of earlier batches that are kept when another is made, at most [bytes]: searches of some realisations take turns.
const KEPT: u64 = 512 << 20;
/// Shots that are set up for a device at a time: they lie in the memory of the host.
const WAITING: usize = 2048;

/// One shot that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShotOrder {
    /// Number of the draw.
    pub shot: u32,
    /// Impact velocity before its scatter [m/s]; `None`: that of the case.
    pub velocity: Option<f64>,
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
    /// Whether the folder must hold the study already: rows that lie there are kept in any case.
    pub resume: bool,
    /// Receiver of the progress.
    pub progress: &'a (dyn Fn(StudyProgress) + Sync),
}

/// Progress of a study.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StudyProgress {
    /// Shots, thresholds or points that are done.
    pub done: u32,
    /// Number of them that is wanted at most.
    pub of: u32,
    /// Shots fired in search of thresholds; 0 where shots or points are counted.
    pub shots: usize,
    /// Limit so far: fastest stop and slowest perforation, the lower one first [m/s].
    pub limit: [Option<f64>; 2],
}

/// Reason why a batch did not end.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BatchError {
    /// Results that cannot be written, or the folder of another batch.
    #[error(transparent)]
    Refused(#[from] CaseError),
    /// Device that was lost; rows so far are written.
    #[error(transparent)]
    Device(#[from] DeviceError),
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
        let table = Mutex::new(ShotTable::open(folder, name, drawn)?);
        let runner = |device| Mutex::new(DeviceRunner { device, interrupt: options.interrupt, batches: Vec::new() });
        Ok(Self { case, options: *options, table, device: options.device.map(runner) })
    }

    /// Rows so far; a shot that ends waits for their release.
    pub fn table(&self) -> MutexGuard<'_, ShotTable> {
        locked(&self.table)
    }

    /// Fires shots on threads, or on the device, and keeps their rows; `fired` sees the rows after each.
    ///
    /// # Errors
    /// A disk that refuses, the end that the user has asked for, a lost device. Shots under way are given up then.
    pub fn fire(
        &self,
        orders: &[ShotOrder],
        threads: usize,
        fired: &(dyn Fn(&ShotTable) + Sync),
    ) -> Result<(), BatchError> {
        fire(&orders.iter().map(|order| (self, *order)).collect::<Vec<_>>(), threads, fired)
    }

    /// Most shots that the device has room for at a time.
    pub fn room(&self) -> u64 {
        let room =
            |runner: &Mutex<DeviceRunner<'_>>| locked(runner).batches.iter().map(DeviceBatch::room).max().unwrap_or(0);
        self.device.as_ref().map_or(0, room)
    }

    /// Case of a shot without output that a row does not need; or the row of one that cannot be drawn.
    fn ready(&self, order: ShotOrder) -> Result<Case, Box<ShotRow>> {
        let mut shot = order_case(&self.case, self.options.seed, order).map_err(|error| {
            let mut row = ShotRow::of_failure(order, &self.case, &error.to_string());
            row.velocity = order.velocity.unwrap_or(row.velocity);
            row.drawn.clear();
            Box::new(row)
        })?;
        // None of these changes the outcome.
        shot.output.frames = 0;
        shot.output.profile_times.clear();
        shot.expect.clear();
        let later_end = self.table().find(order).and_then(|row| row.later_end(&self.case));
        shot.solver.end_time = later_end.unwrap_or(shot.solver.end_time);
        Ok(shot)
    }

    /// Row of a shot on the processor; `None` where it was given up.
    fn shoot(&self, order: ShotOrder) -> Option<ShotRow> {
        let BatchOptions { threads_per_shot, precision, interrupt, .. } = self.options;
        if interrupt.load(Ordering::Relaxed) {
            return None;
        }
        let shot = match self.ready(order) {
            Ok(shot) => shot,
            Err(row) => return Some(*row),
        };
        let options = Options::default().threads(threads_per_shot).precision(precision);
        match run::run(&shot, options, interrupt, &mut ()) {
            Ok(run) if run.interrupted => None,
            Ok(run) => Some(ShotRow::of_run(order, &shot, &run)),
            Err(error) => Some(ShotRow::of_failure(order, &shot, &error.to_string())),
        }
    }
}

/// A shot of a batch.
pub(super) type Wanted<'b, 'a> = (&'b Batch<'a>, ShotOrder);

/// Fires shots of batches with the same options, as [`Batch::fire`] does; one that is there and undecided with a later end.
pub(super) fn fire(
    wanted: &[Wanted<'_, '_>],
    threads: usize,
    fired: &(dyn Fn(&ShotTable) + Sync),
) -> Result<(), BatchError> {
    let add = |number: usize, row: ShotRow| {
        let mut table = wanted[number].0.table();
        table.add(row)?;
        fired(&table);
        Ok(())
    };
    if let Some(device) = wanted.first().and_then(|(batch, _)| batch.device.as_ref()) {
        return locked(device).fire(wanted, &mut |number, row| add(number, row));
    }
    let shoot = |number: usize| {
        let (batch, order) = wanted[number];
        batch.shoot(order).ok_or(BatchError::Interrupted).and_then(|row| add(number, row))
    };
    in_threads(threads, wanted.len(), shoot).map(drop)
}

/// A shot that waits: its number among those to fire, and what was asked for.
type Waiting = (usize, ShotOrder);

/// Receiver of rows with their numbers among the shots to fire.
type Done<'d> = dyn FnMut(usize, ShotRow) -> Result<(), BatchError> + 'd;

/// Runner of shots on a device: those with one layout and time step together, each as if it were alone.
struct DeviceRunner<'a> {
    device: &'a Device,
    interrupt: &'a AtomicBool,
    /// Pipelines and buffers of earlier batches, which may serve again; those used last at the end.
    batches: Vec<DeviceBatch<'a>>,
}

impl<'a> DeviceRunner<'a> {
    /// Computes shots and hands their rows over as they end, in any order, each with its number among `wanted`.
    fn fire(&mut self, wanted: &[Wanted<'_, '_>], done: &mut Done<'_>) -> Result<(), BatchError> {
        let mut numbers = 0..;
        for some in wanted.chunks(WAITING) {
            let mut groups: Vec<(Vec<Waiting>, Vec<PreparedShot>)> = Vec::new();
            for (number, (of, order)) in numbers.by_ref().zip(some.iter().copied()) {
                if self.interrupt.load(Ordering::Relaxed) {
                    return Err(BatchError::Interrupted);
                }
                let prepared = of.ready(order).and_then(|case| {
                    PreparedShot::new(case.clone())
                        .map_err(|error| Box::new(ShotRow::of_failure(order, &case, &error.to_string())))
                });
                match prepared {
                    Err(row) => done(number, *row)?,
                    Ok(shot) => match groups.iter_mut().find(|(_, shots)| shots[0].fits(&shot)) {
                        Some((orders, shots)) => {
                            orders.push((number, order));
                            shots.push(shot);
                        }
                        None => groups.push((vec![(number, order)], vec![shot])),
                    },
                }
            }
            groups.iter().try_for_each(|(orders, shots)| self.fire_group(orders, shots, done))?;
        }
        Ok(())
    }

    /// Computes shots that go together, as many at a time as there is room for.
    fn fire_group(
        &mut self,
        mut orders: &[Waiting],
        mut shots: &[PreparedShot],
        done: &mut Done<'_>,
    ) -> Result<(), BatchError> {
        let interrupt = self.interrupt;
        while let Some(first) = shots.first() {
            let batch = match self.batch_for(first, shots.len()) {
                Ok(batch) => batch,
                Err(lost @ DeviceError::Lost { .. }) => return Err(lost.into()),
                Err(error) => {
                    return orders.iter().zip(shots).try_for_each(|((number, order), shot)| {
                        done(*number, ShotRow::of_failure(*order, &shot.case, &error.to_string()))
                    });
                }
            };
            let taken = shots.len().min(batch.room() as usize);
            let mut refused = None;
            let mut ended = |at: usize, run: &Run| {
                let (number, order) = orders[at];
                refused = done(number, ShotRow::of_run(order, &shots[at].case, run)).err();
                refused.is_none()
            };
            let all = batch.fire(&shots[..taken], interrupt, &mut ended)?;
            match refused {
                Some(error) => return Err(error),
                None if !all => return Err(BatchError::Interrupted),
                None => (orders, shots) = (&orders[taken..], &shots[taken..]),
            }
        }
        Ok(())
    }

    /// Batch for `count` shots like this one, or for as many of them as there is memory for.
    fn batch_for(&mut self, shot: &PreparedShot, count: usize) -> Result<&mut DeviceBatch<'a>, DeviceError> {
        let batch = match self.batches.iter().position(|batch| batch.takes(shot, count)) {
            Some(at) => self.batches.remove(at),
            None => self.new_batch(shot, count)?,
        };
        let last = self.batches.len();
        self.batches.push(batch);
        Ok(&mut self.batches[last])
    }

    fn new_batch(&mut self, shot: &PreparedShot, count: usize) -> Result<DeviceBatch<'a>, DeviceError> {
        while self.batches.iter().map(DeviceBatch::bytes).sum::<u64>() > KEPT {
            self.batches.remove(0);
        }
        let mut room = shot.room(self.device, MEMORY).min(count as u64);
        loop {
            match DeviceBatch::new(self.device, shot, room) {
                Err(DeviceError::OutOfMemory { .. }) if !self.batches.is_empty() => drop(self.batches.remove(0)),
                Err(DeviceError::OutOfMemory { .. }) if room > 1 => room /= 2,
                made => return made,
            }
        }
    }
}

/// Begins a study in a folder without its `files`, or goes on with the one that is there. `parts`: all else that decides its rows.
///
/// # Errors
/// When the disk refuses, or the files that are there have no plan or another one.
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
    let is_there =
        |name: &&str| [(*name).to_owned(), partial(name)].iter().any(|name| folder.path().join(name).exists());
    if options.resume || files.iter().any(is_there) {
        return Ok(check_plan(&plan, &folder.path().join(PLAN))?);
    }
    folder.put(&[(PLAN, format!("{plan:#}\n"))], &[])?;
    Ok(())
}

/// Name of a table to which rows are appended.
pub(super) fn partial(table: &str) -> String {
    format!("{table}.partial")
}

/// Check that the plan in a file is this one.
fn check_plan(plan: &Value, path: &Path) -> Result<(), CaseError> {
    let help = "give the same case and options as before, or another folder with --out DIR";
    let wrong = |expected: String, found: String| CaseError::of_path(path, expected, found, help);
    let parsed = fs::read_to_string(path).map_err(|error| error.to_string());
    let parsed = parsed.and_then(|text| serde_json::from_str::<Value>(&text).map_err(|error| error.to_string()));
    let found = parsed.map_err(|found| {
        let help = "a batch begins without --resume in a folder that has none of its files; --out DIR names another";
        wrong("the plan of a batch that was begun here".to_owned(), found).help(help)
    })?;
    match ["version", "command", "seed", "options", "case"].into_iter().find(|name| found[*name] != plan[*name]) {
        None => Ok(()),
        Some("case") => Err(wrong("the case of this batch".to_owned(), "another case".to_owned())),
        Some(name) => Err(wrong(format!("{name} {}", plan[name]), format!("{name} {}", found[name]))),
    }
}

/// Sentences on what varies from shot to shot, and what of it is assumed.
pub(super) fn notes(case: &Case) -> Vec<String> {
    let mut notes = Vec::new();
    if !case.varies() {
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

/// Results of `work` for every number below `count`, in their order, on at most `threads` threads; after an error none begins any more.
///
/// # Errors
/// The error of the lowest number.
pub(super) fn in_threads<T: Send, E: Send>(
    threads: usize,
    count: usize,
    work: impl Fn(usize) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let (waiting, done) = (Mutex::new(0..count), Mutex::new(BTreeMap::new()));
    let next = || locked(&waiting).next();
    let worker = || {
        while let Some(number) = next() {
            let result = work(number);
            if result.is_err() {
                *locked(&waiting) = 0..0;
            }
            locked(&done).insert(number, result);
        }
    };
    thread::scope(|scope| (0..threads.min(count)).for_each(|_| drop(scope.spawn(worker))));
    done.into_inner().unwrap_or_else(PoisonError::into_inner).into_values().collect()
}

/// Access to a value, also after a panic elsewhere.
pub(super) fn locked<T>(inside: &Mutex<T>) -> MutexGuard<'_, T> {
    inside.lock().unwrap_or_else(PoisonError::into_inner)
}
