//! Files that runs leave, what they hold, and what does not change them.

use super::*;

const SUMMARY: &str = "trust notes residual_velocity_scatter_m_s broken_yarns failures_at outcome residual_velocity_m_s \
    rebound_velocity_m_s carried_velocity_m_s stop_time_us absorbed_energy_j max_deflection_mm max_penetration_mm \
    max_ply_penetration_mm last_ply_deflection_mm fabric_energy_before_j exchanged_energy_j perforated_plies plies energy_error momentum_error hourglass_fraction failed_yarns \
    eroded_elements energy_gained law_energy_j ply_separation_j backing_energy_j backface_signature_mm viscous_dissipation_j breaking_load_ratio newton elements steps \
    time_step_us element_steps element_steps_computed wall_s loop_s element_steps_per_s skipped backend adapter threads precision \
    version case_hash assumed warnings timings expect interrupted unstable device_lost checkpoint_failed host_overhead_s \
    time_step_set_by peak_yarn_tension_n peak_contact_force_n title case time_us";
const HISTORY: &str = "time_us,projectile_velocity_m_s,projectile_displacement_mm,contact_force_n,\
    kinetic_energy_j,internal_energy_j,hourglass_energy_j,contact_dissipation_j,friction_j,failure_energy_j,\
    projectile_energy_j,energy_error,failed_warp,failed_weft,stored_energy_j,external_work_j,eroded_elements,\
    max_deflection_mm,max_yarn_tension_n,momentum_error,perforated_plies,viscous_dissipation_j,\
    energy_gained,law_energy_j,last_ply_deflection_mm,ply_separation_j,backing_energy_j,crater_depth_mm";

fn rows(text: &str) -> Vec<Vec<String>> {
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap()
}

/// History and summary of a run into a folder.
fn shoot(bench: &Bench, out: &str, more: &[&str]) -> (String, Value) {
    let output = bench.shoot(&[&["--quiet", "--out", out], more].concat());
    assert_eq!((code(&output), stdout(&output), stderr(&output)), (0, String::new(), String::new()), "{more:?}");
    (bench.text(&format!("{out}/history.csv")), bench.json(&format!("{out}/summary.json")))
}

#[test]
fn a_run_leaves_the_files_of_the_contract_and_none_of_an_earlier_run() {
    let bench = Bench::new(&small_with("/output/profile_times_us", json!([2, 8])));
    let (_, summary) = shoot(&bench, "out/shot", &[]);
    let mut expected = [&FILES[..], &["profiles.csv"]].concat();
    expected.sort_unstable();
    assert_eq!(bench.names("out/shot"), expected);
    let mut keys: Vec<&str> = summary.as_object().unwrap().keys().map(String::as_str).collect();
    let mut asked: Vec<&str> = SUMMARY.split_whitespace().collect();
    keys.sort_unstable();
    asked.sort_unstable();
    assert_eq!(keys, asked);
    for key in ["adapter", "host_overhead_s", "device_lost", "checkpoint_failed"] {
        assert_eq!(summary[key], Value::Null, "{key}");
    }
    let kernels: Vec<&String> = summary["timings"].as_object().unwrap().keys().collect();
    assert_eq!(kernels, ["sweep", "ply_contact", "projectile_contact", "record", "other"]);
    let share = |part: &Value| part["share"].as_f64().unwrap();
    let shares: f64 = summary["timings"].as_object().unwrap().values().map(share).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{}", summary["timings"]);
    let assumed = summary["assumed"].as_array().unwrap();
    assert!(assumed.contains(&json!("/fabric/crossover/gap_mm")) && !assumed.contains(&json!("/projectile/mass_g")));
    shoot(&bench, "out/shot", &["--set", "/output/profile_times_us=[]", "--no-report"]);
    let left: Vec<&str> = FILES.into_iter().filter(|name| *name != "report.html").collect();
    assert_eq!(bench.names("out/shot"), left);
}

#[test]
fn tables_have_the_columns_of_the_contract_and_agree_with_the_summary() {
    let bench = Bench::new(&small_with("/output/profile_times_us", json!([2, 8])));
    let (history, summary) = shoot(&bench, "a/b", &[]);
    let value = |key: &str| summary[key].as_f64().unwrap();
    assert_eq!(history.lines().next().unwrap(), HISTORY);
    let table = rows(&history);
    assert!(table.len() >= 20 && table.iter().all(|row| row.len() == 28));
    let last = table.last().unwrap();
    assert_eq!([number(&table[0][0]), number(&table[0][1])], [0.0, 600.0]);
    assert_eq!([number(&last[0]), number(&last[1])], ["time_us", "residual_velocity_m_s"].map(value));
    // Half m v² before the first contact, less what is left.
    let absorbed = 0.5 * 0.003 * 600.0 * 600.0 - number(&last[10]);
    assert!((absorbed - value("absorbed_energy_j")).abs() < 1e-9);
    let events = bench.text("a/b/events.csv");
    assert_eq!(events.lines().next().unwrap(), "time_us,ply,i,j,yarn,strain,x_mm,y_mm");
    let failures = rows(&events);
    let of = |yarn: &str| failures.iter().filter(|row| row[4] == yarn).count() as u64;
    assert!(of("warp") > 0 && of("weft") > 0);
    // The strain is the element's own when it is released; the piece that it lies in was strained beyond failure before.
    let strains: Vec<f64> = failures.iter().map(|row| number(&row[5])).collect();
    assert!(strains.iter().all(|strain| (0.0..1.0).contains(strain)) && strains.iter().any(|strain| *strain >= 0.035));
    assert_eq!(summary["failed_yarns"], json!({"warp": of("warp"), "weft": of("weft")}));
    let profiles = bench.text("a/b/profiles.csv");
    let heading = "time_us,reference_mm,position_mm,deflection_mm,strain,force_n_per_m";
    assert_eq!((profiles.lines().next().unwrap(), rows(&profiles).len()), (heading, 2 * 25));
}

#[test]
fn the_case_as_run_and_any_number_of_threads_give_the_same_bits() {
    let bench = Bench::new(&small());
    let (history, summary) = shoot(&bench, "one", &["--set", "/projectile/velocity_m_s=500", "--threads", "1"]);
    assert_eq!(
        code(&bench.ripstop(&["run", "one/case.json", "--backend", "cpu", "--out", "two", "--threads", "3"])),
        0
    );
    assert_eq!((bench.text("two/history.csv"), bench.text("two/events.csv")), (history, bench.text("one/events.csv")));
    let again = bench.json("two/summary.json");
    assert_eq!(
        (&again["case_hash"], &summary["threads"], &again["threads"]),
        (&summary["case_hash"], &json!(1), &json!(3))
    );
    assert_ne!(shoot(&bench, "three", &[]).1["case_hash"], summary["case_hash"]);
}

#[test]
fn numbers_that_are_not_finite_become_null_and_divergence_is_reported() {
    let (case, mut run) = run(&small());
    run.energy_error = f64::NAN;
    run.divergence = Some(Divergence { step: 7, kernel: "node_update", quantity: "v = NaN".into(), place: [0, 3, 5] });
    let summary: Value = serde_json::from_str(&output::summary(&case, &run, 1.0).to_string()).unwrap();
    assert_eq!(summary["energy_error"], Value::Null);
    let unstable = json!({"step": 7, "kernel": "node_update", "quantity": "v = NaN", "ply": 0, "row": 3, "column": 5});
    assert_eq!(summary["unstable"], unstable);
}

#[test]
fn a_skip_changes_no_bit_and_says_what_it_saves() {
    // The outcome is known well before the end.
    let mut case = small_with("/solver/end_time_us", json!(60));
    case["pack"] = json!({"width_mm": 15, "height_mm": 15});
    let bench = Bench::new(&case);
    for precision in ["f64", "f32"] {
        let shoot = |more: &[&str]| shoot(&bench, "out/shot", &[&["--precision", precision], more].concat());
        let count = |summary: &Value, key: &str| summary.pointer(key).unwrap().as_u64().unwrap();
        let (history, part) = shoot(&[]);
        assert_eq!((&part["outcome"], &part["precision"]), (&json!("perforated"), &json!(precision)));
        assert_eq!(
            (&part["skipped"]["mirror_planes"], &part["skipped"]["switched_off"]),
            (&json!(["x", "y"]), &json!([]))
        );
        assert_eq!(4 * count(&part, "/skipped/symmetry"), 3 * count(&part, "/element_steps"));
        let (moving, all) = shoot(&["--no-skip=wavefront"]);
        assert_eq!((&moving, &all["skipped"]["wavefront"]), (&history, &json!(0)));
        assert_eq!(4 * count(&all, "/element_steps_computed"), count(&all, "/element_steps"));
        assert!(count(&part, "/element_steps_computed") < count(&all, "/element_steps_computed"));
        let (whole, switched) = shoot(&["--no-skip=symmetry"]);
        assert_eq!(whole, shoot(&["--set", "/solver/symmetry=none"]).0);
        assert_eq!((&switched["skipped"]["mirror_planes"], &switched["skipped"]["symmetry"]), (&json!([]), &json!(0)));
        let computed = count(&switched, "/element_steps_computed") + count(&switched, "/skipped/wavefront");
        assert_eq!(computed, count(&switched, "/element_steps"));
        let to_the_end = ["--set", "/solver/run_until=end_time"];
        let longer = shoot(&to_the_end).0;
        assert!(longer.starts_with(&history) && longer.len() > history.len());
        let whole = shoot(&[&to_the_end[..], &["--no-skip=symmetry"]].concat()).0;
        for (off, expected, names) in [
            ("--no-skip=outcome", &longer, json!(["outcome"])),
            ("--no-skip=wavefront,outcome", &longer, json!(["wavefront", "outcome"])),
            ("--no-skip=all", &whole, json!(["wavefront", "outcome", "symmetry"])),
            ("--no-skip", &whole, json!(["wavefront", "outcome", "symmetry"])),
        ] {
            let (history, summary) = shoot(&[off]);
            assert_eq!((&history, &summary["skipped"]["switched_off"]), (expected, &names), "{off}");
        }
    }
}

#[test]
fn any_number_or_word_of_the_results_can_be_expected() {
    let mut case = small_with("/output/profile_times_us", json!([2, 4, 8]));
    // What holds, what does not, and what cannot be measured.
    case["expect"] = json!([
        {"quantity": "outcome", "value": "running", "source": "t"},
        {"quantity": "failed_yarns.warp", "min": 1, "source": "t"},
        {"quantity": "interrupted", "value": "false", "source": "t"},
        {"quantity": "projectile_velocity_m_s", "at_us": 0, "value": 600, "tolerance": 0, "source": "t"},
        {"quantity": "projectile_velocity_m_s", "at_us": 10, "max": 600, "min": 590, "source": "t"},
        {"quantity": "failed_weft", "min": 1, "source": "t"},
        {"quantity": "elements", "value": 576, "tolerance": 0, "source": "t"},
        {"quantity": "outcome", "value": "stopped", "source": "t"},
        {"quantity": "residual_velocity_m_s", "value": 1, "tolerance": "1%", "source": "t"},
        {"quantity": "no_such_thing", "min": 0, "source": "t"},
        {"quantity": "stop_time_us", "min": 0, "source": "t"},
        {"quantity": "elements", "at_us": 3, "min": 0, "source": "t"},
        {"quantity": "newton", "min": 0, "source": "t"},
        {"quantity": "plateau_strain", "min": 0, "source": "t"},
        {"quantity": "contact_force_n", "between_us": [1, 2], "min": 0, "source": "t"},
        {"quantity": "frequency_hz", "min": 0, "source": "t"},
    ]);
    let (case, mut run) = run(&case);
    let summary = output::summary(&case, &run, 1.0);
    for (n, check) in summary["expect"].as_array().unwrap().iter().enumerate() {
        assert_eq!((&check["pass"], check["got"].is_null()), (&json!(n < 7), n > 8), "{check}");
        assert_eq!(check["note"].is_string(), n > 8, "{check}");
    }
    assert_eq!(summary["expect"][3]["expected"], json!({"value": 600.0, "tolerance": 0.0}));
    // A run that ended early has no later values.
    run.history.truncate(4);
    let checked = output::check(&case, &run, &summary);
    assert!(checked[4]["pass"] == false && checked[4]["note"].to_string().contains("end_time"), "{}", checked[4]);
}

#[test]
fn a_known_difference_is_shown_with_its_reason_and_is_no_failure() {
    let why = "nothing is fast enough";
    let published =
        json!({"quantity": "outcome", "value": "stopped", "source": "published, Figure 9", "known_difference": why});
    let bench = Bench::new(&small_with("/expect", json!([published])));
    let output = bench.shoot(&[]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("known  outcome") && stdout(&output).contains(why), "{}", stdout(&output));
    let check = &bench.json("out/shot/summary.json")["expect"][0];
    assert_eq!((&check["pass"], &check["known_difference"]), (&json!(false), &json!(why)));
    assert!(bench.text("out/shot/report.html").contains("known difference"));
}

#[test]
fn several_cases_run_one_after_the_other_each_in_its_folder() {
    let bench = Bench::new(&small_with("/solver/end_time_us", json!(2)));
    fs::copy(bench.path("shot.json"), bench.path("other.json")).unwrap();
    fs::write(bench.path("broken.json"), "{}").unwrap();
    let output = bench.ripstop(&["run", "shot.json", "broken.json", "other.json", "--backend", "cpu", "-o", "both"]);
    assert!(code(&output) == 2 && stderr(&output).contains("broken.json"), "{}", stderr(&output));
    assert_eq!(bench.names("both"), ["other", "shot"]);
    fs::create_dir(bench.path("twin")).unwrap();
    fs::copy(bench.path("shot.json"), bench.path("twin/shot.json")).unwrap();
    let twice = bench.ripstop(&["run", "shot.json", "twin/shot.json", "--backend", "cpu", "--quiet"]);
    assert!(code(&twice) == 2 && stderr(&twice).contains("a folder for each case"), "{}", stderr(&twice));
    // A change does not take the place of the file's results.
    assert_eq!(code(&bench.shoot(&["--set", "/projectile/velocity_m_s=50"])), 0);
    let title = |folder: &str| bench.json(&format!("out/{folder}/summary.json"))["title"].as_str().unwrap().to_owned();
    assert_eq!(title("shot+velocity_m_s=50"), format!("{} [velocity_m_s = 50]", title("shot")));
}
