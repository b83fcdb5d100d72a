//! Colour and the progress bar: for people at a terminal, and nobody else.

use super::*;

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

/// The text without colours: ESC [ … m.
fn without_colour(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once('m').map_or("", |(_, rest)| rest))
}

/// What a program shows on a terminal of 100 columns, made by `script` of util-linux.
#[cfg(target_os = "linux")]
fn on_a_terminal(bench: &Bench, arguments: &str, environment: &str) -> String {
    let program = env!("CARGO_BIN_EXE_ripstop");
    let line = format!("stty cols 100 rows 40; {environment} {program} {arguments}");
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
    let mut case = small_with("/solver/end_time_us", json!(1500));
    case["solver"]["run_until"] = json!("end_time");
    let bench = Bench::new(&case);
    let run = "run shot.json --backend cpu --threads 1";
    let shown = on_a_terminal(&bench, run, "");
    for part in ["/1500 µs", " m/s", " failed", " M/s", " left", "\u{1b}[1m", "PERFORATED"] {
        assert!(shown.contains(part), "{part:?} in\n{shown:?}");
    }
    for off in ["NO_COLOR=1", "CLICOLOR=0"] {
        let grey = on_a_terminal(&bench, run, off);
        assert!(grey.contains(" left") && grey.contains("PERFORATED"), "{grey:?}");
        let colours = grey
            .split("\u{1b}[")
            .skip(1)
            .filter_map(|part| part.split_once('m'))
            .filter(|(code, _)| !code.is_empty() && code.chars().all(|c| c.is_ascii_digit() || c == ';'));
        assert_eq!(colours.count(), 0, "{off}: {grey:?}");
    }
    assert_eq!(on_a_terminal(&bench, &format!("{run} --quiet"), ""), "");
    let json = on_a_terminal(&bench, &format!("{run} --json"), "");
    let from = json.find('{').unwrap();
    assert!(serde_json::from_str::<Value>(json[from..].trim_end()).is_ok(), "{json:?}");
}
