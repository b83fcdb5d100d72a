//! `ripstop bench --objectivity`: settings, spreads and verdict from the numbers it writes.

use super::*;

/// Limits of an axis with the reference's, or another number of each.
fn values(report: &Value, axis: &str, key: &str) -> Vec<f64> {
    let settings = report["settings"].as_array().unwrap();
    let of_axis = |one: &&Value| one["axis"] == "reference" || one["axis"] == axis;
    settings.iter().filter(of_axis).map(|one| one[key].as_f64().unwrap_or_else(|| panic!("{key} of {one:#}"))).collect()
}

fn spread(values: &[f64]) -> f64 {
    let [low, high] = [f64::min, f64::max].map(|pick| values.iter().copied().reduce(pick).unwrap());
    (high - low) / values[0] * 100.0
}

#[test]
fn limits_are_bracketed_and_spreads_are_theirs() {
    let mut case = small_with("/solver/end_time_us", json!(100));
    case["pack"] = json!({"width_mm": 15.24, "height_mm": 15.24});
    case["projectile"]["velocity_m_s"] = json!(50);
    let bench = Bench::new(&case);
    let output = bench.ripstop(&["bench", "shot.json", "--objectivity", "--quick", "--threads", "2", "--json"]);
    assert_eq!(bench.names("out/bench"), ["objectivity.json"]);
    let report = bench.json("out/bench/objectivity.json");
    assert_eq!(report, serde_json::from_str::<Value>(&stdout(&output)).unwrap());
    let names: Vec<&str> =
        report["settings"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    let expected = [
        "the case as it is",
        "0.25, 0.25 cells",
        "0.5, 0.5 cells",
        "half as long elements",
        "twice as long elements",
        "0.5",
        "0.95",
    ];
    assert_eq!(names, expected);
    let reference = report["settings"][0]["limit_m_s"].as_f64().unwrap();
    for one in report["settings"].as_array().unwrap() {
        let [stopped, limit, perforated] =
            ["stopped_m_s", "limit_m_s", "perforated_m_s"].map(|key| one[key].as_f64().unwrap());
        assert!(0.0 < stopped && stopped < limit && limit < perforated, "{one:#}");
        // Half a per cent of the guess: the case's velocity, then the limit of the reference.
        assert!(perforated - stopped <= 0.005 * f64::max(50.0, reference) + 1e-9, "{one:#}");
    }
    let figures = report["figures"].as_array().unwrap();
    let got = |at: usize| figures[at]["got_percent"].as_f64().unwrap();
    let limit = "limit_m_s";
    let mean = "mean_residual_velocity_m_s";
    for (at, axis, key) in [
        (2, "position of the hit", limit),
        (4, "Courant number", limit),
        (5, "position of the hit", mean),
        (7, "Courant number", mean),
    ] {
        assert!((got(at) - spread(&values(&report, axis, key))).abs() < 1e-9, "{axis} {key}: {figures:#?}");
    }
    // Absorbed energies over the impact energy at the limit, where every shot has an outcome.
    let mass = case["projectile"]["mass_g"].as_f64().unwrap() * 1e-3;
    for at in 0..5 {
        let asked = |one: &&Value| one["axis"] != "coarser mesh";
        let settings = report["settings"].as_array().unwrap().iter().filter(asked);
        let energies: Option<Vec<f64>> = settings.map(|one| one["absorbed_energy_j"][at].as_f64()).collect();
        let share = energies.map(|energies| {
            let range = energies.iter().fold([f64::MAX, 0.0], |[low, high], e| [e.min(low), e.max(high)]);
            100.0 * (range[1] - range[0]) / (0.5 * mass * reference * reference)
        });
        let got = figures[8 + at]["got_percent"].as_f64();
        assert_eq!(got.is_some(), share.is_some(), "{figures:#?}");
        assert!(got.zip(share).is_none_or(|(got, share)| (got - share).abs() < 1e-9), "{figures:#?}");
    }
    assert!(figures[8..].iter().any(|one| one["got_percent"].is_number()), "{figures:#?}");
    for one in report["settings"].as_array().unwrap().iter().filter(|one| one["axis"] != "coarser mesh") {
        let [mean, error, deviation, low, high] = [
            "mean_residual_velocity_m_s",
            "standard_error_m_s",
            "standard_deviation_m_s",
            "smallest_m_s",
            "largest_m_s",
        ]
        .map(|key| one[key].as_f64().unwrap_or_else(|| panic!("{key} of {one:#}")));
        assert_eq!(one["shots_of_the_mean"], 4);
        assert!(low < mean && mean < high && high - low < 4.0 * deviation, "shots differ: {one:#}");
        assert!((error - deviation / 2.0).abs() < 1e-12 * deviation, "{one:#}");
        // The row as it is, its limit and nine more.
        assert!(one["shots"].as_u64().unwrap() >= 4 + 2 + 3, "{one:#}");
    }
    // The second shift is by half a cell.
    assert_eq!(figures[0]["got_percent"], report["settings"][2]["before_failure_percent"]);
    let met = figures.iter().filter(|one| one["met"] == true).count();
    for one in figures {
        let met = one["got_percent"].as_f64().is_some_and(|got| got <= one["allowed_percent"].as_f64().unwrap());
        assert_eq!(one["met"], json!(met));
    }
    assert_eq!(code(&output), i32::from(met < figures.len()), "{}", stderr(&output));
}

#[test]
fn one_case_at_a_time() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["bench", "shot.json", "shot.json", "--objectivity"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("one case"), "{}", stderr(&output));
}

#[test]
fn without_a_case_it_is_the_papers_shot() {
    let bench = Bench::new(&small());
    for options in [&["--objectivity"][..], &[]] {
        let driven = ["bench", "--set", "/projectile/motion=prescribed"];
        let output = bench.ripstop(&[&driven, options].concat());
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).starts_with("error: s720-1ply-155: /projectile\n"), "{}", stderr(&output));
    }
}
