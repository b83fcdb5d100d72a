//! The README and the book under `docs/`, held to the program.
//!
//! Promises: the README is short; every command in a block marked `sh` or `console` does what its page says, and prints what a
//! `console` block shows; tables marked as generated are what the program prints; lists of keys, columns, checks and commands
//! are those of the program; links, paths and the summary lead somewhere. With `RIPSTOP_UPDATE_DOCS=1` generated tables and the
//! picture are written anew.

mod commands;
mod generated;
mod lists;
mod page;

use std::fs;
use std::path::Path;

pub(crate) use generated::hold;
use page::Page;

/// Lines that somebody reads who has never seen the program.
const README_LINES: usize = 120;

#[test]
fn the_readme_is_short() {
    let lines = fs::read_to_string("README.md").unwrap().lines().count();
    assert!(lines <= README_LINES, "{lines} lines");
}

#[test]
fn the_summary_lists_every_page_once() {
    let summary = Page::read(Path::new("docs/src/SUMMARY.md"));
    let mut listed: Vec<String> = summary.links().into_iter().map(|(target, _)| target).collect();
    let mut there: Vec<String> = page::book().iter().map(Page::name).filter(|name| name != "SUMMARY.md").collect();
    listed.sort();
    there.sort();
    assert!(there.len() > 10, "{there:?}");
    assert_eq!(listed, there);
}

#[test]
fn the_index_lists_every_decision_once() {
    let index = Page::read(Path::new("docs/decisions/README.md"));
    let listed: Vec<String> = index.links().into_iter().map(|(target, _)| target).collect();
    let there = page::all().into_iter().filter(|page| page.path.starts_with("docs/decisions"));
    let there: Vec<String> = there.map(|page| page.name()).filter(|name| name != "README.md").collect();
    assert_eq!(listed, there);
}

#[test]
fn links_lead_somewhere() {
    let mut count = 0;
    for page in page::all() {
        for (target, line) in page.links() {
            let place = format!("{}:{line}: {target}", page.path.display());
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.path.clone() } else { page.path.with_file_name("").join(file) };
            assert!(path.is_file(), "{place}");
            let anchors = || Page::read(&path).anchors();
            assert!(anchor.is_empty() || anchors().iter().any(|known| known == anchor), "{place}: {:?}", anchors());
            count += 1;
        }
    }
    assert!(count > 40, "{count} links");
}

#[test]
fn files_of_the_source_that_pages_name_are_there() {
    const FOLDERS: [&str; 7] = ["src/", "benches/", "cases/", "tests/", "docs/", "shaders/", ".ci/"];
    let mut count = 0;
    for page in page::all() {
        for (name, line) in page.quoted() {
            let names_a_file = FOLDERS.iter().any(|folder| name.starts_with(folder)) && !name.contains(['X', ' ']);
            if names_a_file {
                assert!(Path::new(&name).exists(), "{}:{line}: {name}", page.path.display());
                count += 1;
            }
        }
    }
    assert!(count > 10, "{count} names");
}
