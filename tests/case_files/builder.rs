//! Cases written in Rust are those of a file with the same keys.

use super::*;
use ripstop::BuiltInFabric;

/// A ball on a small ply.
const TEXT: &str = r#"{
  "title": "a small ply",
  "fabric": { "file": "fabrics/s-728.json" },
  "pack": { "width_mm": 40, "height_mm": 30.5, "plies": 2, "edges": "free" },
  "projectile": { "shape": "sphere", "diameter_mm": 6, "density_kg_m3": 7850, "velocity_m_s": 120, "offset_mm": [1, 2] },
  "solver": { "end_time_us": 60 },
  "output": { "history_interval_us": 0.25 },
  "sources": { "/pack": "a frame", "/projectile": "assumed", "": "set by a program" }
}"#;

fn built() -> ripstop::CaseBuilder {
    Case::builder("a small ply")
        .fabric(BuiltInFabric::S728)
        .size_mm(40.0, 30.5)
        .plies(2)
        .edges(Edge::Free)
        .sphere_mm(6.0)
        .density_kg_m3(7850.0)
        .velocity_m_s(120.0)
        .set("/projectile/offset_mm", json!([1, 2]))
        .end_time_us(60.0)
        .history_interval_us(0.25)
        .source("/pack", "a frame")
        .source("/projectile", "assumed")
}

#[test]
fn a_case_that_is_built_is_that_of_the_same_text() {
    let read = case::from_str("case", TEXT, &[]).unwrap();
    let case = built().build().unwrap();
    assert_eq!(case.fields, read.fields, "values and sources");
    assert!(format!("{case:?}") == format!("{read:?}"), "what is not in the fields differs");
    let end = case.fields.iter().find(|field| field.pointer == "/solver/end_time_us").unwrap();
    assert_eq!(end.source, "set by a program");
}

#[test]
fn every_fabric_that_is_built_in_can_be_chosen() {
    for fabric in BuiltInFabric::ALL {
        let case = built().fabric(fabric).build().unwrap();
        assert_eq!(json!(case.fabric.name), serde_json::from_str::<Value>(fabric.text()).unwrap()["name"]);
    }
}

#[test]
fn what_is_wrong_is_said_as_of_a_file_without_the_option_of_the_command_line() {
    let error = |builder: ripstop::CaseBuilder| builder.name("mine").build().unwrap_err().to_string();
    let missing = error(Case::builder("nothing"));
    assert!(missing.contains("mine: /fabric\n") && missing.contains("mine: /pack\n"), "{missing}");
    for velocity in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = error(built().velocity_m_s(velocity));
        assert!(refused.starts_with("error: mine: /projectile/velocity_m_s\n  expected: a number"), "{refused}");
    }
    for (pointer, help) in [("projectile", "JSON pointer"), ("/pack/rim/left", "did you mean")] {
        let refused = error(built().set(pointer, 1));
        assert!(refused.contains(help) && !refused.contains("--set"), "{refused}");
    }
}

#[test]
fn a_key_of_a_case_is_changed_with_the_checks_of_a_new_one() {
    let case = built().build().unwrap();
    let faster = case.with("/projectile/velocity_m_s", 150).unwrap();
    let expected = built().velocity_m_s(150.0).source("/projectile/velocity_m_s", "assumed, set by a program");
    let expected = expected.build().unwrap();
    assert_eq!(faster.fields, expected.fields);
    assert_eq!(case::case_hash(&faster.as_run), case::case_hash(&expected.as_run));
    let other = case.with("/fabric/file", "fabrics/s-720.json").unwrap();
    assert_eq!(other.fabric.name, "S-720");
    let refused = case.with("/projectile/velocity_m_s", "fast").unwrap_err();
    assert_eq!((refused.location.as_str(), &*refused.file), ("/projectile/velocity_m_s", "case"));
}

#[test]
fn a_fabric_of_a_file_is_looked_up_in_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mine.json"), BuiltInFabric::S720.text()).unwrap();
    let case = built().fabric_file(folder.path(), "mine.json").build().unwrap();
    assert_eq!(case.fabric.name, "S-720");
    assert!(built().fabric_file(folder.path(), "../mine.json").build().is_err());
}
