#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

#[test]
fn the_mesh_is_the_nearest_whole_number_and_never_overflows() {
    assert_eq!(mesh("/pack", [0.203, 0.001], [0.00127, 0.00127], 1).unwrap(), [160, 1]);
    assert_eq!(mesh("/pack", [1e-9, 0.00635], [0.00127, 0.00127], 1).unwrap(), [1, 5]);
    assert_eq!(mesh("/pack", [0.0305, 0.0294], [0.000635, 0.000635], 2).unwrap(), [48, 46]);
    assert!(mesh("/pack/layup/1", [1e6, 1e6], [1e-5, 1e-5], 1).unwrap_err().found.contains("elements"));
    assert!(mesh("/pack", [f64::MAX, f64::MAX], [1e-300, 1e-300], 1).is_err());
}

#[test]
fn memory_counts_every_ply_with_its_own_mesh_and_contact_where_there_are_several() {
    let needed = |pack: &str| {
        let text = format!(
            r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 100}},
                "output": {{"history_interval_us": 100}}, "pack": {{"width_mm": 14, "height_mm": 25.4, {pack}}}}}"#
        );
        memory_needed(&crate::case::from_str("t", &text, &[]).unwrap()) - 3.0 * ROW_BYTES
    };
    let (one, two) = (220.0 * ELEMENT_BYTES, 2.0 * (220.0 * ELEMENT_BYTES + 252.0 * CONTACT_BYTES));
    assert_eq!(needed(r#""plies": 1"#), one);
    assert_eq!(needed(r#""plies": 2"#), two);
    assert_eq!(needed(r#""layup": [{}]"#), one);
    assert_eq!(needed(r#""layup": [{}, {"orientation_deg": 90}]"#), two);
    // 14 mm are 9.4 crossovers of S-728 and 11.0 of S-720, 25.4 mm 17 and 20.
    let own = 9.0 * 17.0 * ELEMENT_BYTES + 10.0 * 18.0 * CONTACT_BYTES;
    assert_eq!(needed(r#""layup": [{}, {"fabric": {"file": "fabrics/s-728.json"}}]"#), 0.5 * two + own);
}

#[test]
fn frames_take_memory_within_bounds() {
    let needed = |frames: u32, size: u32| {
        let text = format!(
            r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 100}},
                "output": {{"frames": {frames}}}, "pack": {{"width_mm": {size}, "height_mm": {size}}}}}"#
        );
        let case = crate::case::from_str("t", &text, &[]).unwrap();
        (frames_bytes(&case), case.elements() as f64)
    };
    assert_eq!(needed(0, 203).0, 0.0);
    let (few, elements) = needed(10, 203);
    assert_eq!(few, elements * 10.0 * (400.0 + 2.0 * 80.0));
    let (many, elements) = needed(10_000, 203);
    assert!(many > few && many < 2.0 * 1.35e8, "{many} for {elements}");
    let (large, elements) = needed(10_000, 2000);
    assert_eq!(large, elements * (400.0 + 2.0 * 80.0));
}

#[test]
fn refuses_more_memory_than_there_is_and_says_both_numbers() {
    assert!(memory(1e9, Some(2e9)).is_ok());
    assert!(memory(1e30, None).is_ok());
    let error = memory(2.56e12, Some(1.2e9)).unwrap_err();
    assert!(error.expected.contains("1.2 GB") && error.found.contains("2.6 TB"), "{error}");
}
