//! `ripstop diff`.
//!
//! Promise: differences are those of the files, by closed forms; every bad input is one error with exit code 2 and writes nothing; with
//! `--within` the exit code says whether what is judged is good.

use super::*;

/// Two runs of the small shot, the second 2 % faster, beside a third that is the first again.
fn shots() -> Bench {
    let bench = Bench::new(&small());
    for (folder, velocity) in [("a", "600"), ("b", "612"), ("again", "600")] {
        let set = format!("/projectile/velocity_m_s={velocity}");
        assert_eq!(code(&bench.shoot(&["-q", "--no-report", "--set", &set, "-o", folder])), 0);
    }
    bench
}

/// A folder with tables alone.
fn tables(files: &[(&str, &str)]) -> Bench {
    let bench = Bench::new(&small());
    for (name, text) in files {
        fs::write(bench.path(name), text).unwrap();
    }
    bench
}

fn diff(bench: &Bench, arguments: &[&str]) -> Output {
    bench.ripstop(&[&["diff"], arguments].concat())
}

fn diff_json(bench: &Bench, arguments: &[&str]) -> Value {
    let output = diff(bench, &[arguments, &["--json"]].concat());
    serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)))
}

/// The entry of a list by its name.
fn named<'a>(list: &'a Value, name: &str) -> &'a Value {
    list.as_array().unwrap().iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{name} in {list:#}"))
}

fn near(value: &Value, expected: f64) {
    let got = value.as_f64().unwrap_or_else(|| panic!("{value} instead of {expected}"));
    assert!((got - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{got} instead of {expected}");
}

#[test]
fn two_runs_are_laid_side_by_side() {
    let bench = shots();
    let found = &diff_json(&bench, &["a", "b"])["comparisons"][0];
    let key = json!([{"pointer": "/projectile/velocity_m_s", "a": 600, "b": 612}]);
    assert_eq!((&found["case"], &found["machine"]), (&key, &json!([])));
    let summaries = ["a", "b"].map(|folder| bench.json(&format!("{folder}/summary.json")));
    for name in ["residual_velocity_m_s", "absorbed_energy_j", "steps", "failed_yarns.warp", "trust.advice"] {
        let row = named(&found["summary"], name);
        let [a, b] = summaries.each_ref().map(|s| s.pointer(&format!("/{}", name.replace('.', "/"))).unwrap());
        assert_eq!((&row["a"], &row["b"]), (a, b), "{name}");
        if let (Some(a), Some(b)) = (a.as_f64(), b.as_f64()) {
            near(&row["difference"], b - a);
            near(&row["relative"], if a == b { 0.0 } else { (b - a) / a });
        }
    }
    let curve = named(&found["curves"], "projectile_velocity_m_s");
    assert_eq!(curve["parts_at_us"], 0.0);
    assert!(curve["largest_relative"].as_f64().unwrap() >= 0.02, "{curve}");
    assert_eq!(found["parts"], json!({"name": "projectile_velocity_m_s", "at_us": 0.0}));
    // The first contact force is an impulse over one step, and no point of the curve.
    assert!(named(&found["curves"], "contact_force_n")["span_us"][0].as_f64() > Some(0.1));
    // What is a share already is not made relative.
    let error = named(&found["curves"], "energy_gained");
    assert_eq!(error["largest_relative"].as_f64(), error["largest"].as_f64().map(f64::abs));
    // The terms of the absorbed energy, at the end of each run.
    let history = bench.text("b/history.csv");
    let at = history.lines().next().unwrap().split(',').position(|name| name == "internal_energy_j").unwrap();
    let last: f64 = history.lines().last().unwrap().split(',').nth(at).unwrap().parse().unwrap();
    near(&named(&found["summary"], "internal_energy_j")["b"], last);
    // For people: no wider than 80 columns.
    let text = stdout(&diff(&bench, &["a", "b", "--within", "1"]));
    for part in ["residual_velocity_m_s", "/projectile/velocity_m_s", "B - A", "they part first at 0 µs", "FAIL"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn a_run_does_not_differ_from_itself() {
    let bench = shots();
    let found = diff_json(&bench, &["a", "again", "--within", "1e-9"]);
    assert_eq!(found["pass"], true);
    let found = &found["comparisons"][0];
    assert_eq!((&found["case"], &found["machine"], &found["parts"]), (&json!([]), &json!([]), &Value::Null));
    let curves = found["curves"].as_array().unwrap();
    assert_eq!(curves.len(), 25);
    for row in curves {
        assert_eq!(
            (&row["largest"], &row["rms"], &row["parts_at_us"]),
            (&json!(0.0), &json!(0.0), &Value::Null),
            "{row}"
        );
    }
    for row in found["summary"].as_array().unwrap().iter().filter(|row| row["name"] != "wall_s") {
        assert_eq!(row["a"], row["b"]);
    }
    let text = stdout(&diff(&bench, &["a", "again"]));
    assert!(text.contains("the same to the last digit: all 25"), "{text}");
    // A folder and its history are the same curves.
    let found = diff_json(&bench, &["a", "again/history.csv"]);
    assert_eq!(found["inputs"][1]["kind"], "curve");
    assert!(found["comparisons"][0]["curves"].as_array().unwrap().iter().all(|row| row["largest"] == 0.0));
}

/// v = 100 − t against 102 − 1.1 t, measured in ms and from 10 to 50 µs only: they differ by 2 − t/10, from 1 to −3.
const LINE: &str = "time_us,projectile_velocity_m_s\n0,100\n30,70\n100,0\n";
const CAMERA: &str = "\u{feff}# camera\r\n\"Time (ms)\";\"Velocity (m/s)\"\r\n0.01;91\r\n0.02;80\r\n0.05;47\r\n";

#[test]
fn a_measured_curve_is_compared_where_both_are_known() {
    let bench = tables(&[("line.csv", LINE), ("camera.csv", CAMERA)]);
    let found = diff_json(&bench, &["line.csv", "camera.csv"]);
    let curve = &found["comparisons"][0]["curves"][0];
    assert_eq!(curve["span_us"], json!([10.0, 50.0]));
    near(&curve["largest"], -3.0);
    near(&curve["largest_at_us"], 50.0);
    // The mean of (2 − t/10)² over the span is (1³ + 3³)/(3·4).
    near(&curve["rms"], (28.0 / 12.0_f64).sqrt());
    near(&curve["scale"], 90.0);
    near(&curve["largest_relative"], 3.0 / 90.0);
    // More than 1 % of 90 at once.
    near(&curve["parts_at_us"], 10.0);
    assert_eq!(found["comparisons"][0]["summary"], json!([]));
    // 2 % of 90 are passed at 38 µs.
    let found = diff_json(&bench, &["line.csv", "camera.csv", "--within", "2"]);
    near(&found["comparisons"][0]["curves"][0]["parts_at_us"], 38.0);
    // A clock that is late by 10: the measured curve is now 102 − 1.1 (t + 10), from 0 to 40.
    let found = diff_json(&bench, &["line.csv", "camera.csv", "--shift", "-10"]);
    let curve = &found["comparisons"][0]["curves"][0];
    assert_eq!(curve["span_us"], json!([0.0, 40.0]));
    near(&curve["largest"], -13.0);
    near(&curve["scale"], 100.0);
}

#[test]
fn headings_are_mapped_and_curves_chosen() {
    let other = "t_s,\"Ch 1, v\",remark,force_kn\n0,0.1,x,1\n1e-4,0,y,1\n";
    let line = "time_us,projectile_velocity_m_s,contact_force_n\n0,100,1000\n100,0,500\n";
    let bench = tables(&[("line.csv", line), ("other.csv", other)]);
    let both = ["line.csv", "other.csv"];
    let mapped = [&both[..], &["--column", "Ch 1, v=velocity_km_s"]].concat();
    let output = diff(&bench, &[&mapped[..], &["--json"]].concat());
    assert_eq!(stderr(&output), "note: other.csv: column \"remark\" is left out: line 2 holds \"x\"\n");
    let found: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let curves = &found["comparisons"][0]["curves"];
    near(&named(curves, "projectile_velocity_m_s")["largest"], 0.0);
    near(&named(curves, "contact_force_n")["largest"], 500.0);
    // Only what is named is compared and judged.
    assert_eq!(code(&diff(&bench, &[&mapped[..], &["--within", "1", "-q"]].concat())), 0);
    let force = [&mapped[..], &["--column", "contact_force_n", "--within", "49.9"]].concat();
    let output = diff(&bench, &force);
    assert_eq!(code(&output), 1);
    let message = stderr(&output);
    assert!(message.contains("error: line.csv: others differ by more than 49.90 %"), "{message}");
    assert!(message.contains("B: curve contact_force_n: 500 N (50.000 %) at 100.000 µs"), "{message}");
    assert!(!stdout(&output).contains("projectile_velocity_m_s  "), "{}", stdout(&output));
    assert_eq!(code(&diff(&bench, &[&force[..4], &["--column", "force_n", "--within", "50%"]].concat())), 0);
}

#[test]
fn a_scripts_exit_code_says_whether_two_runs_agree() {
    let bench = shots();
    assert_eq!(code(&diff(&bench, &["a", "b", "-q", "--within", "10"])), 0);
    let output = diff(&bench, &["a", "b", "again", "-q", "--within", "0.5"]);
    assert_eq!((code(&output), stdout(&output).as_str()), (1, ""));
    let message = stderr(&output);
    assert!(
        message.contains("B: absorbed_energy_j") && message.contains("B: curve projectile_velocity_m_s"),
        "{message}"
    );
    assert!(!message.contains("C: "), "{message}");
    assert_eq!(diff_json(&bench, &["a", "b"])["pass"], Value::Null);
}

#[test]
fn files_hold_the_curves_over_each_other_and_need_nothing_else() {
    let bench = tables(&[("line.csv", LINE), ("camera.csv", CAMERA), ("<b>&.csv", LINE)]);
    assert_eq!(code(&diff(&bench, &["line.csv", "camera.csv", "<b>&.csv", "-q", "-o", "out/d"])), 0);
    assert_eq!(bench.names("out/d"), ["diff.csv", "diff.html", "diff.svg"]);
    let csv = bench.text("out/d/diff.csv");
    let mut lines = csv.lines();
    let name = "projectile_velocity_m_s";
    let heads = format!("time_us,{name}_a,{name}_b,{name}_c,{name}_b_minus_a,{name}_c_minus_a");
    assert_eq!(lines.next().unwrap(), heads);
    // All times of all; nothing where a curve is not known.
    let rows: Vec<&str> = lines.collect();
    assert_eq!(
        rows,
        ["0,100,,100,,0", "10,90,91,90,1,0", "20,80,80,80,0,0", "30,70,69,70,-1,0", "50,50,47,50,-3,0", "100,0,,0,,0"]
    );
    let [svg, html] = ["out/d/diff.svg", "out/d/diff.html"].map(|name| bench.text(name));
    for text in [&svg, &html] {
        assert!(text.contains("projectile velocity [m/s]") && text.contains("time [µs]"));
        assert!(text.contains("stroke-dasharray=\"none\"") && text.contains("stroke-dasharray=\"8 4\""));
        assert!(text.contains("&lt;b&gt;&amp;.csv") && !text.contains("<b>"));
        assert_eq!(text.matches("<polyline").count(), 3);
        let external = text.replace("http://www.w3.org/2000/svg", "");
        assert!(!external.contains("://") && !external.contains("<script"));
    }
    assert!(html.contains("C against A"));
}

#[test]
fn what_was_read_is_never_replaced() {
    let bench = tables(&[("diff.csv", LINE), ("camera.csv", CAMERA)]);
    let output = diff(&bench, &["diff.csv", "camera.csv", "-o", "."]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("diff.csv, which was read"), "{}", stderr(&output));
    assert_eq!(bench.text("diff.csv"), LINE);
    assert_eq!(bench.names("."), ["camera.csv", "diff.csv", "shot.json"]);
}

#[test]
fn bad_input_is_one_error_and_nothing_is_written() {
    let bench = tables(&[
        ("line.csv", LINE),
        ("empty.csv", ""),
        ("late.csv", "time_s,velocity_m_s\n1,2\n2,3\n"),
        ("other.csv", "time_us,pressure\n0,1\n1,2\n"),
        ("comma.csv", "time_us;velocity_m_s\n0;1\n1;99,5\n"),
        ("back.csv", "time_us,velocity_m_s\n1,1\n0,2\n"),
        ("nan.csv", "time_us,velocity_m_s\nnan,1\n0,2\n"),
    ]);
    fs::write(bench.path("binary.csv"), [0x50, 0x4b, 3, 4, 0, 0, 0xff]).unwrap();
    fs::File::create(bench.path("huge.csv")).unwrap().set_len(33 << 20).unwrap();
    for (folder, files) in [("bare", &[][..]), ("begun", &["case.json"]), ("stopped", &["case.json", "checkpoint.bin"])]
    {
        fs::create_dir(bench.path(folder)).unwrap();
        files.iter().for_each(|name| fs::write(bench.path(folder).join(name), "{}").unwrap());
    }
    for (folder, summary) in [("cut", "{\"interrupted\": true, \"time_us\": 5}"), ("broken", "{\"interr")] {
        fs::create_dir(bench.path(folder)).unwrap();
        fs::write(bench.path(folder).join("summary.json"), summary).unwrap();
    }
    let before = bench.names(".");
    let refused: [(&[&str], &str); 21] = [
        (&["absent.csv"], "absent.csv"),
        (&["empty.csv"], "an empty file"),
        (&["binary.csv"], "the byte 0x00"),
        (&["huge.csv"], "a file of at most 32 MiB"),
        (&["late.csv"], "--shift"),
        (&["other.csv"], "--column HEADING="),
        (&["comma.csv"], "decimal point"),
        (&["back.csv"], "line 3, column \"time_us\""),
        (&["nan.csv"], "line 2, column \"time_us\""),
        (&["bare"], "no summary.json"),
        (&["begun"], "the run has not ended"),
        (&["stopped"], "ripstop resume stopped"),
        (&["cut"], "broken off at 5 µs"),
        (&["broken"], "broken/summary.json"),
        (&["line.csv", "--column", "contact_force_n"], "--column contact_force_n"),
        (&["line.csv", "--column", "v=velocty_m_s"], "did you mean velocity_m_s?"),
        (&["line.csv", "--column", "v=velocity_m_s"], "a heading of one of the files"),
        (&["line.csv", "--within", "0"], "--within"),
        (&["line.csv", "--within", "-1"], "--within"),
        (&["line.csv", "--shift", "soon"], "--shift"),
        (&["line.csv", "-o", "line.csv"], "a file"),
    ];
    for (arguments, named) in refused {
        let with_folder = if arguments.contains(&"-o") { &[][..] } else { &["-o", "out"] };
        let output = diff(&bench, &[&["line.csv"], arguments, with_folder].concat());
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{arguments:?}: {message}");
        assert!(message.contains(named) && message.matches("error: ").count() == 1, "{arguments:?}: {message}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(code(&diff(&bench, &["line.csv"])), 2);
    assert_eq!(code(&diff(&bench, &["line.csv"; 9])), 2);
    assert_eq!(bench.names("."), before);
}
