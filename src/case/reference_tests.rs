use super::*;

#[test]
fn every_key_has_one_row() {
    let reference = reference();
    let mut leaves = 0;
    for pointer in table::pointers() {
        let name = pointer.rsplit('/').next().unwrap_or_default();
        assert!(reference.contains(&format!("\n| `{name}` |")), "{pointer}");
        leaves += 1;
    }
    assert!(leaves > 100, "{leaves} keys");
    assert_eq!(reference.matches("| `failure_strain` |").count(), 1, "warp and weft share a table");
}
