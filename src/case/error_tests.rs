use super::*;

#[test]
fn counts_edits_and_neighbour_swaps() {
    let count = |a: &str, b: &str| edits(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>());
    assert_eq!(count("", "abc"), 3);
    assert_eq!(count("kitten", "sitting"), 3);
    assert_eq!(count("crmip", "crimp"), 1);
}

#[test]
fn the_nearest_key_is_the_one_meant() {
    let keys = ["mass_g", "velocity_m_s", "standoff_mm", "yaw_deg"];
    assert_eq!(nearest("mass_gg", keys), Some("mass_g"));
    assert_eq!(nearest("velocity", keys), Some("velocity_m_s"));
    assert_eq!(nearest("stand_off_mm", keys), Some("standoff_mm"));
    assert_eq!(nearest("x", []), None);
}

#[test]
fn prints_where_expected_found_and_help() {
    let error = CaseError::at("/a/b", "a number", "\"x\"").help("write a number").in_file("case.json");
    let text = "error: case.json: /a/b\n  expected: a number\n  found: \"x\"\n  help: write a number";
    assert_eq!(error.to_string(), text);
}
