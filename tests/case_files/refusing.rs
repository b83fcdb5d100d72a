//! Refusals: where an error points, what it expected, what it found, and its help.
//!
//! Promise: the texts below, in full, are those of `snapshots/`. Red when one of them changes. Cannot see: a refusal that has no line here.

use super::*;
use std::fmt::Write as _;

/// One refusal a line: a case, then what is changed in it: `-/pointer` leaves a key out, `--set` is a change from the command line, all
/// else is put into the file.
const REFUSED: &str = r#"
good & /projectile/velocity_m_s=0
good & /projectile/velocity_m_s=5001
good & /projectile/velocity_m_s="155"
good & /projectile/velocity_m_s=null
good & /projectile/velocity_m_s={"zzz": 1}
good & /projectile/velocity_m_s=[1, 2]
good & /projectile/velocity_m_s=true
good & /projectile/obliquity_deg=86
good & /projectile/offset_mm=[1]
good & /projectile/offset_mm=[1, "x"]
good & /projectile/offset_mm=[1, 1e6]
good & /projectile/edge_radius_mm=2.8
good & /projectile/nose_length_mm=5
good & /projectile/roll_deg=5
good & /projectile/shape="spere"
good & /projectile/shape=3
good & /projectile/density_kg_m3="7850"
good & /projectile/axial_inertia_g_mm2=1000
good & -/projectile/axial_inertia_g_mm2
good & /projectile=7
good & /solver/courant=1.01
good & /solver/courant=0
good & /solver/end_time_us=1e9
good & /solver/hourglass=-0.1
good & /solver/contact_sampling="edgse"
good & /solver/contact_sampling="rim"
good & /solver/numerics="papr"
good & /solver/run_until="end"
good & /pack/plies=65
good & /pack/plies=2
good & /pack/plies=1.5
good & /pack/plies="3"
good & /pack/width_mm=1e9
good & /pack/crossovers_per_element=0
good & /pack/elements_per_crossover=17
good & /pack/edges="square"
good & /pack/edges={"left": "open"}
good & /pack/edges=[]
good & /pack/mesh_grading={"growth": 1.2}
good & /pack/mesh_grading={"coarsest": 6}
good & /pack/mesh_grading={"max_crossovers": 1} & /pack/crossovers_per_element=2
good & /pack/mesh_grading="fine"
plain & /projectile=null & /solver={"end_time_us": 9} & /pack/mesh_grading="graded"
good & /pack/initial_deflection=true
good & /pack/pretension={"warp": 1}
good & /fabric/shear/gamma1=0.7
good & /fabric/shear/g1_mpa=1001
good & /fabric/shear/thickness_mm=0.26
good & /fabric/shear="nune"
good & /fabric/crossover/gap_mm=1.1
good & /fabric/crossover/compression={"a_mm": 0}
good & /fabric/crossover/compression={"b_mm_n13": 0}
good & /fabric/crossover/compression={"b_mm_n13": 1e-9}
good & /fabric/crossover/compression="ridig"
good & /fabric/crossover/law="kawabata"
good & /fabric/crossover/law="publshed"
good & /fabric/crossover/membrane_force="projected"
good & /fabric/shear/modulus="secant"
good & /solver/unit_cell="safeguarded"
good & /fabric/warp/failure_strain=0
good & /fabric/warp/crimp=0.51
good & /fabric/warp/absent="yes"
good & /fabric/warp/absent=true
good & /fabric/warp={"absent": true, "count_per_cm": 8} & /fabric/weft={"absent": true, "count_per_cm": 8}
good & /fabric/warp/linear_density_tex=158
good & -/fabric/warp/linear_density_denier
good & -/fabric/weft/count_per_inch
good & /fabric=[{}]
good & /fabric=7
good & /fabric/file="fabrics/s-720.json"
good & /fabric={"file": "fabrics/s-721.json"}
good & /fabric={"file": 7}
good & /expect=7
good & /expect=[7]
good & /expect/0/tolerance=1
good & /expect/1/tolerance="1 percent"
good & /expect/1/tolerance=true
good & -/expect/1/tolerance
good & -/expect/0/value
good & /expect/0/value=[]
good & /expect/2/value=1
good & /expect/2/min=1
good & /expect/2/tolerance=1
good & /expect/3/between_us=[20, 10]
good & /expect/3/between_us=[20]
good & /expect/3/at_us=1
good & -/expect/0/source
good & -/expect/0/quantity
good & /output/profile_times_us=[0, 2, 1]
good & /output/frames=-1
good & /sources/~1fabric~1wrap="x"
good & /sources/~1pack=1
good & /sources=[]
good & /title=" "
good & /title=7
good & -/title
good & -/fabric
good & -/pack
good & -/fabric/name
good & -/fabric/warp
good & -/pack/width_mm
good & -/pack/initial_deflection/amplitude_mm
good & -/projectile/shape
good & -/projectile/length_mm
good & -/projectile/mass_g
good & -/projectile/velocity_m_s
good & /zzz=1
good & /pack/mass_g=1
good & /a~1b=1
good & /projectile/velocity=155 & -/projectile/velocity_m_s
good & /projectile/velocity_m_s="155" & /pack/widht_mm=1 & /solver/courant=2 & -/fabric/warp/crimp
good & /variability={"sede": 1, "velocity": {"scatter_m_s": 0}, "yarn_strength": {"shape": 0.5}}
good & /variability={"hit": "unit_cell"} & /projectile=null
good & /variability={"yaw": {"scatter_deg": 1}} & /projectile={"shape": "bar", "diameter_mm": 9, "mass_g": 1, "velocity_m_s": 5}
good & /variability={"shot": 1, "crimp": {"scatter": 0.5}} & /fabric/warp/crimp=0.5
plain & /solver={"run_until": "end_time"}
plain & /projectile/motion="prescribed"
plain & /projectile=null
plain & -/projectile/mass_g
plain & /projectile={"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5}
plain & /projectile={"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5, "mass_g": 1, "rotation": "free", "yaw_deg": 3}
plain & /projectile={"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5, "mass_g": 1, "rotation": "free"}
plain & /projectile={"shape": "cone", "diameter_mm": 6, "length_mm": 4, "mass_g": 1, "velocity_m_s": 1, "edge_radius_mm": 1.501}
plain & /projectile={"shape": "cone", "diameter_mm": 6, "length_mm": 4, "mass_g": 1, "velocity_m_s": 1, "nose_length_mm": 5}
plain & /projectile={"shape": "ogive", "diameter_mm": 6, "length_mm": 12, "mass_g": 1, "velocity_m_s": 1, "nose_length_mm": 2.9}
plain & /projectile={"shape": "ogive", "diameter_mm": 6, "length_mm": 12, "mass_g": 1, "velocity_m_s": 1, "nose_length_mm": 12.1}
plain & /projectile={"shape": "ogive", "diameter_mm": 6, "length_mm": 2.9, "mass_g": 1, "velocity_m_s": 1}
plain & /projectile={"shape": "ogive", "diameter_mm": 6, "length_mm": 12, "mass_g": 1, "velocity_m_s": 1, "nose_flat_mm": 2}
plain & /projectile={"shape": "fragment", "diameter_mm": 6, "length_mm": 12, "mass_g": 1, "velocity_m_s": 1, "nose_flat_mm": 6.1}
plain & /projectile={"shape": "fragment", "diameter_mm": 6, "length_mm": 6, "mass_g": 1, "velocity_m_s": 1, "nose_angle_deg": 75}
plain & /projectile={"shape": "fsp", "diameter_mm": 6, "length_mm": 6, "mass_g": 1, "velocity_m_s": 1, "nose_angle_deg": 80}
plain & /pack={"width_mm": 1e5, "height_mm": 1e5}
plain & /pack={"width_mm": 1e5, "height_mm": 3e4}
plain & /output={"history_interval_us": 1e-6} & /solver={"end_time_us": 1e8}
laid & /pack/layup=[]
laid & /pack/layup={}
laid & /pack/layup=[{}, 3]
laid & /pack/layup=[{"plies": 40}, {"plies": 25}]
laid & /pack/layup=[{"plies": 0}]
laid & /pack/layup=[{}, {"orientation": 45}]
laid & /pack/layup=[{"orientation_deg": 361}]
laid & /pack/layup=[{"edges": {"left": "open"}}]
laid & /pack/layup=[{"fabric": {"name": "f"}}]
laid & /pack/layup=[{"fabric": {"file": "fabrics/none.json"}}]
laid & /pack/layup=[{"fabric": {"file": 3}}]
laid & /pack/layup=[{"fabric": null}]
laid & /pack/layup=[{"initial_velocity_m_s": [1]}]
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /pack/width_mm=1e4 & /pack/height_mm=1e4
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /pack/layup/1/plies=62 & /pack/width_mm=1e3 & /pack/height_mm=1e3
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /pack/layup/1/plies=32 & /pack/width_mm=200 & /pack/height_mm=200
laid & /pack/layup/1/fabric/warp/count_per_cm=400 & /pack/layup/1/fabric/weft/count_per_cm=400 & /solver={"end_time_us": 2e7} & /output={"history_interval_us": 2e6}
laid & --set /pack/layup/2/plies=1
laid & --set /pack/layup/0/plies=65
laid & --set /pack/layup/0/fabric=[1]
plain & --set /pack/layup/0/plies=1
plain & --set /pack/edges/left=open
plain & /pack/edges="free" & --set /pack/edges/left=free
good & --set /projectile/mass_gg=1
good & --set /projectile/velocity_m_s=fast
good & --set /projectile/velocity_m_s=NaN
good & --set /projectile/velocity_m_s=1e999
good & --set /projectile/velocity_m_s=
good & --set /projectile={"shape":
good & --set /projectile={"shape":1,"shape":2}
good & --set /projectile/mass_g/x=1
good & --set /projectle/mass_g=1
good & --set /projectile/offset_mm/2=1
good & --set /pack/edges=square
good & --set /fabric/shear/gamma1=1
good & --set projectile=1
good & --set /projectile
good & --set /=1
good & --set =1
"#;

/// The error of one line of the table; `None` where the case is accepted.
fn of_line(line: &str) -> Option<CaseError> {
    let mut parts = line.split(" & ");
    let mut document = match parts.next() {
        Some("plain") => plain(),
        Some("laid") => laid(json!([{}, {"fabric": coarse(), "plies": 2}])),
        _ => good(),
    };
    let mut sets = Vec::new();
    for part in parts {
        match (part.strip_prefix("--set "), part.strip_prefix('-')) {
            (Some(set), _) => sets.push(set.to_owned()),
            (None, Some(pointer)) => remove(&mut document, pointer),
            (None, None) => {
                let (pointer, value) = part.split_once('=').unwrap();
                put(&mut document, pointer, serde_json::from_str(value).unwrap());
            }
        }
    }
    case::from_str("case.json", &document.to_string(), &sets).err()
}

/// A text without what differs from machine to machine.
fn anywhere(text: &str) -> String {
    let memory = "fits into the memory available, ";
    let line = |line: &str| line.split_once(memory).map_or(line.to_owned(), |(before, _)| format!("{before}{memory}…"));
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_refusal_keeps_its_words() {
    let mut texts = String::new();
    for line in REFUSED.trim().lines() {
        let error = of_line(line);
        error.iter().for_each(assert_well_formed);
        let text = error.map_or("accepted".to_owned(), |error| anywhere(&error.to_string()));
        writeln!(texts, "# {line}\n{text}\n").unwrap();
    }
    insta::assert_snapshot!("refusals", texts);
}

#[test]
fn every_damage_of_a_text_or_a_file_keeps_its_words() {
    let text = serde_json::to_string_pretty(&plain()).unwrap();
    let velocity = |new: &str| text.replacen("100", new, 1);
    let damaged = [
        String::new(),
        " \n\t".to_owned(),
        "[".repeat(10_000),
        format!("\u{feff}{text}"),
        format!("{text} trailing"),
        velocity("NaN"),
        velocity("-Infinity"),
        velocity("1e999"),
        velocity("0x9b"),
        velocity("'155'"),
        velocity("+5"),
        velocity(".5"),
        velocity("5,"),
        velocity("5 // m/s"),
        text.replacen("\"mass_g\"", "\"diameter_mm\"", 1),
        text.replacen("\"mass_g\"", "mass_g", 1),
        text[..text.len() / 2].to_owned(),
        "[]".to_owned(),
        "null".to_owned(),
    ];
    let mut texts = String::new();
    for damaged in damaged {
        let error = case::from_str("damaged.json", &damaged, &[]).unwrap_err();
        assert_well_formed(&error);
        assert!(error.location.starts_with("line "), "{error}");
        writeln!(texts, "{error}\n").unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.json");
    let here = |error: CaseError| error.to_string().replace(&folder.path().display().to_string(), "FOLDER");
    writeln!(texts, "{}\n", here(case::read(&path, &[]).unwrap_err())).unwrap();
    writeln!(texts, "{}\n", here(case::read(folder.path(), &[]).unwrap_err())).unwrap();
    for bytes in [&b"{\n \"title\": \"\xff\"}"[..], b"\xff\xfe{\0}\0", &[b' '; (1 << 20) + 1]] {
        fs::write(&path, bytes).unwrap();
        writeln!(texts, "{}\n", here(case::read(&path, &[]).unwrap_err())).unwrap();
    }
    // Fabrics in files of their own, the first with a fault inside.
    fs::write(folder.path().join("bad.json"), r#"{"name": "f", "sources": {"/wrap": "x"}}"#).unwrap();
    fs::write(folder.path().join("worse.json"), r#"{"name": }"#).unwrap();
    let mut crimped = coarse();
    crimped["warp"]["crimp"] = json!(7);
    fs::write(folder.path().join("crimped.json"), crimped.to_string()).unwrap();
    for name in ["bad.json", "worse.json", "crimped.json", "none.json", "../case.json", "/etc/passwd", "", ".", "\0"] {
        fs::write(&path, laid(json!([{}, {"fabric": {"file": name}}])).to_string()).unwrap();
        writeln!(texts, "{}\n", here(case::read(&path, &[]).unwrap_err())).unwrap();
    }
    insta::assert_snapshot!("damage", texts);
}

#[test]
fn every_field_refuses_the_wrong_type_at_its_place() {
    let document = good();
    for pointer in pointers(&document) {
        let value = document.pointer(&pointer).unwrap();
        for wrong in [json!(null), json!(true), json!("zzz"), json!([[]]), json!({"zzz": 1}), json!(-1e300)] {
            let fits = wrong.is_null() && ["/projectile", "/pack/initial_deflection"].contains(&pointer.as_str())
                || wrong.is_boolean() && value.is_boolean()
                || wrong.is_string() && free_text(&pointer);
            let result = read(&with(&pointer, wrong.clone()));
            if fits && result.is_ok() {
                continue;
            }
            let error = result.map(|_| format!("{pointer} accepts {wrong}")).unwrap_err();
            assert_well_formed(&error);
            let place = error.location.starts_with(&pointer) || fits;
            let group = pointer.ends_with("absent") || pointer.starts_with("/expect");
            assert!(place || group, "{pointer} = {wrong}: {error}");
        }
    }
}

fn free_text(pointer: &str) -> bool {
    let ends = ["/title", "/name", "/notes", "/quantity", "/source", "/value"];
    ends.iter().any(|end| pointer.ends_with(end)) || pointer.starts_with("/sources/")
}

#[test]
fn unknown_keys_at_every_level_name_the_nearest_one() {
    let document = good();
    let mut objects = pointers(&document);
    objects.retain(|pointer| document.pointer(pointer).unwrap().is_object() && pointer != "/sources");
    objects.push(String::new());
    for object in objects {
        let known: &Map<String, Value> = document.pointer(&object).unwrap().as_object().unwrap();
        let key = known.keys().next_back().unwrap();
        let wrong = format!("{object}/{key}x");
        let error = refused(read(&with(&wrong, json!(1))), &wrong, "unknown key");
        assert_eq!(error.help.unwrap(), format!("did you mean \"{key}\"? `ripstop schema` lists every key"));
        assert!(error.expected.starts_with(&format!("\"{key}\"")) && error.expected.len() < 120, "{}", error.expected);
    }
    let error = refused(read(&with("/pack/mass_g", json!(1))), "/pack/mass_g", "unknown key");
    assert_eq!(error.help.unwrap(), "\"mass_g\" belongs at /projectile/mass_g");
    refused(read(&with("/a~1b\n", json!(1))), "/a~1b\\n", "unknown key");
}

#[test]
fn a_dozen_of_many_errors_are_shown() {
    let many: Map<String, Value> = (0..100).map(|i| (format!("key {i}"), json!(1))).collect();
    let text = read(&Value::Object(many)).unwrap_err().to_string();
    assert!(text.matches("error: ").count() == 12 && text.ends_with("more"), "{text}");
}

/// The good case struck by something else.
fn struck_by(shape: &str, keys: Value) -> Result<Case, CaseError> {
    let mut projectile = json!({"shape": shape, "diameter_mm": 6, "length_mm": 12, "mass_g": 1, "velocity_m_s": 1});
    if let (Value::Object(all), Value::Object(keys)) = (&mut projectile, keys) {
        all.extend(keys);
    }
    read(&with("/projectile", projectile))
}

/// The largest edge radius that the reader accepts, and what the solver's own check says just below it [mm].
fn largest_edge(shape: &str, keys: &Value) -> f64 {
    let (mut fits, mut too_large) = (0.0, 6.0);
    let at = |edge: f64| {
        let mut keys = keys.clone();
        keys["edge_radius_mm"] = json!(edge);
        struck_by(shape, keys)
    };
    for _ in 0..60 {
        let middle = 0.5 * (fits + too_large);
        if at(middle).is_ok() { fits = middle } else { too_large = middle }
    }
    refused(at(too_large + 1e-6), "/projectile/edge_radius_mm", "room for");
    let body = |edge: f64| Body::new(at(edge).unwrap().projectile.as_ref().unwrap());
    assert!(body(fits - 1e-9).is_ok(), "{shape}, {keys}: the reader accepts an edge of {fits} mm");
    fits
}

#[test]
fn an_ogive_is_at_least_half_a_ball_and_at_most_its_length() {
    let nose_mm = |keys: Value| match struck_by("ogive", keys).unwrap().projectile.unwrap().shape {
        Shape::Ogive { nose_length, .. } => (nose_length * 1e9).round() / 1e6,
        other => panic!("{other:?}"),
    };
    let bad = |keys: Value, pointer: &str, says: &str| refused(struck_by("ogive", keys), pointer, says);
    assert_eq!(nose_mm(json!({})), 9.0);
    assert_eq!(nose_mm(json!({"length_mm": 8})), 8.0);
    assert_eq!(nose_mm(json!({"nose_length_mm": 3})), 3.0);
    bad(json!({"nose_length_mm": 2.9}), "/projectile/nose_length_mm", "half of diameter_mm, which is 3 mm");
    bad(json!({"nose_length_mm": 12.1}), "/projectile/nose_length_mm", "at most length_mm, which is 12 mm");
    bad(json!({"length_mm": 2.9}), "/projectile/length_mm", "half of diameter_mm");
    bad(json!({"nose_flat_mm": 2}), "/projectile/nose_flat_mm", "\"fragment\"");
    // A ball within the wall, and one between arc and tail.
    assert!((largest_edge("ogive", &json!({})) - 3.0).abs() < 1e-9);
    assert!((largest_edge("ogive", &json!({"length_mm": 9})) - 2.7).abs() < 1e-9);
}

#[test]
fn a_point_is_rounded_unless_it_says_otherwise() {
    let edge = |shape: &str, keys: Value| {
        let case = struck_by(shape, keys).unwrap();
        let field = case.fields.iter().find(|field| field.pointer == "/projectile/edge_radius_mm").unwrap();
        assert_eq!(field.assumed, field.source.contains("assumed"), "{field:?}");
        ((case.projectile.unwrap().edge_radius * 1e9).round() / 1e6, field.assumed)
    };
    for shape in ["cone", "ogive"] {
        assert_eq!(edge(shape, json!({})), (0.5, true));
        assert_eq!(edge(shape, json!({"diameter_mm": 3})), (0.3, true));
        assert_eq!(edge(shape, json!({"edge_radius_mm": 0})), (0.0, false));
    }
    let elements = |keys: Value| {
        let mut document = with(
            "/projectile",
            json!({"shape": "cone", "diameter_mm": 6, "length_mm": 12, "mass_g": 1, "velocity_m_s": 1}),
        );
        put(&mut document, "/solver", keys);
        read(&document).unwrap().pack.elements_per_crossover
    };
    assert_eq!(elements(json!({"end_time_us": 10})), 6);
    assert_eq!(elements(json!({"end_time_us": 10, "accuracy": "converged"})), 8);
    assert_eq!(elements(json!({"end_time_us": 10, "numerics": "paper"})), 1);
    // A flat cone has room for less: 3 · 0.2 / (3 + √(3² + 0.2²)).
    assert_eq!(edge("cone", json!({"length_mm": 0.2, "nose_length_mm": 0.2})), (0.099_889, true));
    // Half a ball has no tip.
    assert_eq!(edge("ogive", json!({"nose_length_mm": 3})), (0.0, false));
    assert_eq!(edge("cylinder", json!({})), (0.0, false));
    assert_eq!(edge("fragment", json!({})), (0.0, false));
}

#[test]
fn a_fragment_has_room_for_its_nose_and_its_edges() {
    let case = struck_by("fragment", json!({})).unwrap();
    let Shape::Fragment { nose_flat, nose_angle, roll, .. } = case.projectile.unwrap().shape else { panic!() };
    assert!((nose_flat - 2.76e-3).abs() < 1e-12 && (nose_angle.to_degrees() - 35.0).abs() < 1e-12 && roll == 0.0);
    for name in ["nose_flat_mm", "nose_angle_deg"] {
        let field = case.fields.iter().find(|field| field.pointer == format!("/projectile/{name}")).unwrap();
        assert!(field.assumed && field.source.contains("assumed"), "{field:?}");
    }
    let bad = |keys: Value, pointer: &str, says: &str| refused(struck_by("fragment", keys), pointer, says);
    bad(json!({"nose_flat_mm": 6.1}), "/projectile/nose_flat_mm", "at most diameter_mm, which is 6 mm");
    bad(json!({"nose_flat_mm": 0}), "/projectile/nose_flat_mm", "mm");
    bad(json!({"nose_angle_deg": 80}), "/projectile/nose_angle_deg", "[5, 75] deg");
    bad(json!({"nose_angle_deg": 75, "length_mm": 6}), "/projectile/nose_angle_deg", "within length_mm, which is 6 mm");
    bad(json!({"nose_length_mm": 2}), "/projectile/nose_length_mm", "\"ogive\"");
    // The wall, the strip, and the room between flats and tail.
    assert!((largest_edge("fragment", &json!({})) - 3.0).abs() < 1e-9);
    let strip = largest_edge("fragment", &json!({"nose_flat_mm": 0.5, "nose_angle_deg": 60}));
    assert!((strip - 0.25 / 30_f64.to_radians().tan()).abs() < 1e-9, "{strip}");
    assert!(largest_edge("fragment", &json!({"length_mm": 3, "nose_angle_deg": 50})) < 1.2);
}
