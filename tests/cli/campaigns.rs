//! `ripstop shots`, `v50`, `sweep`: what a user types, and what a kill leaves.
//!
//! Promise: files and names are those of the contract; a batch that was killed goes on to the same bytes; bad input is one error with exit
//! code 2, and nothing is written then.

use super::*;

/// A small ply in which something varies.
fn varies() -> Value {
    json!({
        "title": "small ply", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 25, "height_mm": 25},
        "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 70},
        "variability": {"hit": "unit_cell", "modulus": {"scatter": 0.05}}
    })
}

/// With few elements: what is tested is what becomes of many shots.
fn bench() -> Bench {
    let mut case = varies();
    case["pack"]["elements_per_crossover"] = json!(2);
    bench_of(&case)
}

fn bench_of(case: &Value) -> Bench {
    let bench = Bench::new(case);
    fs::create_dir(bench.path("fabrics")).unwrap();
    fs::write(bench.path("fabrics/s-720.json"), case::builtin_fabric("fabrics/s-720.json").unwrap()).unwrap();
    bench
}

const SHOTS: [&str; 8] = ["shots", "shot.json", "--count", "8", "--velocity", "50..120", "-o", "out"];

#[cfg(unix)]
#[test]
fn a_batch_that_was_killed_goes_on_to_the_same_bytes() {
    let [whole, killed] = [bench(), bench()];
    assert_eq!(code(&whole.ripstop(&SHOTS)), 0);
    let mut child = killed.command(&SHOTS).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let partial = killed.path("out/shots.csv.partial");
    let rows = || fs::read_to_string(&partial).map_or(0, |text| text.lines().count());
    let patience = Instant::now() + Duration::from_secs(120);
    while rows() < 3 && Instant::now() < patience {
        thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(rows() >= 3 && !killed.path("out/shots.csv").exists(), "killed too late or too early: {} rows", rows());
    let output = killed.ripstop(&[&SHOTS[..], &["--resume"]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    for name in ["shots.csv", "shots.json", "shots.html", "plan.json"] {
        let [one, other] = [&whole, &killed].map(|bench| fs::read(bench.path(&format!("out/{name}"))).unwrap());
        assert!(one == other, "{name}");
    }
    assert!(!partial.exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_batch_with_what_it_has() {
    let bench = bench();
    let output =
        bench.interrupt(&["shots", "shot.json", "--count", "5000", "--velocity", "50..120", "-o", "out"], "out");
    assert_eq!(code(&output), 130);
    assert!(stderr(&output).contains("--resume goes on"), "{}", stderr(&output));
    assert!(bench.path("out/shots.csv.partial").exists() && bench.path("out/plan.json").exists());
}

#[test]
fn a_shot_by_its_number_is_the_row_with_everything_a_run_writes() {
    let bench = bench();
    let text = stdout(&bench.ripstop(&SHOTS));
    assert!(
        text.contains("8 shots") && text.contains("V50") && text.contains("assumed: /variability/modulus"),
        "{text}"
    );
    let summary = bench.ripstop(&["shots", "shot.json", "--velocity", "50..120", "-o", "out", "--only", "5", "--json"]);
    let summary: Value = serde_json::from_str(&stdout(&summary)).unwrap();
    let table = fs::read_to_string(bench.path("out/shots.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().clone();
    let record = reader.records().map(Result::unwrap).find(|record| &record[0] == "5").unwrap();
    let cell = |name: &str| record.get(header.iter().position(|head| head == name).unwrap()).unwrap();
    assert_eq!(summary["outcome"], cell("outcome"));
    assert_eq!(summary["energy_gained"].as_f64().unwrap(), cell("energy_gained").parse::<f64>().unwrap());
    assert_eq!(summary["absorbed_energy_j"].as_f64().unwrap(), cell("absorbed_energy_j").parse::<f64>().unwrap());
    assert!(bench.path("out/shot-5/report.html").exists());
    // Its case, run by itself, is that shot again.
    let again = bench.ripstop(&["run", "out/shot-5/case.json", "-o", "again", "--json", "--no-report"]);
    let again: Value = serde_json::from_str(&stdout(&again)).unwrap();
    assert_eq!(again["absorbed_energy_j"], summary["absorbed_energy_j"]);
}

#[test]
fn a_limit_has_its_agreed_names_and_lies_over_measured_shots() {
    // The mesh of its accuracy, which a limit is corrected from.
    let bench = bench_of(&varies());
    let arguments = ["v50", "shot.json", "--count", "4", "--refined", "1", "--bracket", "2%", "-o", "limit"];
    let text = stdout(&bench.ripstop(&arguments));
    assert!(bench.path("limit/v50-refined.csv").exists(), "{text}");
    assert!(text.contains("4 thresholds of 4 realisations") && text.contains("of that: sampling ±"), "{text}");
    let json: Value = serde_json::from_str(&fs::read_to_string(bench.path("limit/v50.json")).unwrap()).unwrap();
    let v50 = json["v50_m_s"].as_f64().unwrap();
    assert!((50.0..90.0).contains(&v50), "{v50}");
    assert_eq!(json["realisations"], json!(4));
    assert!(fs::read_to_string(bench.path("limit/v50.html")).unwrap().contains("Thresholds"));
    assert_eq!(json["arithmetic"].as_array().unwrap().len(), 4);
    let measured =
        format!("velocity_m_s,perforated\n{},0\n{},1\n{},0\n{},1\n", v50 - 9.0, v50 - 1.0, v50 + 1.0, v50 + 9.0);
    fs::write(bench.path("range.csv"), measured).unwrap();
    let beside = bench.ripstop(&["fit", "range.csv", "--computed", "limit/v50.json", "-o", "beside"]);
    assert!(stdout(&beside).contains("computed V50"), "{}", stdout(&beside));
    assert!(fs::read_to_string(bench.path("beside/fit.svg")).unwrap().contains("dashed green: computed"));
    let wrong = bench.ripstop(&["fit", "range.csv", "--computed", "shot.json"]);
    assert!(code(&wrong) == 2 && stderr(&wrong).contains("v50.json of `ripstop v50`"), "{}", stderr(&wrong));
}

#[test]
fn a_sweep_prints_and_writes_its_points() {
    let bench = bench();
    let arguments = [
        "sweep",
        "shot.json",
        "--over",
        "/pack/plies=1,2",
        "--over",
        "/projectile/velocity_m_s=40..140:100",
        "-o",
        "out",
    ];
    let output = bench.ripstop(&arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("residual_velocity_m_s"));
    assert_eq!(fs::read_to_string(bench.path("out/sweep.csv")).unwrap().lines().count(), 5);
    let page = fs::read_to_string(bench.path("out/sweep.html")).unwrap();
    assert!(page.contains("residual_velocity_m_s over plies and velocity_m_s"));
}

#[test]
fn bad_input_is_one_error_and_nothing_is_written() {
    let bench = bench();
    for (arguments, expected) in [
        (&["shots", "shot.json", "--count", "3", "--velocity", "90..50"][..], "two velocities in m/s, the lower first"),
        (
            &[
                "shots",
                "shot.json",
                "--count",
                "3",
                "--set",
                "/projectile=null",
                "--set",
                "/solver/end_time_us=1",
                "--set",
                "/variability/hit=aimed",
            ],
            "a projectile, to be shot",
        ),
        (&["shots", "shot.json", "--count", "3", "--resume"], "the plan of a batch that was begun here"),
        (&["sweep", "shot.json", "--over", "/pack/plies=1..4"], "a range without a step"),
        (&["sweep", "shot.json", "--over", "/pack/plys=1,2"], "did you mean"),
        (&["sweep", "shot.json", "--over", "/pack/plies=1,0"], "--over /pack/plies\n"),
        (&["sweep", "shot.json", "--over", "/pack/plies=[1,2]"], "without brackets: --over /pack/plies=1,2"),
    ] {
        let output = bench.ripstop(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains(expected), "{arguments:?}: {}", stderr(&output));
        let left: Vec<_> = fs::read_dir(bench.path("out"))
            .into_iter()
            .flatten()
            .flatten()
            .flat_map(|entry| fs::read_dir(entry.path()).into_iter().flatten())
            .collect();
        assert!(left.is_empty(), "{arguments:?}: {left:?}");
    }
}
