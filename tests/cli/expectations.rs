//! What a case says about its result.

use super::*;

/// Checks statements about the small shot; gives `got`, `pass` and `note` of each.
fn check(expect: Value) -> Vec<Value> {
    let mut case = small_with("/output/profile_times_us", json!([2, 4, 8]));
    case["expect"] = expect;
    let (case, run) = run(&case);
    let summary = output::summary(&case, &run, 1.0);
    summary["expect"].as_array().unwrap().clone()
}

#[test]
fn any_number_or_word_of_the_results_can_be_expected() {
    let checks = check(json!([
        {"quantity": "outcome", "value": "running", "source": "t"},
        {"quantity": "failed_yarns.warp", "min": 1, "source": "t"},
        {"quantity": "interrupted", "value": "false", "source": "t"},
        {"quantity": "projectile_velocity_m_s", "at_us": 0, "value": 600, "tolerance": 0, "source": "t"},
        {"quantity": "projectile_velocity_m_s", "at_us": 10, "max": 600, "min": 590, "source": "t"},
        {"quantity": "failed_weft", "min": 1, "source": "t"},
        {"quantity": "elements", "value": 576, "tolerance": 0, "source": "t"},
    ]));
    for check in &checks {
        assert!(check["pass"] == true && !check["got"].is_null() && check.get("note").is_none(), "{check}");
    }
    assert_eq!(checks[3]["expected"], json!({"value": 600.0, "tolerance": 0.0}));
    assert_eq!(checks[4]["at_us"], 10.0);
}

#[test]
fn what_does_not_hold_or_cannot_be_measured_has_failed_with_a_reason() {
    let checks = check(json!([
        {"quantity": "outcome", "value": "stopped", "source": "t"},
        {"quantity": "residual_velocity_m_s", "value": 1, "tolerance": "1%", "source": "t"},
        {"quantity": "no_such_thing", "min": 0, "source": "t"},
        {"quantity": "stop_time_us", "min": 0, "source": "t"},
        {"quantity": "elements", "at_us": 3, "min": 0, "source": "t"},
        {"quantity": "newton", "min": 0, "source": "t"},
        {"quantity": "plateau_strain", "min": 0, "source": "t"},
        {"quantity": "contact_force_n", "between_us": [1, 2], "min": 0, "source": "t"},
        {"quantity": "frequency_hz", "min": 0, "source": "t"},
    ]));
    for (n, check) in checks.iter().enumerate() {
        assert_eq!(check["pass"], false, "{check}");
        assert_eq!(check["got"].is_null(), n > 1, "{check}");
        assert_eq!(check["note"].is_string(), n > 1, "{check}");
    }
}

#[test]
fn a_run_that_ended_early_has_no_later_values() {
    let (mut case, mut run) = run(&small_with("/expect", json!([])));
    run.history.truncate(4);
    let statement = json!([{"quantity": "contact_force_n", "at_us": 9, "min": -1e15, "source": "t"}]);
    case.expect = case::from_str("t.json", &small_with("/expect", statement).to_string(), &[]).unwrap().expect;
    let checked = output::check(&case, &run, &json!({}));
    assert!(!checked[0].pass && checked[0].note.as_ref().unwrap().contains("end_time"), "{checked:?}");
}

#[test]
fn a_known_difference_is_shown_with_its_reason_and_is_no_failure() {
    let why = "nothing is fast enough";
    let published =
        json!({"quantity": "outcome", "value": "stopped", "source": "published, Figure 9", "known_difference": why});
    let bench = Bench::new(&small_with("/expect", json!([published])));
    let output = bench.shoot(&["--out", "out"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("known  outcome") && stdout(&output).contains(why), "{}", stdout(&output));
    let check = &bench.json("out/summary.json")["expect"][0];
    assert_eq!((&check["pass"], &check["known_difference"]), (&json!(false), &json!(why)));
    assert!(bench.text("out/report.html").contains("known difference"));
}
