//! The README, the book under `docs/src`, the decisions and the examples, held to the program.
//!
//! Promises: the README is short; every command in a block marked `sh` or `console` does what its page says, and prints what a
//! `console` block shows; tables marked as generated are what the program prints; lists of keys, columns, checks and commands
//! are those of the program; links, paths and the summary lead somewhere; examples end with no error. With `RIPSTOP_UPDATE_DOCS=1` generated tables and the
//! picture are written anew.

mod commands;
#[path = "../examples/library.rs"]
mod library;
mod lists;
#[allow(dead_code, reason = "the suite does not compute limits")]
#[path = "../examples/measured.rs"]
mod measured;
mod page;

use std::fs;
use std::path::Path;

use page::Page;
pub(crate) use page::hold;
use ripstop::study::v50::AS_WOVEN;
use ripstop::study::v50_result::OVER_MEASURED;

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
        let pages = page::all().into_iter().filter(|page| page.path.parent() == Some(Path::new(folder)));
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
    for page in page::all() {
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
    let output = commands::program(GENERATED[0]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    hold(GENERATED[0], &String::from_utf8(output.stdout).unwrap());
    let mut names = Vec::new();
    for page in page::all() {
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
    match page::is_update() {
        true => fs::write(measured::PICTURE, picture).unwrap(),
        false => assert!(fs::read_to_string(measured::PICTURE).unwrap() == picture, "{}", measured::PICTURE),
    }
    assert!(rows.len() >= 15 && fs::read_to_string("README.md").unwrap().contains(&measured::sentence(&rows)));
    // What `v50` says of limits so far holds for every row.
    for (woven, (_, [least, largest])) in OVER_MEASURED.into_iter().enumerate() {
        let ratios: Vec<f64> = rows.iter().filter_map(|row| row.ratio(woven)).collect();
        assert!(
            ratios.len() > 5 && ratios.iter().all(|ratio| (least - 0.005..largest + 0.005).contains(ratio)),
            "{ratios:?}"
        );
    }
    let row = rows.iter().find(|row| row.name.starts_with("KM2 S-706, 4 plies, 2-grain")).unwrap();
    let case = row.case(AS_WOVEN[0]).unwrap();
    for (velocity, outcome) in row.computed_m_s[1].unwrap().into_iter().zip(["stopped", "perforated"]) {
        let run = case.with("/projectile/velocity_m_s", velocity).unwrap().run().unwrap();
        assert_eq!(run.outcome.word(), outcome, "{} at {velocity} m/s", row.name);
    }
}
