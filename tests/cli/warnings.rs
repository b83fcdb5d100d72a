//! Warnings and `ripstop explain`: numbered, each with a threshold that a run is held against.

use ripstop::output::checks::{self, checks};
use ripstop::output::warnings::{self, KINDS, Warning};

use super::*;

fn codes(warnings: &[Warning]) -> Vec<&'static str> {
    warnings.iter().map(|warning| warning.kind.code).collect()
}

/// A run without any warning.
fn spotless() -> (case::Case, Run) {
    let (mut case, run) = run(&small_with("/solver/end_time_us", json!(2)));
    case.fields.clear();
    assert_eq!(codes(&checks::warnings(&case, &checks(&case, &run))), [""; 0]);
    (case, run)
}

#[test]
fn codes_and_names_stay_what_they_are() {
    let kinds = KINDS.each_ref().map(|kind| (kind.code, kind.name));
    let given = [
        ("W1", "assumed-parameters"),
        ("W2", "energy"),
        ("W3", "hourglass"),
        ("W4", "penetration"),
        ("W5", "coarse-mesh"),
        ("W6", "small-projectile"),
        ("W7", "mass"),
        ("W8", "torn-off"),
    ];
    assert_eq!(kinds, given);
}

#[test]
fn a_run_is_warned_of_above_each_threshold_and_not_at_it() {
    let (case, run) = spotless();
    let diagonal = case.pack.element_length_x.hypot(case.pack.element_length_y);
    type Set = fn(&mut Run, f64);
    let set: [(&str, f64, Set); 4] = [
        ("W2", 0.02, |run, value| run.energy_error = value),
        ("W3", 0.05, |run, value| run.hourglass_fraction = value),
        ("W4", 0.5 * diagonal, |run, value| run.max_penetration = value),
        ("W4", case.fabric.thickness, |run, value| run.max_ply_penetration = value),
    ];
    for (code, limit, set) in set {
        let with = |value: f64| {
            let mut run = run.clone();
            set(&mut run, value);
            checks::warnings(&case, &checks(&case, &run))
        };
        assert_eq!(codes(&with(limit)), [""; 0], "{code} at its limit");
        let above = with(limit * 1.001);
        assert_eq!(codes(&above), [code]);
        let unit = if code == "W4" { 1e3 } else { 1.0 };
        assert!((above[0].limit - unit * limit).abs() < 1e-12 * unit, "{:?}", above[0]);
        assert!((above[0].value / above[0].limit - 1.001).abs() < 1e-9, "{:?}", above[0]);
        assert_eq!(codes(&with(f64::NAN)), [code], "no number is no good number");
    }
}

#[test]
fn what_a_case_shows_before_the_run_is_shown_by_check_and_by_the_run() {
    let bench = Bench::new(&small_with("/solver/end_time_us", json!(2)));
    let assumed = warnings::assumed_fields(&run(&small()).0).count();
    for (set, expected) in [
        ("/projectile/diameter_mm=3.9", &["W1"][..]),
        ("/projectile/diameter_mm=3.7", &["W1", "W6"]), // three elements are 3.81 mm
        ("/projectile/mass_g=0.3", &["W1", "W7"]),      // 300 kg/m³
        ("/projectile/mass_g=30", &["W1", "W7"]),
        ("/projectile/density_kg_m3=2700", &["W1", "W7"]), // the mass given is a tenth more
        ("/projectile/density_kg_m3=2950", &["W1"]),
        ("/pack/crossovers_per_element=2", &["W1", "W5", "W6"]),
    ] {
        let text = stdout(&bench.ripstop(&["check", "shot.json", "--set", set]));
        let output = bench.shoot(&["--set", set, "--out", "out/shot"]);
        assert_eq!((code(&output), stderr(&output)), (0, String::new()));
        let summary = bench.json("out/shot/summary.json");
        let listed = summary["warnings"].as_array().unwrap();
        let codes: Vec<&str> = listed.iter().map(|warning| warning["code"].as_str().unwrap()).collect();
        assert_eq!(codes, expected, "{set}");
        assert_eq!(listed[0]["value"], assumed as f64, "{set}");
        for warning in listed {
            let keys: Vec<&String> = warning.as_object().unwrap().keys().collect();
            assert_eq!(keys, ["code", "name", "message", "value", "limit"]);
            let line = format!("{}  {}", warning["code"].as_str().unwrap(), warning["message"].as_str().unwrap());
            assert!(text.contains(&line), "{line} in what check prints:\n{text}");
            assert!(stdout(&output).contains(&line), "{line} in\n{}", stdout(&output));
        }
        for absent in KINDS.iter().filter(|kind| !expected.contains(&kind.code)) {
            assert!(!text.contains(&format!("{}  ", absent.code)), "{} in\n{text}", absent.code);
        }
    }
    let summary = bench.json("out/shot/summary.json");
    let small = &summary["warnings"][2];
    assert_eq!(small["limit"], 3.0);
    assert!((small["value"].as_f64().unwrap() - 5.5 / 2.54).abs() < 1e-9, "{small}");
}

#[test]
fn explain_knows_every_code_by_number_and_name_and_names_them_to_who_asks_for_another() {
    let bench = Bench::new(&small());
    let explain = |code: &str| bench.ripstop(&["explain", code]);
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
    let list = stdout(&bench.ripstop(&["explain"]));
    for kind in &KINDS {
        let by_code = explain(kind.code);
        assert_eq!(code(&by_code), 0);
        for part in [kind.code, kind.name, kind.measured, kind.given, kind.means, kind.help] {
            assert!(words(&stdout(&by_code)).contains(&words(part)), "{part} in\n{}", stdout(&by_code));
        }
        assert_eq!(stdout(&explain(&kind.code.to_lowercase())), stdout(&by_code));
        assert_eq!(stdout(&explain(kind.name)), stdout(&by_code));
        assert!(words(&list).contains(&format!("{} {}", kind.code, kind.name)), "{list}");
    }
    for (exit, part) in [("0", "done"), ("1", "expectation"), ("2", "input"), ("3", "device"), ("130", "Ctrl-C")] {
        let text = stdout(&explain(exit));
        assert!(text.starts_with(&format!("exit code {exit}: ")) && text.contains(part), "{text}");
        assert!(text.contains("means") && text.contains("to do"), "{text}");
    }
    for unknown in ["W9", "4", "", "0130"] {
        let output = explain(unknown);
        assert_eq!((code(&output), stdout(&output)), (2, String::new()));
        assert!(stderr(&output).contains("0, 1, 2, 3, 130, W1, W2, W3, W4, W5, W6, W7, W8"), "{}", stderr(&output));
    }
}

#[test]
fn what_explain_says_of_a_threshold_is_the_threshold() {
    let percent = |limit: f64| format!("above {} %", limit * 100.0);
    let expected = [
        (
            2,
            format!(
                "{} gained or lost, or a ledger error {}",
                percent(checks::GAINED_LIMIT),
                percent(checks::ENERGY_LIMIT)
            ),
        ),
        (3, percent(checks::HOURGLASS_LIMIT)),
        (5, format!("above {}", checks::CROSSOVERS_LIMIT)),
        (6, format!("below {}", checks::CELLS_LIMIT)),
    ];
    for (number, text) in expected {
        assert!(KINDS[number - 1].given.starts_with(&text), "{} for {text}", KINDS[number - 1].given);
    }
}
