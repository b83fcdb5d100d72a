//! Ballistic limits and sweeps on the device: their shots go together, and each is what it is alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use ripstop::case::{self, Case};
use ripstop::gpu::Device;
use ripstop::num::link::Link;
use ripstop::output::{Folder, residual_velocity};
use ripstop::study::batch::{ShotOrder, order_case};
use ripstop::study::fit::FitRequest;
use ripstop::study::shots::ShotsRequest;
use ripstop::study::sweep::{self, Factor, SweepOf, SweepRequest, grid};
use ripstop::study::v50::{self, V50Request};
use ripstop::study::v50_result::V50Result;
use tempfile::TempDir;

use super::together::options;
use super::{Outcome, Tests, program, run_on};
use crate::kept::{files, same_files};

pub(super) const TESTS: Tests = &[
    ("shots_of_thresholds_go_together_and_are_what_they_are_alone", thresholds),
    ("searches_whose_shots_cannot_go_together_take_turns", turns),
    ("points_of_a_sweep_go_together_and_are_what_they_are_alone", points),
    ("another_backend_does_not_go_on", other_backend),
];

const TINY: &str = r#"{"title": "tiny ply", "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"width_mm": 7.62, "height_mm": 7.62},
    "projectile": {"shape": "sphere", "diameter_mm": 3, "mass_g": 0.05, "velocity_m_s": 120}}"#;
const VARIES: &str = r#"/variability={"obliquity": {"scatter_deg": 1},
    "yarn_strength": {"shape": 11.5, "gauge_length_mm": 125, "yarn_shape": 20}}"#;
const FIT: FitRequest = FitRequest { link: Link::Probit, level: 0.9 };

fn tiny(sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    case::from_str("tiny", TINY, &sets).unwrap_or_else(|e| panic!("{e}"))
}

fn folder(path: &Path) -> Folder {
    Folder::prepare_for(path, &[], &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// The limit of a case on a device, and what lies in its folder.
fn limit(device: &Device, case: &Case, request: &V50Request, path: &Path, resume: bool) -> V50Result {
    let quiet = AtomicBool::new(false);
    let found = v50::run(case, request, &options(device, &quiet, resume), &folder(path));
    found.unwrap_or_else(|e| panic!("{e}"))
}

fn request(count: u32, refined: u32) -> V50Request {
    V50Request { count, until_width: None, bracket: 0.1, refined, level: 0.9 }
}

/// Every third row of a table is what the device makes of that shot of the case alone; how many rows there are.
fn each_as_alone(device: &Device, case: &Case, table: &Path) -> u64 {
    let mut reader = csv::Reader::from_path(table).unwrap();
    let rows: Vec<BTreeMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    for row in rows.iter().step_by(3) {
        let velocity = row["asked_velocity_m_s"].parse().unwrap();
        let order = ShotOrder { shot: row["shot"].parse().unwrap(), velocity: Some(velocity) };
        let shot = order_case(case, 3, order).unwrap();
        let run = run_on(device, &shot);
        let passed = row["perforated"] == "1";
        let residual = residual_velocity(&shot, &run).filter(|_| passed).map(|v| format!("{v}")).unwrap_or_default();
        let alone = [run.outcome.word().to_owned(), run.steps.to_string(), residual, format!("{}", run.energy_error)];
        let found = ["outcome", "steps", "residual_velocity_m_s", "energy_error"].map(|name| row[name].clone());
        let numbers = |cells: &[String]| cells.iter().map(|cell| cell.parse::<f64>().ok()).collect::<Vec<_>>();
        assert_eq!((&found[0], numbers(&found)), (&alone[0], numbers(&alone)), "{order:?}");
    }
    rows.len() as u64
}

fn thresholds(device: &'static Device) -> Outcome {
    let case = tiny(&[VARIES]);
    let [whole, broken] = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let request = request(2, 1);
    let found = limit(device, &case, &request, whole.path(), false);
    assert!(found.thresholds.iter().all(Result::is_ok) && found.refinement.is_some(), "{found:?}");
    let tables = ["v50.csv", "v50-refined.csv"].map(|name| whole.path().join(name));
    let finer = tiny(&[VARIES, "/solver/accuracy=converged"]);
    let shots = each_as_alone(device, &case, &tables[0]);
    let refined = each_as_alone(device, &finer, &tables[1]);
    assert!(shots > 12 && refined > 3 && (found.shots as u64, found.refined_shots as u64) == (shots, refined));
    assert_eq!((found.device.shots, found.device.room), (shots + refined, 2), "realisations together");
    // An end among the shots of both meshes changes nothing; what is there is not fired again.
    fs::copy(whole.path().join("plan.json"), broken.path().join("plan.json")).unwrap();
    for table in &tables {
        let text = fs::read_to_string(table).unwrap();
        let partial = broken.path().join(format!("{}.partial", table.file_name().unwrap().display()));
        fs::write(partial, &text[..3 * text.len() / 4]).unwrap();
    }
    let again = limit(device, &case, &request, broken.path(), true);
    same_files(&files(broken.path()), &files(whole.path()));
    assert!((2..shots).contains(&again.device.shots), "{} of {shots} shots", again.device.shots);
    Ok(())
}

/// Other moduli give another time step: each realisation has pipelines of its own, and its search comes back to them.
fn turns(device: &'static Device) -> Outcome {
    let (case, place) = (tiny(&[r#"/variability={"modulus": {"scatter": 0.05}}"#]), TempDir::new().unwrap());
    let found = limit(device, &case, &request(2, 0), place.path(), false);
    let shots = each_as_alone(device, &case, &place.path().join("v50.csv"));
    assert!(shots > 8 && found.thresholds.iter().all(Result::is_ok), "{found:?}");
    assert_eq!((found.device.shots, found.device.room), (shots, 1));
    Ok(())
}

fn points(device: &'static Device) -> Outcome {
    let factors = vec![Factor::parse("/projectile/velocity_m_s=100,200,300").map_err(|e| e.to_string())?];
    let at = |values: Vec<String>| {
        let case = tiny(&[&format!("/projectile/velocity_m_s={}", values[0])]);
        (values, case)
    };
    let points = grid(&factors).map_err(|e| e.to_string())?.into_iter().map(at).collect();
    let of = SweepOf::Shots(ShotsRequest { count: 1, velocity: None, until_width: None, fit: FIT });
    let request = SweepRequest { factors, level: 0.9, of, points };
    let quiet = AtomicBool::new(false);
    let run = |path: &Path, resume: bool| {
        let swept = sweep::run(&request, &options(device, &quiet, resume), &folder(path), "tiny ply");
        swept.unwrap_or_else(|e| panic!("{e}"))
    };
    let [whole, broken] = [TempDir::new().unwrap(), TempDir::new().unwrap()];
    let swept = run(whole.path(), false);
    assert_eq!((swept.device.shots, swept.device.room), (3, 3), "one batch");
    for (number, (point, (_, case))) in swept.points.iter().zip(&request.points).enumerate() {
        assert_eq!(point[1].as_f64(), residual_velocity(case, &run_on(device, case)), "point {number}");
        let table = whole.path().join(format!("points/{number:04}/shots.csv"));
        assert!(table.exists() && !table.with_extension("csv.partial").exists());
    }
    assert!(swept.points[0][1] == 0.0 && swept.points[2][1].as_f64() > Some(50.0), "{swept:?}");
    // Of two points that are gone each is fired again.
    run(broken.path(), false);
    for point in ["0000", "0002"] {
        fs::remove_dir_all(broken.path().join("points").join(point)).unwrap();
    }
    assert_eq!(run(broken.path(), true).device.shots, 2);
    same_files(&files(broken.path()), &files(whole.path()));
    Ok(())
}

fn other_backend(device: &'static Device) -> Outcome {
    let out = TempDir::new().unwrap();
    let sets = ["--set", "/solver/end_time_us=4", "--set", "/expect=[]"];
    let v50 = ["v50", program::CASE, "--count", "1", "--refined", "0"];
    let sweep = ["sweep", program::CASE, "--over", "/projectile/velocity_m_s=300"];
    for (name, command) in [("v50", &v50[..]), ("sweep", &sweep[..])] {
        let path = out.path().join(name);
        let run =
            |more: &[&str]| program::ripstop(&[command, &sets, &["--out", path.to_str().unwrap()], more].concat());
        let begun = run(&["--backend", "gpu"]);
        let text = program::text(&begun.stdout);
        assert_eq!(begun.status.code(), Some(0), "{}", program::text(&begun.stderr));
        assert!(text.contains("GPU: 1 shots, up to 1 at a time;"), "{text}");
        let refused = run(&["--backend", "cpu", "--precision", "f32", "--resume"]);
        let message = program::text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{message}");
        assert!(message.contains(r#"expected: options {"backend":"cpu"}"#), "{message}");
        assert!(message.contains(&format!(r#"found: options {{"backend":"gpu","adapter":"{}"}}"#, device.name())));
        let again = run(&["--backend", "gpu", "--precision", "f32", "--resume"]);
        assert_eq!(again.status.code(), Some(0), "{}", program::text(&again.stderr));
    }
    Ok(())
}
