//! What a run leaves in its folder.

use super::*;

const SUMMARY: [&str; 59] = [
    "trust",
    "notes",
    "residual_velocity_scatter_m_s",
    "broken_yarns",
    "failures_at",
    "outcome",
    "residual_velocity_m_s",
    "rebound_velocity_m_s",
    "carried_velocity_m_s",
    "stop_time_us",
    "absorbed_energy_j",
    "max_deflection_mm",
    "max_penetration_mm",
    "max_ply_penetration_mm",
    "last_ply_deflection_mm",
    "perforated_plies",
    "plies",
    "energy_error",
    "momentum_error",
    "hourglass_fraction",
    "failed_yarns",
    "eroded_elements",
    "energy_gained",
    "law_energy_j",
    "ply_separation_j",
    "viscous_dissipation_j",
    "breaking_load_ratio",
    "newton",
    "elements",
    "steps",
    "time_step_us",
    "element_steps",
    "element_steps_computed",
    "wall_s",
    "loop_s",
    "element_steps_per_s",
    "skipped",
    "backend",
    "adapter",
    "threads",
    "precision",
    "version",
    "case_hash",
    "assumed",
    "warnings",
    "timings",
    "expect",
    "interrupted",
    "unstable",
    "device_lost",
    "checkpoint_failed",
    "terms",
    "host_overhead_s",
    "time_step_set_by",
    "peak_yarn_tension_n",
    "peak_contact_force_n",
    "title",
    "case",
    "time_us",
];
const HISTORY: &str = "time_us,projectile_velocity_m_s,projectile_displacement_mm,contact_force_n,\
    kinetic_energy_j,internal_energy_j,hourglass_energy_j,contact_dissipation_j,friction_j,failure_energy_j,\
    projectile_energy_j,energy_error,failed_warp,failed_weft,stored_energy_j,external_work_j,eroded_elements,\
    max_deflection_mm,max_yarn_tension_n,momentum_error,perforated_plies,viscous_dissipation_j,\
    energy_gained,law_energy_j,last_ply_deflection_mm,ply_separation_j";

fn rows(text: &str) -> Vec<Vec<String>> {
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

#[test]
fn a_run_leaves_the_files_of_the_contract_and_nothing_else() {
    let bench = Bench::new(&small_with("/output/profile_times_us", json!([2, 8])));
    let output = bench.shoot(&[]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let expected =
        ["case.json", "events.csv", "history.csv", "profiles.csv", "report.html", "shot.svg", "summary.json"];
    assert_eq!(bench.names("out/shot"), expected);
    let summary = bench.json("out/shot/summary.json");
    for key in SUMMARY {
        assert!(summary.get(key).is_some(), "{key}");
    }
    assert_eq!(summary.as_object().unwrap().len(), SUMMARY.len());
    assert_eq!(summary["backend"], "cpu");
    for key in ["adapter", "host_overhead_s", "device_lost", "checkpoint_failed"] {
        assert_eq!(summary[key], Value::Null, "{key}");
    }
    let terms: Vec<(&str, &str)> = summary["terms"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, value)| (name.as_str(), value.as_str().unwrap()))
        .collect();
    let expected = [
        ("law", "published, tension"),
        ("compression", "yes"),
        ("shear", "tangent"),
        ("hourglass", "yes"),
        ("failure", "yes"),
        ("projectile", "yes"),
        ("friction", "yes"),
        ("rotation", "no"), // two mirror planes leave none
        ("ply contact", "no"),
        ("ply friction", "no"),
    ];
    assert_eq!(terms, expected);
    let [all, computed] = ["element_steps", "element_steps_computed"].map(|key| summary[key].as_u64().unwrap());
    let (mirrored, at_rest) = (all - all / 4, all / 4 - computed);
    let skipped = json!({"symmetry": mirrored, "mirror_planes": ["x", "y"], "wavefront": at_rest, "switched_off": []});
    assert_eq!(summary["skipped"], skipped);
    assert!(0 < computed && computed < all);
    assert_eq!(summary["precision"], "f64");
    let assumed: Vec<&str> = summary["assumed"].as_array().unwrap().iter().map(|p| p.as_str().unwrap()).collect();
    assert!(assumed.contains(&"/fabric/crossover/gap_mm") && !assumed.contains(&"/projectile/mass_g"));
    // A later run without profiles leaves none of the earlier one.
    let output = bench.shoot(&["--set", "/output/profile_times_us=[]"]);
    assert_eq!(code(&output), 0);
    assert_eq!(
        bench.names("out/shot"),
        ["case.json", "events.csv", "history.csv", "report.html", "shot.svg", "summary.json"]
    );
}

#[test]
fn without_a_report_there_is_none_of_an_earlier_run_either() {
    let bench = Bench::new(&small());
    assert_eq!(code(&bench.shoot(&["--quiet"])), 0);
    assert!(bench.text("out/shot/report.html").starts_with("<!DOCTYPE html>"));
    assert_eq!(code(&bench.shoot(&["--quiet", "--no-report"])), 0);
    assert_eq!(bench.names("out/shot"), ["case.json", "events.csv", "history.csv", "shot.svg", "summary.json"]);
}

#[test]
fn tables_have_the_columns_of_the_contract_and_agree_with_the_summary() {
    let bench = Bench::new(&small_with("/output/profile_times_us", json!([2, 8])));
    assert_eq!(code(&bench.shoot(&["--out", "here", "--quiet"])), 0);
    let history = bench.text("here/history.csv");
    assert_eq!(history.lines().next().unwrap(), HISTORY);
    let summary = bench.json("here/summary.json");
    let table = rows(&history);
    assert!(table.len() >= 20 && table.iter().all(|row| row.len() == 26));
    let last = table.last().unwrap();
    assert_eq!(number(&table[0][0]), 0.0);
    assert_eq!(number(&table[0][1]), 600.0);
    assert_eq!(number(&last[0]), summary["time_us"].as_f64().unwrap());
    assert_eq!(number(&last[1]), summary["residual_velocity_m_s"].as_f64().unwrap());
    // Half m v² before the first contact, less what is left.
    let absorbed = 0.5 * 0.003 * 600.0 * 600.0 - number(&last[10]);
    assert!((absorbed - summary["absorbed_energy_j"].as_f64().unwrap()).abs() < 1e-9);
    // The first row's force is an impulse over one step, ten times what follows.
    let force = HISTORY.split(',').position(|name| name == "contact_force_n").unwrap();
    let peak = table[1..].iter().map(|row| number(&row[force])).fold(0.0, f64::max);
    assert_eq!(summary["peak_contact_force_n"].as_f64().unwrap(), peak);
    assert!(peak > 0.0 && number(&table[0][force]) > 2.0 * peak);
    let events = bench.text("here/events.csv");
    assert_eq!(events.lines().next().unwrap(), "time_us,ply,i,j,yarn,strain,x_mm,y_mm");
    let failures = rows(&events);
    let of = |yarn: &str| failures.iter().filter(|row| row[4] == yarn).count() as u64;
    assert!(of("warp") > 0 && of("weft") > 0);
    assert_eq!(summary["failed_yarns"], json!({"warp": of("warp"), "weft": of("weft")}));
    assert!(failures.iter().all(|row| number(&row[5]) >= 0.035));
    let profiles = bench.text("here/profiles.csv");
    let heading = "time_us,reference_mm,position_mm,deflection_mm,strain,force_n_per_m";
    assert_eq!(profiles.lines().next().unwrap(), heading);
    assert_eq!(rows(&profiles).len(), 2 * 25);
}

#[test]
fn the_case_as_run_computes_the_same_again() {
    let bench = Bench::new(&small());
    let output = bench.shoot(&["--set", "/projectile/velocity_m_s=500", "--out", "one"]);
    assert_eq!(code(&output), 0);
    assert_eq!(code(&bench.ripstop(&["run", "one/case.json", "--backend", "cpu", "--out", "two"])), 0);
    assert_eq!(bench.text("one/history.csv"), bench.text("two/history.csv"));
    let hash = |folder: &str| bench.json(&format!("{folder}/summary.json"))["case_hash"].clone();
    assert_eq!(hash("one"), hash("two"));
    assert_eq!(code(&bench.shoot(&["--out", "three"])), 0);
    assert_ne!(hash("one"), hash("three"));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let bench = Bench::new(&small());
    for threads in ["1", "2", "5"] {
        let output = bench.shoot(&["--threads", threads, "--out", threads]);
        assert_eq!(code(&output), 0);
        assert_eq!(bench.json(&format!("{threads}/summary.json"))["threads"].to_string(), threads);
    }
    for name in ["history.csv", "events.csv"] {
        let one = fs::read(bench.path("1").join(name)).unwrap();
        assert_eq!(one, fs::read(bench.path("2").join(name)).unwrap(), "{name}");
        assert_eq!(one, fs::read(bench.path("5").join(name)).unwrap(), "{name}");
    }
}

#[test]
fn numbers_that_are_not_finite_become_null_and_trouble_is_told() {
    let (case, mut run) = run(&small());
    run.energy_error = f64::NAN;
    run.divergence = Some(Divergence { step: 7, kernel: "node_update", quantity: "v = NaN".into(), place: [0, 3, 5] });
    let summary: Value = serde_json::from_str(&output::summary(&case, &run, 1.0).to_string()).unwrap();
    assert_eq!(summary["energy_error"], Value::Null);
    let unstable = json!({"step": 7, "kernel": "node_update", "quantity": "v = NaN", "ply": 0, "row": 3, "column": 5});
    assert_eq!(summary["unstable"], unstable);
}
