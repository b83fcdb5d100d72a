//! The layup of a pack: plies that differ, in groups from the struck side.

use super::*;

fn layup(groups: Value) -> Vec<Layer> {
    read(&laid(groups)).unwrap().pack.layup
}

fn shown(case: &Case, pointer: &str) -> (String, Origin, String, bool) {
    let field = field(case, pointer);
    (field.value.clone(), field.origin, field.source.clone(), field.assumed)
}

fn file(name: &str) -> Value {
    json!({"fabric": {"file": format!("fabrics/{name}.json")}})
}

#[test]
fn a_group_takes_what_it_does_not_say_from_the_pack_and_the_case() {
    let mut document = laid(json!([{}, {"plies": 3, "edges": {"left": "free"}, "initial_velocity_m_s": [1, 2, 3]}]));
    put(&mut document, "/pack/edges", json!("roller"));
    put(&mut document, "/pack/initial_velocity_m_s", json!([0, 0, 7]));
    put(&mut document, "/sources", json!({"/pack/edges": "assumed: not said"}));
    let case = read(&document).unwrap();
    let [first, second] = &case.pack.layup[..] else { panic!("two groups") };
    assert_eq!((case.pack.plies, first.plies, second.plies), (4, 1, 3));
    assert_eq!((&first.fabric, &first.edges), (&case.fabric, &case.pack.edges));
    assert_eq!((first.initial_velocity, second.initial_velocity), ([0.0, 0.0, 7.0], [1.0, 2.0, 3.0]));
    assert_eq!((first.orientation, first.columns, first.rows), (0.0, 10, 4));
    assert_eq!((second.edges.left, second.edges.right), (Edge::Free, Edge::Clamped));
    let derived = |value: &str, source: &str, assumed| (value.to_owned(), Origin::Derived, source.to_owned(), assumed);
    assert_eq!(shown(&case, "/pack/plies"), derived("4", "the sum over the layup", false));
    assert_eq!(shown(&case, "/pack/layup/0/fabric"), derived("S-720", "the case's fabric", false));
    assert_eq!(shown(&case, "/pack/layup/0/edges"), derived("roller", "the pack's edges", true));
    let velocity = shown(&case, "/pack/layup/0/initial_velocity_m_s");
    assert_eq!(velocity, derived("[0, 0, 7]", "the pack's initial_velocity_m_s", false));
    assert_eq!(field(&case, "/pack/layup/0/plies").origin, Origin::Default);
    assert_eq!(field(&case, "/pack/layup/1/plies").origin, Origin::Read);
    assert_eq!(field(&case, "/pack/layup/1/edges/right").origin, Origin::Default);
}

#[test]
fn a_quarter_turn_exchanges_the_sizes_and_any_other_angle_does_not() {
    for (degrees, mesh) in [
        (0.0_f64, (10, 4)),
        (180.0, (10, 4)),
        (-360.0, (10, 4)),
        // 8 mm along the warp are 3 elements of 3 mm, 30 mm along the weft 15 of 2 mm.
        (90.0, (3, 15)),
        (-90.0, (3, 15)),
        (270.0, (3, 15)),
        (45.0, (10, 4)),
        (89.9, (10, 4)),
    ] {
        let layer = &layup(json!([{"orientation_deg": degrees}]))[0];
        assert_eq!((layer.columns, layer.rows), mesh, "{degrees}");
        close(layer.orientation, degrees.to_radians(), 1e-15);
        close(layer.element_length_x, 3e-3, 1e-12);
        close(layer.element_length_y, 2e-3, 1e-12);
    }
}

#[test]
fn a_mesh_is_refined_below_the_crossover() {
    let mut document = laid(json!([{}]));
    put(&mut document, "/pack/elements_per_crossover", json!(4));
    let case = read(&document).unwrap();
    let fine = &case.pack.layup[0];
    // 3 × 2 mm a crossover, 30 × 8 mm a ply.
    assert_eq!((fine.columns, fine.rows), (40, 16));
    close(fine.element_length_x, 0.75e-3, 1e-12);
    put(&mut document, "/pack/crossovers_per_element", json!(2));
    assert_eq!(read(&document).unwrap().pack.layup[0].columns, 20);
}

#[test]
fn the_mesh_of_a_group_follows_from_its_own_fabric() {
    let mut document = laid(json!([{}, {"fabric": coarse(), "plies": 2, "orientation_deg": 90}]));
    put(&mut document, "/pack/crossovers_per_element", json!(2));
    let case = read(&document).unwrap();
    let [first, second] = &case.pack.layup[..] else { panic!("two groups") };
    assert_eq!((first.columns, first.rows), (5, 2));
    // 8 mm over 12 mm, and 30 mm over 4 mm.
    assert_eq!((second.columns, second.rows), (1, 8));
    close(second.element_length_x, 12e-3, 1e-12);
    assert_eq!(field(&case, "/pack/layup/1/columns").value, "1");
    assert_eq!(field(&case, "/pack/layup/1/rows").value, "8");
    let report = case::report(&case);
    let lines: Vec<&str> = report.lines().skip(1).take(2).collect();
    let expected = [
        "1 ply of S-720 at 0°, 5 × 2 elements of 6.0000 × 4.0000 mm: 30.00 × 8.00 mm",
        "2 plies of coarse at 90°, 1 × 8 elements of 12.0000 × 4.0000 mm: 12.00 × 32.00 mm",
    ];
    assert_eq!(lines, expected);
    let pointers: Vec<&str> = case.fields.iter().map(|field| field.pointer.as_str()).collect();
    let place = |pointer: &str| pointers.iter().position(|found| *found == pointer).unwrap();
    let order = ["/pack/width_mm", "/pack/layup/0/columns", "/pack/layup/1/plies", "/pack/layup/1/fabric/name"];
    assert!(order.windows(2).all(|pair| place(pair[0]) < place(pair[1])), "{pointers:?}");
    assert!(place("/pack/layup/1/fabric/shear/g1_mpa") < place("/pack/layup/1/orientation_deg"), "{pointers:?}");
}

#[test]
fn each_interface_has_the_mean_of_its_two_thicknesses() {
    let mut thick = coarse();
    thick["thickness_mm"] = json!(0.45);
    thick["shear"] = json!("none");
    let spacing = |groups: Value| {
        let case = read(&laid(groups)).unwrap();
        assert_eq!(case.pack.spacing, None);
        shown(&case, "/pack/spacing_mm")
    };
    let how = "the mean of the thickness_mm of the two plies".to_owned();
    let derived = |value: &str, assumed| (value.to_owned(), Origin::Derived, how.clone(), assumed);
    assert_eq!(spacing(json!([{}, {"fabric": thick}])), derived("0.35", false));
    assert_eq!(spacing(json!([{"plies": 2}, {"fabric": thick, "plies": 2}])), derived("0.25 to 0.45", false));
    assert_eq!(spacing(json!([{"fabric": thick}])), derived("0.45", false));
    // The default thickness, 0.30 mm, is assumed.
    thick.as_object_mut().unwrap().shift_remove("thickness_mm");
    assert_eq!(spacing(json!([{}, {"fabric": thick}])), derived("0.275", true));
    let mut document = laid(json!([{}, {"fabric": thick}]));
    put(&mut document, "/pack/spacing_mm", json!(0.5));
    close(read(&document).unwrap().pack.spacing.unwrap(), 0.5e-3, 1e-15);
}

#[test]
fn a_fabric_file_brings_its_sources_to_its_group() {
    let mut document = laid(json!([{}, file("s-728")]));
    put(&mut document, "/sources", json!({"/pack": "a frame", "/pack/layup/1/fabric/crossover": "our tests"}));
    let case = read(&document).unwrap();
    assert_eq!(case.pack.layup[1].fabric.name, "S-728");
    assert_eq!(field(&case, "/pack/layup/1/fabric/name").source, "Shahkarami & Vaziri 2006, Table I");
    assert_eq!(field(&case, "/pack/layup/1/fabric/crossover/gap_mm").source, "our tests");
    assert!(field(&case, "/pack/layup/1/fabric/shear/g1_mpa").assumed);
    assert!(case.as_run.pointer("/pack/layup/1/fabric/warp/crimp").is_some(), "{}", case.as_run);
    let again = case::from_str("again.json", &case.as_run.to_string(), &[]).unwrap();
    assert_eq!((again.fields, again.pack), (case.fields, case.pack));
}

#[test]
fn an_error_in_a_fabric_file_is_one_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("fabrics")).unwrap();
    let mut fabric = coarse();
    fabric["warp"]["crimp"] = json!(7);
    fs::write(folder.path().join("fabrics/bad.json"), fabric.to_string()).unwrap();
    let path = folder.path().join("case.json");
    fs::write(&path, laid(json!([{}, file("bad")])).to_string()).unwrap();
    let error = refused(case::read(&path, &[]), "/warp/crimp", "[0, 0.5]");
    assert!(error.file.ends_with("fabrics/bad.json"), "{error}");
    // A change beside the fault leaves the file to blame no longer alone; one of another group does.
    let change = |change: &str| case::read(&path, &[change.to_owned()]);
    refused(change("/pack/layup/0/plies=2"), "/warp/crimp", "bad.json");
    refused(change("/pack/layup/1/fabric/weft/crimp=0"), "/pack/layup/1/fabric/warp/crimp", "case.json");
    assert!(change("/pack/layup/1/fabric/warp/crimp=0.1").is_ok());
    fs::write(&path, laid(json!([file("../bad")])).to_string()).unwrap();
    refused(case::read(&path, &[]), "/pack/layup/0/fabric/file", "leaves the folder");
}

#[test]
fn changes_reach_into_a_group() {
    let text = laid(json!([{}, file("s-720")])).to_string();
    let change = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        case::from_str("case.json", &text, &changes)
    };
    let case = change(&["/pack/layup/0/orientation_deg=45", "/pack/layup/1/fabric/shear/g1_mpa=20"]).unwrap();
    assert_eq!(shown(&case, "/pack/layup/0/orientation_deg").2, "--set");
    assert_eq!(case.pack.layup[1].fabric.shear.as_ref().unwrap().g1, 20e6);
    assert_eq!(shown(&case, "/pack/layup/1/fabric/shear/g1_mpa").2, "assumed, --set");
    for choice in
        ["/pack/layup/0/fabric={\"file\": \"fabrics/s-728.json\"}", "/pack/layup/0/fabric/file=fabrics/s-728.json"]
    {
        let case = change(&["/pack/layup/0/fabric/warp/crimp=0.03", choice]).unwrap();
        assert_eq!(case.pack.layup[0].fabric.name, "S-728");
        assert_eq!(case.pack.layup[0].fabric.warp.crimp, 0.03);
        assert_eq!(field(&case, "/pack/layup/0/fabric/name").source, "Shahkarami & Vaziri 2006, Table I");
    }
    let whole = "/pack/layup=[{\"plies\": 5}, {\"fabric\": {\"file\": \"fabrics/s-728.json\"}}]";
    let case = change(&[whole]).unwrap();
    assert_eq!((case.pack.plies, case.pack.layup[1].fabric.name.as_str()), (6, "S-728"));
    assert_eq!(field(&case, "/pack/layup/0/plies").source, "--set");
    refused(change(&["/pack/layup/2/plies=1"]), "--set /pack/layup/2", "from 0 to 1");
    refused(change(&["/pack/layup/0/plies=65"]), "--set /pack/layup/0/plies", "[1, 64]");
    refused(change(&["/pack/layup/0/fabric=[1]"]), "--set /pack/layup/0/fabric", "one fabric in each item");
    let absent =
        case::from_str("case.json", &without("/pack/layup").to_string(), &["/pack/layup/0/plies=1".to_owned()]);
    refused(absent, "--set /pack/layup", "as a whole");
}

/// A change inside the fabric of a group that has none of its own makes it one: the case's with that change.
#[test]
fn a_change_inside_the_common_fabric_is_of_one_group_only() {
    let mut document = laid(json!([{}, {}]));
    put(&mut document, "/sources", json!({"/fabric/shear": "assumed: guessed", "/pack": "a frame"}));
    let change = "/pack/layup/1/fabric/shear/g2_mpa=70".to_owned();
    let case = case::from_str("case.json", &document.to_string(), &[change]).unwrap();
    let g2 = |fabric: &Fabric| fabric.shear.as_ref().unwrap().g2;
    assert_eq!([g2(&case.fabric), g2(&case.pack.layup[0].fabric), g2(&case.pack.layup[1].fabric)], [1e9, 1e9, 70e6]);
    assert_eq!(field(&case, "/pack/layup/1/fabric/shear/g1_mpa").source, "assumed: guessed");
    assert_eq!(field(&case, "/pack/layup/1/fabric/shear/g2_mpa").source, "assumed, --set");
    assert_eq!(field(&case, "/pack/layup/1/fabric/warp/crimp").source, "case file");
}

#[test]
fn a_layup_that_cannot_be_is_refused_at_its_place() {
    let table = [
        (json!([]), "/pack/layup", "1 to 64 objects"),
        (json!(vec![json!({}); 65]), "/pack/layup", "1 to 64 objects"),
        (json!({}), "/pack/layup", "1 to 64 objects"),
        (json!([{}, 3]), "/pack/layup/1", "an object with \"plies\""),
        (json!([{"plies": 40}, {"plies": 25}]), "/pack/layup", "65 plies"),
        (json!([{"plies": 0}]), "/pack/layup/0/plies", "[1, 64]"),
        (json!([{}, {"orientation": 45}]), "/pack/layup/1/orientation", "did you mean \"orientation_deg\""),
        (json!([{"orientation_deg": 361}]), "/pack/layup/0/orientation_deg", "[-360, 360] deg"),
        (json!([{"edges": {"left": "open"}}]), "/pack/layup/0/edges/left", "\"clamped\""),
        (json!([{"fabric": {"name": "f"}}]), "/pack/layup/0/fabric/fibre_density_kg_m3", "required"),
        (json!([{"fabric": {"file": "fabrics/none.json"}}]), "/pack/layup/0/fabric/file", "built in"),
        (json!([{"fabric": {"file": 3}}]), "/pack/layup/0/fabric/file", "name of a file"),
        (json!([{"fabric": null}]), "/pack/layup/0/fabric", "null"),
        (json!([{"initial_velocity_m_s": [1]}]), "/pack/layup/0/initial_velocity_m_s", "3 numbers"),
    ];
    for (groups, location, words) in table {
        refused(read(&laid(groups)), location, words);
    }
    let mut document = laid(json!([{"plies": 2}, {}]));
    put(&mut document, "/pack/plies", json!(3));
    assert_eq!(read(&document).unwrap().pack.plies, 3);
    put(&mut document, "/pack/plies", json!(2));
    let error = refused(read(&document), "/pack/plies", "3, the sum of the plies of /pack/layup");
    assert!(error.help.unwrap().contains("leave"));
}

#[test]
fn absurd_layups_are_refused_before_anything_is_allocated() {
    let mut fine = coarse();
    for yarn in ["warp", "weft"] {
        fine[yarn]["count_per_cm"] = json!(400);
    }
    let refuse = |groups: Value, size: [f64; 2], location: &str, words: &str| {
        let mut document = laid(groups);
        put(&mut document, "/pack/width_mm", json!(size[0]));
        put(&mut document, "/pack/height_mm", json!(size[1]));
        refused(read(&document), location, words);
    };
    refuse(json!([{}, {"fabric": fine}]), [1e4, 1e4], "/pack/layup/1", "in a ply");
    refuse(json!([{}, {"fabric": fine, "plies": 63}]), [1e3, 1e3], "/pack", "over all plies");
    // 32 plies of 6.4e7 elements: 0.8 TB of state, and 0.7 TB of contact between the plies.
    refuse(json!([{}, {"fabric": fine, "plies": 32}]), [200.0, 200.0], "/pack", "needed");
    // The group of the finest mesh sets the step: 80 times the counts, some 700 times the steps.
    let mut document = laid(json!([{}, {"fabric": fine}]));
    put(&mut document, "/solver/end_time_us", json!(2e7));
    put(&mut document, "/output/history_interval_us", json!(2e6));
    refused(read(&document), "/solver/end_time_us", "steps");
    put(&mut document, "/pack/layup", json!([{}]));
    assert!(read(&document).is_ok());
}
