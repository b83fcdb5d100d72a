//! Many shots in one dispatch: each gives the bits that it gives alone, whatever its neighbours are and whatever becomes of them.

use std::sync::atomic::{AtomicBool, Ordering};

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::output::Folder;
use ripstop::run::batch::{DeviceBatch, PreparedShot};
use ripstop::run::{Precision, Run};
use ripstop::study::batch::{Batch, BatchError, BatchOptions, ShotOrder};
use ripstop::study::shot_table::ShotRow;
use tempfile::TempDir;

use super::{Outcome, Tests, resume, run_on, run_until};
use crate::kept::{pack, ply, quarter, result};
use crate::scene::shipped;

pub(super) const TESTS: Tests = &[
    ("a_ply_is_what_it_is_alone", |device| each_as_alone(device, &ply(), &[400.0, 250.0, 600.0, 400.5])),
    ("a_pack_is_what_it_is_alone", |device| each_as_alone(device, &pack(), &[500.0, 350.0, 650.0])),
    ("a_quarter_is_what_it_is_alone", |device| each_as_alone(device, &quarter(), &[350.0, 140.0, 250.0])),
    ("contact_at_the_rim_is_what_it_is_alone", |device| each_as_alone(device, &resume::rim(), &[400.0, 550.0])),
    ("one_that_goes_bad_ends_alone", one_goes_bad),
    ("rows_do_not_depend_on_the_batch", rows),
    ("what_cannot_go_together_goes_alone", apart),
    ("an_interrupt_gives_up_what_is_under_way", interrupted),
];

/// A case at another velocity [m/s].
fn at(case: &Case, velocity: f64) -> Case {
    let mut case = case.clone();
    if let Some(projectile) = &mut case.projectile {
        projectile.velocity = velocity;
    }
    case
}

fn prepared(case: &Case) -> PreparedShot {
    PreparedShot::new(case.clone()).unwrap_or_else(|e| panic!("{e}"))
}

/// Everything that shots gave, in their order.
fn together(batch: &mut DeviceBatch<'_>, cases: &[Case]) -> Vec<Vec<String>> {
    let shots: Vec<PreparedShot> = cases.iter().map(prepared).collect();
    assert!(batch.takes(&shots[0], shots.len()));
    let mut results = vec![Vec::new(); cases.len()];
    let mut ended = |number: usize, run: &Run| {
        assert!(results[number].is_empty(), "told twice");
        results[number] = result(&cases[number], run);
        true
    };
    assert_eq!(batch.fire(&shots, &AtomicBool::new(false), &mut ended), Ok(true));
    results
}

fn same(found: &[String], expected: &[String], what: &str) {
    for (one, two) in found.iter().zip(expected) {
        assert_eq!(one, two, "{what}");
    }
    assert_eq!(found.len(), expected.len(), "{what}");
}

fn each_as_alone(device: &'static Device, case: &Case, velocities: &[f64]) -> Outcome {
    let cases: Vec<Case> = velocities.iter().map(|velocity| at(case, *velocity)).collect();
    let alone: Vec<_> = cases.iter().map(|case| result(case, &run_on(device, case))).collect();
    assert!(alone.iter().any(|rows| rows.iter().any(|row| row.starts_with("FailureEvent"))), "nothing has failed");
    let room = cases.len() as u64 + 1;
    let mut batch = DeviceBatch::new(device, &prepared(&cases[0]), room).map_err(|e| e.to_string())?;
    for (found, expected) in together(&mut batch, &cases).iter().zip(&alone) {
        same(found, expected, "among others");
    }
    // With other neighbours, in another place, and after a batch that has left its traces.
    let turned = together(&mut batch, &[cases[1].clone(), cases[0].clone()]);
    same(&turned[0], &alone[1], "in front");
    same(&turned[1], &alone[0], "behind");
    let used = batch.device_use();
    assert_eq!((used.shots, used.room), (cases.len() as u64 + 2, room));
    assert!(used.dispatches > 0 && used.bytes > 0);
    Ok(())
}

fn one_goes_bad(device: &'static Device) -> Outcome {
    let cases = [400.0, 1e30, 300.0].map(|velocity| at(&ply(), velocity));
    let alone = cases.clone().map(|case| run_until(device, &case, &AtomicBool::new(false)));
    let bad: Vec<bool> = alone.iter().map(|run| run.divergence.is_some()).collect();
    assert_eq!(bad, [false, true, false]);
    let mut batch = DeviceBatch::new(device, &prepared(&cases[0]), 3).map_err(|e| e.to_string())?;
    let found = together(&mut batch, &cases);
    for ((found, case), run) in found.iter().zip(&cases).zip(&alone) {
        same(found, &result(case, run), "with one that goes bad");
    }
    Ok(())
}

pub(super) fn options<'a>(device: &'a Device, interrupt: &'a AtomicBool, resume: bool) -> BatchOptions<'a> {
    let (seed, precision, progress) = (3, Precision::F32, &|_| {});
    BatchOptions { seed, threads: 1, threads_per_shot: 1, precision, device: Some(device), interrupt, resume, progress }
}

/// Fires shots in an empty folder until `stop` is raised, which the first row does where `once` is set.
fn fire(
    device: &Device,
    case: &Case,
    orders: &[ShotOrder],
    stop: &AtomicBool,
    once: bool,
) -> (Result<(), BatchError>, Vec<ShotRow>, u64) {
    let place = TempDir::new().unwrap();
    let folder = Folder::prepare_for(place.path(), &[], &[]).unwrap();
    let batch = Batch::open(case.clone(), &options(device, stop, false), &folder, "shots.csv").unwrap();
    let ended = batch.fire(orders, 1, &|_| stop.store(once, Ordering::Relaxed));
    let rows = batch.table().rows(u32::MAX).cloned().collect();
    (ended, rows, batch.device_use().room)
}

fn order(shot: u32, velocity: f64) -> ShotOrder {
    ShotOrder { shot, velocity: Some(velocity) }
}

/// Rows by shot, and how many the device computed at a time at most.
fn fired(device: &Device, case: &Case, orders: &[ShotOrder]) -> (Vec<ShotRow>, u64) {
    let (ended, rows, room) = fire(device, case, orders, &AtomicBool::new(false), false);
    ended.unwrap_or_else(|e| panic!("{e}"));
    (rows, room)
}

/// A small ply whose yarns differ in strength from shot to shot.
fn varied(sets: &[&str]) -> Case {
    let elements = "/pack/elements_per_crossover=2";
    let small = ["/pack/width_mm=25.4", "/pack/height_mm=25.4", elements, "/solver/end_time_us=40", "/expect=[]"];
    shipped("cases/s720-1ply-155.json", &[&small[..], sets].concat())
}

const STRENGTH: &str = r#"/variability={"velocity": {"scatter_m_s": 5}, "obliquity": {"scatter_deg": 1},
    "yarn_strength": {"shape": 11.5, "gauge_length_mm": 125, "yarn_shape": 20}}"#;

fn rows(device: &'static Device) -> Outcome {
    let case = varied(&[STRENGTH]);
    // The third is faster than any case may ask for.
    let orders = [order(0, 400.0), order(1, 300.0), order(2, 1e6), order(3, 500.0)];
    let (all, at_a_time) = fired(device, &case, &orders);
    assert_eq!(all.len(), 4);
    assert_eq!(at_a_time, 3, "those that can be set up go together");
    assert!(all[2].outcome.is_none() && all[2].reason.contains("velocity"), "{:?}", all[2]);
    assert!(all.iter().all(|row| row.order.shot == 2 || row.outcome.is_some()), "{all:?}");
    for (number, order) in orders.iter().enumerate() {
        assert_eq!(fired(device, &case, &[*order]).0, [all[number].clone()], "shot {number} alone");
    }
    assert_eq!(fired(device, &case, &[orders[3], orders[1]]).0, [all[1].clone(), all[3].clone()]);
    Ok(())
}

/// Other moduli give another time step.
fn apart(device: &'static Device) -> Outcome {
    let case = varied(&[r#"/variability={"modulus": {"scatter": 0.05}}"#, "/solver/end_time_us=10"]);
    let orders = [order(0, 300.0), order(1, 300.0)];
    let (rows, at_a_time) = fired(device, &case, &orders);
    assert_eq!((rows.len(), at_a_time), (2, 1));
    assert_eq!(fired(device, &case, &orders[1..]).0, rows[1..]);
    Ok(())
}

fn interrupted(device: &'static Device) -> Outcome {
    let stop = AtomicBool::new(false);
    let orders = [order(0, 900.0), order(1, 60.0)];
    let case = varied(&["/solver/end_time_us=200"]);
    let (fired, rows, _) = fire(device, &case, &orders, &stop, true);
    match fired {
        Err(BatchError::Interrupted) if rows.len() == 1 => Ok(()),
        other => Err(format!("{} rows, {other:?}", rows.len())),
    }
}
