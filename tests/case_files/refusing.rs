//! What is refused, where the error points and what it says.

use super::*;

#[test]
fn damaged_text_is_one_error_with_line_and_column() {
    let text = serde_json::to_string_pretty(&good()).unwrap();
    let damaged = [
        String::new(),
        " \n\t".to_owned(),
        "[".repeat(10_000),
        "{\"a\":".repeat(10_000),
        format!("\u{feff}{text}"),
        format!("{text} trailing"),
        format!("{text}{text}"),
        text.replacen("155", "NaN", 1),
        text.replacen("155", "-Infinity", 1),
        text.replacen("155", "1e999", 1),
        text.replacen("155", "0x9b", 1),
        text.replacen("155", "'155'", 1),
        text.replacen("\"mass_g\"", "\"friction\"", 1),
        text.replacen('{', "{ // comment\n", 1),
        "[]".to_owned(),
        "7".to_owned(),
        "null".to_owned(),
    ];
    let truncated = (0..text.len()).step_by(37).filter(|end| text.is_char_boundary(*end));
    for damaged in damaged.into_iter().chain(truncated.map(|end| text[..end].to_owned())) {
        let error = case::from_str("damaged.json", &damaged, &[]).unwrap_err();
        assert_well_formed(&error);
        assert!(error.location.starts_with("line "), "{error}");
    }
}

#[test]
fn a_key_given_twice_is_named() {
    let text = good().to_string().replacen("\"mass_g\":3", "\"mass_g\":3,\"mass_g\":4", 1);
    let error = case::from_str("twice.json", &text, &[]).unwrap_err();
    assert!(error.found.contains("\"mass_g\""), "{error}");
}

#[test]
fn files_that_are_no_case_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.json");
    let read = || case::read(&path, &[]);
    refused(read(), "", "can be read");
    fs::write(&path, b"{\n \"title\": \"\xff\"}").unwrap();
    refused(read(), "line 2, column 12", "0xFF");
    fs::write(&path, b"\xff\xfe{\0}\0").unwrap();
    refused(read(), "line 1, column 1", "UTF-8");
    fs::File::create(&path).unwrap().set_len((1 << 20) + 1).unwrap();
    refused(read(), "", "1 MiB");
    let error = refused(case::read(folder.path(), &[]), "", "a folder");
    let first = format!("error: {}\n", folder.path().display());
    assert!(error.to_string().starts_with(&first), "{error}");
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
fn all_that_is_wrong_is_said_at_once() {
    let mut document = with("/projectile/velocity_m_s", json!("155"));
    put(&mut document, "/pack/widht_mm", json!(1));
    put(&mut document, "/solver/courant", json!(2));
    remove(&mut document, "/fabric/warp/crimp");
    let error = read(&document).unwrap_err();
    let mut places: Vec<&str> = error.all().map(|error| error.location.as_str()).collect();
    places.sort();
    assert_eq!(places, ["/fabric/warp/crimp", "/pack/widht_mm", "/projectile/velocity_m_s", "/solver/courant"]);
    let text = error.to_string();
    assert_eq!(text.matches("error: ").count(), 4, "{text}");
    assert_well_formed(&error);
    // Who wrote a key wrong need not hear that it is missing.
    let mut document = good();
    remove(&mut document, "/projectile/velocity_m_s");
    put(&mut document, "/projectile/velocity", json!(155));
    let error = read(&document).unwrap_err();
    assert!(error.location == "/projectile/velocity" && error.next.is_none(), "{error}");
    let many: Map<String, Value> = (0..100).map(|i| (format!("key {i}"), json!(1))).collect();
    let text = read(&Value::Object(many)).unwrap_err().to_string();
    assert!(text.matches("error: ").count() == 12 && text.ends_with("more"), "{text}");
}

#[test]
fn what_is_required_is_said_to_be_missing() {
    for pointer in [
        "/title",
        "/fabric",
        "/fabric/name",
        "/fabric/warp",
        "/fabric/weft/crimp",
        "/pack",
        "/pack/width_mm",
        "/pack/initial_deflection/amplitude_mm",
        "/projectile/shape",
        "/projectile/length_mm",
        "/projectile/mass_g",
        "/projectile/velocity_m_s",
        "/expect/0/quantity",
        "/expect/0/source",
    ] {
        refused(read(&without(pointer)), pointer, "found: nothing");
    }
    refused(read(&without("/fabric/warp/linear_density_denier")), "/fabric/warp", "linear_density_tex");
    refused(read(&without("/fabric/weft/count_per_inch")), "/fabric/weft", "count_per_cm");
    refused(read(&without("/expect/0/value")), "/expect/0", "none of them");
    refused(read(&without("/expect/1/tolerance")), "/expect/1/tolerance", "tolerance");
}

#[test]
fn values_out_of_range_or_at_odds_with_others_are_refused() {
    let table = [
        ("/projectile/velocity_m_s", json!(0), "(0, 5000] m/s"),
        ("/projectile/velocity_m_s", json!(5001), "5000"),
        ("/projectile/velocity_m_s", json!("155"), "without quotes"),
        ("/projectile/obliquity_deg", json!(86), "85"),
        ("/projectile/offset_mm", json!([1]), "2 numbers"),
        ("/projectile/offset_mm/1", json!("x"), "\"x\""),
        ("/projectile/edge_radius_mm", json!(2.8), "2.75 mm"),
        ("/projectile/nose_length_mm", json!(5), "belongs where \"shape\" is \"cone\" or \"ogive\""),
        ("/projectile/roll_deg", json!(5), "belongs where \"shape\" is \"fragment\""),
        ("/projectile/shape", json!("spere"), "\"sphere\""),
        ("/solver/courant", json!(1.01), "unstable"),
        ("/solver/end_time_us", json!(1e9), "steps"),
        ("/solver/hourglass", json!(-0.1), "[0, 1]"),
        ("/pack/plies", json!(65), "[1, 64]"),
        ("/pack/plies", json!(2), "3, the sum"),
        ("/pack/plies", json!(1.5), "whole"),
        ("/pack/width_mm", json!(1e9), "100000"),
        ("/pack/crossovers_per_element", json!(0), "[1, 64]"),
        ("/pack/elements_per_crossover", json!(17), "[1, 16]"),
        ("/solver/contact_sampling", json!("edgse"), "\"edges\""),
        ("/fabric/shear/gamma1", json!(0.7), "gamma2"),
        ("/fabric/shear/g1_mpa", json!(1001), "g2_mpa"),
        ("/fabric/shear/thickness_mm", json!(0.26), "one thickness"),
        ("/fabric/crossover/gap_mm", json!(1.1), "[0, 1] mm"),
        ("/fabric/crossover/compression", json!({"a_mm": 0}), "rigid"),
        ("/fabric/crossover/compression", json!({"b_mm_n13": 0}), "rigid"),
        ("/fabric/crossover/compression", json!({"b_mm_n13": 1e-9}), "at least 1e-6 of a_mm"),
        ("/fabric/crossover/compression", json!("ridig"), "\"rigid\""),
        ("/fabric/warp/failure_strain", json!(0), "(0, 1]"),
        ("/fabric/warp/crimp", json!(0.51), "[0, 0.5]"),
        ("/fabric/warp/linear_density_tex", json!(158), "2 of them"),
        ("/expect/0/tolerance", json!(1), "word"),
        ("/expect/1/tolerance", json!("1 percent"), "for example \"1%\""),
        ("/expect/2/value", json!(1), "both"),
        ("/expect/2/min", json!(1), "at most max"),
        ("/expect/3/between_us", json!([20, 10]), "earlier"),
    ];
    for (pointer, value, words) in table {
        refused(read(&with(pointer, value)), pointer, words);
    }
    refused(read(&with("/output/profile_times_us", json!([0, 2, 1]))), "/output/profile_times_us/2", "ascending");
    refused(read(&without("/projectile/axial_inertia_g_mm2")), "/projectile/transverse_inertia_g_mm2", "together");
    refused(read(&with("/fabric", json!([{}]))), "/fabric", "/pack/layup");
}

#[test]
fn absurd_sizes_are_refused_before_anything_is_allocated() {
    let mut document = with("/pack/plies", json!(1));
    remove(&mut document, "/pack/layup");
    put(&mut document, "/pack/width_mm", json!(1e5));
    put(&mut document, "/pack/height_mm", json!(1e5));
    refused(read(&document), "/pack", "elements");
    // 1.9e9 elements are 750 GB; 8e13 rows of history are 16 PB.
    put(&mut document, "/pack/height_mm", json!(3e4));
    refused(read(&document), "/pack", "needed");
    let mut document = with("/output/history_interval_us", json!(1e-6));
    put(&mut document, "/solver/end_time_us", json!(1e8));
    refused(read(&document), "/pack", "needed");
}

#[test]
fn a_cone_has_room_for_its_edges() {
    let cone = |radius: f64| {
        let cone = json!({"shape": "cone", "diameter_mm": 6, "length_mm": 4, "mass_g": 1, "velocity_m_s": 1,
            "edge_radius_mm": radius});
        read(&with("/projectile", cone))
    };
    // A cone of radius 3 and height 4 holds a ball of radius 3·4/(3 + 5).
    assert!(cone(1.499).is_ok());
    refused(cone(1.501), "/projectile/edge_radius_mm", "1.5 mm");
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
