//! Files that runs leave and what does not change them; the result at a terminal, warnings and their explanations.
//!
//! Names of files, keys and columns are held to `docs/src/results.md` by `tests/docs`.

use ripstop::output::checks;
use ripstop::output::warnings::{self, KINDS};

use super::*;

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
fn tables_agree_with_the_summary() {
    let bench = Bench::new(&small_with("/output/profile_times_us", json!([2, 8])));
    let (history, summary) = shoot(&bench, "a/b", &[]);
    let value = |key: &str| summary[key].as_f64().unwrap();
    let table = rows(&history);
    assert!(table.len() >= 20 && table.iter().all(|row| row.len() == 28));
    let last = table.last().unwrap();
    assert_eq!([number(&table[0][0]), number(&table[0][1])], [0.0, 600.0]);
    assert_eq!([number(&last[0]), number(&last[1])], ["time_us", "residual_velocity_m_s"].map(value));
    // Half m v² before the first contact, less what is left.
    let absorbed = 0.5 * 0.003 * 600.0 * 600.0 - number(&last[10]);
    assert!((absorbed - value("absorbed_energy_j")).abs() < 1e-9);
    let events = bench.text("a/b/events.csv");
    let failures = rows(&events);
    let of = |yarn: &str| failures.iter().filter(|row| row[4] == yarn).count() as u64;
    assert!(of("warp") > 0 && of("weft") > 0);
    // The strain is the element's own when it is released; the piece that it lies in was strained beyond failure before.
    let strains: Vec<f64> = failures.iter().map(|row| number(&row[5])).collect();
    assert!(strains.iter().all(|strain| (0.0..1.0).contains(strain)) && strains.iter().any(|strain| *strain >= 0.035));
    assert_eq!(summary["failed_yarns"], json!({"warp": of("warp"), "weft": of("weft")}));
    assert_eq!(rows(&bench.text("a/b/profiles.csv")).len(), 2 * 25);
}

#[test]
fn the_case_as_run_and_any_number_of_threads_give_the_same_bits() {
    let bench = Bench::new(&small());
    let (history, summary) = shoot(&bench, "one", &["--set", "/projectile/velocity_m_s=500", "--threads", "1"]);
    let again = bench.ripstop(&["run", "one/case.json", "--backend", "cpu", "--out", "two", "--threads", "3"]);
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    assert_eq!((bench.text("two/history.csv"), bench.text("two/events.csv")), (history, bench.text("one/events.csv")));
    let again = bench.json("two/summary.json");
    assert_eq!([&summary["threads"], &again["threads"]], [1, 3]);
    assert_eq!(again["case_hash"], summary["case_hash"]);
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
        let skipped = &part["skipped"];
        assert_eq!((&skipped["mirror_planes"], &skipped["switched_off"]), (&json!(["x", "y"]), &json!([])));
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

/// Text without colours: ESC [ … m.
fn without_colour(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once('m').map_or("", |(_, rest)| rest))
}

#[test]
fn the_result_begins_with_the_verdict_and_has_the_numbers_of_the_summary() {
    let bench =
        Bench::new(&small_with("/expect", json!([{"quantity": "peak_contact_force_n", "min": 0, "source": "t"}])));
    let text = stdout(&bench.shoot(&["--frames", "5", "--no-skip=outcome"]));
    let verdict = text.lines().filter(|line| !line.is_empty()).nth(1).unwrap();
    assert!(verdict.starts_with("UNDECIDED at 10") && text.contains("struck at 600 m/s"), "{text}");
    for part in ["a quarter, mirrored at x = 0 and y = 0", "not skipped  outcome", "out/shot", "frames.pvd"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let summary = bench.json("out/shot/summary.json");
    for (key, before, unit) in [
        ("max_deflection_mm", "deflected ", 1.0),
        ("breaking_load_ratio", "load of a yarn ", 100.0),
        ("peak_contact_force_n", "pass  peak_contact_force_n ≥ 0, got ", 1.0),
    ] {
        let shown = text.split_once(before).unwrap().1.split_whitespace().next().unwrap();
        let (shown, kept) = (shown.parse::<f64>().unwrap() / unit, summary[key].as_f64().unwrap());
        assert!(kept > 0.0 && (shown / kept - 1.0).abs() < 1e-3, "{key}: {shown} for {kept}");
    }
    let output = bench.shoot(&["--json", "--precision", "f32"]);
    assert_eq!((stdout(&output), stderr(&output)), (bench.text("out/shot/summary.json"), String::new()));
    assert_eq!(bench.json("out/shot/summary.json")["precision"], "f32");
}

/// Red where Mesa's layer of Vulkan is there.
#[cfg(target_os = "linux")]
#[test]
fn libraries_of_drivers_are_not_heard() {
    let bench = Bench::new(&small());
    let line = ["-u", "XDG_RUNTIME_DIR", "-u", "WAYLAND_DISPLAY", env!("CARGO_BIN_EXE_ripstop"), "info", "shot.json"];
    let output = Command::new("env").args(line).current_dir(bench.folder.path()).output().unwrap();
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    assert!(stdout(&output).contains("a small shot"), "{}", stdout(&output));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let bench = Bench::new(&small());
    for arguments in [&["schema"][..], &["check", "shot.json"], &["run", "shot.json", "--backend", "cpu"]] {
        let mut child = bench.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((code(&output), stderr(&output)), (0, String::new()), "{arguments:?}");
    }
}

#[test]
fn colour_where_it_is_asked_for_changes_nothing_but_colour() {
    let bench = Bench::new(&small_with("/expect", json!([{"quantity": "elements", "min": 1, "source": "t"}])));
    let forced = |arguments: &[&str]| bench.command(arguments).env("CLICOLOR_FORCE", "1").output().unwrap();
    for arguments in [&["explain"][..], &["explain", "W3"], &["check", "shot.json"], &["check", "absent.json"]] {
        let (plain, painted) = (bench.ripstop(arguments), forced(arguments));
        assert!(stdout(&painted).contains('\u{1b}') || stderr(&painted).contains('\u{1b}'), "{arguments:?}");
        for (plain, painted) in [(stdout(&plain), stdout(&painted)), (stderr(&plain), stderr(&painted))] {
            assert!(!plain.contains('\u{1b}'), "{plain}");
            assert_eq!(without_colour(&painted), plain, "{arguments:?}");
        }
    }
    let run = ["run", "shot.json", "--backend", "cpu"];
    assert!(stdout(&forced(&run)).contains("\u{1b}[32mpass"), "{}", stdout(&forced(&run)));
    let json = forced(&[&run[..], &["--json"]].concat());
    assert!(!stdout(&json).contains('\u{1b}'), "{}", stdout(&json));
}

/// Text that a program shows on a terminal of so many columns, made by `script` of util-linux.
#[cfg(target_os = "linux")]
fn on_a_terminal(bench: &Bench, columns: usize, arguments: &str, environment: &str) -> String {
    let program = env!("CARGO_BIN_EXE_ripstop");
    let line = format!("stty cols {columns} rows 40; {environment} {program} {arguments}");
    let command = bench.command(&[]);
    let mut script = Command::new("script");
    script.args(["-qec", &line, "/dev/null"]).current_dir(bench.folder.path()).stdin(Stdio::null());
    script.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?)))).env("TERM", "xterm");
    script.env_remove("NO_COLOR").env_remove("CLICOLOR").env_remove("CLICOLOR_FORCE");
    stdout(&script.output().unwrap())
}

#[test]
#[cfg(target_os = "linux")]
fn a_terminal_shows_bar_and_colour_unless_they_are_not_wanted() {
    // Long enough for the bar to be drawn, ten times a second.
    let mut case = small_with("/solver/end_time_us", json!(4000));
    case["solver"]["run_until"] = json!("end_time");
    let bench = Bench::new(&case);
    let run = "run shot.json --backend cpu --threads 1";
    let shown = on_a_terminal(&bench, 100, run, "");
    for part in ["/4000 µs", " m/s", " left", "\u{1b}[1m", "PERFORATED"] {
        assert!(shown.contains(part), "{part:?} in\n{shown:?}");
    }
    for off in ["NO_COLOR=1", "CLICOLOR=0"] {
        let grey = on_a_terminal(&bench, 100, run, off);
        let has_colour = ["[1m", "[31", "[32", "[33", "[36"].iter().any(|code| grey.contains(&format!("\u{1b}{code}")));
        assert!(grey.contains(" left") && !has_colour, "{off}: {grey:?}");
    }
    assert_eq!(on_a_terminal(&bench, 100, &format!("{run} --quiet"), ""), "");
}

#[test]
fn warnings_of_a_case_are_shown_by_check_and_by_the_run() {
    let mut case = small_with("/solver/end_time_us", json!(2));
    // Else the step makes more than a hundredth of the little that the fabric has taken up by then.
    case["solver"]["courant"] = json!(0.3);
    let bench = Bench::new(&case);
    let assumed = warnings::assumed_fields(&run(&small()).0).count();
    for (set, expected) in [
        ("/projectile/diameter_mm=3.9", &["W1"][..]),
        ("/projectile/diameter_mm=3.7", &["W1", "W6"]), // three elements are 3.81 mm
        ("/projectile/mass_g=0.3", &["W1", "W7"]),      // 300 kg/m³
        ("/projectile/mass_g=30", &["W1", "W7"]),
        ("/projectile/density_kg_m3=2700", &["W1", "W7"]), // the mass given is a tenth more
        ("/projectile/density_kg_m3=2950", &["W1"]),
        ("/fabric/areal_density_g_m2=265", &["W1"]), // of yarns of 252.9 g/m²
        ("/fabric/areal_density_g_m2=266", &["W1", "W7"]),
        ("/fabric/areal_density_g_m2=190", &["W1", "W7"]),
        ("/pack/crossovers_per_element=2", &["W1", "W5", "W6"]),
        ("/fabric/fibre_density_kg_m3=3000", &["W1"]),
        ("/fabric/fibre_density_kg_m3=3010", &["W1", "W9"]),
        ("/fabric/weft/modulus_gpa=228", &["W1"]), // 7.98 GPa
        ("/fabric/weft/modulus_gpa=229", &["W1", "W9"]),
    ] {
        let text = stdout(&bench.ripstop(&["check", "shot.json", "--set", set]));
        let output = bench.shoot(&["--set", set, "--out", "out/shot"]);
        assert_eq!((code(&output), stderr(&output)), (0, String::new()));
        let summary = bench.json("out/shot/summary.json");
        let listed = summary["warnings"].as_array().unwrap();
        let codes: Vec<&str> = listed.iter().map(|warning| warning["code"].as_str().unwrap()).collect();
        assert_eq!((codes, &listed[0]["value"]), (expected.to_vec(), &json!(assumed as f64)), "{set}");
        for warning in listed {
            let line = format!("{}  {}", warning["code"].as_str().unwrap(), warning["message"].as_str().unwrap());
            assert!(text.contains(&line) && stdout(&output).contains(&line), "{line} in\n{text}");
        }
    }
}

#[test]
fn explain_knows_every_code_by_number_and_name_and_its_threshold() {
    let names = KINDS.each_ref().map(|kind| format!("{} {}", kind.code, kind.name)).join(", ");
    let given = "W1 assumed-parameters, W2 energy, W3 hourglass, W4 penetration, W5 coarse-mesh, W6 small-projectile, W7 mass, W8 torn-off, \
                 W9 fibre";
    assert_eq!(names, given, "codes and names once given stay");
    let bench = Bench::new(&small());
    let explain = |code: &str| stdout(&bench.ripstop(&["explain", code]));
    let list = stdout(&bench.ripstop(&["explain"]));
    for kind in &KINDS {
        let text = explain(kind.code);
        assert!(text.starts_with(&format!("{} {}\n", kind.code, kind.name)) && list.contains(kind.name), "{text}");
        assert_eq!([explain(&kind.code.to_lowercase()), explain(kind.name)], [text.clone(), text]);
    }
    for exit in ["0", "1", "2", "3", "130"] {
        assert!(explain(exit).starts_with(&format!("{exit} ")), "{exit}");
    }
    for (code, limit) in [("W2", checks::ENERGY_LIMIT), ("W2", checks::GAINED_LIMIT), ("W3", checks::HOURGLASS_LIMIT)] {
        assert!(explain(code).contains(&format!("{} %", limit * 100.0)), "{code}");
    }
}
