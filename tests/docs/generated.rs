//! Parts of pages that the program makes: between `<!-- generated: NAME -->` and `<!-- /generated -->`.

use std::fs;

use super::commands;
use super::page::{self, Page};

const END: &str = "<!-- /generated -->";

/// Made here, by the command that is their name.
const BY_COMMAND: [&str; 1] = ["ripstop schema --markdown"];
/// Made in other tests, which compute the same anyway, and call [`hold`].
const BY_OTHERS: [&str; 2] = [
    "coverage of intervals from thresholds, 10 000 synthetic campaigns",
    "coverage of intervals, 6000 synthetic ranges",
];

/// Whether pages are to be written anew.
pub(super) fn is_update() -> bool {
    std::env::var("RIPSTOP_UPDATE_DOCS").is_ok_and(|value| value == "1")
}

/// Holds the part of that name to what was made, or writes it into its page.
#[track_caller]
pub(crate) fn hold(name: &str, made: &str) {
    let start = format!("<!-- generated: {name} -->\n");
    let mut pages = page::book();
    pages.retain(|page| page.text.contains(&start));
    let [Page { path, text }] = &pages[..] else { panic!("{name}: in {} pages", pages.len()) };
    let (before, rest) = text.split_once(&start).unwrap();
    let (shown, after) = rest.split_once(END).expect("its end");
    if is_update() {
        return fs::write(path, format!("{before}{start}{}\n{END}{after}", made.trim())).unwrap();
    }
    let differs = shown.trim().lines().zip(made.trim().lines()).find(|(shown, made)| shown != made);
    let counts = [shown, made].map(|text| text.trim().lines().count());
    assert!(
        differs.is_none() && counts[0] == counts[1],
        "{}: not what `{name}` makes, {counts:?} lines; first: {differs:?}\nRIPSTOP_UPDATE_DOCS=1 writes it anew",
        path.display()
    );
}

#[test]
fn tables_are_what_the_program_prints() {
    for name in BY_COMMAND {
        let output = commands::program(name).output().unwrap();
        assert!(output.status.success(), "{name}: {output:?}");
        hold(name, &String::from_utf8(output.stdout).unwrap());
    }
}

#[test]
fn no_generated_part_is_held_by_nobody() {
    let mut names = Vec::new();
    for page in page::all() {
        let parts = page.text.split("<!-- generated: ").skip(1);
        names.extend(parts.map(|part| part.split_once(" -->").unwrap().0.to_owned()));
    }
    names.sort();
    let mut held = [&BY_COMMAND[..], &BY_OTHERS].concat();
    held.sort_unstable();
    assert_eq!(names, held);
}
