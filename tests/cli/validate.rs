//! `ripstop validate`: published numbers, on the screen, for scripts, in a page and in the README.
//!
//! Promise: every published number that a case states is in the table; the README shows what this build computes.

use ripstop::validate::{SHOTS, is_published};

use super::*;

#[test]
fn readme_json_and_page_show_the_table_of_this_build() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["validate", "--backend", "cpu", "--markdown", "--html", "page.html"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let readme = fs::read_to_string("README.md").unwrap();
    let (_, after) = readme.split_once("<!-- validate -->\n").expect("the marker before the table");
    let (table, _) = after.split_once("<!-- /validate -->").expect("the marker after it");
    assert_eq!(table.trim(), stdout(&output).trim(), "`ripstop validate --backend cpu --markdown` makes it");
    let page = bench.text("page.html");
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"), "{page}");
    for row in stdout(&output).lines().skip(2) {
        for cell in row.trim_matches('|').split(" | ").map(str::trim).filter(|cell| !cell.is_empty()) {
            assert!(page.contains(cell), "{cell} in\n{page}");
        }
    }
    assert!(!page.contains("http://") && !page.contains("https://"), "the page needs nothing but itself");
    assert!(page.matches("class=\"pass\"").count() >= 10 && !page.contains("class=\"fail\""), "{page}");
}

#[test]
fn no_published_number_of_a_case_is_left_out() {
    let mut found = Vec::new();
    for entry in fs::read_dir("cases").unwrap().map(|entry| entry.unwrap().path()) {
        if entry.extension().is_some_and(|extension| extension == "json") {
            let case: Value = serde_json::from_str(&fs::read_to_string(&entry).unwrap()).unwrap();
            let mut sources = case["expect"].as_array().into_iter().flatten().filter_map(|e| e["source"].as_str());
            if sources.any(is_published) {
                found.push(entry.file_stem().unwrap().to_str().unwrap().to_owned());
            }
        }
    }
    found.sort();
    assert_eq!(found, SHOTS.map(|(name, _)| name));
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_anything_is_computed() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["validate", "--backend", "cpu", "--html", "shot.json/page.html"]);
    assert_eq!((code(&output), stdout(&output)), (2, String::new()));
    assert!(stderr(&output).contains("shot.json"), "{}", stderr(&output));
    assert_eq!(code(&bench.ripstop(&["validate", "--json", "--markdown"])), 2);
}
