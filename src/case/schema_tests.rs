use super::*;

#[test]
fn every_key_has_one_row() {
    let reference = reference();
    for pointer in crate::case::keys::pointers() {
        let name = pointer.rsplit('/').next().unwrap_or_default();
        assert!(reference.contains(&format!("\n| `{name}` |")), "{pointer}");
    }
    assert_eq!(reference.matches("| `failure_strain` |").count(), 1, "warp and weft share a table");
}
