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
use crate::scene;

/// Two small plies, struck for a few steps.
fn shot() -> &'static (Case, Run) {
    static SHOT: OnceLock<(Case, Run)> = OnceLock::new();
    SHOT.get_or_init(|| {
        let text = r#"{"title": "two plies", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"plies": 2, "width_mm": 20, "height_mm": 20},
            "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 1, "velocity_m_s": 100},
            "solver": {"end_time_us": 2}}"#;
        let case = case::from_str("two-plies", text, &[]).unwrap();
        let run = scene::run(&case);
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
    let files = page("files.md");
    assert_eq!(files.first_cells("summary.json").iter().collect::<Vec<_>>(), keys);
    assert_eq!(files.first_cells("history.csv"), COLUMNS.map(|column| column.name));
}

#[test]
fn columns_of_the_small_tables() {
    let folder = tempfile::TempDir::new().unwrap();
    let sets = "--set /output/profile_times_us=[1] --quiet -o out";
    let case = r#"cases/verify/mirror.json --set /pack/plies=2 --set /solver/end_time_us=2 --set /expect=[]"#;
    let line = format!("ripstop run {case} {sets}").replace("cases", &format!("{}/cases", env!("CARGO_MANIFEST_DIR")));
    let output = program(&line).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let files = page("files.md");
    for name in ["events.csv", "plies.csv", "profiles.csv"] {
        let text = fs::read_to_string(folder.path().join("out").join(name)).unwrap();
        let columns: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let (_, section) = files.text.split_once(&format!("## {name}\n")).unwrap();
        let section = Page { path: files.path.clone(), text: section.split("\n## ").next().unwrap().to_owned() };
        let mut quoted: Vec<String> = section.quoted().into_iter().map(|(word, _)| word).collect();
        quoted.truncate(columns.len());
        assert_eq!(quoted, columns, "{name}");
    }
    let names: Vec<String> = fs::read_dir(folder.path().join("out"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    let listed = files.first_cells("Files, keys and columns");
    for name in names {
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
    let output = program("ripstop --help").env("COLUMNS", "400").output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let list = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let names = list.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names: Vec<&str> =
        names.map(|line| line.split_whitespace().next().unwrap()).filter(|name| *name != "help").collect();
    let mut listed = page("commands.md").first_cells("The commands");
    let mut names: Vec<String> = names.iter().map(ToString::to_string).collect();
    listed.sort();
    names.sort();
    assert_eq!(listed, names);
}

#[test]
fn codes_of_the_program() {
    let output = program("ripstop explain").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let (exits, warnings) = text.split_once("\nwarnings\n").unwrap();
    let codes = |text: &str, is_code: fn(&str) -> bool| -> Vec<String> {
        let words = text.lines().filter_map(|line| line.split_whitespace().next());
        words.filter(|word| is_code(word)).map(ToString::to_string).collect()
    };
    let is_exit = |word: &str| word.bytes().all(|byte| byte.is_ascii_digit());
    let is_warning = |word: &str| word.len() == 2 && word.starts_with('W');
    assert_eq!(page("codes.md").first_cells("Exit codes"), codes(exits, is_exit));
    assert_eq!(page("codes.md").first_cells("Warnings"), codes(warnings, is_warning));
}

#[test]
fn cases_in_pages_are_cases() {
    let mut count = 0;
    for page in super::page::all() {
        for block in page.blocks().iter().filter(|block| block.kind == "json") {
            let text = block.lines.join("\n");
            let read = case::from_text("page", &text, Path::new("cases"), &[]);
            assert!(read.is_ok(), "{}:{}: {}", page.path.display(), block.at, read.unwrap_err());
            count += 1;
        }
    }
    assert!(count >= 1);
}
