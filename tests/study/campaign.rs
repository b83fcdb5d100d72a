//! Batches, thresholds and sweeps: what a shot gives does not depend on its company, and what was broken off ends as if it had not been.

mod ballistic_limits;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use ripstop::case::{self, Case};
use ripstop::num::link::Link;
use ripstop::output::{Folder, residual_velocity};
use ripstop::run::Precision;
use ripstop::study::batch::{BatchError, BatchOptions, order_case};
use ripstop::study::fit::FitRequest;
use ripstop::study::interval::Interval;
use ripstop::study::shots::{self, ShotsRequest};
use ripstop::study::sweep::factor::{Factor, grid};
use ripstop::study::sweep::{self, SweepOf, SweepRequest};
use tempfile::TempDir;

use crate::scene;
use ballistic_limits::{limit, v50_request};

/// A small ply.
pub(super) const SMALL: &str = r#"{"title": "small ply", "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"width_mm": 25, "height_mm": 25},
    "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 70}}"#;
const VARIES: &str =
    r#"/variability={"hit": "unit_cell", "velocity": {"scatter_m_s": 3}, "modulus": {"scatter": 0.05}}"#;
const FIT: FitRequest = FitRequest { link: Link::Probit, level: 0.9, interval: Interval::Likelihood };
static QUIET: AtomicBool = AtomicBool::new(false);

/// That case with changes, and few elements: it is shot in tens of milliseconds.
pub(super) fn small(sets: &[&str]) -> Case {
    of_its_accuracy(&[&["/pack/elements_per_crossover=2"], sets].concat())
}

/// The same on the mesh that its accuracy asks for.
fn of_its_accuracy(sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    case::from_str("small", SMALL, &sets).unwrap()
}

fn options(threads: usize) -> BatchOptions<'static> {
    BatchOptions { seed: 3, threads, threads_per_shot: 1, precision: Precision::F64, device: None, interrupt: &QUIET }
}

fn shots_request(count: u32) -> ShotsRequest {
    ShotsRequest { count, velocity: Some([40.0, 140.0]), until_width: None, fit: FIT }
}

fn folder(path: &Path) -> Folder {
    Folder::prepare_for(path, &[], &[]).unwrap()
}

/// Every file of a folder.
fn files(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(path).unwrap().map(Result::unwrap).filter(|entry| entry.path().is_file()) {
        found.insert(entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).unwrap());
    }
    found.remove(".ripstop.lock");
    found
}

fn fire(case: &Case, count: u32, threads: usize, path: &Path, resume: bool) -> Result<shots::ShotsResult, BatchError> {
    shots::run(case, &shots_request(count), &options(threads), &folder(path), resume, &mut |_| {})
}

#[test]
fn a_shot_of_a_batch_is_the_shot_alone_bit_by_bit() {
    let case = small(&[VARIES]);
    let [one, other] = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let rows = fire(&case, 6, 2, one.path(), false).unwrap().rows;
    assert_eq!(rows.len(), 6);
    for number in [0, 3, 5] {
        let order = shots::order(&shots_request(1), 3, number);
        let alone = order_case(&case, 3, order).unwrap();
        let run = scene::run(&alone);
        let row = &rows[number as usize];
        assert_eq!(row.outcome, Some(run.outcome));
        assert_eq!(row.residual, residual_velocity(&alone, &run));
        assert_eq!((row.velocity, &row.drawn), (alone.projectile.as_ref().unwrap().velocity, &alone.drawn));
    }
    // Neither company nor threads change a table.
    fire(&case, 3, 1, other.path(), false).unwrap();
    let [long, short] = [one, other].map(|folder| fs::read_to_string(folder.path().join("shots.csv")).unwrap());
    let cut: String = long.lines().take(4).map(|line| format!("{line}\n")).collect();
    assert_eq!(cut, short);
}

#[test]
fn a_batch_that_was_broken_off_anywhere_ends_as_if_it_had_not_been() {
    let case = small(&[VARIES]);
    let whole = TempDir::new().unwrap();
    fire(&case, 5, 2, whole.path(), false).unwrap();
    let expected = files(whole.path());
    let table = &expected["shots.csv"];
    assert!(!expected.contains_key("shots.csv.partial"));
    // Rows as they were appended by another order of ends, cut anywhere: within the heading, a number, a line's end.
    let lines: Vec<&[u8]> = table.split_inclusive(|byte| *byte == b'\n').collect();
    let appended = [lines[0], lines[3], lines[1], lines[5], lines[2], lines[4]].concat();
    let ends: Vec<usize> = (0..appended.len()).filter(|at| at % 97 == 0 || appended[*at] == b'\n').collect();
    for end in ends.into_iter().chain([appended.len()]) {
        let broken = TempDir::new().unwrap();
        fs::write(broken.path().join("plan.json"), &expected["plan.json"]).unwrap();
        fs::write(broken.path().join("shots.csv.partial"), &appended[..end]).unwrap();
        fire(&case, 5, 1, broken.path(), true).unwrap();
        assert!(files(broken.path()) == expected, "cut at byte {end}");
    }
}

#[test]
fn an_interrupted_batch_keeps_its_rows_and_goes_on() {
    let case = small(&[VARIES]);
    let [whole, broken] = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    fire(&case, 6, 2, whole.path(), false).unwrap();
    let stop = AtomicBool::new(false);
    let options = BatchOptions { interrupt: &stop, ..options(2) };
    let run = |resume: bool, after: u32| {
        let mut progress = |at: shots::BatchProgress<'_>| {
            if at.done >= after {
                stop.store(true, Ordering::Relaxed);
            }
        };
        shots::run(&case, &shots_request(6), &options, &folder(broken.path()), resume, &mut progress)
    };
    assert!(matches!(run(false, 2), Err(BatchError::Interrupted)));
    let kept = fs::read_to_string(broken.path().join("shots.csv.partial")).unwrap();
    assert!((2..6).contains(&kept.lines().skip(1).count()), "{kept}");
    stop.store(false, Ordering::Relaxed);
    run(true, 99).unwrap();
    assert_eq!(files(broken.path()), files(whole.path()));
    // And once more: nothing is left to do.
    run(true, 99).unwrap();
    assert_eq!(files(broken.path()), files(whole.path()));
}

#[test]
fn only_the_same_batch_goes_on() {
    let place = TempDir::new().unwrap();
    fire(&small(&[VARIES]), 2, 2, place.path(), false).unwrap();
    let error = |case: &Case, options: &BatchOptions<'_>, path: &Path| {
        let error = shots::run(case, &shots_request(2), options, &folder(path), true, &mut |_| {}).unwrap_err();
        error.to_string()
    };
    let heavier = small(&[VARIES, "/projectile/mass_g=0.6"]);
    assert!(error(&heavier, &options(1), place.path()).contains("another case"));
    let seed = BatchOptions { seed: 4, ..options(1) };
    assert!(error(&small(&[VARIES]), &seed, place.path()).contains("expected: seed 4"));
    let empty = TempDir::new().unwrap();
    let error = error(&small(&[VARIES]), &options(1), empty.path());
    assert!(error.contains("the plan of a batch that was begun here") && error.contains("help:"), "{error}");
    // The rows that are there stay.
    assert_eq!(fs::read_to_string(place.path().join("shots.csv")).unwrap().lines().count(), 3);
}

#[test]
fn a_shot_that_fails_is_a_row_with_a_reason() {
    // A crimp far below zero is drawn now and then.
    let case =
        small(&[r#"/variability={"crimp": {"scatter": 0.5}}"#, "/fabric/warp/crimp=0.0001", "/solver/end_time_us=60"]);
    let place = TempDir::new().unwrap();
    let found = fire(&case, 60, 2, place.path(), false).unwrap();
    let failed: Vec<_> = found.rows.iter().filter(|row| row.outcome.is_none()).collect();
    assert!(!failed.is_empty() && failed.len() < 40, "{}", failed.len());
    assert!(failed.iter().all(|row| row.reason.contains("crimp") && row.reason.contains("expected")), "{failed:?}");
    assert!(found.rows.iter().any(|row| row.reason.contains("undecided")));
    // `ripstop fit` reads the table: shots without an outcome do not count.
    let rows = ripstop::study::fit::read(&place.path().join("shots.csv")).unwrap();
    let decided = found.rows.iter().filter(|row| row.perforated().is_some()).count() as u64;
    assert_eq!(rows.iter().map(|row| row.count).sum::<u64>(), decided);
}

/// Nothing can be drawn of such shots; what there is to say is said.
#[test]
fn shots_without_any_outcome_end_in_rows_with_a_reason() {
    let case = small(&["/solver/end_time_us=2"]);
    let shots = fire(&case, 3, 2, TempDir::new().unwrap().path(), false).unwrap();
    assert!(shots.rows.len() == 3 && shots.rows.iter().all(|row| row.reason.contains("undecided")), "{:?}", shots.rows);
    let found = limit(&case, &v50_request(2), 2, TempDir::new().unwrap().path(), false);
    assert!(found.v50.is_none() && found.failed > 0, "{found:?}");
    let of = SweepOf::Shots(ShotsRequest { count: 1, velocity: None, until_width: None, fit: FIT });
    let request = SweepRequest {
        factors: vec![Factor::parse("/pack/plies=1,2").unwrap()],
        level: 0.9,
        points: vec![vec!["1".to_owned()], vec!["2".to_owned()]],
        cases: vec![(case.clone(), of), (small(&["/solver/end_time_us=2", "/pack/plies=2"]), of)],
    };
    let out = TempDir::new().unwrap();
    let swept = sweep::run(&request, &options(2), &folder(out.path()), false, "small ply", &|_| {}).unwrap();
    assert!(swept.points.iter().all(|point| point.reason.contains("undecided")), "{swept:?}");
}

#[test]
fn velocities_fill_their_range_and_a_narrow_interval_ends_a_batch() {
    let request = shots_request(40);
    let mut velocities: Vec<f64> = (0..40).filter_map(|shot| shots::order(&request, 3, shot).velocity).collect();
    velocities.sort_by(f64::total_cmp);
    assert!(
        velocities[0] < 45.0 && velocities[39] > 135.0 && velocities.windows(2).all(|pair| pair[1] - pair[0] < 5.0)
    );
    let place = TempDir::new().unwrap();
    let request = ShotsRequest { until_width: Some(0.3), ..request };
    let found =
        shots::run(&small(&[VARIES]), &request, &options(2), &folder(place.path()), false, &mut |_| {}).unwrap();
    assert!(found.early && found.rows.len() < 40, "{}", found.rows.len());
    let v50 = found.fit.v50().unwrap();
    assert!(0.5 * (v50.bounds.high.unwrap() - v50.bounds.low.unwrap()) <= 0.3 * v50.value.unwrap());
}

#[test]
fn a_sweep_has_a_row_for_every_point_and_goes_on() {
    let factors: Vec<Factor> = ["/pack/plies=1,2", "/projectile/velocity_m_s=30..230:100"]
        .iter()
        .map(|text| Factor::parse(text).unwrap())
        .collect();
    let points = grid(&factors).unwrap();
    let of = |values: &Vec<String>| {
        let sets: Vec<String> =
            factors.iter().zip(values).map(|(factor, value)| format!("{}={value}", factor.pointer)).collect();
        let case = small(&sets.iter().map(String::as_str).collect::<Vec<_>>());
        (case, SweepOf::Shots(ShotsRequest { count: 1, velocity: None, until_width: None, fit: FIT }))
    };
    let cases = points.iter().map(of).collect();
    let request = SweepRequest { factors: factors.clone(), level: 0.9, points, cases };
    let seen = Mutex::new(0);
    let run = |path: &Path, resume: bool| {
        let count = |done: usize| *seen.lock().unwrap() = done;
        sweep::run(&request, &options(2), &folder(path), resume, "small ply", &count).unwrap()
    };
    let [whole, broken] = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let results = run(whole.path(), false);
    assert_eq!((results.points.len(), *seen.lock().unwrap()), (6, 6));
    let residual: Vec<f64> = results.points.iter().map(|result| result.numbers[0].unwrap()).collect();
    assert!(residual[0] == 0.0 && residual[1] > residual[4] && residual[5] > 0.0, "{residual:?}");
    let table = fs::read_to_string(whole.path().join("sweep.csv")).unwrap();
    assert!(table.starts_with("point,/pack/plies,/projectile/velocity_m_s,residual_velocity_m_s,"), "{table}");
    // Half of the points, one of them without its end.
    run(broken.path(), false);
    for point in ["0003", "0005"] {
        fs::remove_dir_all(broken.path().join("points").join(point)).unwrap();
    }
    for name in ["sweep.csv", "points/0001/shots.csv"] {
        fs::remove_file(broken.path().join(name)).unwrap();
    }
    run(broken.path(), true);
    assert_eq!(files(broken.path()), files(whole.path()));
}
