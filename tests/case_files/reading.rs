//! What a case says reaches its field, in SI units and with its source.

use super::*;

#[test]
fn every_key_reaches_its_field_in_si_units() {
    let case = read(&good()).unwrap();
    let warp = &case.fabric.warp;
    assert_eq!((case.name.as_str(), case.title.as_str()), ("good", "every key"));
    close(warp.linear_density, 1.577_777_777_8e-4, 1e-10);
    close(warp.count, 787.401_574_8, 1e-10);
    close(warp.half_span(), 0.635e-3, 1e-12);
    close(warp.modulus, 96e9, 0.0);
    close(case.fabric.areal_density, 0.2552, 1e-15);
    close(case.fabric.crossover.gap, 1e-5, 1e-15);
    close(case.fabric.crossover.compression.unwrap().b, 0.12e-3, 1e-15);
    let shear = case.fabric.shear.as_ref().unwrap();
    close(shear.g2, 1e9, 0.0);
    close(case.fabric.thickness, 0.25e-3, 1e-15);
    assert_eq!((case.pack.columns, case.pack.rows, case.pack.plies), (16, 8, 3));
    close(case.pack.friction, 0.1, 1e-15);
    close(case.pack.spacing.unwrap(), 0.4e-3, 1e-15);
    assert_eq!((case.pack.edges.left, case.pack.edges.right), (Edge::Clamped, Edge::Free));
    assert_eq!(case.pack.pretension, Some([Some(100.0), Some(200.0)]));
    assert_eq!(case.pack.initial_velocity, [1.0, 2.0, -3.0]);
    assert_eq!(case.pack.initial_deflection.unwrap().weft_half_waves, 2);
    let projectile = case.projectile.as_ref().unwrap();
    assert_eq!(projectile.shape, Shape::Cylinder { diameter: 5.5e-3, length: 42.1e-3 });
    close(projectile.mass, 3e-3, 1e-15);
    close(projectile.inertia.unwrap()[1], 4.4e-7, 1e-12);
    assert_eq!(projectile.offset, [1e-3, -2e-3]);
    close(projectile.obliquity, std::f64::consts::FRAC_PI_6, 1e-15);
    close(case.solver.end_time, 4e-4, 1e-15);
    assert_eq!(case.output.profile_times, [0.0, 50e-6, 100e-6]);
    assert_eq!(case.expect[0].bound, Bound::Word("perforated".to_owned()));
    assert_eq!(case.expect[1].bound, Bound::Value { value: -50.0, tolerance: 5.0 });
    assert_eq!(case.expect[3].bound, Bound::Range { min: 1.0, max: f64::INFINITY });
    assert_eq!(case.expect[3].between, Some([10e-6, 20e-6]));
    assert_eq!(case.expect[4].at, Some(1e-6));
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
fn tex_dtex_and_counts_per_cm_are_the_same_yarn() {
    let denier = read(&good()).unwrap().fabric;
    for (key, value) in [("linear_density_tex", 1420.0 / 9.0), ("linear_density_dtex", 1420.0 / 0.9)] {
        let mut document = without("/fabric/warp/linear_density_denier");
        put(&mut document, &format!("/fabric/warp/{key}"), json!(value));
        remove(&mut document, "/fabric/warp/count_per_inch");
        put(&mut document, "/fabric/warp/count_per_cm", json!(20.0 / 2.54));
        let fabric = read(&document).unwrap().fabric;
        close(fabric.warp.linear_density, denier.warp.linear_density, 1e-14);
        close(fabric.warp.count, denier.warp.count, 1e-14);
    }
}

#[test]
fn what_is_left_out_takes_its_documented_default_and_assumptions_are_marked() {
    let mut document = good();
    for pointer in ["/fabric/crossover", "/fabric/shear", "/fabric/thickness_mm", "/output", "/expect", "/sources"] {
        remove(&mut document, pointer);
    }
    for key in ["friction", "axial_inertia_g_mm2", "transverse_inertia_g_mm2"] {
        remove(&mut document, &format!("/projectile/{key}"));
    }
    for key in ["spacing_mm", "friction", "layup"] {
        remove(&mut document, &format!("/pack/{key}"));
    }
    remove(&mut document, "/pack/edges/top");
    let case = read(&document).unwrap();
    let assumed: Vec<&str> =
        case.fields.iter().filter(|field| field.assumed).map(|field| field.pointer.as_str()).collect();
    let expected = [
        "/fabric/crossover/gap_mm",
        "/fabric/crossover/compression/a_mm",
        "/fabric/crossover/compression/b_mm_n13",
        "/fabric/thickness_mm",
        "/fabric/shear/thickness_mm",
        "/fabric/shear/g1_mpa",
        "/fabric/shear/g2_mpa",
        "/fabric/shear/gamma1",
        "/fabric/shear/gamma2",
        "/pack/spacing_mm",
        "/pack/friction",
        "/projectile/friction",
    ];
    assert_eq!(assumed, expected);
    close(case.fabric.thickness, 0.30e-3, 1e-15);
    assert_eq!(case.pack.spacing, None);
    assert_eq!(case.pack.edges.top, Edge::Clamped);
    let projectile = case.projectile.as_ref().unwrap();
    assert_eq!((projectile.friction, projectile.inertia), (0.2, None));
    let origin = |pointer: &str| case.fields.iter().find(|field| field.pointer == pointer).unwrap().origin;
    assert_eq!(origin("/pack/width_mm"), Origin::Read);
    assert_eq!(origin("/pack/edges/top"), Origin::Default);
    assert_eq!(origin("/pack/columns"), Origin::Derived);
    assert!(case.fields.iter().all(|field| !field.source.is_empty()), "{:?}", case.fields);
}

#[test]
fn a_source_holds_for_everything_below_it() {
    let case = read(&good()).unwrap();
    let field = |pointer: &str| case.fields.iter().find(|field| field.pointer == pointer).unwrap();
    assert_eq!(field("/fabric/warp/modulus_gpa").source, "paper, Table I");
    assert_eq!(field("/fabric/weft/modulus_gpa").source, "case file");
    assert!(field("/fabric/crossover/compression/a_mm").assumed);
    assert!(!field("/fabric/crossover/gap_mm").assumed);
    refused(read(&with("/sources/~1fabric~1wrap", json!("x"))), "/sources/~1fabric~1wrap", "/fabric/warp");
    refused(read(&with("/sources/~1pack", json!(1))), "/sources/~1pack", "text");
}

#[test]
fn an_absent_yarn_has_a_count_and_nothing_else() {
    let absent = with("/fabric/weft", json!({"absent": true, "count_per_cm": 8}));
    let case = read(&absent).unwrap();
    assert!(!case.fabric.weft.present && case.fabric.warp.present);
    close(case.fabric.weft.count, 800.0, 1e-15);
    let mut document = absent.clone();
    put(&mut document, "/fabric/weft/crimp", json!(0.01));
    refused(read(&document), "/fabric/weft/crimp", "absent");
    let mut document = absent;
    put(&mut document, "/fabric/warp", json!({"absent": true, "count_per_cm": 8}));
    refused(read(&document), "/fabric", "at least one yarn");
}

#[test]
fn a_prescribed_bar_needs_no_mass_and_never_turns() {
    let bar = json!({"shape": "bar", "diameter_mm": 10, "velocity_m_s": 5, "motion": "prescribed"});
    let projectile = read(&with("/projectile", bar.clone())).unwrap().projectile.unwrap();
    assert_eq!(projectile.mass, 1.0);
    assert_eq!(projectile.rotation, case::Rotation::Locked);
    let mut document = with("/projectile", bar);
    put(&mut document, "/projectile/rotation", json!("free"));
    refused(read(&document), "/projectile/rotation", "locked");
    remove(&mut document, "/projectile/rotation");
    remove(&mut document, "/projectile/motion");
    refused(read(&document), "/projectile/mass_g", "required");
}

#[test]
fn without_a_projectile_the_pack_is_alone() {
    assert!(read(&with("/projectile", Value::Null)).unwrap().projectile.is_none());
    assert!(read(&without("/projectile")).unwrap().projectile.is_none());
}

#[test]
fn the_case_as_run_reads_back_as_the_same_case() {
    let changes = ["/projectile/velocity_m_s=200".to_owned(), "/fabric/shear/g1_mpa=20".to_owned()];
    let first = case::read(Path::new("cases/s720-1ply-155.json"), &changes).unwrap();
    let again = case::from_str("again.json", &first.as_run.to_string(), &[]).unwrap();
    assert_eq!(again.fields, first.fields);
    assert_eq!((again.fabric, again.pack), (first.fabric, first.pack));
    assert_eq!((again.projectile, again.solver), (first.projectile, first.solver));
}

#[test]
fn the_report_names_every_field_with_its_source() {
    let case = case::read(Path::new("cases/s720-1ply-155.json"), &[]).unwrap();
    let report = case::report(&case);
    assert!(
        report.starts_with("Kevlar 129 S-720, 1 ply, RCC at 155 m/s\n1 ply, 86 × 86 elements from 0.3175 × 0.3175 mm"),
        "{report}"
    );
    for field in &case.fields {
        let line = report.lines().find(|line| line.split_whitespace().any(|word| word == field.pointer)).unwrap();
        assert!(line.contains(&field.value) && line.ends_with(&field.source), "{line}");
        assert_eq!(line.starts_with("* "), field.assumed, "{line}");
    }
}

#[test]
fn a_shot_needs_no_solver_and_ends_with_its_outcome() {
    let case = read(&plain()).unwrap();
    close(case.solver.end_time, 1e-3, 1e-15);
    assert_eq!(field(&case, "/solver/end_time_us").origin, Origin::Derived);
    let without_outcome = [
        ("/projectile/motion", json!("prescribed")),
        ("/projectile", Value::Null),
        ("/solver", json!({"run_until": "end_time"})),
    ];
    for (pointer, value) in without_outcome {
        let mut document = plain();
        put(&mut document, pointer, value);
        let error = read(&document).unwrap_err();
        assert_eq!(error.location, "/solver/end_time_us", "{pointer}");
    }
}

#[test]
fn a_pack_that_does_not_span_may_take_longer_to_an_outcome() {
    let edges =
        |[left, right, bottom, top]: [&str; 4]| json!({"left": left, "right": right, "bottom": bottom, "top": top});
    for (sides, end) in [
        (["clamped", "clamped", "free", "free"], 1e-3),
        (["free", "roller", "clamped", "clamped"], 1e-3),
        (["clamped", "free", "clamped", "free"], 8e-3),
        (["clamped", "roller", "free", "free"], 8e-3),
        (["roller"; 4], 8e-3),
    ] {
        let mut document = plain();
        put(&mut document, "/pack/edges", edges(sides));
        close(read(&document).unwrap().solver.end_time, end, 1e-15);
        // One group that spans is enough.
        put(&mut document, "/pack/layup", json!([{"plies": 1}, {"plies": 1, "edges": "clamped"}]));
        close(read(&document).unwrap().solver.end_time, 1e-3, 1e-15);
    }
}

#[test]
fn what_comes_after_the_end_is_left_out_and_noted() {
    let mut document = good();
    put(&mut document, "/output/profile_times_us", json!([0, 50, 500]));
    put(&mut document, "/expect/4/at_us", json!(401));
    let case = read(&document).unwrap();
    assert_eq!(case.output.profile_times, [0.0, 50e-6]);
    assert_eq!(case.expect.len(), 4);
    let notes = case.notes.join("\n");
    assert!(notes.contains("500 µs left out") && notes.contains("/expect/4 at 401 µs"), "{notes}");
    put(&mut document, "/output/history_interval_us", json!(401));
    let case = read(&document).unwrap();
    close(case.output.history_interval, case.solver.end_time, 0.0);
    assert!(read(&good()).unwrap().notes.is_empty());
}

#[test]
fn shapes_have_the_names_that_people_have_for_them() {
    for (word, shape) in [("ball", "sphere"), ("rcc", "cylinder"), ("fsp", "fragment")] {
        let mut document = plain();
        put(&mut document, "/projectile/shape", json!(word));
        if shape != "sphere" {
            put(&mut document, "/projectile/length_mm", json!(6));
        }
        let case = read(&document).unwrap();
        assert_eq!(case.as_run["projectile"]["shape"], shape);
        assert_eq!(field(&case, "/projectile/shape").value, shape);
    }
}

#[test]
fn the_mass_of_a_solid_follows_from_its_density() {
    let mut document = plain();
    remove(&mut document, "/projectile/mass_g");
    let error = read(&document).unwrap_err();
    assert!(error.location == "/projectile/mass_g" && error.to_string().contains("density_kg_m3"), "{error}");
    put(&mut document, "/projectile/density_kg_m3", json!(7850));
    let case = read(&document).unwrap();
    close(case.projectile.unwrap().mass, 7850.0 * std::f64::consts::PI / 6.0 * 6e-3_f64.powi(3), 1e-12);
    put(&mut document, "/projectile/mass_g", json!(2));
    close(read(&document).unwrap().projectile.unwrap().mass, 2e-3, 1e-15);
}

#[test]
fn changes_are_named_in_title_and_name() {
    let named = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let mut case = case::from_str("plain.json", &plain().to_string(), &sets).unwrap();
        case.name_changes(&sets);
        assert_eq!(case.as_run["title"], case.title.as_str());
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
