//! `ripstop bench`: every choice against one reference, and what follows from the numbers.

use super::*;

/// The numbers of a choice.
fn choice<'a>(case: &'a Value, name: &str) -> &'a Value {
    let choices = case["choices"].as_array().unwrap();
    choices.iter().find(|choice| choice["name"].as_str().unwrap().starts_with(name)).unwrap_or_else(|| panic!("{name}"))
}

fn number(choice: &Value, key: &str) -> f64 {
    choice[key].as_f64().unwrap_or_else(|| panic!("{key} of {choice:#}"))
}

/// Time and error of a choice.
fn point(choice: &Value) -> [f64; 2] {
    ["loop_s", "velocity_error_percent"].map(|key| number(choice, key))
}

#[test]
fn every_choice_is_measured_and_the_front_is_what_nothing_beats() {
    let bench = Bench::new(&small());
    let output =
        bench.ripstop(&["bench", "shot.json", "--threads", "1", "--repeat", "2", "--tolerance", "50%", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(bench.names("out/bench"), ["bench.json", "bench.svg"]);
    let report = bench.json("out/bench/bench.json");
    assert_eq!(report, serde_json::from_str::<Value>(&stdout(&output)).unwrap());
    let common = ["version", "vectors"].map(|key| report[key].is_string());
    assert_eq!((common, &report["threads"], &report["adapter"]), ([true; 2], &json!(1), &Value::Null));
    assert_eq!((&report["repeat"], number(&report, "tolerance_percent")), (&json!(2), 50.0));
    let case = &report["cases"][0];
    let reference = &case["reference"];
    assert_eq!(number(reference, "courant"), 0.25);
    assert_eq!((&reference["precision"], &reference["backend"]), (&json!("f64"), &json!("cpu")));
    let scatter = number(reference, "scatter_percent");
    assert!(0.0 < scatter && scatter < 5.0, "{scatter}");
    let names: Vec<&str> = case["choices"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    let expected = [
        "default: f64, Courant 0.9, mesh 1",
        "f32",
        "Courant 0.95",
        "Courant 0.8",
        "Courant 0.5",
        "mesh 2",
        "mesh 4",
        "graded",
        "no symmetry",
        "no skip",
        "f32, Courant 0.95",
        "f32, mesh 2",
        "f32, graded",
    ];
    assert_eq!(names, expected);
    assert_eq!(case["skipped"], json!([]));
    let choices = case["choices"].as_array().unwrap();
    for one in choices {
        let [time, error] = point(one);
        assert!(time > 0.0 && error > 0.0 && error.is_finite(), "{one:#}");
        assert_eq!(one["loop_s_of_each_run"].as_array().unwrap().len(), 2);
        assert!(number(one, "element_steps_per_s") > 0.0);
        let beaten =
            choices.iter().map(point).any(|other| other[0] <= time && other[1] <= error && other != [time, error]);
        assert_eq!(one["on_front"], json!(!beaten), "{one:#}");
        assert_eq!(
            one["within_tolerance"],
            json!(one["same_outcome"] == true && error <= 50.0 && number(one, "end_error_percent") <= 50.0)
        );
    }
    let error = |name: &str| point(choice(case, name))[1];
    assert!(error("mesh 4") > error("mesh 2") && error("mesh 2") > error("default"));
    // What is left out changes nothing; in which numbers, next to nothing.
    assert_eq!(error("no skip"), error("no symmetry"));
    assert!((error("no symmetry") / error("default") - 1.0).abs() < 1e-6);
    assert!((error("f32") / error("default") - 1.0).abs() < 0.2);
    let within = choices.iter().filter(|one| one["within_tolerance"] == true);
    let cheapest = within.min_by(|a, b| number(a, "loop_s").total_cmp(&number(b, "loop_s"))).unwrap();
    assert_eq!(case["cheapest_within_tolerance"], cheapest["name"]);
    let svg = bench.text("out/bench/bench.svg");
    assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
    for name in ["default", "f32, mesh 2", "no skip", "asked for: 50 %"] {
        assert!(svg.contains(&format!(">{name}")), "{name}");
    }
}

#[test]
fn the_paper_s_shot_is_built_in_and_small_meshes_leave_choices_out() {
    let bench = Bench::new(&small());
    let shrunk = ["/pack/width_mm=17.8", "/pack/height_mm=17.8", "/solver/end_time_us=3"];
    let mut arguments = vec!["bench", "--backend", "cpu", "--out", "here", "--tolerance", "0.000001"];
    arguments.extend(shrunk.iter().flat_map(|set| ["--set", set]));
    let output = bench.ripstop(&arguments);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    let text = stdout(&output);
    for part in [
        "Kevlar 129 S-720, 1 ply, RCC at 155 m/s",
        "reference: CPU, f64, Courant 0.25",
        "left out: mesh 4: 14 crossovers along the warp do not divide by 4",
        "no choice has the reference's outcome and velocities and end within 0.0001 %",
        "files  here: bench.json, bench.svg",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let case = &bench.json("here/bench.json")["cases"][0];
    assert_eq!((&case["case"], &case["cheapest_within_tolerance"]), (&json!("s720-1ply-155"), &Value::Null));
    assert_eq!(case["skipped"][0]["name"], "mesh 4");
}

#[test]
fn bad_input_is_2_and_nothing_is_written() {
    let bench = Bench::new(&small());
    for wrong in ["much", "0", "-1%", "200%", "5", "nan", "%", ""] {
        let output = bench.ripstop(&["bench", "shot.json", "--tolerance", wrong]);
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{wrong}: {message}");
        for part in ["error: --tolerance\n", "  expected: ", &format!("  found: {wrong:?}\n"), "  help: "] {
            assert!(message.contains(part), "{wrong}: {part} in {message}");
        }
    }
    let refused: [(&[&str], &str); 5] = [
        (&["absent.json"], "absent.json"),
        (&["shot.json", "--set", "/projectile/motion=prescribed"], "one that is driven"),
        (&["shot.json", "--set", "/solver/courant=2"], "--set /solver/courant"),
        (&["shot.json", "--repeat", "0"], "--repeat"),
        (&["shot.json", "--out", "shot.json"], "a file"),
    ];
    for (arguments, named) in refused {
        let output = bench.ripstop(&[&["bench", "--backend", "cpu"], arguments].concat());
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{arguments:?}: {message}");
        assert!(message.contains("error: ") && message.contains(named), "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(bench.names("."), ["shot.json"]);
}

#[test]
fn results_never_replace_the_case() {
    let bench = Bench::new(&small());
    fs::rename(bench.path("shot.json"), bench.path("bench.json")).unwrap();
    let before = bench.text("bench.json");
    let output = bench.ripstop(&["bench", "bench.json", "--backend", "cpu", "--out", "."]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert_eq!((bench.text("bench.json"), bench.names(".")), (before, vec!["bench.json".to_owned()]));
}

#[cfg(unix)]
#[test]
fn ctrl_c_is_130_and_what_was_measured_is_there() {
    let bench = Bench::new(&small());
    let arguments = ["bench", "shot.json", "--backend", "cpu", "--repeat", "1000", "--quiet"];
    let output = bench.interrupt(&arguments, "out/bench");
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    assert_eq!(bench.names("out/bench"), ["bench.json", "bench.svg"]);
    let report = bench.json("out/bench/bench.json");
    assert_eq!((&report["interrupted"], &report["cases"][0]["interrupted"]), (&json!(true), &json!(true)));
    assert!(report["cases"][0]["choices"].as_array().unwrap().len() < 11);
}
