#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

#[test]
fn defaults_are_values_of_their_own_key_and_have_a_source() {
    let all = pointers();
    assert!(all.len() > 100, "{}", all.len());
    for pointer in all {
        let key = lookup(&pointer).unwrap();
        assert!(key.text("description").ends_with('.'), "{pointer}");
        if let Some(default) = key.node.get("default") {
            assert!(accepts(key.node, default), "{pointer}");
            assert!(default.is_object() || !key.text("source").is_empty(), "{pointer}");
        }
    }
}

#[test]
fn pointers_are_looked_up() {
    let known = [("/expect/3/at_us", "at_us"), ("/expect/0", "expect"), ("/pack/layup/12/fabric/warp/crimp", "crimp")];
    assert!(known.into_iter().all(|(pointer, name)| lookup(pointer).is_some_and(|key| key.name == name)));
    let unknown =
        ["/pack/layup/fabric", "/pack/layup/0/1", "/pack/layup/01", "", "/", "/expect/at_us", "/title/0", "pack"];
    assert!(unknown.into_iter().all(|pointer| lookup(pointer).is_none()));
}
