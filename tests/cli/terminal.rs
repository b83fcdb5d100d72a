//! Text for people: the result, warnings and their explanations, colour and the bar at a terminal, the log.

use ripstop::output::checks::{self, checks};
use ripstop::output::warnings::{self, KINDS, Warning};

use super::*;

/// Text without colours: ESC [ … m.
fn without_colour(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once('m').map_or("", |(_, rest)| rest))
}

#[test]
fn the_table_begins_with_the_verdict_and_holds_what_a_reader_asks_for() {
    let bench = Bench::new(&small_with("/expect", json!([{"quantity": "elements", "min": 1, "source": "t"}])));
    let text = stdout(&bench.shoot(&["--frames", "5", "--no-skip=outcome"]));
    let verdict = text.lines().filter(|line| !line.is_empty()).nth(1).unwrap();
    assert!(verdict.starts_with("UNDECIDED at 10") && text.contains("struck at 600 m/s"), "{text}");
    for part in [
        "of 540",
        "contact",
        "energy absorbed",
        "energy per areal density",
        "peak contact force",
        "highest load of a yarn",
        "back-face deflection",
        "yarns broken",
        "parameters are assumed",
        "576 elements",
        "a quarter, mirrored at x = 0 and y = 0",
        "not skipped  outcome",
        "element-steps/s",
        "cpu",
        "pass  elements",
        "out/shot",
        "frames.pvd",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let output = bench.shoot(&["--json", "--precision", "f32"]);
    assert_eq!((stdout(&output), stderr(&output)), (bench.text("out/shot/summary.json"), String::new()));
    assert_eq!(bench.json("out/shot/summary.json")["precision"], "f32");
}

#[test]
fn numbers_on_the_terminal_are_those_of_the_summary() {
    let names = ["peak_yarn_tension_n", "breaking_load_ratio", "last_ply_deflection_mm", "peak_contact_force_n"];
    let expect = names.map(|name| json!({"quantity": name, "min": 0, "source": "t"}));
    let bench = Bench::new(&small_with("/expect", json!(expect)));
    let text = stdout(&bench.shoot(&["--set", "/projectile/velocity_m_s=100", "--out", "out/shot"]));
    let summary = bench.json("out/shot/summary.json");
    let own = [("max_deflection_mm", "deflected "), ("breaking_load_ratio", "load of a yarn ")];
    let expected = names.map(|name| (name, format!("pass  {name} ≥ 0, got ")));
    for (name, before) in own.map(|(name, before)| (name, before.to_owned())).iter().chain(&expected) {
        let unit = if before.ends_with("yarn ") { 100.0 } else { 1.0 };
        let shown = text.split_once(before).unwrap().1.split_whitespace().next().unwrap();
        let (shown, kept) = (shown.parse::<f64>().unwrap() / unit, summary[*name].as_f64().unwrap());
        assert!(kept > 0.0 && (shown / kept - 1.0).abs() < 1e-3, "{name}: {shown} for {kept}");
    }
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
    let plain = stdout(&bench.ripstop(&run));
    assert!(plain.contains("pass  elements") && !plain.contains('\u{1b}'), "{plain}");
    assert!(stdout(&forced(&run)).contains("\u{1b}[32mpass"), "{}", stdout(&forced(&run)));
    let json = forced(&[&run[..], &["--json"]].concat());
    assert!(!stdout(&json).contains('\u{1b}'), "{}", stdout(&json));
}

/// Text that a program shows on a terminal of so many columns, made by `script` of util-linux.
#[cfg(target_os = "linux")]
pub(super) fn on_a_terminal(bench: &Bench, columns: usize, arguments: &str, environment: &str) -> String {
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
    for part in ["/4000 µs", " m/s", " yarns failed", " M/s", " left", "\u{1b}[1m", "PERFORATED"] {
        assert!(shown.contains(part), "{part:?} in\n{shown:?}");
    }
    for off in ["NO_COLOR=1", "CLICOLOR=0"] {
        let grey = on_a_terminal(&bench, 100, run, off);
        let has_colour = ["[1m", "[31", "[32", "[33", "[36"].iter().any(|code| grey.contains(&format!("\u{1b}{code}")));
        assert!(grey.contains(" left") && grey.contains("PERFORATED") && !has_colour, "{off}: {grey:?}");
    }
    assert_eq!(on_a_terminal(&bench, 100, &format!("{run} --quiet"), ""), "");
}

#[test]
#[cfg(target_os = "linux")]
fn lines_end_between_words_and_a_check_has_eighty_columns() {
    let bench = Bench::new(&small_with("/expect", json!([{"quantity": "elements", "min": 1, "source": "t"}])));
    let widest = |text: &str| text.lines().map(|line| line.chars().count()).max().unwrap();
    let words = |text: &str| without_colour(text).split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let arguments = ["check shot.json", "check shot.json --all", "explain W4", "run shot.json --backend cpu -o out"];
    for (line, tolerated) in arguments.into_iter().zip([0, 0, 0, 5]) {
        let page = stdout(&bench.ripstop(&line.split(' ').collect::<Vec<_>>()));
        assert!(widest(&page) <= 80 || !line.contains("check"), "{page}");
        let narrow = on_a_terminal(&bench, 60, line, "NO_COLOR=1");
        let narrow = narrow.rsplit("\u{1b}[2K").next().unwrap().replace('\r', "");
        assert!(widest(&narrow) <= 60, "{narrow}");
        // A run says how long it took.
        let off = words(&page).iter().zip(&words(&narrow)).filter(|(page, narrow)| page != narrow).count();
        assert!(words(&page).len() == words(&narrow).len() && off <= tolerated, "{page}\n{narrow}");
    }
    let stopped = stdout(&bench.shoot(&["--set", "/projectile/velocity_m_s=60", "--set", "/solver/end_time_us=400"]));
    assert!(stopped.lines().count() <= 40, "{stopped}");
}

fn codes(warnings: &[Warning]) -> Vec<&'static str> {
    warnings.iter().map(|warning| warning.kind.code).collect()
}

#[test]
fn a_run_is_warned_of_above_each_threshold_and_not_at_it() {
    let (mut case, run) = run(&small_with("/solver/end_time_us", json!(2)));
    case.fields.clear();
    let diagonal = case.pack.mesh.length[0].hypot(case.pack.mesh.length[1]);
    type Set = fn(&mut Run, f64);
    let set: [(&str, f64, Set); 4] = [
        ("W2", checks::ENERGY_LIMIT, |run, value| run.energy_error = value),
        ("W3", checks::HOURGLASS_LIMIT, |run, value| run.hourglass_fraction = value),
        ("W4", 0.5 * diagonal, |run, value| run.max_penetration = value),
        ("W4", case.fabric.thickness, |run, value| (run.plies, run.max_ply_penetration) = (2, value)),
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
        assert!((above[0].value / above[0].limit - 1.001).abs() < 1e-9, "{:?}", above[0]);
        assert_eq!(codes(&with(f64::NAN)), [code], "no number is no good number");
    }
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
            let keys: Vec<&String> = warning.as_object().unwrap().keys().collect();
            assert_eq!(keys, ["code", "name", "message", "value", "limit"]);
            let line = format!("{}  {}", warning["code"].as_str().unwrap(), warning["message"].as_str().unwrap());
            assert!(text.contains(&line) && stdout(&output).contains(&line), "{line} in\n{text}");
        }
        for absent in KINDS.iter().filter(|kind| !expected.contains(&kind.code)) {
            assert!(!text.contains(&format!("{}  ", absent.code)), "{} in\n{text}", absent.code);
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
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>().join(" ");
    let list = words(&stdout(&bench.ripstop(&["explain"])));
    for kind in &KINDS {
        let text = explain(kind.code);
        assert!(text.starts_with(&format!("{} {}\n", kind.code, kind.name)), "{text}");
        for part in ["measured  ", "given  ", "means  ", "to do  "] {
            assert!(text.contains(part), "{part} in\n{text}");
        }
        assert_eq!([explain(&kind.code.to_lowercase()), explain(kind.name)], [text.clone(), text]);
        assert!(list.contains(&format!("{} {}", kind.code, kind.name)), "{list}");
    }
    for (exit, part) in [("0", "done"), ("1", "expectation"), ("2", "input"), ("3", "device"), ("130", "Ctrl-C")] {
        let text = explain(exit);
        assert!(text.starts_with(&format!("{exit} ")) && text.contains(part), "{text}");
        assert!(text.contains("means") && text.contains("to do"), "{text}");
    }
    let percent = |limit: f64| format!("above {} %", limit * 100.0);
    let energy =
        [checks::GAINED_LIMIT, checks::ENERGY_LIMIT].map(percent).join(" created or dissipated, or an error of work ");
    for (number, text) in [
        (2, energy),
        (3, percent(checks::HOURGLASS_LIMIT)),
        (5, format!("above {}", checks::CROSSOVERS_LIMIT)),
        (6, format!("below {}", checks::CELLS_LIMIT)),
    ] {
        let explained = words(&explain(KINDS[number - 1].code));
        assert!(explained.contains(&format!("given {text}")), "{text} in\n{explained}");
    }
}
