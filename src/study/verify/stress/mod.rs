//! Stability to stress: the list of hard scenes, long runs, and random scenes, on every backend and precision.
//!
//! A scene is sound when every number is finite, every unit cell converged, the ledger closed and no energy was
//! invented, or when what is impossible is diagnosed by name. A random scene that is not is shrunk to the plain shot with the
//! fewest changes that still fail alike, as a complete case.

mod changes;
mod disturbance;
mod document;
mod drift;
mod judge;
mod law_path;
mod list;
mod random;
mod user;
mod values;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

use proptest::strategy::ValueTree;
use serde_json::Value;

use super::Check;
use crate::study::threads::side_by_side;
use judge::SkipReason;
pub use judge::{FaultKind, StressBackend, Unsound};

/// How many scenes are tried to make a failing one smaller.
const TRIALS: usize = 600;
/// A device compiles its kernels for every scene, and a step of a small mesh costs it a hundred times as much: fewer random
/// scenes and a shorter long run there.
const DEVICE_SHARE: u64 = 50;

/// What to run.
#[derive(Clone, Debug)]
pub struct StressPlan<'a> {
    /// On what.
    pub machines: Vec<StressBackend<'a>>,
    /// Random scenes.
    pub scenes: SceneNumbers,
    /// Steps of the long run on the processor; on a device a fiftieth of them.
    pub steps: u64,
    /// Where the random scenes come from.
    pub seed: u64,
    /// Worker threads; `None` takes all cores. Scenes run side by side.
    pub threads: Option<usize>,
    /// Also the list and the long runs.
    pub list: bool,
}

/// Which random scenes of a seed.
#[derive(Clone, Debug)]
pub enum SceneNumbers {
    /// So many on the processor, from number 0 on; on a device a fiftieth of them.
    First(u64),
    /// These, on every machine.
    These(Vec<u64>),
}

impl SceneNumbers {
    /// The numbers on a machine that takes one scene of `share`.
    fn on(&self, share: u64) -> Vec<u64> {
        match self {
            Self::First(count) => (0..count.div_ceil(share)).collect(),
            Self::These(numbers) => numbers.clone(),
        }
    }
}

/// A random scene that is not sound, made as small as it will get.
#[derive(Clone, Debug)]
pub struct UnsoundScene {
    /// Of the scenes.
    pub seed: u64,
    /// Of this one.
    pub number: u64,
    /// What computed it.
    pub machine: &'static str,
    /// What is wrong.
    pub fault: Unsound,
    /// A complete case.
    pub case: Value,
}

impl UnsoundScene {
    /// Name of a file for the case.
    pub fn file(&self) -> String {
        format!("stress-{}-{}-{}.json", self.seed, self.number, self.machine.replace(' ', "-"))
    }
}

/// What came of a plan.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Lines of the table.
    pub rows: Vec<Check>,
    /// Random scenes that are not sound.
    pub found: Vec<UnsoundScene>,
    /// Random scenes without a model, on the machines that were asked: numbers and reasons.
    pub refused: Vec<(&'static str, u64, String)>,
}

/// What became of a random scene.
enum Ending {
    Sound,
    Refused(String),
    Found(Box<UnsoundScene>),
    Interrupted,
}

/// Runs a plan. `progress` is told what runs, how much of it is done and how much there is.
pub fn run(plan: &StressPlan<'_>, interrupt: &AtomicBool, progress: &(dyn Fn(&str, usize, usize) + Sync)) -> Report {
    let mut report = Report::default();
    for &machine in &plan.machines {
        let on = MachineRun { machine, threads: threads(machine, plan.threads), interrupt, progress };
        let share = if matches!(machine, StressBackend::Gpu(_)) { DEVICE_SHARE } else { 1 };
        if plan.list {
            report.rows.extend(on.hard(plan.steps.div_ceil(share)));
        }
        on.random_scenes(plan.seed, &plan.scenes.on(share), &mut report);
    }
    report
}

/// The quick part of the list. Rows after an interrupt are left out.
pub(super) fn quick(
    group: &'static str,
    machine: StressBackend<'_>,
    asked: Option<usize>,
    interrupt: &AtomicBool,
) -> impl Iterator<Item = Check> {
    let scenes: Vec<_> = list::LIST.iter().filter(|scene| scene.quick).collect();
    let row = |at: usize| list::row(group, scenes[at], machine, interrupt);
    alone(threads(machine, asked), scenes.len(), row).into_iter().map_while(|row| row)
}

/// How many scenes run side by side: as many as asked for, on all cores otherwise; a device has one queue.
fn threads(machine: StressBackend<'_>, asked: Option<usize>) -> usize {
    match machine {
        StressBackend::Cpu(_) => asked.or_else(|| thread::available_parallelism().ok().map(Into::into)).unwrap_or(1),
        StressBackend::Gpu(_) => 1,
    }
}

/// Heading of the rows of a machine.
fn group(machine: StressBackend<'_>) -> &'static str {
    match machine {
        StressBackend::Gpu(_) => "stress, gpu f32",
        cpu if cpu.is_double() => "stress, cpu f64",
        StressBackend::Cpu(_) => "stress, cpu f32",
    }
}

/// A machine, and how scenes are run there.
struct MachineRun<'a> {
    machine: StressBackend<'a>,
    threads: usize,
    interrupt: &'a AtomicBool,
    progress: &'a (dyn Fn(&str, usize, usize) + Sync),
}

impl MachineRun<'_> {
    /// Does so many pieces of work side by side, and tells of each that is done.
    fn all<T: Send>(&self, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
        let done = AtomicUsize::new(0);
        alone(self.threads, count, |at| {
            let result = work(at);
            (self.progress)(self.machine.name(), done.fetch_add(1, Ordering::Relaxed) + 1, count);
            result
        })
    }

    /// The list and the long run.
    fn hard(&self, steps: u64) -> Vec<Check> {
        let (machine, group) = (self.machine, group(self.machine));
        // The long run first: the others fill the time it takes.
        let rows = self.all(list::LIST.len() + 1, |at| match at.checked_sub(1) {
            None => drift::rows(group, machine, steps, self.interrupt),
            Some(at) => list::row(group, &list::LIST[at], machine, self.interrupt).map(|row| vec![row]),
        });
        rows.into_iter().flatten().flatten().collect()
    }

    fn random_scenes(&self, seed: u64, numbers: &[u64], report: &mut Report) {
        let machine = self.machine;
        let endings = self.all(numbers.len(), |at| random_scene(seed, numbers[at], machine, self.interrupt));
        let (mut found, mut refused) = (Vec::new(), 0);
        for (&number, ending) in numbers.iter().zip(endings) {
            match ending {
                Ending::Sound | Ending::Interrupted => {}
                Ending::Found(one) => found.push(*one),
                Ending::Refused(why) => {
                    refused += 1;
                    report.refused.push((machine.name(), number, why));
                }
            }
        }
        if self.interrupt.load(Ordering::Relaxed) || numbers.is_empty() {
            return;
        }
        let row = |name: String, got: String, pass: bool| Check {
            group: group(machine),
            name,
            expected: "0 unsound".to_owned(),
            got,
            source: format!("seed {seed}"),
            pass,
            ..Check::default()
        };
        let name = format!("{} random scenes, {refused} refused", numbers.len());
        report.rows.push(row(name, format!("{} unsound", found.len()), found.is_empty()));
        report
            .rows
            .extend(found.iter().map(|found| row(format!("scene {}", found.number), found.fault.what.clone(), false)));
        report.found.extend(found);
    }
}

/// Draws a scene, runs it and, where it is not sound, makes it smaller.
fn random_scene(seed: u64, number: u64, machine: StressBackend<'_>, interrupt: &AtomicBool) -> Ending {
    let name = format!("random scene {number} of seed {seed}");
    let Some(tree) = random::tree(seed, number) else { return Ending::Refused("no scene was drawn".to_owned()) };
    let try_it = |draw: &random::RandomScene| attempt(draw, &name, machine, interrupt);
    let (fault, case) = match try_it(&tree.current()) {
        Ok((None, _)) => return Ending::Sound,
        Ok((Some(fault), case)) => (fault, case),
        Err(SkipReason::Refused(why) | SkipReason::Unable(why) | SkipReason::Panicked(why)) => {
            return Ending::Refused(why);
        }
        Err(SkipReason::Interrupted) => return Ending::Interrupted,
    };
    let smaller = smallest(tree, |draw| match try_it(draw) {
        // Another fault would be another story.
        Ok((Some(smaller), of)) if smaller.kind == fault.kind => Some((smaller, of)),
        _ => None,
    });
    let (fault, case) = smaller.unwrap_or((fault, case));
    Ending::Found(Box::new(UnsoundScene { seed, number, machine: machine.name(), fault, case }))
}

/// Runs a scene and judges it; the document as run. What the machine does not compute of it is left out.
fn attempt(
    draw: &random::RandomScene,
    name: &str,
    machine: StressBackend<'_>,
    interrupt: &AtomicBool,
) -> Result<(Option<Unsound>, Value), SkipReason> {
    let alone = |draw: &random::RandomScene| {
        let ending = judge::caught(|| {
            let case = document::case(draw, name).map_err(SkipReason::Refused)?;
            judge::judge(&case, machine, interrupt).map(|judged| (judged, case.as_run))
        });
        match ending.and_then(|ending| ending) {
            Err(SkipReason::Panicked(why)) => Ok((Some(Unsound::new(FaultKind::Panic, why)), document::document(draw))),
            other => other,
        }
    };
    match alone(draw) {
        Err(SkipReason::Unable(why)) => {
            let less =
                draw.with_less().map(|less| alone(&less)).find(|ending| !matches!(ending, Err(SkipReason::Unable(_))));
            less.unwrap_or(Err(SkipReason::Unable(why)))
        }
        other => other,
    }
}

/// The smallest that is found of which `fails` still says something, and what it says; `None`: nothing smaller was found.
fn smallest<T>(
    mut tree: impl ValueTree<Value = random::RandomScene>,
    fails: impl Fn(&random::RandomScene) -> Option<T>,
) -> Option<T> {
    let mut found = None;
    let mut more = tree.simplify();
    for _ in 0..TRIALS {
        if !more {
            break;
        }
        more = match fails(&tree.current()) {
            Some(smaller) => {
                found = Some(smaller);
                tree.simplify()
            }
            None => tree.complicate(),
        };
    }
    found
}

/// Does so many pieces of work on some threads, each in a pool of one thread, so that the loops over rows stay on it.
fn alone<T: Send>(threads: usize, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    thread_local! {
        static POOL: Option<rayon::ThreadPool> = rayon::ThreadPoolBuilder::new().num_threads(1).build().ok();
    }
    side_by_side(threads, 0..count, |at| {
        POOL.with(|pool| match pool {
            Some(pool) => pool.install(|| work(at)),
            None => work(at),
        })
    })
}

#[cfg(test)]
#[path = "stress_tests.rs"]
mod tests;
