//! Changes of a case: `--set`, fabrics from files of their own, and cases written in Rust.

use super::*;

#[test]
fn changes_are_named_in_title_and_name() {
    let named = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let mut case = case::from_str("plain.json", &plain().to_string(), &sets).unwrap();
        case.name_changes(&sets);
        assert_eq!(case.as_run["title"], case.title.as_str());
        // A case at hand is changed to the same.
        let changed = case::from_str("plain.json", &plain().to_string(), &[]).unwrap().with_sets(&sets).unwrap();
        assert_eq!((&changed.as_run, &changed.name, &changed.title), (&case.as_run, &case.name, &case.title));
        (case.name, case.title)
    };
    let pair = |name: &str, title: &str| (name.to_owned(), title.to_owned());
    assert_eq!(named(&[]), pair("plain", "plain"));
    let fast = "/projectile/velocity_m_s=200";
    assert_eq!(named(&[fast]), pair("plain+velocity_m_s=200", "plain [velocity_m_s = 200]"));
    // The last of two counts; what does not change the shot has no name.
    assert_eq!(named(&["/projectile/velocity_m_s=9", fast, "/output/frames=3", "/expect=[]"]), named(&[fast]));
    // Other keys end alike: the object is named too.
    assert_eq!(named(&["/pack/friction=0.1"]).0, "plain+pack.friction=0.1");
    assert_eq!(named(&["/title=mine", fast]), pair("plain+velocity_m_s=200", "mine"));
    let free = |side: &str| named(&[&format!("/pack/edges={{\"{side}\": \"free\"}}")]).0;
    assert!(free("left") != free("right") && free("left").starts_with("plain+edges="), "{}", free("left"));
    let many: Vec<String> = (1..8).map(|i| format!("/projectile/offset_mm=[{i}.123456789, 0]")).collect();
    assert!(many.iter().map(|set| named(&[set]).0).all(|name| name.len() < 120 && !name.contains(['/', ' ', '['])));
}

#[test]
fn a_title_has_the_velocity_of_its_shot() {
    let ball = "a ball at 91 m/s, cold";
    let case = read(&with("/title", json!(ball))).unwrap();
    let titled = |set: &str| case.with_sets(&[set.to_owned()]).unwrap().title;
    assert_eq!(titled("/projectile/velocity_m_s=200.5"), "a ball at 200.5 m/s, cold [velocity_m_s = 200.5]");
    assert!(titled("/pack/friction=0.1").starts_with("a ball at 91 m/s, cold ["));
    for (title, without) in [("ball at 91 m/s", "ball"), ("look at that m/s", "look at that m/s"), ("ball", "ball")] {
        assert_eq!(case::with_velocity(title, None), without);
    }
    assert_eq!(case::with_velocity(ball, Some(90.0)), "a ball at 90 m/s, cold");
}

#[test]
fn a_fabric_of_a_file_brings_its_sources_and_its_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.json");
    let mut fabric = laid()["fabric"].clone();
    fabric["sources"] = json!({"/weft": "assumed: guessed", "/shear/g1_mpa": "paper"});
    fs::write(folder.path().join("f.json"), fabric.to_string()).unwrap();
    let mut document = laid();
    put(&mut document, "/pack/layup/1/fabric", json!({"file": "f.json"}));
    put(&mut document, "/sources", json!({"/pack": "a frame", "/pack/layup/1/fabric/crossover": "our tests"}));
    fs::write(&path, document.to_string()).unwrap();
    let case = case::read(&path, &[]).unwrap();
    for (key, source) in [
        ("weft/crimp", "assumed: guessed"),
        ("shear/g1_mpa", "paper"),
        ("shear/g2_mpa", "f.json"),
        ("crossover/gap_mm", "our tests"),
    ] {
        assert_eq!(field(&case, &format!("/pack/layup/1/fabric/{key}")).source, source);
    }
    assert!(case.as_run.pointer("/pack/layup/1/fabric/sources").is_none());
    let again = case::from_str("again.json", &case.as_run.to_string(), &[]).unwrap();
    assert_eq!((again.fields, again.pack), (case.fields, case.pack));
    // A change beside a fault leaves the file to blame no longer alone; one of another group does.
    fabric["warp"]["crimp"] = json!(7);
    fs::write(folder.path().join("f.json"), fabric.to_string()).unwrap();
    let change = |change: &str| case::read(&path, &[change.to_owned()]);
    refused(change("/pack/layup/0/plies=2"), "/warp/crimp", "f.json");
    refused(change("/pack/layup/1/fabric/weft/crimp=0"), "/pack/layup/1/fabric/warp/crimp", "case.json");
    assert!(change("/pack/layup/1/fabric/warp/crimp=0.1").is_ok());
}

#[cfg(unix)]
#[test]
fn a_link_does_not_leave_the_folder() {
    let outside = tempfile::tempdir().unwrap();
    fs::write(outside.path().join("f.json"), good()["fabric"].to_string()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.json");
    fs::write(&path, with("/fabric", json!({"file": "f.json"})).to_string()).unwrap();
    std::os::unix::fs::symlink(outside.path().join("f.json"), folder.path().join("f.json")).unwrap();
    refused(case::read(&path, &[]), "/fabric/file", "link");
}

/// A ball on a small ply.
const TEXT: &str = r#"{
  "title": "a small ply",
  "fabric": { "file": "fabrics/s-728.json" },
  "pack": { "width_mm": 40.0, "height_mm": 30.5, "plies": 2, "edges": "free" },
  "projectile": { "shape": "sphere", "diameter_mm": 6.0, "density_kg_m3": 7850.0, "velocity_m_s": 120.0, "offset_mm": [1, 2] },
  "solver": { "end_time_us": 60.0 },
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
        .set("/output/history_interval_us", 0.25)
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
fn what_is_wrong_is_said_as_of_a_file_without_the_option_of_the_command_line() {
    let error = |builder: ripstop::CaseBuilder| builder.name("mine").build().unwrap_err().to_string();
    assert!(error(Case::builder("nothing")).contains("mine: /fabric\n"));
    for velocity in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = error(built().velocity_m_s(velocity));
        assert!(refused.starts_with("error: mine: /projectile/velocity_m_s\n  expected: a number"), "{refused}");
    }
    for (pointer, help) in [("projectile", "JSON pointer"), ("/pack/edge/left", "did you mean")] {
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
