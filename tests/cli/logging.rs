//! `-v` and `RIPSTOP_LOG`: what is done, on standard error, without a trace in what scripts read.

use super::*;

/// Every event of a shot that breaks yarns, in order.
const STORY: [&str; 7] =
    ["case read", "backend chosen", "model built", "first contact", "first yarn failed", "loop ended", "files written"];

fn assert_in_order(text: &str) {
    let mut rest = text;
    for part in STORY {
        let at = rest.find(part).unwrap_or_else(|| panic!("{part} after what comes before it in\n{text}"));
        rest = &rest[at + part.len()..];
    }
}

#[test]
fn verbose_tells_the_story_of_a_run_and_leaves_standard_output_alone() {
    let bench = Bench::new(&small());
    let silent = bench.shoot(&["--json"]);
    assert_eq!(stderr(&silent), "");
    let told = bench.shoot(&["--json", "-v"]);
    assert_in_order(&stderr(&told));
    assert!(stderr(&told).contains("run{case=\"shot\"}") && stderr(&told).contains("INFO"), "{}", stderr(&told));
    assert!(!stderr(&told).contains('\u{1b}'), "{}", stderr(&told));
    assert_eq!(stdout(&told), bench.text("out/shot/summary.json"));
    let result = |output: &Output| -> Value { serde_json::from_str(&stdout(output)).unwrap() };
    for same in ["residual_velocity_m_s", "energy_error", "steps", "failed_yarns"] {
        assert_eq!(result(&silent)[same], result(&told)[same], "{same}");
    }
}

#[test]
fn the_variable_takes_filters_and_a_wrong_one_is_named() {
    let bench = Bench::new(&small());
    let with = |filter: &str| {
        bench.command(&["run", "shot.json", "--backend", "cpu", "--quiet"]).env("RIPSTOP_LOG", filter).output().unwrap()
    };
    assert_in_order(&stderr(&with("info")));
    let records = stderr(&with("ripstop::run::record=info"));
    assert!(records.contains("first contact") && !records.contains("model built"), "{records}");
    assert_eq!(stderr(&with("")), "");
    let wrong = with("ripstop=loud");
    assert_eq!(code(&wrong), 2);
    assert!(stderr(&wrong).starts_with("error: RIPSTOP_LOG") && stderr(&wrong).contains("loud"), "{}", stderr(&wrong));
}

#[test]
fn the_profile_names_the_kernels_and_adds_up_to_the_loop() {
    let bench = Bench::new(&small_with("/pack/plies", json!(2)));
    assert_eq!(code(&bench.shoot(&["--quiet"])), 0);
    let summary = bench.json("out/shot/summary.json");
    let profile = summary["timings"].as_object().unwrap();
    let names: Vec<&String> = profile.keys().collect();
    assert_eq!(names, ["element_force", "node_update", "ply_contact", "projectile_contact", "record", "other"]);
    let sum = |key: &str| profile.values().map(|phase| phase[key].as_f64().unwrap()).sum::<f64>();
    assert!((sum("share") - 1.0).abs() < 1e-9, "{profile:?}");
    assert!((sum("s") / summary["loop_s"].as_f64().unwrap() - 1.0).abs() < 1e-9, "{profile:?}");
    for kernel in &names[..4] {
        assert!(profile[*kernel]["s"].as_f64().unwrap() > 0.0, "{kernel}: {profile:?}");
    }
}
