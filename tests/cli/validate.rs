//! `ripstop validate`: published numbers, on the screen, for scripts, in a page and in the book.
//!
//! Promise: every published number and closed form that a case states is in the table; the book shows what this build computes; a row that
//! fails is exit code 1, a case without a published statement is refused.

use ripstop::study::validate::is_published;

use super::*;

#[test]
fn book_and_page_show_the_table_of_this_build() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["validate", "--backend", "cpu", "--markdown", "--html", "page.html"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    crate::docs::hold("ripstop validate --backend cpu --markdown", &stdout(&output));
    let page = bench.text("page.html");
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"), "{page}");
    for row in stdout(&output).lines().skip(2) {
        for cell in row.split('|').map(str::trim).filter(|cell| !cell.is_empty()) {
            assert!(page.contains(&cell.replace('&', "&amp;").replace('\'', "&#39;")), "{cell} in\n{page}");
        }
    }
    assert!(!page.contains("http://") && !page.contains("https://"), "the page needs nothing but itself");
    assert!(page.matches("class=\"pass\"").count() >= 33, "{page}");
    let failed =
        "bias extension at three angles, the paper's perforation, the breaking velocity, Cunniff's failure strain";
    assert_eq!(page.matches("class=\"fail\"").count(), 6, "{failed}: {page}");
    let table = stdout(&output);
    for (group, count) in [
        ("weft free", 4),
        ("weft held", 3),
        ("blunt cone", 3),
        ("Picture frame", 3),
        ("Bias extension", 3),
        ("1 ply, RCC", 9),
    ] {
        let rows = table.lines().filter(|line| line.split('|').nth(1).is_some_and(|of| of.contains(group)));
        assert_eq!(rows.count(), count, "{group} in\n{table}");
    }
}

#[test]
fn no_published_number_of_a_case_is_left_out() {
    let mut found = Vec::new();
    for entry in ["cases", "cases/verify"].into_iter().flat_map(|folder| fs::read_dir(folder).unwrap()) {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "json") {
            let case: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
            let mut sources = case["expect"].as_array().into_iter().flatten().filter_map(|e| e["source"].as_str());
            if sources.any(is_published) {
                found.push(case["title"].as_str().unwrap().to_owned());
            }
        }
    }
    let page = fs::read_to_string("docs/src/validation.md").unwrap();
    assert!(found.len() >= 10, "{found:?}");
    for title in found {
        assert!(page.contains(&format!("\n| {title} | ")), "{title} is not in the table");
    }
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_anything_is_computed() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["validate", "--backend", "cpu", "--html", "shot.json/page.html"]);
    assert_eq!((code(&output), stdout(&output)), (2, String::new()));
    assert!(stderr(&output).contains("shot.json"), "{}", stderr(&output));
    assert_eq!(code(&bench.ripstop(&["validate", "--json", "--markdown"])), 2);
    assert_eq!(code(&bench.ripstop(&["validate", "--limits", "shot.json"])), 2);
}

/// Keys of a row, in order.
const KEYS: [&str; 11] = [
    "group",
    "name",
    "expected",
    "tolerance",
    "tolerance_because",
    "got",
    "difference",
    "source",
    "judged",
    "pass",
    "known_difference",
];

fn rows(output: &Output) -> Vec<Value> {
    let table: Value = serde_json::from_str(&stdout(output)).unwrap();
    let rows = table["rows"].as_array().unwrap().clone();
    let failed = rows.iter().any(|row| row["pass"] == false && row["known_difference"] == "");
    assert_eq!((&table["pass"], code(output)), (&json!(!failed), i32::from(failed)), "{}", stderr(output));
    assert!(table["paper"].as_str().unwrap().contains("2006"));
    for row in &rows {
        assert_eq!(row.as_object().unwrap().keys().collect::<Vec<_>>(), KEYS);
        assert_eq!(row["judged"], json!(row["pass"].is_boolean()));
        assert!(is_published(row["source"].as_str().unwrap()), "{row}");
    }
    rows
}

#[test]
fn json_holds_every_row_with_its_numbers() {
    let bench = Bench::new(&small());
    let root = env!("CARGO_MANIFEST_DIR");
    let cases =
        ["s720-1ply-155", "verify/smith-yarn-155", "verify/first-drop"].map(|name| format!("{root}/cases/{name}.json"));
    let named: Vec<&str> = cases.iter().map(String::as_str).collect();
    let output = bench.ripstop(&[&["validate", "--backend", "cpu", "--json"], &named[..]].concat());
    assert_eq!(stderr(&output), "");
    let rows = rows(&output);
    let count = |what: &Value| rows.iter().filter(|row| row["pass"] == *what).count();
    assert_eq!([json!(true), json!(false), Value::Null].each_ref().map(count), [4, 1, 0]);
    for row in rows.iter().filter(|row| row["expected"].is_number()) {
        let number = |key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"));
        let off = number("got") - number("expected");
        assert!((number("got") / number("expected") - 1.0 - number("difference")).abs() < 1e-12, "{row}");
        assert!(off.abs() <= number("tolerance") && !row["tolerance_because"].as_str().unwrap().is_empty(), "{row}");
    }
    let drop = rows.iter().find(|row| row["name"].as_str().unwrap().starts_with("projectile_velocity_m_s")).unwrap();
    assert_eq!(drop["expected"], json!(154.72403));
}

#[test]
fn a_statement_of_a_case_that_does_not_hold_is_1_and_is_shown_everywhere() {
    let state = |outcome: &str| {
        let published = json!({"quantity": "outcome", "value": outcome, "source": "published, Figure 9"});
        Bench::new(&small_with("/expect", json!([published, {"quantity": "elements", "max": 1, "source": "mine"}])))
    };
    let validate = ["validate", "shot.json", "--backend", "cpu"];
    let holds = rows(&state("running").ripstop(&[&validate[..], &["--json"]].concat()));
    assert_eq!((holds.len(), &holds[0]["pass"], &holds[0]["name"]), (1, &json!(true), &json!("outcome")));
    let bench = state("stopped");
    let fails = rows(&bench.ripstop(&[&validate[..], &["--json"]].concat()));
    assert_eq!((fails.len(), &fails[0]["pass"]), (1, &json!(false)));
    assert_eq!((&fails[0]["expected"], &fails[0]["got"]), (&json!("stopped"), &json!("running")));
    let output = bench.ripstop(&[&validate[..], &["--html", "page.html"]].concat());
    assert_eq!(code(&output), 1);
    assert!(stderr(&output).starts_with("error: validation: 0 of 1 judged rows pass"), "{}", stderr(&output));
    assert!(stdout(&output).contains("FAIL  outcome"), "{}", stdout(&output));
    let page = bench.text("page.html");
    assert!(page.contains("class=\"fail\"") && page.contains("0 pass, 1 fail"), "{page}");
}

#[test]
fn a_known_difference_stays_red_with_its_reason_and_is_no_failure() {
    let why = "nothing is fast enough";
    let published =
        json!({"quantity": "outcome", "value": "stopped", "source": "published, Figure 9", "known_difference": why});
    let bench = Bench::new(&small_with("/expect", json!([published])));
    let output = bench.ripstop(&["validate", "shot.json", "--backend", "cpu", "--html", "page.html"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("FAIL  outcome") && stdout(&output).contains(why), "{}", stdout(&output));
    assert!(stdout(&output).contains("1 differ for a known reason"), "{}", stdout(&output));
    let page = bench.text("page.html");
    assert!(page.contains("class=\"fail\"") && page.contains(why), "{page}");
    let output = bench.ripstop(&["run", "shot.json", "--backend", "cpu", "--out", "out"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("known  outcome") && stdout(&output).contains(why), "{}", stdout(&output));
    let check = &bench.json("out/summary.json")["expect"][0];
    assert_eq!((&check["pass"], &check["known_difference"]), (&json!(false), &json!(why)));
    assert!(bench.text("out/report.html").contains("known difference"));
}

#[test]
fn a_case_that_states_nothing_published_is_2() {
    let mine = json!([{"quantity": "elements", "min": 1, "source": "mine"}]);
    for case in [small(), small_with("/expect", mine)] {
        let output = Bench::new(&case).ripstop(&["validate", "shot.json", "--backend", "cpu"]);
        assert_eq!((code(&output), stdout(&output)), (2, String::new()));
        assert!(stderr(&output).contains("shot.json: /expect"), "{}", stderr(&output));
    }
}
