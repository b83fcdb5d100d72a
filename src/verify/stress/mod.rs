//! Stability to stress: the list of hard scenes, long runs, and random scenes, on every backend and precision.
//!
//! A scene is sound when every number is finite, every unit cell converged, the ledger closed and no energy was
//! invented, or when what is impossible is diagnosed by name. A random scene that is not is shrunk to the plain shot with the
//! fewest changes that still fail alike, as a complete case.

mod disturbance;
mod drift;
mod judge;
pub(super) mod list;
mod random;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::{iter, thread};

use proptest::strategy::ValueTree;
use serde_json::Value;

use super::Row;
use crate::case::Case;
pub use judge::{Fault, Kind, Machine};
use judge::{Judged, NoRun};

/// How many scenes are tried to make a failing one smaller.
const TRIALS: usize = 300;
/// A device compiles its kernels for every scene: fewer random ones there.
const DEVICE_SHARE: u64 = 50;
/// Steps of the long run in a device that is software, where a step costs a hundred times as much.
const DEVICE_STEPS: u64 = 20_000;

/// What to run.
#[derive(Clone, Debug)]
pub struct Plan<'a> {
    /// On what.
    pub machines: Vec<Machine<'a>>,
    /// Random scenes on the processor; on a device a fiftieth of them.
    pub scenes: u64,
    /// Where the random scenes come from.
    pub seed: u64,
    /// Worker threads; `None` takes all cores. Scenes run side by side.
    pub threads: Option<usize>,
    /// Also the list and the long runs.
    pub list: bool,
}

/// A random scene that is not sound, made as small as it will get.
#[derive(Clone, Debug)]
pub struct Found {
    /// Of the scenes.
    pub seed: u64,
    /// Of this one.
    pub number: u64,
    /// What computed it.
    pub machine: &'static str,
    /// What is wrong.
    pub fault: Fault,
    /// A complete case.
    pub case: Value,
}

impl Found {
    /// Name of a file for the case.
    pub fn file(&self) -> String {
        format!("stress-{}-{}-{}.json", self.seed, self.number, self.machine.replace(' ', "-"))
    }
}

/// What came of a plan.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Lines of the table.
    pub rows: Vec<Row>,
    /// Random scenes that are not sound.
    pub found: Vec<Found>,
}

/// What became of a random scene.
enum Ending {
    Sound,
    /// Gains energy, so much of what was put in, but not with a shorter step.
    Coarse(f64),
    Refused(String),
    Found(Box<Found>),
    Interrupted,
}

/// Runs a plan. `progress` is told what runs, how much of it is done and how much there is.
pub fn run(plan: &Plan<'_>, interrupt: &AtomicBool, progress: &(dyn Fn(&str, usize, usize) + Sync)) -> Report {
    let mut report = Report::default();
    for &machine in &plan.machines {
        let threads = match machine {
            Machine::Cpu(_) => {
                plan.threads.or_else(|| thread::available_parallelism().ok().map(Into::into)).unwrap_or(1)
            }
            // One queue.
            Machine::Gpu(_) => 1,
        };
        if plan.list {
            report.rows.extend(hard(machine, threads, interrupt, progress));
        }
        let scenes = if matches!(machine, Machine::Gpu(_)) { plan.scenes.div_ceil(DEVICE_SHARE) } else { plan.scenes };
        random_scenes(plan.seed, scenes, machine, threads, interrupt, progress, &mut report);
    }
    report
}

/// Heading of the rows of a machine.
fn group(machine: Machine<'_>) -> &'static str {
    match machine {
        Machine::Gpu(_) => "stress, gpu f32",
        cpu if cpu.is_double() => "stress, cpu f64",
        Machine::Cpu(_) => "stress, cpu f32",
    }
}

/// The list and the long run.
fn hard(
    machine: Machine<'_>,
    threads: usize,
    interrupt: &AtomicBool,
    progress: &(dyn Fn(&str, usize, usize) + Sync),
) -> Vec<Row> {
    let steps = if matches!(machine, Machine::Gpu(_)) { DEVICE_STEPS } else { drift::STEPS };
    let count = list::LIST.len() + 1;
    let done = AtomicUsize::new(0);
    // The long run first: the others fill the time it takes.
    let rows = side_by_side(threads, count, |at| {
        let rows = match at.checked_sub(1) {
            None => drift::rows(group(machine), machine, steps, interrupt),
            Some(at) => list::row(group(machine), &list::LIST[at], machine, interrupt).map(|row| vec![row]),
        };
        progress(machine.name(), done.fetch_add(1, Ordering::Relaxed) + 1, count);
        rows.unwrap_or_default()
    });
    rows.into_iter().flatten().collect()
}

fn random_scenes(
    seed: u64,
    scenes: u64,
    machine: Machine<'_>,
    threads: usize,
    interrupt: &AtomicBool,
    progress: &(dyn Fn(&str, usize, usize) + Sync),
    report: &mut Report,
) {
    let done = AtomicUsize::new(0);
    let endings = side_by_side(threads, scenes as usize, |at| {
        let ending = random_scene(seed, at as u64, machine, interrupt);
        progress(machine.name(), done.fetch_add(1, Ordering::Relaxed) + 1, scenes as usize);
        ending
    });
    let refused = endings.iter().filter(|e| matches!(e, Ending::Refused(_))).count();
    let coarse: Vec<f64> =
        endings.iter().filter_map(|e| if let Ending::Coarse(gain) = e { Some(*gain) } else { None }).collect();
    if interrupt.load(Ordering::Relaxed) || scenes == 0 {
        return;
    }
    let found: Vec<Found> =
        endings.into_iter().filter_map(|e| if let Ending::Found(found) = e { Some(*found) } else { None }).collect();
    let row = |name: String, got: String, pass: bool| Row {
        group: group(machine),
        name,
        expected: "0 unsound".to_owned(),
        got,
        tolerance: String::new(),
        source: format!("seed {seed}"),
        pass,
    };
    let name = format!("{scenes} random scenes, {refused} refused, {} with too long a step", coarse.len());
    report.rows.push(row(name, format!("{} unsound", found.len()), found.is_empty()));
    report
        .rows
        .extend(found.iter().map(|found| row(format!("scene {}", found.number), found.fault.what.clone(), false)));
    report.found.extend(found);
}

/// Why the scenes with these numbers are refused, for those that are.
pub fn refusals(seed: u64, numbers: std::ops::Range<u64>) -> Vec<(u64, String)> {
    let machine = Machine::Cpu(crate::simulation::Precision::F64);
    let why = |number| match random_scene(seed, number, machine, &AtomicBool::new(false)) {
        Ending::Refused(why) => Some((number, why)),
        _ => None,
    };
    numbers.filter_map(why).collect()
}

/// Draws a scene, runs it and, where it is not sound, makes it smaller.
fn random_scene(seed: u64, number: u64, machine: Machine<'_>, interrupt: &AtomicBool) -> Ending {
    let name = format!("random scene {number} of seed {seed}");
    let Some(mut tree) = random::tree(seed, number) else { return Ending::Refused("no scene was drawn".to_owned()) };
    let try_it = |draw: &random::Draw| -> Result<(Judged, Case), NoRun> {
        let case = random::case(draw, &name).map_err(NoRun::Refused)?;
        judge::judge(&case, machine, interrupt).map(|judged| (judged, case))
    };
    let (mut fault, mut case) = match try_it(&tree.current()) {
        Ok((Judged::Sound, _)) => return Ending::Sound,
        Ok((Judged::Coarse(gain), _)) => return Ending::Coarse(gain),
        Ok((Judged::Unsound(fault), case)) => (fault, case),
        Err(NoRun::Refused(why) | NoRun::Panicked(why)) => return Ending::Refused(why),
        Err(NoRun::Interrupted) => return Ending::Interrupted,
    };
    let mut more = tree.simplify();
    for _ in iter::repeat_n((), TRIALS) {
        if !more {
            break;
        }
        more = match try_it(&tree.current()) {
            // Another fault would be another story.
            Ok((Judged::Unsound(smaller), of)) if smaller.kind == fault.kind => {
                (fault, case) = (smaller, of);
                tree.simplify()
            }
            Err(NoRun::Interrupted) => break,
            _ => tree.complicate(),
        };
    }
    Ending::Found(Box::new(Found { seed, number, machine: machine.name(), fault, case: case.as_run }))
}

/// Does `count` pieces of work on some threads, each alone on its thread; results in order.
fn side_by_side<T: Send>(threads: usize, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut done = Vec::new();
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            if at >= count {
                return done;
            }
            done.push((at, work(at)));
        }
    };
    // A pool of one thread each, so that the loops over rows stay on it.
    let alone = || match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(worker),
        Err(_) => worker(),
    };
    let mut results: Vec<(usize, T)> = thread::scope(|scope| {
        let handles: Vec<_> = (0..threads.min(count)).map(|_| scope.spawn(alone)).collect();
        handles.into_iter().filter_map(|handle| handle.join().ok()).flatten().collect()
    });
    results.sort_by_key(|(at, _)| *at);
    results.into_iter().map(|(_, result)| result).collect()
}
