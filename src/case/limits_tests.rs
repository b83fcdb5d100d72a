#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

#[test]
fn the_mesh_is_the_nearest_whole_number_and_never_overflows() {
    assert_eq!(mesh("/pack", [0.203, 0.001], [0.00127, 0.00127], 1.0).unwrap(), [160, 1]);
    assert_eq!(mesh("/pack", [0.0305, 0.0294], [0.000635, 0.000635], 2.0).unwrap(), [48, 46]);
    assert!(mesh("/pack", [f64::MAX, f64::MAX], [1e-300, 1e-300], 1.0).is_err());
}

/// Memory for a case of these plies and frames, its two rows of history aside, and its elements.
fn needed(pack: &str, frames: u32) -> (f64, f64) {
    let text = format!(
        r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 100}},
            "output": {{"history_interval_us": 100, "frames": {frames}}}, "pack": {{"width_mm": 14, "height_mm": 25.4, {pack}}}}}"#
    );
    let case = crate::case::from_str("t", &text, &[]).unwrap();
    (memory_needed(&case) - 3.0 * ROW_BYTES, case.elements() as f64)
}

#[test]
fn memory_counts_every_ply_its_contact_and_its_frames() {
    let (one, two) = (220.0 * ELEMENT_BYTES, 2.0 * (220.0 * ELEMENT_BYTES + 252.0 * CONTACT_BYTES));
    // 14 mm are 9.4 crossovers of S-728 and 11.0 of S-720, 25.4 mm 17 and 20.
    let own = 9.0 * 17.0 * ELEMENT_BYTES + 10.0 * 18.0 * CONTACT_BYTES;
    for (pack, bytes) in [
        (r#""plies": 1"#, one),
        (r#""plies": 2"#, two),
        (r#""layup": [{}, {"orientation_deg": 90}]"#, two),
        (r#""layup": [{}, {"fabric": {"file": "fabrics/s-728.json"}}]"#, 0.5 * two + own),
    ] {
        assert_eq!(needed(pack, 0).0, bytes, "{pack}");
    }
    let frames = |pack: &str, frames: u32| (needed(pack, frames).0 - needed(pack, 0).0, needed(pack, 0).1);
    let (few, elements) = frames(r#""plies": 1"#, 10);
    assert_eq!(few, elements * 10.0 * (FRAME_BYTES + 2 * SNAPSHOT_BYTES) as f64);
    // Of many frames of a large pack one is made and two wait.
    let (many, elements) = frames(r#""plies": 16, "elements_per_crossover": 16"#, 10_000);
    assert_eq!(many, elements * (FRAME_BYTES + 2 * SNAPSHOT_BYTES) as f64);
}

#[test]
fn refuses_more_memory_than_there_is_and_says_both_numbers() {
    assert!(memory(1e9, Some(2e9)).is_ok() && memory(1e30, None).is_ok());
    let error = memory(2.56e12, Some(1.2e9)).unwrap_err();
    assert!(error.expected.contains("1.2 GB") && error.found.contains("2.6 TB"), "{error}");
}
