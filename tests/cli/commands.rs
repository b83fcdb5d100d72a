//! `new`, `check`, `info`, `schema`, `crossover`, `bench`, `verify` and `completions`.

use std::io::Write;

use ripstop::case::Yarn;
use ripstop::output::checks::case_warnings;

use super::*;
use crate::objectivity::names;

/// Every projectile or fabric that `new` knows.
fn known(bench: &Bench, flag: &str) -> Vec<String> {
    let text = stderr(&bench.ripstop(&["new", "x.json", "--force", flag, "no such thing"]));
    let line = text.lines().find(|line| line.contains("expected:")).unwrap();
    let names = line.split_once("expected: ").unwrap().1.split_once(", or").unwrap().0;
    names.split(", ").map(str::to_owned).collect()
}

#[test]
fn every_name_gives_a_valid_case_whose_mass_is_that_of_its_steel() {
    let bench = Bench::new(&small());
    let projectiles = known(&bench, "--projectile");
    assert!(projectiles.len() > 8 && projectiles.iter().any(|name| name == "fsp-22"), "{projectiles:?}");
    let sized = ["sphere:6.35", "ball:5", "rcc:5.5", "cylinder:5.5x8", "ogive:9x15", "cone:9x15"].map(str::to_owned);
    for projectile in projectiles.into_iter().chain(sized) {
        for fabric in known(&bench, "--fabric") {
            let named = ["new", "x.json", "--force", "--fabric", &fabric, "--projectile", &projectile];
            let output = bench.ripstop(&[&named[..], &["--plies", "2", "--velocity", "321.5"]].concat());
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            let value = bench.json("x.json");
            assert_eq!(bench.json(value["$schema"].as_str().unwrap()), case::schema());
            let case = case::read(&bench.path("x.json"), &[]).unwrap();
            assert!(case_warnings(&case).iter().all(|warning| warning.kind.code != "W7"), "{projectile}");
            let body = case.projectile.unwrap();
            assert_eq!((case.pack.plies, body.velocity), (2, 321.5));
            let density = body.mass / body.shape.volume();
            // The paper's cylinder is hollow, bullets are of lead in a jacket.
            let is_bullet = ["9mm-fmj", "357-magnum", "44-magnum"].contains(&&*projectile);
            let (metal, within) = if is_bullet { (10_800.0, 0.01) } else { (7850.0, 0.01) };
            assert!(projectile == "rcc-paper" || (density / metal - 1.0_f64).abs() < within, "{projectile}: {density}");
        }
    }
}

#[test]
fn a_fabric_from_a_file_comes_with_its_sources() {
    let bench = Bench::new(&small());
    let text = case::builtin_fabric("fabrics/s-728.json").unwrap().replace("\"S-728\"", "\"Mine\"");
    fs::write(bench.path("mine.json"), text).unwrap();
    let output = bench.ripstop(&["new", "x.json", "--fabric", "mine.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let case = case::read(&bench.path("x.json"), &[]).unwrap();
    assert_eq!(case.title, "Mine, 1 ply, RCC at 200 m/s");
    let crimp = case.fields.iter().find(|field| field.pointer == "/fabric/warp/crimp").unwrap();
    assert!(crimp.assumed && crimp.source.contains("Table I"), "{crimp:?}");
}

#[test]
fn a_sheet_is_asked_for_number_by_number_each_with_its_unit() {
    let bench = Bench::new(&small());
    let ask = |answers: &str| {
        let mut program = bench.command(&["new", "x.json", "--force", "--from-sheet"]);
        let mut child = program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(answers.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    // Name, fibre, linear densities, modulus, strength, ends, picks, areal density, crimps, thickness.
    let output = ask("Mine\n\n600 den\n670 dtex\n12.2 Msi\n24 g/den\n34 /in\n13 /cm\n\n1 %\n0.5 %\n9 mil\n");
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let case = case::read(&bench.path("x.json"), &[]).unwrap();
    let Yarn { linear_density, modulus, failure_strain, count, crimp, .. } = case.fabric.warp.clone();
    let psi = 4.448_221_615_260_5 / 0.0254_f64.powi(2);
    let strain = 24.0 * 9.80665e-3 * 9e6 * 1440.0 / (12.2e6 * psi);
    // Picks stand beside one another along the warp.
    let expected = [600.0 / 9e6, 12.2e6 * psi, strain, 1300.0, 0.01];
    for (got, expected) in [linear_density, modulus, failure_strain, count, crimp].into_iter().zip(expected) {
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} for {expected}");
    }
    let weft = &case.fabric.weft;
    assert!((weft.count * 0.0254 / 34.0 - 1.0).abs() < 1e-12 && weft.failure_strain == failure_strain, "{weft:?}");
    let source = |pointer: &str| case.fields.iter().find(|field| field.pointer == pointer).unwrap().clone();
    assert!(source("/fabric/fibre_density_kg_m3").assumed && !source("/fabric/warp/modulus_gpa").assumed);
    assert!(source("/fabric/thickness_mm").source.ends_with("9 mil, 1 mil = 0.0254 mm"));
    for (answers, place) in [("Mine\n\n600\n", "linear density, warp"), ("Mine\n\n600 den\n\n84 lb\n", "modulus")] {
        let output = ask(answers);
        assert!(code(&output) == 2 && stderr(&output).contains(&format!("error: {place}\n")), "{}", stderr(&output));
    }
}

#[test]
fn check_prints_every_field_and_what_follows_and_refuses_bad_cases() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["check", "absent.json", "shot.json", "shot.json", "--all"]);
    assert_eq!((code(&output), stderr(&output).matches("error: absent.json").count()), (2, 1));
    let text = stdout(&output);
    assert_eq!(text.matches("/pack/width_mm").count(), 2);
    for part in ["critical time step", "memory", "576", "a quarter, mirrored at x = 0 and y = 0"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert_eq!(bench.names("."), ["shot.json"]);
}

/// S-720 by hand: 1420 denier are 157.8 mg/m and 0.1096 mm² of 1440 kg/m³; 96 GPa and 3.5 % of it break at 368 N.
#[test]
fn check_begins_with_what_a_data_sheet_says() {
    let bench = Bench::new(&small());
    let sheet: Value = serde_json::from_str(&stdout(&bench.ripstop(&["check", "shot.json", "--json"]))).unwrap();
    let near = |found: &Value, expected: f64| (found.as_f64().unwrap() / expected - 1.0).abs() < 1e-3;
    let yarn = &sheet["fabrics"][0]["warp"];
    assert!(near(&yarn["breaking_load_n"], 1420.0 / 9e6 / 1440.0 * 96e9 * 0.035), "{yarn}");
    assert!(near(&yarn["wave_speed_m_s"], (96e9_f64 / 1440.0).sqrt()), "{yarn}");
    assert!(near(&sheet["areal_density_kg_m2"], 0.2552) && near(&sheet["impact_energy_j"], 540.0), "{sheet}");
    assert_eq!(sheet["fields"].as_array().unwrap().len(), run(&small()).0.fields.len());
    let plies = stdout(&bench.ripstop(&["check", "shot.json", "--set", "/pack/plies=3", "--json"]));
    assert!(plies.contains("\"areal_density_kg_m2\": 0.765"), "{plies}");
}

#[test]
fn info_and_schema_say_what_the_machine_has_and_what_a_case_needs() {
    let bench = Bench::new(&small());
    let machine = stdout(&bench.ripstop(&["info"]));
    assert!(["memory", "backend cpu", "auto chooses"].iter().all(|part| machine.contains(part)), "{machine}");
    fs::write(bench.path("without.json"), small_with("/projectile", Value::Null).to_string()).unwrap();
    for (case, part) in [("shot.json", "projectile_contact"), ("without.json", "sweep, yarn_load, energy_balance")] {
        let scene = stdout(&bench.ripstop(&["info", case]));
        assert!(scene.contains("device memory") && scene.contains(part), "{part} in\n{scene}");
    }
    let schema: Value = serde_json::from_str(&stdout(&bench.ripstop(&["schema"]))).unwrap();
    assert_eq!(schema, case::schema());
}

/// The rigid S-720, as printed to half a unit of the last digit.
#[test]
fn crossover_meets_the_published_numbers_of_every_law_in_every_form() {
    let bench = Bench::new(&small_with("/fabric/crossover/compression", json!("rigid")));
    let solve = |more: &[&str]| stdout(&bench.ripstop(&[&["crossover", "shot.json"], more].concat()));
    let solve_json = |more: &[&str]| -> Value { serde_json::from_str(&solve(&[more, &["--json"]].concat())).unwrap() };
    let at = ["--warp-stretch", "1.010", "--weft-stretch", "1"];
    let near = |value: &Value, expected: f64| {
        let half_a_digit = if expected < 1.0 { 5.1e-7 } else { 5.1e-5 };
        assert!((value.as_f64().unwrap() - expected).abs() <= half_a_digit, "{value} {expected}");
    };
    let solved = solve_json(&at);
    let point = &solved["points"][0];
    let contract = "warp_stretch weft_stretch warp_tension_n weft_tension_n contact_force_n warp_height_mm weft_height_mm \
                    warp_strain weft_strain iterations residual";
    let keys: Vec<&str> = point.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys.join(" "), contract);
    near(&point["warp_height_mm"], 0.105521);
    near(&point["weft_height_mm"], 0.110638);
    near(&point["weft_tension_n"], 47.4183);
    assert!(point["iterations"].is_u64() && point["residual"].as_f64().unwrap() < 1e-6);
    for (law, force) in [("published", 25.0347), ("variational", 19.8285), ("kawabata", 17.9505)] {
        let solved = solve_json(&[&at[..], &["--law", law]].concat());
        assert_eq!(solved["law"], law);
        near(&solved["points"][0]["contact_force_n"], force);
    }
    let grid = ["--warp-stretch", "1:1.04:3", "--weft-stretch", "0.99:1.01:2"];
    let solved = solve_json(&grid);
    let points = solved["points"].as_array().unwrap();
    let stretch = |point: &Value| ["warp_stretch", "weft_stretch"].map(|key| point[key].as_f64().unwrap());
    let stretches: Vec<[f64; 2]> = points.iter().map(stretch).collect();
    assert_eq!(stretches, [[1.0, 0.99], [1.0, 1.01], [1.02, 0.99], [1.02, 1.01], [1.04, 0.99], [1.04, 1.01]]);
    let csv = solve(&[&grid[..], &["--csv"]].concat());
    let tension: f64 = csv.lines().nth(6).unwrap().split(',').nth(2).unwrap().parse().unwrap();
    assert_eq!((csv.lines().count(), tension), (7, points[5]["warp_tension_n"].as_f64().unwrap()));
}

#[test]
fn bench_measures_every_choice() {
    let mut case = small();
    case["pack"] = json!({"width_mm": 17.8, "height_mm": 17.8});
    let bench = Bench::new(&case);
    let asked = ["bench", "shot.json", "--backend", "cpu", "--threads", "1"];
    let output = bench.ripstop(&[&asked[..], &["--json"]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(bench.names("out/bench"), ["bench.json"]);
    let report = bench.json("out/bench/bench.json");
    assert_eq!(report, serde_json::from_str::<Value>(&stdout(&output)).unwrap());
    assert_eq!((&report["threads"], &report["adapter"]), (&json!(1), &Value::Null));
    let case = &report["cases"][0];
    let reference = &case["reference"];
    assert_eq!((&reference["courant"], &reference["precision"]), (&json!(0.25), &json!("f64")));
    let choices = case["choices"].as_array().unwrap();
    let point = |choice: &Value| ["loop_s", "velocity_error_percent"].map(|key| choice[key].as_f64().unwrap());
    for one in choices {
        let [time, error] = point(one);
        assert!(time > 0.0 && error > 0.0 && error.is_finite(), "{one:#}");
    }
    let named = |name: &str| choices.iter().find(|one| one["name"].as_str().unwrap().starts_with(name));
    let error = |name: &str| point(named(name).unwrap())[1];
    assert!(error("mesh 2") > error("default"));
    // Skips change nothing, single precision next to nothing.
    assert_eq!(error("no skip"), error("no symmetry"));
    assert!((error("no symmetry") / error("default") - 1.0).abs() < 1e-6);
    assert!((error("f32") / error("default") - 1.0).abs() < 0.2);
    // Fourteen crossovers are no whole number of elements of four.
    assert!(named("mesh 4").is_none() && case["skipped"][0]["name"] == "mesh 4", "{}", case["skipped"]);
}

#[cfg(unix)]
#[test]
fn bench_ends_at_ctrl_c_with_what_was_measured() {
    let mut case = small_with("/solver/end_time_us", json!(5000));
    case["solver"]["run_until"] = json!("end_time");
    let bench = Bench::new(&case);
    let arguments = ["bench", "shot.json", "--backend", "cpu", "--quiet"];
    let output = bench.interrupt(&arguments, "out/bench");
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    let report = bench.json("out/bench/bench.json");
    assert_eq!((&report["interrupted"], &report["cases"][0]["interrupted"]), (&json!(true), &json!(true)));
}

#[test]
fn verify_has_a_row_for_each_expectation_of_each_case() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["verify", "--backend", "cpu", "--json"]);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert!(report["pass"] == true && rows.iter().all(|row| row["pass"] == true && !row["got"].is_null()), "{rows:#?}");
    let quantities = |rows: &[&Value]| rows.iter().map(|row| row["quantity"].clone()).collect::<Vec<_>>();
    for folder in ["verify", "stress"] {
        for name in names(folder).iter().map(|name| format!("{folder}/{name}")) {
            let text = fs::read_to_string(format!("cases/{name}.json")).unwrap();
            let case: Value = serde_json::from_str(&text).unwrap();
            let of_case: Vec<&Value> = rows.iter().filter(|row| row["name"] == *name).collect();
            let stated: Vec<&Value> = case["expect"].as_array().unwrap().iter().collect();
            assert!(!stated.is_empty() && quantities(&of_case) == quantities(&stated), "{name}: {of_case:?}");
        }
    }
}
