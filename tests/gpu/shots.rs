//! Whole runs on the device.
//!
//! Promises: up to the first broken yarn a shot is the double-precision reference's to 1e-4 of the impact velocity; after
//! that the outcome is the same and integral quantities agree; a run gives the same bits every time and for every
//! batch length; no failure is lost; a run that ends early says why and keeps what it had.
//! Red when: a kernel, the ledger, the order of stages or the host loop of the GPU backend differs from the processor's.

mod batches;
mod campaigns;
mod endings;
mod frames;
mod graded;
mod killed;
mod packs;
mod program;
mod resume;
mod rim;
mod scenes;
mod symmetry;
mod together;
mod whole;

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use libtest_mimic::Trial;
use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::run::device::DeviceSimulation;
use ripstop::run::{self, Options, Run, Skips};

use super::harness::{Outcome, trial};

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    // The longest first, so that no thread is left alone with it.
    let modules = [
        ("campaigns", campaigns::TESTS),
        ("whole", whole::TESTS),
        ("scenes", scenes::TESTS),
        ("symmetry", symmetry::TESTS),
        ("batches", batches::TESTS),
        ("rim", rim::TESTS),
        ("packs", packs::TESTS),
        ("graded", graded::TESTS),
        ("endings", endings::TESTS),
        ("resume", resume::TESTS),
        ("killed", killed::TESTS),
        ("frames", frames::TESTS),
        ("program", program::TESTS),
        ("together", together::TESTS),
    ];
    let named = |(module, tests): (&'static str, Tests)| {
        tests.iter().map(move |(name, test)| trial(format!("shots::{module}::{name}"), *test))
    };
    modules.into_iter().flat_map(named).collect()
}

/// Tests by name.
type Tests = &'static [(&'static str, fn(&'static Device) -> Outcome)];

/// A run to its end that leaves out what it is told to.
fn simulated(device: &Device, case: &Case, skips: Skips) -> Run {
    to_its_end(case, begun(device, case, skips))
}

fn begun<'a>(device: &'a Device, case: &Case, skips: Skips) -> DeviceSimulation<'a> {
    DeviceSimulation::with_skips(case, device, skips).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

fn to_its_end(case: &Case, mut simulation: DeviceSimulation<'_>) -> Run {
    while !simulation.finished() {
        simulation.advance(case);
    }
    sound(case, simulation.into_run(1.0))
}

/// Step, ply, row, column and yarn of each failure.
fn places(run: &Run) -> Vec<(u64, u32, u32, u32, u8)> {
    run.events.iter().map(|e| (e.step, e.ply, e.j, e.i, e.yarn)).collect()
}

/// When the first yarn breaks [s].
fn first_failure(run: &Run) -> f64 {
    run.events.first().map_or(f64::INFINITY, |e| e.step as f64 * run.time_step)
}

/// Velocities up to the first failure are those of the processor, in more than so many rows.
#[track_caller]
fn same_until_failure(cpu: &Run, gpu: &Run, impact: f64, least: usize) {
    assert_eq!(gpu.time_step, cpu.time_step);
    let broken = first_failure(cpu).min(first_failure(gpu));
    let rows = || cpu.history.iter().zip(&gpu.history).take_while(|(c, _)| c.time <= broken);
    assert!(rows().count() > least, "{} rows up to {broken} s", rows().count());
    for (c, g) in rows() {
        let off = (c.projectile_velocity - g.projectile_velocity).abs();
        assert!(c.time == g.time && off <= 1e-4 * impact, "{off} m/s at {} s, before the first failure", c.time);
    }
}

/// Runs a case on the device, to its end.
fn run_on(device: &Device, case: &Case) -> Run {
    sound(case, run_until(device, case, &AtomicBool::new(false)))
}

/// Runs a case on the device until it ends or is interrupted.
fn run_until(device: &Device, case: &Case, interrupt: &AtomicBool) -> Run {
    let options = Options::default().threads(1).device(device);
    run::run(case, options, interrupt, &mut ()).unwrap_or_else(|e| panic!("{}: {e}", case.name))
}

/// Runs a case on the device in batches of so many steps.
fn run_in_batches(device: &Device, case: &Case, steps: usize) -> Run {
    to_its_end(case, begun(device, case, Skips::default()).with_batch(steps))
}

/// A run that nothing cut short, with every unit cell solved.
#[track_caller]
fn sound(case: &Case, run: Run) -> Run {
    assert!(run.divergence.is_none() && run.lost.is_none(), "{}: {:?} {:?}", case.title, run.divergence, run.lost);
    assert_eq!(run.newton.unconverged, 0, "{}", case.title);
    assert_eq!(run.backend, "gpu");
    failures_add_up(case, &run);
    run
}

/// Every failure once and in order, and the counts of the last row are those of the list.
#[track_caller]
fn failures_add_up(case: &Case, run: &Run) {
    let places: Vec<_> = run.events.iter().map(|e| (e.step, e.ply, e.j, e.i, e.yarn)).collect();
    assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "not in order of step, element, yarn: {places:?}");
    let mut yarns: Vec<_> = places.iter().map(|p| (p.1, p.2, p.3, p.4)).collect();
    yarns.sort_unstable();
    yarns.dedup();
    assert_eq!(yarns.len(), places.len(), "a yarn of an element breaks once");
    // The last step is a sample, so that the last row knows every failure.
    let of = |yarn: u8| places.iter().filter(|p| p.4 == yarn).count() as u64;
    let last = run.history.last().unwrap();
    assert_eq!(last.failed, [of(0), of(1)], "failures lost or invented");
    let woven = usize::from(case.fabric.warp.present) + usize::from(case.fabric.weft.present);
    let mut broken = BTreeMap::<_, usize>::new();
    yarns.iter().for_each(|y| *broken.entry((y.0, y.1, y.2)).or_default() += 1);
    let bare = broken.values().filter(|count| **count == woven).count() as u64;
    assert_eq!(last.eroded, bare, "eroded is what has lost every yarn");
}
