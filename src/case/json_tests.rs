#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

#[test]
fn reads_what_serde_json_reads() {
    let text = r#"{"z": [1, -2, 0.1, true, null, "µ"], "a": {"b": 18446744073709551615}}"#;
    assert_eq!(parse(text).unwrap(), serde_json::from_str::<Value>(text).unwrap());
}

#[test]
fn each_damage_is_named_where_it_is() {
    let cases = [
        ("{\"a\": 1,\n \"a\": 2}", "line 2, column 4", "duplicate key \"a\""),
        ("{\"a\": NaN}", "line 1, column 7", "\"NaN\""),
        ("{\"a\": -Infinity}", "line 1, column 8", "-Infinity"),
        ("{\"a\": 1e999}", "line 1", "1e999"),
        ("{\"a\": 1} x", "line 1, column 10", "\"x\""),
        ("{\"a\": 1,}", "line 1, column 9", "comma"),
        ("{\"a\": 1", "line 1, column 7", "end of the text"),
        ("{a: 1}", "line 1, column 2", "\"a\""),
        ("{\"a\": 1 // mm\n}", "line 1, column 9", "\"//\""),
        ("\u{feff}{}", "line 1, column 1", "BOM"),
        (" \n", "line 1, column 1", "an empty file"),
    ];
    for (text, location, found) in cases {
        let error = parse(text).unwrap_err();
        assert!(error.location.starts_with(location), "{text}: {error}");
        assert!(error.found.contains(found), "{text}: {error}");
        assert!(!error.expected.is_empty(), "{text}: {error}");
    }
}
