//! What is printed, and where.

use super::*;

fn plain(output: &Output) {
    for text in [stdout(output), stderr(output)] {
        assert!(!text.contains('\u{1b}') && !text.contains('\r'), "{text}");
    }
}

#[test]
fn the_table_begins_with_the_verdict_and_holds_what_a_reader_asks_for() {
    let bench = Bench::new(&small_with("/expect", json!([{"quantity": "elements", "min": 1, "source": "t"}])));
    let output = bench.shoot(&["--frames", "5"]);
    assert_eq!(code(&output), 0);
    plain(&output);
    let text = stdout(&output);
    let verdict = text.lines().filter(|line| !line.is_empty()).nth(1).unwrap();
    assert!(verdict.starts_with("UNDECIDED at 10") && verdict.contains("struck at 600 m/s"), "{verdict}");
    let parts = [
        "lost by the projectile",
        "of 540",
        "fabric, kinetic",
        "hourglass",
        "contact",
        "friction",
        "yarn failure",
        "unaccounted",
        "energy gained",
        "work balance",
        "momentum error",
        "hourglass / internal",
        "fabric inside the projectile",
        "unit cells unsolved",
        "assumed parameters",
        "/fabric/crossover/gap_mm",
        "576 elements",
        "set by:",
        "element-steps/s",
        "cpu",
        "pass  elements",
        "out/shot",
        "history.csv",
        "frames",
        "frames.pvd",
    ];
    for part in parts {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}

#[test]
fn quiet_prints_nothing_and_json_prints_the_summary_alone() {
    let bench = Bench::new(&small());
    let output = bench.shoot(&["--quiet", "--set", "/output/frames=5"]);
    assert_eq!((code(&output), stdout(&output), stderr(&output)), (0, String::new(), String::new()));
    let output = bench.shoot(&["--json"]);
    assert_eq!(code(&output), 0);
    plain(&output);
    assert_eq!(stdout(&output), bench.text("out/shot/summary.json"));
    assert_eq!(stderr(&output), "");
}

#[test]
fn single_precision_says_so() {
    let bench = Bench::new(&small());
    let output = bench.shoot(&["--json", "--precision", "f32"]);
    let summary: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(summary["precision"], "f32");
}

#[test]
fn check_prints_every_field_and_what_follows_and_refuses_bad_cases() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["check", "shot.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    plain(&output);
    let text = stdout(&output);
    for field in &case::from_str("shot.json", &small().to_string(), &[]).unwrap().fields {
        assert!(text.contains(&field.pointer) && text.contains(&field.value), "{}", field.pointer);
    }
    for part in ["critical time step", "set by:", "steps", "element-steps", "memory", "elements", "576"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert_eq!(bench.names("."), ["shot.json"]);
    let output = bench.ripstop(&["check", "absent.json", "shot.json", "shot.json", "absent.json"]);
    assert_eq!(code(&output), 2);
    assert_eq!(stderr(&output).matches("error: absent.json").count(), 2);
    assert_eq!(stdout(&output).matches("/pack/width_mm").count(), 2);
    let overlap = r#"/pack/initial_deflection={"amplitude_mm":-2,"warp_half_waves":1,"weft_half_waves":1}"#;
    assert_eq!(code(&bench.ripstop(&["check", "shot.json", "--set", overlap])), 2);
}

#[test]
fn the_schema_is_one_and_accepts_the_case() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["schema"]);
    assert_eq!(code(&output), 0);
    let schema: Value = serde_json::from_str(&stdout(&output)).unwrap();
    jsonschema::draft202012::meta::validate(&schema).unwrap();
    let schema = jsonschema::draft202012::new(&schema).unwrap();
    assert!(schema.is_valid(&small()));
    assert!(!schema.is_valid(&small_with("/pack/plies", json!("many"))));
}

#[test]
fn info_says_what_the_machine_has_and_what_a_case_needs() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["info"]);
    assert_eq!(code(&output), 0);
    plain(&output);
    let machine = stdout(&output);
    for part in ["threads", "SIMD", "memory", "backend cpu", "f64 or f32", "auto chooses"] {
        assert!(machine.contains(part), "{part} in\n{machine}");
    }
    assert!(!machine.contains("kernels per step"), "{machine}");
    let output = bench.ripstop(&["info", "shot.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let scene = stdout(&output);
    let terms = ["law", "compression", "shear", "hourglass", "failure", "projectile", "friction", "rotation"];
    for part in terms.into_iter().chain(["a small shot", "device memory", "published, tension", "projectile_contact"]) {
        assert!(scene.contains(part), "{part} in\n{scene}");
    }
    let without = bench.path("without.json");
    let mut case = small();
    case.as_object_mut().unwrap().remove("projectile");
    fs::write(&without, case.to_string()).unwrap();
    let scene = stdout(&bench.ripstop(&["info", "without.json"]));
    assert!(scene.contains("element_force, node_update, energy_balance"), "{scene}");
    assert_eq!(code(&bench.ripstop(&["info", "absent.json"])), 2);
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
fn help_shows_how_a_run_is_asked_for() {
    let text = stdout(&Bench::new(&small()).ripstop(&["run", "--help"]));
    for part in ["--backend", "--out", "--set", "--threads", "--precision", "--quiet", "--json", "Examples:"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}
