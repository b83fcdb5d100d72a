#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;

/// The document of a scene.
fn document(draw: &random::RandomScene) -> Value {
    document::case(draw, "scene").map_or(Value::Null, |case| case.as_run)
}

#[test]
fn seed_and_number_give_the_same_scene_and_others_another() {
    let scene = |seed, number| document(&random::tree(seed, number).unwrap().current());
    assert_eq!(scene(1, 0), scene(1, 0));
    let others = [scene(1, 0), scene(1, 1), scene(2, 0), scene(2, 1)];
    assert!(others.iter().enumerate().all(|(i, a)| others[..i].iter().all(|b| a != b)));
}

#[test]
fn what_a_machine_does_not_compute_is_left_out_of_the_same_scene() {
    const FURTHER: [&str; 3] = ["/pack/elements_per_crossover", "/pack/mesh_grading", "/solver/contact_sampling"];
    let given = |draw: &random::RandomScene| {
        let document = document::document(draw);
        FURTHER.map(|key| document.pointer(key).is_some())
    };
    let mut seen = [false; FURTHER.len()];
    for number in 0..100 {
        let draw = random::tree(5, number).unwrap().current();
        let whole = given(&draw);
        seen = [0, 1, 2].map(|key| seen[key] || whole[key]);
        let less: Vec<_> = draw.with_less().map(|less| given(&less)).collect();
        let count = |given: &[bool]| given.iter().filter(|given| **given).count();
        // Every other choice of them, the richest first, and nothing of its own.
        assert_eq!(less.len() + 1, 1 << count(&whole));
        assert!(less.windows(2).all(|pair| count(&pair[0]) >= count(&pair[1])));
        assert!(less.iter().all(|less| less != &whole && (0..FURTHER.len()).all(|key| whole[key] || !less[key])));
        let parts = |draw: &random::RandomScene| {
            let mut document = document::document(draw);
            // The aim is relative to the size, which goes with that of the elements.
            document["projectile"]["offset_mm"] = Value::Null;
            ["fabric", "projectile"].map(|part| document[part].clone())
        };
        assert!(draw.with_less().all(|less| parts(&less) == parts(&draw)));
    }
    assert_eq!(seen, [true; FURTHER.len()]);
}

#[test]
fn shrinking_leaves_the_changes_that_matter() {
    // As if whatever is faster than 900 m/s and obliquer than 30° failed.
    let fails = |draw: &random::RandomScene| {
        let document = document(draw);
        let number = |key: &str| document.pointer(&format!("/projectile/{key}")).and_then(Value::as_f64).unwrap_or(0.0);
        (number("velocity_m_s") > 900.0 && number("obliquity_deg") > 30.0).then_some(document)
    };
    let number = (0..).find(|number| fails(&random::tree(3, *number).unwrap().current()).is_some()).unwrap();
    let before = fails(&random::tree(3, number).unwrap().current()).unwrap();
    let after = smallest(random::tree(3, number).unwrap(), fails).unwrap();
    assert!(after.to_string().len() < before.to_string().len());
    let speed = after["projectile"]["velocity_m_s"].as_f64().unwrap();
    let angle = after["projectile"]["obliquity_deg"].as_f64().unwrap();
    assert!((900.0..908.0).contains(&speed) && (30.0..30.1).contains(&angle), "{speed} {angle}");
    assert_eq!(after["pack"], serde_json::json!({"width_mm": 1.27, "height_mm": 1.27}));
    assert_eq!(after["projectile"]["shape"], "cylinder");
    assert_eq!(after["fabric"]["crossover"], serde_json::json!({}));
}
