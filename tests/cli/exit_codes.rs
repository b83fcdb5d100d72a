//! 0, 1, 2, 3 and 130.

use super::*;

#[test]
fn a_failed_expectation_is_1_and_the_results_are_there() {
    let expect = json!([{"quantity": "outcome", "value": "stopped", "source": "this test"}]);
    let bench = Bench::new(&small_with("/expect", expect));
    let output = bench.shoot(&["--quiet"]);
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).contains("outcome: expected stopped, got running"), "{}", stderr(&output));
    assert!(output.stdout.is_empty());
    assert_eq!(bench.json("out/shot/summary.json")["expect"][0]["pass"], false);
}

#[test]
fn bad_input_is_2_and_nothing_is_written() {
    let bench = Bench::new(&small());
    fs::write(bench.path("broken.json"), "{ \"title\": ").unwrap();
    fs::write(bench.path("file"), "").unwrap();
    let overlap = r#"/pack/initial_deflection={"amplitude_mm":-2,"warp_half_waves":1,"weft_half_waves":1}"#;
    let refused: [(&[&str], &str); 16] = [
        (&["run", "broken.json"], "line 1, column"),
        (&["run", "absent.json"], "absent.json"),
        (&["run", "shot.json", "--set", "/projectile/velocity=1"], "velocity_m_s"),
        (&["run", "shot.json", "--set", "/pack/pretension/warp_n_per_m=1e7"], "/pack/pretension"),
        (&["run", "shot.json", "--set", overlap], "/projectile"),
        (&["run", "shot.json", "--out", "file"], "a file"),
        (&["run", "shot.json", "--out", "file/below"], "file/below"),
        (&["run", "shot.json", "--threads", "0"], "--threads"),
        (&["run", "shot.json", "--precision", "f16"], "f64"),
        (&["run", "shot.json", "--backend", "gpu", "--precision", "f64"], "--backend cpu"),
        (&["verify", "--backend", "gpu", "--precision", "f64"], "--backend cpu"),
        (&["run", "shot.json", "--backend", "cpu", "--adapter", "0"], "--adapter"),
        (&["run", "shot.json", "--backend", "tpu"], "auto, cpu, gpu"),
        (&["run", "shot.json", "--frames", "10001"], "/output/frames"),
        (&["run"], "CASE.json"),
        (&["fly"], "fly"),
    ];
    for (arguments, named) in refused {
        let output = bench.ripstop(arguments);
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{arguments:?}: {message}");
        assert!(message.contains("error: ") && message.contains(named), "{arguments:?}: {message}");
        assert_eq!(message.matches("error: ").count(), 1, "{message}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(bench.names("."), ["broken.json", "file", "shot.json"]);
}

#[test]
fn results_never_replace_the_case() {
    let bench = Bench::new(&small());
    fs::rename(bench.path("shot.json"), bench.path("case.json")).unwrap();
    let before = bench.text("case.json");
    let output = bench.ripstop(&["run", "case.json", "--out", "."]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert_eq!(bench.text("case.json"), before);
    assert_eq!(bench.names("."), ["case.json"]);
}

#[cfg(unix)]
#[test]
fn ctrl_c_is_130_with_complete_results() {
    let bench = Bench::new(&small());
    let long = ["/solver/end_time_us=1e6", "/solver/run_until=end_time", "/output/history_interval_us=50"];
    let mut arguments = vec!["run", "shot.json", "--backend", "cpu", "--json", "--out", "out/shot"];
    arguments.extend(long.iter().flat_map(|set| ["--set", set]));
    let output = bench.interrupt(&arguments, "out/shot");
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    assert!(stderr(&output).contains("interrupted at"));
    assert_eq!(
        bench.names("out/shot"),
        ["case.json", "events.csv", "history.csv", "report.html", "shot.svg", "summary.json"]
    );
    let summary = bench.json("out/shot/summary.json");
    assert_eq!(summary["interrupted"], true);
    assert_eq!(summary, serde_json::from_str::<Value>(&stdout(&output)).unwrap());
    let history = bench.text("out/shot/history.csv");
    let last: f64 = history.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert_eq!(last, summary["time_us"].as_f64().unwrap());
    assert!(last < 1e6);
}
