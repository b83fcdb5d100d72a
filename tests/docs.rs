//! The README, the book under `docs/src`, the decisions and the examples, held to the program.
//!
//! Promises: the README is short; every command in a block marked `sh` or `console` does what its page says, and prints what a
//! `console` block shows; tables marked as generated are what the program prints; lists of keys, columns, checks and commands
//! are those of the program; links, paths and the summary lead somewhere; examples end with no error; the rooms of `src/` use one another in one
//! direction, as `lib.rs` says. With `RIPSTOP_UPDATE_DOCS=1` generated tables and the picture are written anew.

#[path = "../examples/library.rs"]
mod library;
#[allow(dead_code, reason = "the suite does not compute limits")]
#[path = "../examples/measured.rs"]
mod measured;
mod pages;

use std::fs;
use std::path::{Path, PathBuf};

pub(crate) use pages::hold;
use pages::{Page, program};
use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::output::checks::{self, GAINED_LIMIT, HOURGLASS_LIMIT};
use ripstop::output::csv::COLUMNS;
use ripstop::run::Run;
use ripstop::study::v50::AS_WOVEN;
use ripstop::study::v50_result::OVER_MEASURED;

use crate::support;

/// Lines of the README at most.
const README_LINES: usize = 130;
/// Generated parts: by the command of their name, and by tests that compute the same anyway and call [`hold`].
const GENERATED: [&str; 4] = [
    "ripstop schema --markdown",
    "coverage of intervals, 6000 synthetic ranges",
    "coverage of intervals from thresholds, 10 000 synthetic campaigns",
    "measured limits",
];

#[test]
fn the_readme_is_short_and_lists_of_pages_have_every_page_once() {
    let lines = fs::read_to_string("README.md").unwrap().lines().count();
    assert!(lines <= README_LINES, "{lines} lines");
    for (list, folder) in [("docs/src/SUMMARY.md", "docs/src"), ("docs/decisions/README.md", "docs/decisions")] {
        let list = Page::read(Path::new(list));
        let mut listed: Vec<String> = list.links().into_iter().map(|(target, _)| target).collect();
        let pages = pages::all().into_iter().filter(|page| page.path.parent() == Some(Path::new(folder)));
        let mut there: Vec<String> = pages.map(|page| page.name()).filter(|name| *name != list.name()).collect();
        listed.sort();
        there.sort();
        assert!(there.len() > 10 && listed == there, "{listed:?}, but there are {there:?}");
    }
}

#[test]
fn links_and_names_of_files_lead_somewhere() {
    const FOLDERS: [&str; 8] = ["examples/", "src/", "benches/", "cases/", "tests/", "docs/", "shaders/", ".ci/"];
    let mut counts = [0; 2];
    for page in pages::all() {
        for (target, line) in page.links() {
            let place = format!("{}:{line}: {target}", page.path.display());
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.path.clone() } else { page.path.with_file_name("").join(file) };
            assert!(path.is_file(), "{place}");
            assert!(anchor.is_empty() || Page::read(&path).anchors().iter().any(|known| known == anchor), "{place}");
            counts[0] += 1;
        }
        let is_file = |name: &str| FOLDERS.iter().any(|folder| name.starts_with(folder)) && !name.contains(['X', ' ']);
        for (name, line) in page.quoted().into_iter().filter(|(name, _)| is_file(name)) {
            assert!(Path::new(&name).exists(), "{}:{line}: {name}", page.path.display());
            counts[1] += 1;
        }
    }
    assert!(counts[0] > 40 && counts[1] > 10, "{counts:?}");
}

#[test]
fn every_generated_part_is_held() {
    let output = program(GENERATED[0]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    hold(GENERATED[0], &String::from_utf8(output.stdout).unwrap());
    let mut names = Vec::new();
    for page in pages::all() {
        let parts = page.text.split("<!-- generated: ").skip(1);
        names.extend(parts.map(|part| part.split_once(" -->").unwrap().0.to_owned()));
    }
    names.sort();
    let mut held = GENERATED;
    held.sort_unstable();
    assert_eq!(names, held);
}

#[test]
fn the_example_of_the_library_runs() {
    library::main().unwrap();
}

/// A row whose bracket as woven is shot again: two shots. The limit of the first row is shot in `objectivity`.
#[test]
fn measured_limits_are_those_of_their_page() {
    let rows = measured::rows().unwrap();
    hold(GENERATED[3], &measured::table(&rows));
    let picture = measured::picture(&rows);
    match pages::is_update() {
        true => fs::write(measured::PICTURE, picture).unwrap(),
        false => assert!(fs::read_to_string(measured::PICTURE).unwrap() == picture, "{}", measured::PICTURE),
    }
    assert!(rows.len() >= 15 && fs::read_to_string("README.md").unwrap().contains(&measured::sentence(&rows)));
    // What `v50` says of limits so far holds for every row.
    for (woven, (_, [least, largest])) in OVER_MEASURED.into_iter().enumerate() {
        let ratios: Vec<f64> = rows.iter().filter_map(|row| row.ratio(woven)).collect();
        let range = least - 0.005..largest + 0.005;
        assert!(ratios.len() > 5 && ratios.iter().all(|ratio| range.contains(ratio)), "{ratios:?}");
    }
    let row = rows.iter().find(|row| row.name.starts_with("KM2 S-706, 4 plies, 2-grain")).unwrap();
    let case = row.case(AS_WOVEN[0]).unwrap();
    for (velocity, outcome) in row.computed_m_s[1].unwrap().into_iter().zip(["stopped", "perforated"]) {
        let run = case.with("/projectile/velocity_m_s", velocity).unwrap().run().unwrap();
        assert_eq!(run.outcome.word(), outcome, "{} at {velocity} m/s", row.name);
    }
}

/// Two small plies, struck for a few steps.
fn shot() -> (Case, Run) {
    let text = r#"{"title": "two plies", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"plies": 2, "width_mm": 20, "height_mm": 20},
        "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 1, "velocity_m_s": 100},
        "solver": {"end_time_us": 2}}"#;
    let case = support::read("two-plies", text, &[]);
    let run = support::run(&case);
    (case, run)
}

fn page(name: &str) -> Page {
    Page::read(&Path::new("docs/src").join(name))
}

#[test]
fn keys_of_the_summary_and_columns_of_the_history() {
    let (case, run) = shot();
    let summary = output::summary(&case, &run, 1.0);
    let keys: Vec<&String> = summary.as_object().unwrap().keys().collect();
    let files = page("results.md");
    assert_eq!(files.first_cells("summary.json").iter().collect::<Vec<_>>(), keys);
    assert_eq!(files.first_cells("history.csv"), COLUMNS.map(|(name, _)| name));
}

#[test]
fn files_of_a_run_and_columns_of_the_small_tables() {
    let folder = tempfile::TempDir::new().unwrap();
    let sets = "--set /pack/plies=2 --set /solver/end_time_us=2 --set /expect=[] --set /output/profile_times_us=[1]";
    let case = format!("{}/cases/verify/mirror.json", env!("CARGO_MANIFEST_DIR"));
    let line = format!("ripstop run {case} {sets} --quiet -o out");
    assert!(program(&line).current_dir(folder.path()).status().unwrap().success());
    let out = folder.path().join("out");
    let files = page("results.md");
    for name in ["events.csv", "plies.csv", "profiles.csv"] {
        let text = fs::read_to_string(out.join(name)).unwrap();
        let columns: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let (_, section) = files.text.split_once(&format!("## {name}\n")).unwrap();
        let quoted: Vec<&str> = section.split('`').skip(1).step_by(2).take(columns.len()).collect();
        assert_eq!(quoted, columns, "{name}");
    }
    let listed = files.first_cells("Files");
    for entry in fs::read_dir(out).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(listed.contains(&name), "{name} of {listed:?}");
    }
}

#[test]
fn checks_behind_the_line_of_trust_and_energies() {
    let (case, run) = shot();
    let results = page("results.md");
    let mut listed = results.first_cells("The line of trust");
    let mut names: Vec<&str> = checks::checks(&case, &run).iter().map(|check| check.name).collect();
    listed.sort();
    names.sort_unstable();
    assert_eq!(listed, names);
    // The first limits of those that have one in per cent.
    for (check, limit) in [
        ("energy gained", GAINED_LIMIT),
        ("hourglass / internal energy", HOURGLASS_LIMIT),
        ("energy of ply separation", GAINED_LIMIT),
    ] {
        let row = format!("| {check} | more than {} %", 100.0 * limit);
        assert!(results.text.contains(&row), "{row}");
    }
    let energies = output::Energies::of(&run).unwrap();
    let shares: Vec<&str> = energies.shares.iter().map(|(name, _)| *name).collect();
    assert_eq!(results.first_cells("Where the energy went"), shares);
}

#[test]
fn commands_of_the_program_are_listed_and_every_shell_knows_them() {
    let text = |line: &str| String::from_utf8(program(line).env("COLUMNS", "400").output().unwrap().stdout).unwrap();
    let first_words = |lines: &str| -> Vec<String> {
        let words =
            lines.lines().filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
        words.map(ToString::to_string).collect()
    };
    let help = text("ripstop --help");
    let commands = help.split_once("Commands:\n").unwrap().1.split_once("\n\n").unwrap().0;
    let mut commands: Vec<String> = first_words(commands).into_iter().filter(|name| name != "help").collect();
    let mut listed = page("commands.md").first_cells("The commands");
    listed.sort();
    commands.sort();
    assert_eq!(listed, commands);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = text(&format!("ripstop completions {shell}"));
        commands.iter().for_each(|command| assert!(script.contains(command), "{command} for {shell}"));
    }
}

#[test]
fn cases_in_pages_are_cases() {
    let mut count = 0;
    for page in pages::all() {
        for block in page.blocks().iter().filter(|block| block.kind == "json") {
            let text = block.lines.join("\n");
            let read = case::from_str("page", &text, &[]);
            assert!(read.is_ok(), "{}:{}: {}", page.path.display(), block.at, read.unwrap_err());
            count += 1;
        }
    }
    assert!(count >= 1);
}

/// From the top down; each may use itself and those before it.
const ROOMS: [&str; 10] = ["num", "case", "physics", "model", "solver", "gpu", "run", "output", "study", "cli"];

/// Files of `src/` itself, and why they stand there.
const LOOSE: [&str; 2] = ["lib.rs", "main.rs"];

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
    found
}

/// Rooms that a source text names, comments left out.
fn used(text: &str) -> Vec<String> {
    let code: String = text.lines().map(|line| line.split("//").next().unwrap_or_default().to_owned() + "\n").collect();
    let mut rooms = Vec::new();
    for path in code.split("crate::").skip(1).chain(code.split("ripstop::").skip(1)) {
        match path.strip_prefix('{') {
            Some(group) => {
                let names = group.split(';').next().unwrap_or_default().split([',', '{', '}', ':', '\n']);
                rooms.extend(names.map(|name| name.trim().to_owned()));
            }
            None => rooms.push(path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()),
        }
    }
    rooms
}

fn rank(room: &str) -> Option<usize> {
    ROOMS.iter().position(|name| *name == room)
}

#[test]
fn every_file_stands_in_a_room_that_uses_none_below_it() {
    let mut wrong = Vec::new();
    for path in sources(Path::new("src")) {
        let room = path.components().nth(1).unwrap().as_os_str().to_string_lossy().into_owned();
        let Some(own) = rank(&room) else {
            assert!(LOOSE.contains(&room.as_str()), "src/{room} is in no room");
            continue;
        };
        let text = fs::read_to_string(&path).unwrap();
        let text = text.split("\n#[cfg(test)]\n").next().unwrap();
        wrong.extend(
            used(text)
                .into_iter()
                .filter(|used| rank(used).is_some_and(|other| other > own))
                .map(|used| format!("{} uses {used}", path.display())),
        );
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
