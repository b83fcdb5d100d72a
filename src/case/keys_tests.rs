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
fn pointers_are_looked_up_and_ordered() {
    for (pointer, name) in
        [("/expect/3/at_us", "at_us"), ("/expect/0", "expect"), ("/pack/layup/12/fabric/warp/crimp", "crimp")]
    {
        assert_eq!(lookup(pointer).unwrap().name, name);
    }
    let unknown =
        ["/pack/layup/fabric", "/pack/layup/0/1", "/pack/layup/01", "", "/", "/expect/at_us", "/title/0", "fabric"];
    for unknown in unknown {
        assert!(lookup(unknown).is_none(), "{unknown}");
    }
    for [first, second] in [
        ["/fabric/warp/crimp", "/fabric/weft/absent"],
        ["/expect/2", "/expect/10"],
        ["/pack/layup/2/edges", "/pack/layup/10/plies"],
        ["/pack/layup/0/fabric/shear/modulus", "/pack/layup/0/orientation_deg"],
    ] {
        assert!(order(first) < order(second), "{first}");
    }
}
