//! `ripstop crossover`.

use super::*;

fn solve(arguments: &[&str]) -> Output {
    let bench = Bench::new(&small_with("/fabric/crossover/compression", json!("rigid")));
    let mut all = vec!["crossover", "shot.json"];
    all.extend(arguments);
    bench.ripstop(&all)
}

fn solve_json(arguments: &[&str]) -> Value {
    let output = solve(arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

fn near(value: &Value, expected: f64, tolerance: f64) {
    assert!((value.as_f64().unwrap() - expected).abs() <= tolerance, "{value} {expected}");
}

/// the verification table, rigid S-720; half a unit of the last digit printed there.
#[test]
fn meets_the_published_numbers_of_every_law() {
    let at = ["--warp-stretch", "1.010", "--weft-stretch", "1", "--json"];
    let published = solve_json(&at);
    assert_eq!(published["law"], "published");
    let point = &published["points"][0];
    near(&point["warp_height_mm"], 0.105521, 5.1e-7);
    near(&point["weft_height_mm"], 0.110638, 5.1e-7);
    near(&point["warp_tension_n"], 50.0251, 5.1e-5);
    near(&point["weft_tension_n"], 47.4183, 5.1e-5);
    near(&point["contact_force_n"], 25.0347, 5.1e-5);
    assert!(point["iterations"].is_u64() && point["residual"].as_f64().unwrap() < 1e-6);
    let keys: Vec<&String> = point.as_object().unwrap().keys().collect();
    let contract = [
        "warp_stretch",
        "weft_stretch",
        "warp_tension_n",
        "weft_tension_n",
        "contact_force_n",
        "warp_height_mm",
        "weft_height_mm",
        "warp_strain",
        "weft_strain",
        "iterations",
        "residual",
    ];
    assert_eq!(keys, contract);
    for (law, warp, force) in [("variational", 50.0444, 19.8285), ("kawabata", 50.0246, 17.9505)] {
        let solved = solve_json(&[&at[..], &["--law", law]].concat());
        assert_eq!(solved["law"], law);
        near(&solved["points"][0]["warp_tension_n"], warp, 5.1e-5);
        near(&solved["points"][0]["contact_force_n"], force, 5.1e-5);
    }
}

#[test]
fn a_grid_is_complete_and_the_same_in_every_form() {
    let grid = ["--warp-stretch", "1:1.04:3", "--weft-stretch", "0.99:1.01:2"];
    let solved = solve_json(&[&grid[..], &["--json"]].concat());
    let points = solved["points"].as_array().unwrap();
    let stretches: Vec<[f64; 2]> =
        points.iter().map(|p| ["warp_stretch", "weft_stretch"].map(|key| p[key].as_f64().unwrap())).collect();
    assert_eq!(stretches, [[1.0, 0.99], [1.0, 1.01], [1.02, 0.99], [1.02, 1.01], [1.04, 0.99], [1.04, 1.01]]);
    let csv = stdout(&solve(&[&grid[..], &["--csv"]].concat()));
    assert_eq!(csv.lines().count(), 7);
    let tension: f64 = csv.lines().nth(6).unwrap().split(',').nth(2).unwrap().parse().unwrap();
    assert_eq!(tension, points[5]["warp_tension_n"].as_f64().unwrap());
    let table = stdout(&solve(&grid));
    assert!(table.contains("published law") && table.lines().count() >= 8, "{table}");
}

#[test]
fn bad_ranges_are_usage_errors() {
    for range in ["0", "-1", "2.1", "1:1.1", "1:1.1:1", "1:1.1:2.5", "1:1.1:2:3", "nan", "inf", "", "a", "1::2"] {
        let output = solve(&[&format!("--warp-stretch={range}"), "--weft-stretch", "1"]);
        assert_eq!(code(&output), 2, "{range}");
        assert!(output.stdout.is_empty() && stderr(&output).contains("--warp-stretch"), "{range}");
    }
    assert_eq!(code(&solve(&["--warp-stretch", "1:2:2000", "--weft-stretch", "1:2:2000"])), 2);
    assert_eq!(code(&solve(&["--warp-stretch", "1"])), 2);
    assert_eq!(code(&solve(&["--warp-stretch", "1", "--weft-stretch", "1", "--json", "--csv"])), 2);
}
