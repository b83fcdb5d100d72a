use serde_json::json;

use super::*;

#[test]
fn the_hash_knows_numbers_not_words_or_order() {
    let one = case_hash(&json!({"title": "a", "pack": {"plies": 1, "width_mm": 30}, "sources": {"/pack": "x"}}));
    let same = case_hash(&json!({"pack": {"width_mm": 30.0, "plies": 1}, "title": "b", "expect": []}));
    let other = case_hash(&json!({"title": "a", "pack": {"plies": 1, "width_mm": 31}}));
    assert_eq!(one, same);
    assert_ne!(one, other);
    assert_eq!(case_hash(&json!({})), "08f44b07b5901a25"); // FNV-1a of "{}"
}
