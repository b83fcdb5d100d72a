//! Acceptance: what a case says reaches its field, in SI units and with its source.

use super::*;

#[test]
fn every_key_reaches_its_field_in_si_units() {
    let case = read(&good()).unwrap();
    assert_eq!((&case.as_run, case.name.as_str()), (&good(), "good"));
    let Case { fabric, pack, projectile, solver, output, expect, .. } = &case;
    insta::assert_debug_snapshot!("good", (fabric, pack, projectile, solver, output, expect));
    close(fabric.warp.linear_density, 1420.0 / 9e6, 1e-15);
    close(fabric.warp.count, 20.0 / 25.4e-3, 1e-15);
    close(fabric.crossover.compression.unwrap().b, 0.12e-3, 1e-15);
    close(projectile.as_ref().unwrap().obliquity, std::f64::consts::FRAC_PI_6, 1e-15);
}

/// Derived numbers from the shipped fabrics.
#[test]
fn shipped_fabrics_have_the_published_numbers() {
    for (file, stiffness, areal_density, half_span) in
        [("s-720", 10_518.5, 0.2529, 0.635e-3), ("s-728", 11_111.1, 0.2261, 0.747_06e-3)]
    {
        let mut document = good();
        let text = case::builtin_fabric(&format!("fabrics/{file}.json")).unwrap();
        let mut fabric: Value = serde_json::from_str(text).unwrap();
        fabric.as_object_mut().unwrap().shift_remove("sources");
        put(&mut document, "/fabric", fabric);
        let given = read(&document).unwrap().fabric;
        close(given.areal_density, if file == "s-720" { 0.2552 } else { 0.2311 }, 1e-12);
        close(given.warp.modulus * given.warp.area(given.fibre_density), stiffness, 5e-6);
        close(given.warp.half_span(), half_span, 1e-5);
        remove(&mut document, "/fabric/areal_density_g_m2");
        close(read(&document).unwrap().fabric.areal_density, areal_density, 2e-4);
    }
}

#[test]
fn a_straight_curve_is_the_modulus_and_another_keeps_its_points_in_pascal() {
    let with = |curve: Value| {
        let mut document = good();
        remove(&mut document, "/fabric/warp/modulus_gpa");
        put(&mut document, "/fabric/warp/curve", curve);
        read(&document).unwrap().fabric.warp
    };
    let linear = read(&good()).unwrap().fabric.warp;
    for curve in [json!([[0, 0], [0.035, 3.36]]), json!([[0, 0], [0.01, 0.96], [0.021, 2.016], [0.035, 3.36]])] {
        assert_eq!(with(curve), linear);
    }
    let bent = with(json!([[0, 0], [0.01, 0.8], [0.04, 4.1]]));
    assert_eq!((bent.curve.len(), bent.curve[0], bent.curve[2][0]), (3, [0.0; 2], 0.04));
    close(bent.curve[2][1], 4.1e9, 1e-15);
    close(bent.modulus, 110e9, 1e-12);
}

/// Cases, and pointers to fields of theirs or to what is around these: a case as [`document_of`] reads it, then `?` and pointers.
const FIELDS: &str = include_str!("fields.txt");

#[test]
fn fields_have_their_values_and_sources() {
    let mut texts = String::new();
    for line in FIELDS.trim().lines() {
        let (case, asked) = line.split_once(" ? ").unwrap();
        let case = case_of(case).unwrap_or_else(|error| panic!("{line}: {error}"));
        writeln!(texts, "# {line}").unwrap();
        for asked in asked.split(' ') {
            let below = format!("{asked}/");
            for Field { pointer, value, unit, origin, source, assumed, .. } in &case.fields {
                if pointer == asked || pointer.starts_with(&below) {
                    let mark = if *assumed { "*" } else { " " };
                    writeln!(texts, "{mark} {pointer} = {value} {unit} ({}: {source})", origin.word()).unwrap();
                }
            }
        }
        texts.push('\n');
    }
    insta::assert_snapshot!("fields", texts);
}

#[test]
fn the_report_names_every_field_with_its_source() {
    let turned = "every key
1 ply of S-720 at 0°, 10 × 4 elements of 3.0000 × 2.0000 mm: 30.00 × 8.00 mm
2 plies of coarse at 90°, 1 × 15 elements of 6.0000 × 2.0000 mm: 6.00 × 30.00 mm\n\n";
    for (line, head) in [("plain", "plain\n1 ply, "), ("laid & /pack/layup/1/orientation_deg=90", turned)] {
        let case = case_of(line).unwrap();
        let report = case::report(&case);
        assert!(report.starts_with(head), "{report}");
        for field in &case.fields {
            let line = report.lines().find(|line| line.split_whitespace().any(|word| word == field.pointer)).unwrap();
            assert!(line.contains(&field.value) && line.ends_with(&field.source), "{line}");
            assert_eq!(line.starts_with("* "), field.assumed, "{line}");
        }
    }
}

#[test]
fn what_comes_after_the_end_is_left_out_and_noted() {
    let line = "good & /output/profile_times_us=[0, 50, 500] & /expect/4/at_us=401";
    let case = case_of(line).unwrap();
    assert_eq!(case.output.profile_times, [0.0, 50e-6]);
    assert_eq!(case.expect.len(), 4);
    let notes = case.notes.join("\n");
    assert!(notes.contains("500 µs left out") && notes.contains("/expect/4 at 401 µs"), "{notes}");
    let case = case_of(&format!("{line} & /output/history_interval_us=401")).unwrap();
    close(case.output.history_interval, case.solver.end_time, 0.0);
    assert!(read(&good()).unwrap().notes.is_empty());
}

/// The largest edge radius that the reader accepts [mm]; the solver's own check agrees just below it.
fn largest_edge(line: &str) -> f64 {
    let (mut fits, mut too_large) = (0.0, 6.0);
    let at = |edge: f64| case_of(&format!("{line} & /projectile/edge_radius_mm={edge}"));
    for _ in 0..60 {
        let middle = 0.5 * (fits + too_large);
        if at(middle).is_ok() { fits = middle } else { too_large = middle }
    }
    refused(at(too_large + 1e-6), "/projectile/edge_radius_mm", "room for");
    let body = Body::new(at(fits - 1e-9).unwrap().projectile.as_ref().unwrap());
    assert!(body.is_some(), "{line}: the reader accepts an edge of {fits} mm");
    fits
}

#[test]
fn a_body_has_room_for_its_edges() {
    for (line, edge) in [
        // A cone of radius 3 and height 4 holds a ball of radius 3·4/(3 + 5).
        ("cone & /projectile/length_mm=4", 1.5),
        // A ball within the wall, and one between arc and tail.
        ("ogive", 3.0),
        ("ogive & /projectile/length_mm=9", 2.7),
        // The wall, and the strip.
        ("fragment", 3.0),
        ("fragment & /projectile/nose_flat_mm=0.5 & /projectile/nose_angle_deg=60", 0.25 / 30_f64.to_radians().tan()),
    ] {
        assert!((largest_edge(line) - edge).abs() < 1e-9, "{line}: {}", largest_edge(line));
    }
    // The room between flats and tail.
    assert!(largest_edge("fragment & /projectile/length_mm=3 & /projectile/nose_angle_deg=50") < 1.2);
}

#[test]
fn the_hash_knows_numbers_not_words_or_order() {
    let hash = |value: Value| case::case_hash(&value);
    let one = hash(json!({"title": "a", "pack": {"plies": 1, "width_mm": 30}, "sources": {"/pack": "x"}}));
    assert_eq!(one, hash(json!({"pack": {"width_mm": 30.0, "plies": 1}, "title": "b", "expect": []})));
    assert_ne!(one, hash(json!({"title": "a", "pack": {"plies": 1, "width_mm": 31}})));
    assert_eq!(hash(json!({})), "08f44b07b5901a25"); // FNV-1a of "{}"
}
