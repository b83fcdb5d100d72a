//! What a run leaves out changes no result; it can be switched off, kind by kind.

use super::*;

/// History and summary of a run into a folder.
fn shoot(bench: &Bench, out: &str, more: &[&str]) -> (String, Value) {
    let output = bench.shoot(&[&["--quiet", "--out", out], more].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    (bench.text(&format!("{out}/history.csv")), bench.json(&format!("{out}/summary.json")))
}

#[test]
fn without_the_wavefront_skip_every_bit_stays() {
    let bench = Bench::new(&small());
    for precision in ["f64", "f32"] {
        let shoot = |out: &str, more: &[&str]| shoot(&bench, out, &[&["--precision", precision], more].concat());
        let (history, summary) = shoot("skipping", &[]);
        let (whole_history, whole) = shoot("whole", &["--no-skip=wavefront"]);
        assert_eq!(history, whole_history);
        assert_eq!(bench.text("skipping/events.csv"), bench.text("whole/events.csv"));
        assert_eq!(summary["element_steps"], whole["element_steps"]);
        assert_eq!(4 * whole["element_steps_computed"].as_u64().unwrap(), whole["element_steps"].as_u64().unwrap());
        assert!(
            summary["element_steps_computed"].as_u64().unwrap() < whole["element_steps_computed"].as_u64().unwrap()
        );
        assert_eq!(
            (&whole["skipped"]["wavefront"], &whole["skipped"]["switched_off"]),
            (&json!(0), &json!(["wavefront"]))
        );
        assert_eq!(summary["skipped"]["switched_off"], json!([]));
    }
}

#[test]
fn symmetry_is_switched_off_by_the_case_and_by_the_switch_and_says_what_it_saves() {
    let bench = Bench::new(&small());
    let shoot = |more: &[&str]| shoot(&bench, "out/shot", more);
    let (_, part) = shoot(&[]);
    let (switched, whole) = shoot(&["--no-skip=symmetry"]);
    let (by_case, none) = shoot(&["--set", "/solver/symmetry=none"]);
    assert_eq!(switched, by_case);
    assert_eq!((&part["skipped"]["mirror_planes"], &part["skipped"]["switched_off"]), (&json!(["x", "y"]), &json!([])));
    assert_eq!(4 * part["skipped"]["symmetry"].as_u64().unwrap(), 3 * part["element_steps"].as_u64().unwrap());
    for (summary, off) in [(&whole, json!(["symmetry"])), (&none, json!([]))] {
        assert_eq!((&summary["skipped"]["mirror_planes"], &summary["skipped"]["symmetry"]), (&json!([]), &json!(0)));
        assert_eq!(summary["skipped"]["switched_off"], off);
        assert_eq!((&summary["elements"], &summary["failed_yarns"]), (&part["elements"], &part["failed_yarns"]));
        let computed = ["wavefront"].map(|key| summary["skipped"][key].as_u64().unwrap());
        let all = summary["element_steps"].as_u64().unwrap();
        assert_eq!(summary["element_steps_computed"].as_u64().unwrap() + computed[0], all);
    }
    let table = stdout(&bench.shoot(&[]));
    assert!(table.contains("a quarter, mirrored at x = 0 and y = 0"), "{table}");
    let checked = stdout(&bench.ripstop(&["check", "shot.json"]));
    assert!(checked.contains("a quarter, mirrored at x = 0 and y = 0"), "{checked}");
}

/// A shot through a small ply whose outcome is known well before the end.
fn decided() -> Value {
    let mut case = small_with("/solver/end_time_us", json!(60));
    case["pack"]["width_mm"] = json!(15);
    case["pack"]["height_mm"] = json!(15);
    case
}

#[test]
fn without_the_outcome_skip_a_run_goes_on_to_its_end() {
    let bench = Bench::new(&decided());
    let shoot = |more: &[&str]| shoot(&bench, "out/shot", more);
    let (history, summary) = shoot(&[]);
    assert_eq!(summary["outcome"], "perforated");
    let (asked, by_case) = shoot(&["--set", "/solver/run_until=end_time"]);
    let (whole, _) = shoot(&["--set", "/solver/run_until=end_time", "--no-skip=symmetry"]);
    assert!(asked.starts_with(&history) && asked.len() > history.len());
    for off in [&["--no-skip=outcome"][..], &["--no-skip"], &["--no-skip=wavefront,outcome"], &["--no-skip=all"]] {
        let (longer, summary) = shoot(off);
        let all = off[0] == "--no-skip" || off[0] == "--no-skip=all";
        assert_eq!(longer, if all { whole.as_str() } else { asked.as_str() }, "{off:?}");
        assert_eq!(summary["time_us"], by_case["time_us"]);
        assert_eq!(summary["outcome"], "perforated");
        let expected = match off[0] {
            "--no-skip=outcome" => json!(["outcome"]),
            "--no-skip=wavefront,outcome" => json!(["wavefront", "outcome"]),
            _ => json!(["wavefront", "outcome", "symmetry"]),
        };
        assert_eq!(summary["skipped"]["switched_off"], expected);
    }
}

#[test]
fn the_table_says_what_was_not_skipped() {
    let bench = Bench::new(&small());
    assert!(stdout(&bench.shoot(&["--no-skip"])).contains("not skipped  wavefront, outcome, symmetry"));
    assert!(!stdout(&bench.shoot(&[])).contains("not skipped"));
}

#[test]
fn an_unknown_kind_is_2() {
    let bench = Bench::new(&small());
    for wrong in ["--no-skip=wave", "--no-skip=wavefront,mirror", "--no-skip="] {
        let output = bench.shoot(&[wrong]);
        assert_eq!(code(&output), 2, "{wrong}");
        assert!(stderr(&output).contains("wavefront, outcome, symmetry, all"), "{}", stderr(&output));
    }
    // A kind follows an equals sign only: what stands alone is the case.
    let output = bench.ripstop(&["run", "--backend", "cpu", "--quiet", "--no-skip", "shot.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(bench.names("."), ["out", "shot.json"]);
}
