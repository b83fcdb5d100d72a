//! `ripstop verify`: the shipped cases, a line for each expectation.

use ripstop::study::verify::CASES;

use super::*;

#[test]
fn every_shipped_case_passes_and_each_expectation_has_a_row() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["verify", "--backend", "cpu", "--precision", "f32", "--json"]);
    assert_eq!((code(&output), stderr(&output)), (0, String::new()));
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(report["pass"], true);
    for (name, text) in CASES {
        let case: Value = serde_json::from_str(text).unwrap();
        let of_case: Vec<&Value> = rows.iter().filter(|row| row["name"] == *name).collect();
        let quantities = |rows: Vec<&Value>| rows.iter().map(|row| row["quantity"].clone()).collect::<Vec<_>>();
        assert_eq!(quantities(of_case), quantities(case["expect"].as_array().unwrap().iter().collect()), "{name}");
    }
    assert!(rows.iter().all(|row| row["pass"] == true && !row["got"].is_null()), "{rows:#?}");
    assert_eq!(rows.len(), CASES.iter().map(|(_, text)| text.matches("\"quantity\"").count()).sum::<usize>());
}
