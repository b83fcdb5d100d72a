//! `ripstop shots`, `v50`, `sweep` and `fit`: what a user types, and what a kill leaves.
//!
//! Promise: files and names are those of the contract; a batch that was killed goes on to the same bytes; fitted numbers are those of a
//! published set; bad input is one error with exit code 2, with the place, what was expected, what was found and help, and nothing is
//! written then.

use super::*;
use crate::study::{GONOGO, WU_TIAN};
use crate::support;

/// A small ply in which something varies.
fn varies() -> Value {
    json!({
        "title": "small ply", "fabric": small()["fabric"], "pack": {"width_mm": 25, "height_mm": 25},
        "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 70},
        "variability": {"hit": "unit_cell", "modulus": {"scatter": 0.05}}
    })
}

/// With few elements: what is tested is what becomes of many shots.
fn bench() -> Bench {
    let mut case = varies();
    case["pack"]["elements_per_crossover"] = json!(2);
    Bench::new(&case)
}

/// Runs a command line without blanks in its arguments.
fn typed(bench: &Bench, line: &str) -> Output {
    bench.ripstop(&line.split(' ').collect::<Vec<_>>())
}

const SHOTS: &str = "shots shot.json --count 8 --velocity 50..120 -o out";

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_batch_with_what_it_has_and_what_there_was() {
    let bench = bench();
    assert_eq!(code(&typed(&bench, SHOTS)), 0);
    let finished = ["plan.json", "shots.csv", "shots.html", "shots.json"];
    let texts = || finished.map(|name| bench.text(&format!("out/{name}")));
    let before = texts();
    let longer = SHOTS.replace("--count 8", "--count 5000");
    let output = bench.interrupt(&longer.split(' ').collect::<Vec<_>>(), "out/shots.csv.partial");
    assert_eq!(code(&output), 130);
    assert!(stderr(&output).contains("the same command goes on"), "{}", stderr(&output));
    // What was finished stays until more is.
    assert!(texts() == before && bench.text("out/shots.csv.partial").lines().count() >= 9);
}

#[test]
fn a_shot_by_its_number_is_the_row_with_everything_a_run_writes() {
    let bench = bench();
    assert_eq!(code(&typed(&bench, SHOTS)), 0);
    let summary = typed(&bench, "shots shot.json --velocity 50..120 -o out --only 5 --json");
    let summary: Value = serde_json::from_str(&stdout(&summary)).unwrap();
    let table = bench.text("out/shots.csv");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().clone();
    let record = reader.records().map(Result::unwrap).find(|record| &record[0] == "5").unwrap();
    let cell = |name: &str| record.get(header.iter().position(|head| head == name).unwrap()).unwrap();
    assert_eq!(summary["outcome"], cell("outcome"));
    assert_eq!(summary["energy_gained"].as_f64().unwrap(), cell("energy_gained").parse::<f64>().unwrap());
    assert_eq!(summary["absorbed_energy_j"].as_f64().unwrap(), cell("absorbed_energy_j").parse::<f64>().unwrap());
    assert!(bench.path("out/shot-5/report.html").exists());
    assert!(bench.text("out/shots.html").contains("shot-5/report.html"));
    // Its case, run by itself, is that shot again.
    let again = typed(&bench, "run out/shot-5/case.json -o again --json --no-report");
    let again: Value = serde_json::from_str(&stdout(&again)).unwrap();
    assert_eq!(again["absorbed_energy_j"], summary["absorbed_energy_j"]);
}

#[test]
fn a_limit_has_its_agreed_names() {
    // A small ply on the mesh of its accuracy, which a limit is corrected from.
    let mut case = varies();
    case["pack"] = json!({"width_mm": 7.62, "height_mm": 7.62});
    case["projectile"] = json!({"shape": "sphere", "diameter_mm": 3, "mass_g": 0.05, "velocity_m_s": 120});
    let bench = Bench::new(&case);
    let line = "v50 shot.json --count 3 --refined 1 --bracket 3% -o limit";
    let text = stdout(&typed(&bench, line));
    assert!(bench.path("limit/v50-refined.csv").exists() && bench.path("limit/v50.html").exists(), "{text}");
    let json = bench.json("limit/v50.json");
    let v50 = json["v50_m_s"].as_f64().unwrap();
    assert!((60.0..250.0).contains(&v50), "{v50}");
    assert_eq!(json["realisations"], 3);
    // Another V50 would replace it; this one is there.
    let other = typed(&bench, &line.replace("3%", "2%"));
    assert!(code(&other) == 2 && stderr(&other).contains("help: give the same case and options"), "{}", stderr(&other));
    let again = typed(&bench, line);
    assert_eq!((stdout(&again), bench.json("limit/v50.json")), (text, json));
}

#[test]
fn a_limit_that_is_not_found_is_an_error_with_what_to_do() {
    let mut case = varies();
    case.as_object_mut().unwrap().remove("variability");
    let output = typed(&Bench::new(&case), "v50 shot.json --set /solver/end_time_us=0.2 -o out");
    let error = stderr(&output);
    assert_eq!(code(&output), 1, "{error}");
    assert!(error.contains("no ballistic limit") && error.contains("raise /solver/end_time_us"), "{error}");
    assert!(stdout(&output).contains("no ballistic limit") && stdout(&output).contains("v50.csv"));
}

#[test]
fn a_sweep_prints_and_writes_its_points() {
    let bench = bench();
    let output =
        typed(&bench, "sweep shot.json --over /pack/plies=1,2 --over /projectile/velocity_m_s=40..140:100 -o out");
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let (table, page) = (bench.text("out/sweep.csv"), bench.text("out/sweep.html"));
    assert!(table.lines().count() == 5 && page.contains("points/0003/shots.html"), "{table}");
    // By hand: from the means of the rows at 40 and at 140 m/s.
    let residual = |row: usize| table.lines().nth(row).unwrap().split(',').nth(3).unwrap().parse::<f64>().unwrap();
    let effect = ((residual(2) + residual(4)) - (residual(1) + residual(3))).abs() / 2.0;
    let printed = stdout(&output).split_once("velocity_m_s: ").unwrap().1.split(',').next().unwrap().parse::<f64>();
    assert!(effect > 1.0 && (printed.unwrap() / effect - 1.0).abs() < 5e-3, "{effect}, {}", stdout(&output));
}

#[test]
fn bad_input_is_one_error_and_nothing_is_written() {
    let bench = bench();
    for (arguments, expected) in [
        ("shots shot.json --count 3 --velocity 90..50", "two velocities in m/s, the lower first"),
        (
            "shots shot.json --count 3 --set /projectile=null --set /solver/end_time_us=1 --set /variability/hit=aimed",
            "a projectile, to be shot",
        ),
        ("shots shot.json --count 3 --resume", "the plan of a batch that was begun here"),
        ("sweep shot.json --over /pack/plies=1..4", "a range A..B:STEP"),
        ("sweep shot.json --over /pack/plys=1,2", "did you mean"),
        ("sweep shot.json --over /pack/plies=1,0", "--set /pack/plies"),
    ] {
        let output = typed(&bench, arguments);
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(stderr(&output).contains(expected), "{arguments:?}: {}", stderr(&output));
        let folders = fs::read_dir(bench.path("out")).into_iter().flatten().flatten();
        assert_eq!(folders.flat_map(|entry| fs::read_dir(entry.path())).flatten().count(), 0, "{arguments:?}");
    }
}

/// Table of Wu & Tian 2014 and the overview of `gonogo`: V50 10.17033, σ 0.93398, deviance 14.139.
fn published() -> String {
    let shots = [WU_TIAN, GONOGO].into_iter().flat_map(str::split_whitespace);
    let rows = shots.zip(1..).map(|(shot, number)| format!("{number},{}\n", shot.replace('/', ",")));
    "shot,velocity_m_s,perforated\n".to_owned() + &rows.collect::<String>()
}

/// No stop was faster than a perforation.
const APART: &str = "velocity_m_s;perforated;count\n400;0;2\n420;0;1\n440;1;2\n450;1;0\n";

/// A folder with these tables.
fn fit_bench(files: &[(&str, &str)]) -> Bench {
    let bench = Bench::new(&small());
    files.iter().for_each(|(name, text)| fs::write(bench.path(name), text).unwrap());
    bench
}

fn fit(bench: &Bench, arguments: &[&str]) -> Output {
    bench.ripstop(&[&["fit"], arguments].concat())
}

fn fit_json(bench: &Bench, arguments: &[&str]) -> Value {
    let output = fit(bench, &[arguments, &["--json"]].concat());
    serde_json::from_str(&stdout(&output)).unwrap_or_else(|_| panic!("{}", stderr(&output)))
}

#[track_caller]
fn near(value: &Value, expected: f64, tolerance: f64) {
    support::near(value.as_f64().unwrap_or_else(|| panic!("{value} instead of {expected}")), expected, tolerance);
}

#[test]
fn a_fit_has_its_agreed_names_and_says_how_it_was_made() {
    let bench = fit_bench(&[
        ("shots.csv", &published()),
        ("apart.csv", APART),
        ("stopped.csv", "velocity_m_s,perforated\n400,0\n450,0\n470,0\n"),
    ]);
    let found = fit_json(&bench, &["shots.csv"]);
    for (key, expected, tolerance) in [("mu", 10.17033, 5e-5), ("sigma", 0.93398, 5e-5), ("deviance", 14.139, 5e-4)] {
        near(&found[key], expected, tolerance);
    }
    assert_eq!((&found["overlap"], &found["shots"]), (&json!(true), &json!(30)));
    let quantiles = found["quantiles"].as_array().unwrap();
    let chances: Vec<f64> = quantiles.iter().map(|quantile| quantile["p"].as_f64().unwrap()).collect();
    assert_eq!(chances, [0.1, 0.25, 0.5, 0.75, 0.9]);
    for (key, expected) in [("value", 10.17033), ("low", 9.1593), ("high", 10.7550)] {
        near(&quantiles[2][key], expected, 1e-4);
    }
    // Wider with more confidence, in either way of writing it.
    let [wide, same] = ["95%", "0.95"].map(|level| fit_json(&bench, &["shots.csv", "--level", level]));
    assert!(wide["quantiles"][2]["low"].as_f64() < found["quantiles"][2]["low"].as_f64());
    assert_eq!(wide["quantiles"], same["quantiles"]);
    // Without overlap.
    let found = fit_json(&bench, &["apart.csv"]);
    assert_eq!((&found["overlap"], &found["method"]), (&json!(false), &json!("Firth's penalised likelihood")));
    assert_eq!((&found["shots"], &found["perforated"], &found["stopped"]), (&json!(5), &json!(2), &json!(3)));
    // One outcome: no estimate, but a bound.
    let found = fit_json(&bench, &["stopped.csv"]);
    assert_eq!((&found["mu"], &found["quantiles"][2]["value"]), (&Value::Null, &Value::Null));
    assert!(found["quantiles"][2]["low"].as_f64() > Some(400.0) && found["quantiles"][2]["high"].is_null());
    assert!(found["no_estimate"].as_str().unwrap().contains("every shot was stopped"), "{found:#}");
}

/// The same shots as different people write them: heading, marks of a stop and a perforation (empty: none), and what stands for no residual
/// velocity.
#[test]
fn range_data_is_read_as_it_is_written() {
    const SHOTS: &str = "390.5 0,402.5 0,411 60.2,415 0,421.5 95.2,428 0,433.5 130.2,440.5 160.2";
    let shots: Vec<[f64; 2]> = SHOTS
        .split(',')
        .map(|shot| shot.split_once(' ').map(|(v, left)| [v, left].map(|n| n.parse().unwrap())).unwrap())
        .collect();
    let written = |head: &str, marks: [&str; 2], none: &str, unit: f64| {
        let separator = if head.contains(';') { ";" } else { [",", "\t"][usize::from(head.contains('\t'))] };
        let line = |[velocity, left]: &[f64; 2]| {
            let left_text = if *left > 0.0 { format!("{left}") } else { none.to_owned() };
            let cells = [format!("{:?}", velocity / unit), marks[usize::from(*left > 0.0)].to_owned(), left_text];
            let cells: Vec<String> =
                cells.into_iter().filter(|cell| !cell.is_empty() || !marks[0].is_empty()).collect();
            let line = cells.join(separator) + "\n";
            if separator == ";" { line.replace('.', ",") } else { line }
        };
        format!("{head}\n{}", shots.iter().map(line).collect::<String>())
    };
    let plain = written("velocity_m_s,perforated,residual_velocity_m_s", ["0", "1"], "", 1.0);
    let bench = fit_bench(&[("plain.csv", &plain)]);
    let expected = fit_json(&bench, &["plain.csv"]);
    assert_eq!((&expected["unit"], &expected["shots"]), (&json!("m/s"), &json!(8)));
    let named: &[&str] =
        &["--column", "velocity=Speed", "--column=perforated=Through?", "--column=residual=v", "--unit=m/s"];
    for (head, marks, none, more, options) in [
        ("v [m/s]; Result ;Vr [m/s]", ["PP", "cp"], "NA", "", &[][..]),
        ("\u{feff}# range 7\r\nStriking velocity (m/s)\tOutcome\tV_r (m/s)", ["Stopped", "Perforated"], "n/a", "", &[]),
        ("Vs (m/s),Vr (m/s)", ["", ""], "0", "", &[]),
        ("vs,vr", ["", ""], "0", "", &["--unit", "m/s"]),
        ("Speed,Through?,v", ["no", "YES"], "-", "na,yes,\n450,,\n", named),
    ] {
        fs::write(bench.path("other.csv"), written(head, marks, none, 1.0) + more).unwrap();
        let mut found = fit_json(&bench, &[&["other.csv"], options].concat());
        let notes = found["notes"].take();
        let says = notes.to_string().contains("lines without a velocity or an outcome: 2, left out");
        assert_eq!(says, !more.is_empty(), "{notes}");
        for key in ["mu", "sigma", "quantiles", "arithmetic", "residual"] {
            assert_eq!(found[key], expected[key], "{key} of {head}");
        }
    }
    // Velocities in feet per second stay in feet per second, those of another column are turned into it, and rules are those of the standard.
    let feet = written("velocity_ft_s,perforated,residual_velocity_m_s", ["false", "true"], "", 0.3048);
    fs::write(bench.path("feet.csv"), feet).unwrap();
    let found = fit_json(&bench, &["feet.csv", "--spread", "70"]);
    for (got, of) in
        [(&found["mu"], &expected["mu"]), (&found["residual"][0]["limit"], &expected["residual"][0]["limit"])]
    {
        near(got, of.as_f64().unwrap() / 0.3048, 1e-4);
    }
    let own = &found["arithmetic"][4];
    assert_eq!((&found["unit"], &found["arithmetic"][0]["rule"]), (&json!("ft/s"), &json!("2 + 2 within 60 ft/s")));
    assert_eq!((&own["standard"], &own["rule"]), (&json!("own"), &json!("2 + 2 within 70 ft/s")));
    near(&own["value"], (411.0 + 415.0 + 421.5 + 428.0) / 4.0 / 0.3048, 1e-6);
    let text = stdout(&fit(&bench, &["feet.csv"]));
    assert!(text.contains("V50 1373 ft/s") && !text.contains(" m/s"), "{text}");
}

#[test]
fn residual_velocities_and_the_rules_of_standards_are_in_the_results() {
    let exact = |velocity: f64| format!("{velocity},1,{}\n", (velocity * velocity - 300.0 * 300.0).sqrt());
    let passed: String = [305.0, 310.0, 320.0, 340.0, 380.0].map(exact).concat();
    let text = format!("velocity_m_s,perforated,residual_velocity_m_s\n280,0,0\n295,0,\n299,0,\n306,0,\n{passed}");
    let bench = fit_bench(&[("shots.csv", &text)]);
    let found = fit_json(&bench, &["shots.csv"]);
    for (curve, name) in found["residual"].as_array().unwrap().iter().zip(["Recht-Ipson", "Lambert-Jonas"]) {
        assert_eq!(curve["curve"], name);
        near(&curve["limit"], 300.0, 1e-3);
    }
    assert_eq!(found["arithmetic"][2]["refused"], "perforations: 5, stops: 4");
}

#[test]
fn files_are_whole_and_need_nothing_else() {
    let bench = fit_bench(&[("<b>&.csv", &published())]);
    let output = fit(&bench, &["<b>&.csv", "-q", "-o", "out/fit"]);
    assert_eq!((code(&output), stdout(&output).as_str()), (0, ""), "{}", stderr(&output));
    assert_eq!(bench.names("out/fit"), ["fit.html", "fit.json"]);
    assert_eq!(bench.json("out/fit/fit.json"), fit_json(&bench, &["<b>&.csv"]));
    let text = bench.text("out/fit/fit.html");
    assert!(text.contains("&lt;b&gt;&amp;.csv") && !text.contains("<b>") && text.matches("<circle").count() == 30);
    let external = text.replace("http://www.w3.org/2000/svg", "");
    assert!(!external.contains("://") && !external.contains("<script") && !external.contains("NaN"));
}

#[test]
fn a_bad_table_is_one_error_and_nothing_is_written() {
    let head = "velocity_m_s,perforated,count,residual_velocity_m_s\n";
    let lines = |line: &str| format!("{head}400,0,,\n{line}\n");
    let tables: [(&str, String, &str); 13] = [
        ("no-unit", "velocity,perforated\n1,1\n".into(), "line 1|a column velocity_m_s or velocity_ft_s, or --unit"),
        ("no-outcome", "velocity_m_s,hit\n1,1\n".into(), "line 1|a column perforated|\"hit\""),
        ("empty", String::new(), "a column velocity_m_s"),
        ("none", lines("410,1,0,").replace("400,0,,", "400,0,0,"), "no shot"),
        ("word", lines("fast,1,,"), "line 3, column velocity_m_s|\"fast\""),
        ("nothing", format!("{head},1,,\n400,na,,\n"), "no shot"),
        ("two", lines("410,2,,"), "line 3, column perforated|stopped where it was stopped|\"2\""),
        ("nan", lines("NaN,1,,"), "line 3, column velocity_m_s|\"NaN\""),
        ("part", lines("410,1,1.5,"), "line 3, column count|\"1.5\""),
        ("faster", lines("410,1,1,411"), "line 3, column residual_velocity_m_s|410 m/s|\"411\""),
        ("comma", "velocity_m_s,perforated\n400,5,1\n".into(), "line: 2|2 fields|decimal point"),
        ("ends", "velocity_m_s,perforated\r\n400,0\r\n410,x\r\n".into(), "line 3, column perforated|\"x\""),
        ("absent", String::new(), "velocity_m_s,perforated"),
    ];
    let bench = Bench::new(&small());
    for (name, text, named) in &tables {
        let file = format!("{name}.csv");
        if *name != "absent" {
            fs::write(bench.path(&file), text).unwrap();
        }
        refused(&bench, &[&file, "-o", "out"], &format!("{file}|expected: |found: |help: |{named}"));
    }
    ["shots.csv", "fit.json"].iter().for_each(|name| fs::write(bench.path(name), published()).unwrap());
    for (arguments, named) in [
        (&["shots.csv", "--level", "90"][..], "--level|90%"),
        (&["shots.csv", "--unit", "ft/s"], "line 1|velocities in ft/s, as --unit says|\"velocity_m_s\""),
        (&["shots.csv", "--column", "velocity=Speed"], "line 1|a column Speed|\"velocity_m_s\""),
        (&["shots.csv", "--column", "speed=x"], "velocity, perforated, count or residual"),
        (&["shots.csv", "--spread", "0"], "--spread|a number above 0"),
        (&["shots.csv", "-o", "shots.csv"], "a file"),
        (&["fit.json", "-o", "."], "fit.json, which was read"),
        (&[], "DATA.csv"),
    ] {
        refused(&bench, arguments, named);
    }
    assert!(!bench.path("out").exists() && bench.text("fit.json") == published());
}

#[track_caller]
fn refused(bench: &Bench, arguments: &[&str], named: &str) {
    let output = fit(bench, arguments);
    let message = stderr(&output);
    assert_eq!(code(&output), 2, "{arguments:?}: {message}");
    assert_eq!(message.matches("error: ").count(), 1, "{arguments:?}: {message}");
    for part in named.split('|') {
        assert!(message.contains(part), "{part} of {arguments:?}: {message}");
    }
    assert!(output.stdout.is_empty());
}
