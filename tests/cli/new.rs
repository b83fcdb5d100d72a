//! `ripstop new`, several cases at once, and a case on standard input: the way from nothing to a first shot.

use std::io::Write as _;
use std::process::Stdio;

use super::*;

/// Every projectile and fabric that the program says it knows.
fn known(bench: &Bench, flag: &str) -> Vec<String> {
    let text = stderr(&bench.ripstop(&["new", "x.json", "--force", flag, "no such thing"]));
    let line = text.lines().find(|line| line.contains("expected:")).unwrap();
    let names = line.split_once("expected: ").unwrap().1.split_once(", or").unwrap().0;
    names.split(", ").map(str::to_owned).collect()
}

#[test]
fn every_name_gives_a_case_that_is_read_valid_and_without_a_warning_about_its_mass() {
    let bench = Bench::new(&small());
    let validator = jsonschema::draft202012::new(&case::schema()).unwrap();
    let projectiles = known(&bench, "--projectile");
    assert!(projectiles.len() > 8 && projectiles.iter().any(|name| name == "fsp-22"), "{projectiles:?}");
    let sized = ["sphere:6.35", "ball:5", "rcc:5.5", "cylinder:5.5x8"].map(str::to_owned);
    for projectile in projectiles.into_iter().chain(sized) {
        for fabric in known(&bench, "--fabric") {
            let arguments =
                ["new", "x.json", "--force", "--fabric", &fabric, "--projectile", &projectile, "--plies", "2"];
            let output = bench.ripstop(&[&arguments[..], &["--velocity", "321.5"]].concat());
            assert_eq!(code(&output), 0, "{}", stderr(&output));
            let value = bench.json("x.json");
            let errors: Vec<String> = validator.iter_errors(&value).map(|error| error.to_string()).collect();
            assert!(errors.is_empty(), "{projectile}, {fabric}: {errors:?}");
            let case = case::read(&bench.path("x.json"), &[]).unwrap();
            assert_eq!((case.pack.plies, case.projectile.as_ref().unwrap().velocity), (2, 321.5));
            let warned: Vec<&str> =
                ripstop::output::checks::case_warnings(&case).iter().map(|warning| warning.kind.code).collect();
            assert!(!warned.contains(&"W7"), "{projectile}: {warned:?}");
            // A solid of steel, but for the paper's hollow cylinder.
            if projectile != "rcc-paper" {
                let body = case.projectile.unwrap();
                let density = body.mass / body.shape.volume();
                assert!((density / 7850.0 - 1.0).abs() < 0.01, "{projectile}: {density}");
            }
        }
    }
}

#[test]
fn the_schema_beside_it_is_the_one_it_names_and_nothing_is_written_over() {
    let bench = Bench::new(&small());
    assert_eq!(code(&bench.ripstop(&["new", "x.json"])), 0);
    let written = bench.json("x.json");
    assert_eq!(bench.json(written["$schema"].as_str().unwrap()), case::schema());
    let before = bench.text("x.json");
    let again = bench.ripstop(&["new", "x.json", "--plies", "3"]);
    assert!(code(&again) == 2 && stderr(&again).contains("--force"), "{}", stderr(&again));
    assert_eq!(bench.text("x.json"), before);
    let nowhere = bench.ripstop(&["new", "no/such/folder/x.json"]);
    assert!(code(&nowhere) == 2 && stderr(&nowhere).contains("error: no/such/folder"), "{}", stderr(&nowhere));
    let wrong =
        [["--velocity", "1e9"], ["--velocity", "-3"], ["--velocity", "nan"], ["--plies", "0"], ["--plies", "2.5"]];
    for [flag, value] in wrong {
        let said = bench.ripstop(&["new", "y.json", flag, value]);
        let text = stderr(&said);
        assert!(
            code(&said) == 2 && text.contains(&format!("error: {flag}")) && text.contains(&format!("{value:?}")),
            "{text}"
        );
        assert!(!bench.path("y.json").exists());
    }
}

#[cfg(unix)]
fn at_a_terminal(bench: &Bench, arguments: &[&str]) -> rexpect::session::PtySession {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_ripstop"));
    command.current_dir(bench.path("")).args(arguments).env("NO_COLOR", "1");
    rexpect::session::spawn_command(command, Some(20_000)).unwrap()
}

#[cfg(unix)]
#[test]
fn an_error_fits_on_a_terminal_and_says_the_same_as_elsewhere() {
    let bench = Bench::new(&small());
    let arguments = ["new", "x.json", "--fabric", "s-720", "--plies", "1", "--projectile", "none"];
    let there = at_a_terminal(&bench, &arguments).exp_eof().unwrap();
    let elsewhere = stderr(&bench.ripstop(&arguments));
    assert!(elsewhere.lines().any(|line| line.len() > 80), "{elsewhere}");
    assert!(there.lines().all(|line| line.chars().count() <= 80), "{there}");
    assert!(there.contains("\n      "), "{there}");
    assert_eq!(there.split_whitespace().collect::<Vec<_>>(), elsewhere.split_whitespace().collect::<Vec<_>>());
}

/// At a terminal it asks, and asks again after what it cannot read; what flags give is not asked.
#[cfg(unix)]
#[test]
fn at_a_terminal_it_asks_until_it_can_read_the_answer() {
    let bench = Bench::new(&small());
    let mut terminal = at_a_terminal(&bench, &["new", "x.json", "--projectile", "fsp-22"]);
    for (question, found, answer) in [
        ("fabric [s-720]: ", "no such fabric", "s-728"),
        ("plies [1]: ", "65", "3"),
        ("velocity [m/s] [200]: ", "fast", ""),
    ] {
        terminal.exp_string(question).unwrap();
        terminal.send_line(found).unwrap();
        terminal.exp_string(&format!("found: {found:?}")).unwrap();
        terminal.exp_string(question).unwrap();
        terminal.send_line(answer).unwrap();
    }
    terminal.exp_string("ripstop run x.json").unwrap();
    terminal.exp_eof().unwrap();
    let case = case::read(&bench.path("x.json"), &[]).unwrap();
    assert_eq!(case.title, "S-728, 3 plies, chisel-nosed fragment simulator, .22 calibre, 17 grains at 200 m/s");
}

#[test]
fn a_fabric_of_one_s_own_comes_with_its_sources() {
    let bench = Bench::new(&small());
    let text = case::builtin_fabric("fabrics/s-728.json").unwrap().replace("\"S-728\"", "\"Mine\"");
    std::fs::write(bench.path("mine.json"), text).unwrap();
    let output = bench.ripstop(&["new", "x.json", "--fabric", "mine.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let case = case::read(&bench.path("x.json"), &[]).unwrap();
    assert!(case.title.starts_with("Mine, 1 ply"), "{}", case.title);
    let crimp = case.fields.iter().find(|field| field.pointer == "/fabric/warp/crimp").unwrap();
    assert!(crimp.assumed && crimp.source.contains("Table I"), "{crimp:?}");
}

#[cfg(unix)]
#[test]
fn a_fabric_file_without_an_end_is_refused() {
    let bench = Bench::new(&small());
    let output =
        bench.ripstop(&["new", "x.json", "--fabric", "/dev/zero", "--plies", "1", "--projectile", "rcc-paper"]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("(more than 1 MiB)"), "{}", stderr(&output));
    assert_eq!(bench.names("."), ["shot.json"]);
}

#[test]
fn several_cases_run_one_after_the_other_each_in_its_folder() {
    let bench = Bench::new(&small_with("/solver/end_time_us", json!(2)));
    std::fs::copy(bench.path("shot.json"), bench.path("other.json")).unwrap();
    std::fs::write(bench.path("broken.json"), "{}").unwrap();
    let output = bench.ripstop(&["run", "shot.json", "broken.json", "other.json", "--backend", "cpu", "-o", "both"]);
    assert!(code(&output) == 2 && stderr(&output).contains("broken.json"), "{}", stderr(&output));
    for folder in ["both/shot", "both/other"] {
        assert!(bench.path(folder).join("summary.json").exists(), "{folder}");
    }
    std::fs::create_dir(bench.path("twin")).unwrap();
    std::fs::copy(bench.path("shot.json"), bench.path("twin/shot.json")).unwrap();
    let twice = bench.ripstop(&["run", "shot.json", "twin/shot.json", "--backend", "cpu", "--quiet"]);
    assert!(code(&twice) == 2 && stderr(&twice).contains("a folder for each case"), "{}", stderr(&twice));
}

#[test]
fn a_case_comes_on_standard_input() {
    let bench = Bench::new(&small_with("/solver/end_time_us", json!(2)));
    let piped = |arguments: &[&str], text: &str| {
        let mut command = bench.command(&[arguments, &["--backend", "cpu"]].concat());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        child.wait_with_output().unwrap()
    };
    let run = ["run", "-", "--set", "/projectile/velocity_m_s=50"];
    let output = piped(&run, &bench.text("shot.json"));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(bench.path("out/stdin+velocity_m_s=50/summary.json").exists());
    // Every point of a sweep reads what came once.
    let output = piped(&["sweep", "-", "--over", "/projectile/velocity_m_s=40,50"], &bench.text("shot.json"));
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let bad = piped(&run, "{");
    assert!(code(&bad) == 2 && stderr(&bad).starts_with("error: stdin: line 1"), "{}", stderr(&bad));
}

#[test]
fn what_was_changed_does_not_take_the_place_of_the_file_s_results() {
    let bench = Bench::new(&small_with("/solver/end_time_us", json!(2)));
    assert_eq!(code(&bench.shoot(&[])), 0);
    assert_eq!(code(&bench.shoot(&["--set", "/projectile/velocity_m_s=50"])), 0);
    let title = |folder: &str| bench.json(&format!("out/{folder}/summary.json"))["title"].as_str().unwrap().to_owned();
    assert_eq!(title("shot+velocity_m_s=50"), format!("{} [velocity_m_s = 50]", title("shot")));
}
