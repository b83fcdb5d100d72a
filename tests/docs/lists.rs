//! Lists in pages that are written by hand: their names are those of the program.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::output::checks::{self, GAINED_LIMIT, HOURGLASS_LIMIT};
use ripstop::output::csv::COLUMNS;
use ripstop::run::Run;

use super::commands::program;
use super::page::Page;
use crate::support;

/// Two small plies, struck for a few steps.
fn shot() -> &'static (Case, Run) {
    static SHOT: OnceLock<(Case, Run)> = OnceLock::new();
    SHOT.get_or_init(|| {
        let text = r#"{"title": "two plies", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"plies": 2, "width_mm": 20, "height_mm": 20},
            "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 1, "velocity_m_s": 100},
            "solver": {"end_time_us": 2}}"#;
        let case = case::from_str("two-plies", text, &[]).unwrap();
        let run = support::run(&case);
        (case, run)
    })
}

fn page(name: &str) -> Page {
    Page::read(&Path::new("docs/src").join(name))
}

#[test]
fn keys_of_the_summary_and_columns_of_the_history() {
    let (case, run) = shot();
    let summary = output::summary(case, run, 1.0);
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
    let mut names: Vec<&str> = checks::checks(case, run).iter().map(|check| check.name).collect();
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
    let energies = output::Energies::of(run).unwrap();
    let shares: Vec<&str> = energies.shares.iter().map(|(name, _)| *name).collect();
    assert_eq!(results.first_cells("Where the energy went"), shares);
}

#[test]
fn commands_of_the_program() {
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
}

#[test]
fn cases_in_pages_are_cases() {
    let mut count = 0;
    for page in super::page::all() {
        for block in page.blocks().iter().filter(|block| block.kind == "json") {
            let text = block.lines.join("\n");
            let read = case::from_str("page", &text, &[]);
            assert!(read.is_ok(), "{}:{}: {}", page.path.display(), block.at, read.unwrap_err());
            count += 1;
        }
    }
    assert!(count >= 1);
}
