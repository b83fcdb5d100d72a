#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use std::collections::HashSet;

use super::*;

/// Cases that together give every key, or have it by default.
const EVERY_KEY: &[&str] = &[
    r#""pack": {"width_mm": 9, "height_mm": 9, "spacing_mm": 1, "edges": {}, "mesh_grading": {}, "initial_deflection":
        {"amplitude_mm": 1, "warp_half_waves": 1, "weft_half_waves": 1}},
        "projectile": {"shape": "cone", "diameter_mm": 5, "length_mm": 9, "mass_g": 1, "velocity_m_s": 9}"#,
    // The fabric of the group is the case's.
    r#""pack": {"width_mm": 9, "height_mm": 9, "layup": [{"fabric": FABRIC, "edges": {}}]}"#,
    r#""pack": {"width_mm": 9, "height_mm": 9, "layup": [{"edges": "free"}]}"#,
    r#""pack": {"width_mm": 9, "height_mm": 9},
        "projectile": {"shape": "fragment", "diameter_mm": 5, "length_mm": 6, "density_kg_m3": 7850, "velocity_m_s": 9}"#,
    r#""pack": {"width_mm": 9, "height_mm": 9},
        "projectile": {"shape": "bar", "diameter_mm": 5, "velocity_m_s": 9, "motion": "prescribed"}"#,
    r#""pack": {"width_mm": 9, "height_mm": 9},
        "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 1, "velocity_m_s": 9},
        "variability": {"shot": 0, "velocity": {"scatter_m_s": 1}, "obliquity": {"scatter_deg": 1}, "yaw": {"scatter_deg": 1},
        "modulus": {"scatter": 0.01}, "crimp": {"scatter": 0.01},
        "yarn_strength": {"shape": 9, "gauge_length_mm": 50, "yarn_shape": 20}}"#,
];

/// Every pointer, those of one group of plies too.
fn with_layup() -> Vec<String> {
    let mut known = pointers();
    collect("/pack/layup/0", lookup("/pack/layup").unwrap().keys(), &mut known);
    known
}

#[test]
fn the_reader_reads_every_key() {
    let yarn = |density: &str, count: &str| {
        format!(
            r#"{{"linear_density_{density}": 150, "modulus_gpa": 9, "failure_strain": 1, "{count}": 9, "crimp": 0}}"#
        )
    };
    let mut read = HashSet::new();
    for (warp, weft) in [("denier", "tex"), ("dtex", "denier"), ("tex", "dtex")] {
        for part in EVERY_KEY {
            for counts in [["count_per_inch", "count_per_cm"], ["count_per_cm", "count_per_inch"]] {
                let (warp, weft) = (yarn(warp, counts[0]), yarn(weft, counts[1]));
                let fabric = format!(r#"{{"name": "f", "fibre_density_kg_m3": 1440, "warp": {warp}, "weft": {weft}}}"#);
                let part = part.replace("FABRIC", &fabric);
                let text = format!(
                    r#"{{"$schema": "s", "title": "t", "notes": "n", {part}, "solver": {{"end_time_us": 9}}, "fabric": {fabric}}}"#
                );
                let case = crate::case::from_str("t", &text, &[]).unwrap();
                read.extend(case.fields.into_iter().map(|field| field.pointer));
            }
        }
    }
    let leaf = |pointer: &String| lookup(pointer).is_some_and(|key| key.keys().is_empty());
    let unread: Vec<String> =
        with_layup().into_iter().filter(|pointer| leaf(pointer) && !read.contains(pointer)).collect();
    assert_eq!(unread, ["/sources"]);
}

#[test]
fn defaults_are_values_of_their_own_key() {
    for pointer in with_layup() {
        let key = lookup(&pointer).unwrap();
        if let crate::case::fields::Presence::Default(literal, source) = key.presence {
            assert!(key.accepts(&literal.value()) && !source.is_empty(), "{pointer}");
        }
        assert!(key.doc.ends_with('.'), "{pointer}");
    }
}

#[test]
fn pointers_are_looked_up_and_ordered() {
    assert_eq!(lookup("/expect/3/at_us").unwrap().name, "at_us");
    assert_eq!(lookup("/expect/0").unwrap().name, "expect");
    assert_eq!(lookup("/pack/layup/12/fabric/warp/crimp").unwrap().name, "crimp");
    for unknown in [
        "/pack/layup/fabric",
        "/pack/layup/0/1",
        "/pack/layup/01",
        "",
        "/",
        "/expect/at_us",
        "/fabric/warp/",
        "/title/0",
        "fabric",
    ] {
        assert!(lookup(unknown).is_none(), "{unknown}");
    }
    assert!(order("/fabric/warp/crimp") < order("/fabric/weft/absent"));
    assert!(order("/expect/2") < order("/expect/10"));
    assert!(order("/pack/layup/2/edges") < order("/pack/layup/10/plies"));
    assert!(order("/pack/layup/0/fabric/shear/modulus") < order("/pack/layup/0/orientation_deg"));
}
