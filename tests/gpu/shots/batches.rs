//! Many shots in one dispatch: each gives the bits that it gives alone, whatever its neighbours are and
//! whatever becomes of them.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use ripstop::case::{Backing, BackingMaterial, Case};
use ripstop::gpu::Device;
use ripstop::output::Folder;
use ripstop::run::batch::{DeviceBatch, PreparedShot};
use ripstop::run::{Precision, Run};
use ripstop::study::batch::{Batch, BatchError, BatchOptions, ShotOrder};
use ripstop::study::shots::ShotRow;
use tempfile::TempDir;

use super::endings::edges;
use super::{Outcome, Tests, run_until};
use crate::support::{pack, ply, quarter, result, shipped};

pub(super) const TESTS: Tests = &[
    ("shots_of_a_batch_are_what_they_are_alone", each_as_alone),
    ("rows_do_not_depend_on_the_batch", rows),
    ("an_interrupt_gives_up_what_is_under_way", interrupted),
];

/// A case at other velocities [m/s].
fn at(case: &Case, velocities: &[f64]) -> Vec<Case> {
    let at = |velocity: &f64| {
        let mut case = case.clone();
        case.projectile.as_mut().unwrap().velocity = *velocity;
        case
    };
    velocities.iter().map(at).collect()
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
        assert!(results[number].is_empty(), "reported twice");
        results[number] = result(&cases[number], run);
        true
    };
    assert_eq!(batch.fire(&shots, &AtomicBool::new(false), &mut ended), Ok(true));
    results
}

fn each_as_alone(device: &'static Device) -> Outcome {
    let mut clay = pack();
    clay.backing = Some(Backing { material: BackingMaterial::Clay, gap: 0.0, pressure: 0.71e6, doubling_depth: None });
    for (case, velocities) in [
        // One whose numbers blow up ends alone.
        (ply(), &[400.0, 250.0, 1e30, 400.5][..]),
        (pack(), &[500.0, 350.0, 650.0]),
        (clay, &[500.0, 350.0]),
        (quarter(), &[350.0, 140.0, 250.0]),
        (edges(), &[400.0, 550.0]),
    ] {
        let cases = at(&case, velocities);
        let runs: Vec<Run> = cases.iter().map(|case| run_until(device, case, &AtomicBool::new(false))).collect();
        for (velocity, run) in velocities.iter().zip(&runs) {
            assert_eq!(run.divergence.is_some(), *velocity > 1e6, "{velocity} m/s");
        }
        assert!(runs.iter().any(|run| !run.events.is_empty()), "nothing has failed");
        let alone: Vec<_> = cases.iter().zip(&runs).map(|(case, run)| result(case, run)).collect();
        let room = cases.len() as u64 + 1;
        let mut batch = DeviceBatch::new(device, &prepared(&cases[0]), room).map_err(|e| e.to_string())?;
        assert!(together(&mut batch, &cases) == alone, "{velocities:?} together");
        // With other neighbours, in another place, and after a batch that has left its traces.
        let turned = together(&mut batch, &[cases[1].clone(), cases[0].clone()]);
        assert!(turned == [alone[1].clone(), alone[0].clone()], "{velocities:?} turned");
        assert!(batch.room() == room && batch.bytes() > 0);
    }
    Ok(())
}

fn options<'a>(device: &'a Device, interrupt: &'a AtomicBool) -> BatchOptions<'a> {
    let (seed, precision, progress) = (3, Precision::F32, &|_| {});
    BatchOptions {
        seed,
        threads: 1,
        threads_per_shot: 1,
        precision,
        device: Some(device),
        interrupt,
        resume: false,
        progress,
    }
}

fn folder(path: &Path) -> Folder {
    Folder::prepare_for(path, &[], &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// Shots in an empty folder until the end, or the first row where `once` is set: how they ended, their rows, and how many the device computed
/// at a time at most.
fn fired(
    device: &Device,
    case: &Case,
    shots: &[(u32, f64)],
    once: bool,
) -> (Result<(), BatchError>, Vec<ShotRow>, u64) {
    let (place, stop) = (TempDir::new().unwrap(), AtomicBool::new(false));
    let folder = folder(place.path());
    let orders: Vec<ShotOrder> =
        shots.iter().map(|(shot, velocity)| ShotOrder { shot: *shot, velocity: Some(*velocity) }).collect();
    let batch = Batch::open(case.clone(), &options(device, &stop), &folder, "shots.csv").unwrap();
    let ended = batch.fire(&orders, 1, &|_| stop.store(once, Ordering::Relaxed));
    let rows = batch.table().rows(u32::MAX).cloned().collect();
    (ended, rows, batch.room())
}

/// A small ply that differs from shot to shot.
fn varied(sets: &[&str]) -> Case {
    let small = ["/pack/width_mm=25.4", "/pack/height_mm=25.4", "/pack/elements_per_crossover=2", "/expect=[]"];
    shipped("cases/s720-1ply-155.json", &[&small[..], sets].concat())
}

fn rows(device: &'static Device) -> Outcome {
    const STRENGTH: &str = r#"/variability={"velocity": {"scatter_m_s": 5}, "obliquity": {"scatter_deg": 1},
        "yarn_strength": {"shape": 11.5, "gauge_length_mm": 125, "yarn_shape": 20}}"#;
    let case = varied(&[STRENGTH, "/solver/end_time_us=20"]);
    // The third is faster than any case may ask for.
    let shots = [(0, 400.0), (1, 300.0), (2, 1e6), (3, 500.0)];
    let (ended, all, at_a_time) = fired(device, &case, &shots, false);
    ended.map_err(|e| e.to_string())?;
    assert_eq!((all.len(), at_a_time), (4, 3), "those that can be set up go together");
    assert!(all[2].outcome.is_none() && all[2].reason.contains("velocity"), "{:?}", all[2]);
    assert!(all.iter().all(|row| row.order.shot == 2 || row.outcome.is_some()), "{all:?}");
    for (number, shot) in shots.iter().enumerate() {
        assert_eq!(fired(device, &case, &[*shot], false).1, [all[number].clone()], "shot {number} alone");
    }
    assert_eq!(fired(device, &case, &[shots[3], shots[1]], false).1, [all[1].clone(), all[3].clone()]);
    // Other moduli give another time step: each has pipelines of its own.
    let case = varied(&[r#"/variability={"modulus": {"scatter": 0.05}}"#, "/solver/end_time_us=10"]);
    let (_, rows, at_a_time) = fired(device, &case, &shots[..2], false);
    assert_eq!((rows.len(), at_a_time), (2, 1));
    assert_eq!(fired(device, &case, &shots[1..2], false).1, rows[1..]);
    Ok(())
}

fn interrupted(device: &'static Device) -> Outcome {
    let (ended, rows, _) = fired(device, &varied(&["/solver/end_time_us=200"]), &[(0, 900.0), (1, 60.0)], true);
    match ended {
        Err(BatchError::Interrupted) if rows.len() == 1 => Ok(()),
        other => Err(format!("{} rows, {other:?}", rows.len())),
    }
}
