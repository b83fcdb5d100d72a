//! Case files: what is read, what is refused and how that is said. Public API only.
//!
//! Promise: any bytes whatever give a checked case or one error with place, expectation and finding; never a panic.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use ripstop::case::{self, Bound, Case, CaseError, Edge, Origin, Shape};
use serde_json::{Map, Value, json};

/// A case that gives every key that a free cylinder can have.
fn good() -> Value {
    let yarn = |crimp: f64| {
        json!({"absent": false, "linear_density_denier": 1420, "modulus_gpa": 96, "failure_strain": 0.035,
            "count_per_inch": 20, "crimp": crimp})
    };
    json!({
        "title": "every key",
        "fabric": {
            "name": "S-720", "fibre_density_kg_m3": 1440, "areal_density_g_m2": 255.2,
            "warp": yarn(0.0218), "weft": yarn(0.0139),
            "crossover": {"law": "published", "membrane_force": "projected", "gap_mm": 0.01,
                "compression": {"a_mm": 0.10, "b_mm_n13": 0.12}},
            "thickness_mm": 0.25,
            "shear": {"thickness_mm": 0.25, "g1_mpa": 10, "g2_mpa": 1000, "gamma1": 0.35, "gamma2": 0.6,
                "modulus": "secant"},
        },
        "pack": {"plies": 1, "width_mm": 20.3, "height_mm": 10.1, "crossovers_per_element": 1, "spacing_mm": 0.4,
            "edges": {"left": "clamped", "right": "free", "bottom": "roller", "top": "clamped"},
            "pretension": {"warp_n_per_m": 100, "weft_n_per_m": 200}, "initial_velocity_m_s": [1, 2, -3],
            "initial_deflection": {"amplitude_mm": 0.1, "warp_half_waves": 1, "weft_half_waves": 2}},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 42.1, "edge_radius_mm": 0.1, "mass_g": 3,
            "axial_inertia_g_mm2": 11, "transverse_inertia_g_mm2": 440, "velocity_m_s": 155, "offset_mm": [1, -2],
            "standoff_mm": 1, "obliquity_deg": 30, "azimuth_deg": 90, "yaw_deg": 10,
            "angular_velocity_rad_s": [0, 0, 5], "friction": 0.2, "motion": "free", "rotation": "free"},
        "solver": {"end_time_us": 400, "courant": 0.9, "hourglass": 0.02, "symmetry": "none", "run_until": "end_time"},
        "output": {"history_interval_us": 0.5, "frames": 10, "profile_times_us": [0, 50, 100], "profile_along": "weft"},
        "expect": [
            {"quantity": "outcome", "value": "perforated", "source": "paper, Figure 6"},
            {"quantity": "residual_velocity_m_s", "value": -50, "tolerance": "10%", "source": "paper, Figure 6"},
            {"quantity": "energy_error", "min": -0.01, "max": 0.01, "source": "model"},
            {"quantity": "wave_speed_m_s", "min": 1, "between_us": [10, 20], "source": "theory"},
            {"quantity": "kinetic_energy_j", "value": 36, "tolerance": 0.5, "at_us": 1, "source": "½ m v²"}
        ],
        "sources": {"/fabric/warp": "paper, Table I", "/fabric/crossover/compression": "assumed", "/pack": "a frame"},
        "notes": "none",
    })
}

fn read(value: &Value) -> Result<Case, CaseError> {
    case::from_str("good.json", &value.to_string(), &[])
}

fn with(pointer: &str, value: Value) -> Value {
    let mut document = good();
    put(&mut document, pointer, value);
    document
}

fn put(document: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(map) => drop(map.insert(unescape(key), value)),
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        other => panic!("{pointer} is inside {other}"),
    }
}

fn unescape(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
}

fn without(pointer: &str) -> Value {
    let mut document = good();
    remove(&mut document, pointer);
    document
}

fn remove(document: &mut Value, pointer: &str) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().shift_remove(key).unwrap();
}

fn set(change: &str) -> Result<Case, CaseError> {
    case::from_str("good.json", &good().to_string(), &[change.to_owned()])
}

/// Every pointer into a document, itself aside.
fn pointers(value: &Value) -> Vec<String> {
    fn collect(prefix: &str, value: &Value, found: &mut Vec<String>) {
        let children: Vec<(String, &Value)> = match value {
            Value::Object(map) => map.iter().map(|(key, child)| (key.replace('/', "~1"), child)).collect(),
            Value::Array(list) => list.iter().enumerate().map(|(index, child)| (index.to_string(), child)).collect(),
            _ => Vec::new(),
        };
        for (part, child) in children {
            let pointer = format!("{prefix}/{part}");
            collect(&pointer, child, found);
            found.push(pointer);
        }
    }
    let mut found = Vec::new();
    collect("", value, &mut found);
    found
}

/// One line for each part, none of them empty.
fn assert_well_formed(error: &CaseError) {
    for part in [&error.file, &error.location, &error.expected, &error.found] {
        assert!(!part.trim().is_empty() && !part.contains('\n'), "{error:?}");
    }
    assert!(error.help.as_ref().is_none_or(|help| !help.is_empty() && !help.contains('\n')), "{error:?}");
    let text = error.to_string();
    assert!(text.starts_with("error: ") && text.lines().count() <= 4, "{text}");
}

#[track_caller]
fn refused(result: Result<Case, CaseError>, location: &str, words: &str) -> CaseError {
    let error = match result {
        Ok(_) => panic!("accepted, but {location}: {words}"),
        Err(error) => error,
    };
    assert_well_formed(&error);
    assert_eq!(error.location, location, "{error}");
    assert!(error.to_string().contains(words), "{words:?} is not in\n{error}");
    error
}

fn close(got: f64, expected: f64, relative: f64) {
    assert!((got - expected).abs() <= relative * expected.abs(), "{got} is not {expected}");
}

mod reading {
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
        assert_eq!((case.pack.columns, case.pack.rows), (16, 8));
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
        for pointer in ["/fabric/crossover", "/fabric/shear", "/fabric/thickness_mm", "/output", "/expect", "/sources"]
        {
            remove(&mut document, pointer);
        }
        for key in ["friction", "axial_inertia_g_mm2", "transverse_inertia_g_mm2"] {
            remove(&mut document, &format!("/projectile/{key}"));
        }
        remove(&mut document, "/pack/spacing_mm");
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
        assert!(report.starts_with("Kevlar 129 S-720, 1 ply, RCC at 155 m/s\n1 ply, 160 × 160 elements"), "{report}");
        for field in &case.fields {
            let line = report.lines().find(|line| line.split_whitespace().any(|word| word == field.pointer)).unwrap();
            assert!(line.contains(&field.value) && line.ends_with(&field.source), "{line}");
            assert_eq!(line.starts_with("* "), field.assumed, "{line}");
        }
    }
}

mod refusing {
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
        refused(read(), "line 1, column 1", "can be read");
        fs::write(&path, b"{\n \"title\": \"\xff\"}").unwrap();
        refused(read(), "line 2, column 12", "0xFF");
        fs::write(&path, b"\xff\xfe{\0}\0").unwrap();
        refused(read(), "line 1, column 1", "UTF-8");
        fs::File::create(&path).unwrap().set_len((1 << 20) + 1).unwrap();
        refused(read(), "line 1, column 1", "1 MiB");
        refused(case::read(folder.path(), &[]), "line 1, column 1", "a folder");
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
            assert_eq!(error.help.unwrap(), format!("did you mean \"{key}\"?"));
        }
        let error = refused(read(&with("/pack/mass_g", json!(1))), "/pack/mass_g", "unknown key");
        assert_eq!(error.help.unwrap(), "\"mass_g\" belongs at /projectile/mass_g");
        refused(read(&with("/a~1b\n", json!(1))), "/a~1b\\n", "unknown key");
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
            "/solver",
            "/solver/end_time_us",
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
            ("/projectile/nose_length_mm", json!(5), "belongs where \"shape\" is \"cone\""),
            ("/projectile/shape", json!("ogive"), "not yet"),
            ("/projectile/shape", json!("fragment"), "not yet"),
            ("/projectile/shape", json!("spere"), "\"sphere\""),
            ("/solver/courant", json!(1.01), "unstable"),
            ("/solver/end_time_us", json!(1e9), "steps"),
            ("/solver/hourglass", json!(-0.1), "[0, 1]"),
            ("/pack/plies", json!(65), "[1, 64]"),
            ("/pack/plies", json!(2), "not yet"),
            ("/pack/plies", json!(1.5), "whole"),
            ("/pack/width_mm", json!(1e9), "100000"),
            ("/pack/crossovers_per_element", json!(0), "[1, 64]"),
            ("/fabric/shear/gamma1", json!(0.7), "gamma2"),
            ("/fabric/shear/g1_mpa", json!(1001), "g2_mpa"),
            ("/fabric/shear/thickness_mm", json!(0.26), "one thickness"),
            ("/fabric/crossover/gap_mm", json!(1.1), "[0, 1] mm"),
            ("/fabric/crossover/compression", json!({"a_mm": 0}), "rigid"),
            ("/fabric/crossover/compression", json!({"b_mm_n13": 0}), "rigid"),
            ("/fabric/crossover/compression", json!("ridig"), "\"rigid\""),
            ("/fabric/warp/failure_strain", json!(0), "(0, 1]"),
            ("/fabric/warp/crimp", json!(0.51), "[0, 0.5]"),
            ("/fabric/warp/linear_density_tex", json!(158), "2 of them"),
            ("/output/history_interval_us", json!(401), "end_time_us"),
            ("/expect/0/tolerance", json!(1), "word"),
            ("/expect/1/tolerance", json!("1 percent"), "for example \"1%\""),
            ("/expect/2/value", json!(1), "both"),
            ("/expect/2/min", json!(1), "at most max"),
            ("/expect/3/between_us", json!([20, 10]), "earlier"),
            ("/expect/4/at_us", json!(401), "end_time_us"),
        ];
        for (pointer, value, words) in table {
            refused(read(&with(pointer, value)), pointer, words);
        }
        refused(read(&with("/output/profile_times_us", json!([0, 2, 1]))), "/output/profile_times_us/2", "ascending");
        refused(read(&with("/output/profile_times_us", json!([0, 500]))), "/output/profile_times_us/1", "500");
        refused(read(&without("/projectile/axial_inertia_g_mm2")), "/projectile/transverse_inertia_g_mm2", "together");
        let mut document = with("/fabric/crossover/law", json!("kawabata"));
        refused(read(&document), "/fabric/crossover/membrane_force", "tension");
        put(&mut document, "/fabric/crossover/membrane_force", json!("tension"));
        assert!(read(&document).is_ok());
        refused(read(&with("/fabric", json!([{}]))), "/fabric", "not yet");
    }

    #[test]
    fn absurd_sizes_are_refused_before_anything_is_allocated() {
        let mut document = with("/pack/width_mm", json!(1e5));
        put(&mut document, "/pack/height_mm", json!(1e5));
        refused(read(&document), "/pack", "elements");
        // 2e9 elements are 800 GB; 8e13 rows of history are 16 PB.
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
}

mod fabric_files {
    use super::*;

    fn in_folder(fabric_file: &Value, text: &str) -> (tempfile::TempDir, Result<Case, CaseError>) {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("fabrics")).unwrap();
        fs::write(folder.path().join("fabrics/f.json"), text).unwrap();
        let path = folder.path().join("case.json");
        fs::write(&path, with("/fabric", json!({"file": fabric_file})).to_string()).unwrap();
        let result = case::read(&path, &[]);
        (folder, result)
    }

    #[test]
    fn stand_in_for_the_fabric_with_their_own_sources() {
        let mut fabric = good()["fabric"].clone();
        fabric["sources"] = json!({"/weft": "assumed: guessed", "/shear/g1_mpa": "paper"});
        let (_folder, result) = in_folder(&json!("fabrics/f.json"), &fabric.to_string());
        let case = result.unwrap();
        let field = |pointer: &str| case.fields.iter().find(|field| field.pointer == pointer).unwrap();
        assert!(field("/fabric/weft/crimp").assumed);
        assert_eq!(field("/fabric/shear/g1_mpa").source, "paper");
        assert_eq!(field("/fabric/shear/g2_mpa").source, "fabrics/f.json");
        assert_eq!(field("/fabric/warp/crimp").source, "paper, Table I");
        assert_eq!(case.as_run["fabric"]["name"], "S-720");
        assert!(case.as_run["fabric"].get("sources").is_none());
    }

    #[test]
    fn are_named_in_errors_about_what_is_in_them() {
        for (change, value, location) in [
            ("/warp/crimp", json!(7), "/warp/crimp"),
            ("/sources", json!({"/wrap": "x"}), "/sources/~1wrap"),
            ("/file", json!("g.json"), "/file"),
        ] {
            let mut fabric = good()["fabric"].clone();
            put(&mut fabric, change, value);
            let (_folder, result) = in_folder(&json!("fabrics/f.json"), &fabric.to_string());
            let error = result.unwrap_err();
            assert_well_formed(&error);
            assert!(error.file.ends_with("fabrics/f.json"), "{error}");
            assert_eq!(error.location, location);
        }
        let (_folder, result) = in_folder(&json!("fabrics/f.json"), "{\"name\": }");
        let error = refused(result, "line 1, column 10", "value");
        assert!(error.file.ends_with("fabrics/f.json"), "{error}");
    }

    #[test]
    fn stay_inside_the_folder_of_the_case() {
        for name in ["/etc/passwd", "../f.json", "fabrics/../../f.json", "", "none.json", "fabrics", "\0"] {
            let (_folder, result) = in_folder(&json!(name), "{}");
            let error = result.unwrap_err();
            assert_well_formed(&error);
            assert!(error.location == "/fabric/file" || error.found == "a folder", "{error}");
        }
        let (_folder, result) = in_folder(&json!(7), "{}");
        refused(result, "/fabric/file", "7");
        let error = read(&with("/fabric/file", json!("fabrics/s-720.json"))).unwrap_err();
        assert!(error.found.contains("beside"), "{error}");
        let unknown = read(&with("/fabric", json!({"file": "fabrics/s-721.json"})));
        refused(unknown, "/fabric/file", "built in");
        assert!(read(&with("/fabric", json!({"file": "fabrics/s-720.json"}))).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn do_not_leave_it_by_a_link() {
        let outside = tempfile::tempdir().unwrap();
        fs::write(outside.path().join("f.json"), good()["fabric"].to_string()).unwrap();
        let (folder, _) = in_folder(&json!("x.json"), "{}");
        std::os::unix::fs::symlink(outside.path().join("f.json"), folder.path().join("x.json")).unwrap();
        refused(case::read(&folder.path().join("case.json"), &[]), "/fabric/file", "link");
    }
}

mod changes {
    use super::*;

    #[test]
    fn replace_and_create_values() {
        assert_eq!(set("/projectile/velocity_m_s=200").unwrap().projectile.unwrap().velocity, 200.0);
        assert_eq!(set("/solver/symmetry=auto").unwrap().solver.symmetry, case::Symmetry::Auto);
        assert_eq!(set("/solver/symmetry=\"auto\"").unwrap().solver.symmetry, case::Symmetry::Auto);
        assert_eq!(set("/projectile/offset_mm/1=5").unwrap().projectile.unwrap().offset, [1e-3, 5e-3]);
        assert_eq!(set("/expect/1/value=10").unwrap().expect[1].bound, Bound::Value { value: 10.0, tolerance: 1.0 });
        assert!(set("/projectile=null").unwrap().projectile.is_none());
        let text = without("/output").to_string();
        let change = |change: &str| case::from_str("case.json", &text, &[change.to_owned()]);
        assert_eq!(change("/output/frames=7").unwrap().output.frames, 7);
        assert_eq!(change("/fabric/file=fabrics/s-728.json").unwrap().fabric.name, "S-728");
        let both = ["/fabric/warp/crimp=0.03".to_owned(), "/fabric={\"file\": \"fabrics/s-728.json\"}".to_owned()];
        let case = case::from_str("case.json", &text, &both).unwrap();
        assert_eq!((case.fabric.name.as_str(), case.fabric.warp.crimp), ("S-728", 0.03));
        let text = without("/pack/initial_velocity_m_s").to_string();
        let case = case::from_str("case.json", &text, &["/pack/initial_velocity_m_s/2=4".to_owned()]).unwrap();
        assert_eq!(case.pack.initial_velocity, [0.0, 0.0, 4.0]);
    }

    #[test]
    fn take_the_place_of_the_source() {
        let change = |change: &str| case::read(Path::new("cases/s720-1ply-155.json"), &[change.to_owned()]).unwrap();
        let field = |case: &Case, pointer: &str| case.fields.iter().find(|f| f.pointer == pointer).unwrap().clone();
        let case = change("/projectile/mass_g=4");
        assert_eq!(field(&case, "/projectile/mass_g").source, "--set");
        assert!(!field(&case, "/projectile/mass_g").assumed);
        let case = change("/fabric/shear/g1_mpa=4");
        assert!(field(&case, "/fabric/shear/g1_mpa").assumed, "an assumed value stays one when it is varied");
        assert_eq!(field(&case, "/fabric/shear/g2_mpa").source, "assumed: not published");
    }

    #[test]
    fn are_refused_like_the_file() {
        for (change, location, words) in [
            ("/projectile/mass_gg=1", "--set /projectile/mass_gg", "\"mass_g\""),
            ("/projectile/velocity_m_s=fast", "--set /projectile/velocity_m_s", "\"fast\""),
            ("/projectile/velocity_m_s=NaN", "--set /projectile/velocity_m_s", "\"NaN\""),
            ("/projectile/velocity_m_s=1e999", "--set /projectile/velocity_m_s", "1e999"),
            ("/projectile/velocity_m_s=", "--set /projectile/velocity_m_s", "value"),
            ("/projectile={\"shape\":", "--set /projectile", "end of the text"),
            ("/projectile={\"shape\":1,\"shape\":2}", "--set /projectile", "duplicate"),
            ("/projectile/mass_g/x=1", "--set /projectile/mass_g", "object or a list"),
            ("/projectle/mass_g=1", "--set /projectle", "/projectile"),
            ("/projectile/offset_mm/2=1", "--set /projectile/offset_mm/2", "from 0 to 1"),
            ("/pack/edges=square", "--set /pack/edges", "clamped"),
            ("/fabric/shear/gamma1=1", "--set /fabric/shear/gamma1", "gamma2"),
            ("projectile=1", "--set projectile=1", "/json/pointer=value"),
            ("/projectile", "--set /projectile", "no ="),
            ("/=1", "--set /=1", "/json/pointer=value"),
            ("=1", "--set =1", "/json/pointer=value"),
            ("", "--set ", "/json/pointer=value"),
        ] {
            refused(set(change), location, words);
        }
        let word = with("/pack/edges", json!("free")).to_string();
        let inside = case::from_str("case.json", &word, &["/pack/edges/left=free".to_owned()]);
        refused(inside, "--set /pack/edges", "as a whole");
    }
}

mod schema {
    use super::*;

    fn validator() -> jsonschema::Validator {
        let schema = case::schema();
        jsonschema::draft202012::meta::validate(&schema).unwrap();
        jsonschema::draft202012::new(&schema).unwrap()
    }

    #[test]
    fn every_shipped_case_is_read_and_is_valid() {
        let validator = validator();
        let mut count = 0;
        for folder in ["cases", "cases/verify"] {
            for entry in fs::read_dir(folder).into_iter().flatten() {
                let path = entry.unwrap().path();
                if path.extension().is_none_or(|extension| extension != "json") {
                    continue;
                }
                count += 1;
                let value: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
                let case = case::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
                for value in [&value, &case.as_run] {
                    let errors: Vec<String> = validator.iter_errors(value).map(|error| error.to_string()).collect();
                    assert!(errors.is_empty(), "{}: {errors:?}", path.display());
                }
            }
        }
        assert!(count > 0);
        assert!(validator.is_valid(&good()));
    }

    #[test]
    fn bad_cases_are_not() {
        let validator = validator();
        for (pointer, value) in [
            ("/zzz", json!(1)),
            ("/projectile/mass_gg", json!(1)),
            ("/projectile/shape", json!("sphere")),
            ("/projectile/shape", json!("ogive")),
            ("/projectile/nose_length_mm", json!(1)),
            ("/projectile/velocity_m_s", json!(0)),
            ("/projectile/offset_mm", json!([0])),
            ("/solver/courant", json!(0)),
            ("/solver/courant", json!(1.5)),
            ("/fabric/warp/linear_density_tex", json!(1)),
            ("/fabric/warp/absent", json!(true)),
            ("/fabric/file", json!("f.json")),
            ("/fabric/crossover/compression", json!("soft")),
            ("/pack/plies", json!(65)),
            ("/pack/edges/left", json!("open")),
            ("/sources/x", json!("no pointer")),
            ("/title", json!("")),
        ] {
            assert!(!validator.is_valid(&with(pointer, value.clone())), "{pointer} = {value}");
        }
        for pointer in
            ["/title", "/projectile/mass_g", "/projectile/axial_inertia_g_mm2", "/fabric/warp/linear_density_denier"]
        {
            assert!(!validator.is_valid(&without(pointer)), "without {pointer}");
        }
    }

    proptest! {
        #![proptest_config(config())]
        /// The schema never refuses what the reader accepts.
        #[test]
        fn follows_the_reader(document in mutated()) {
            thread_local!(static VALIDATOR: jsonschema::Validator = validator());
            if read(&document).is_ok() {
                prop_assert!(VALIDATOR.with(|validator| validator.is_valid(&document)), "{document}");
            }
        }
    }
}

fn config() -> ProptestConfig {
    ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() }
}

/// Any JSON, with a liking for the words and numbers that cases are made of.
fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        (0.0..1000.0).prop_map(Value::from),
        (0..5).prop_map(Value::from),
        prop::sample::select(vec!["free", "none", "rigid", "cone", "bar", "sphere", "5%", "weft", "prescribed", ""])
            .prop_map(Value::from),
        ".{0,8}".prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 12, 4, |inner| {
        let key = prop_oneof![
            prop::sample::select(vec!["file", "a_mm", "left", "shape", "absent", "count_per_cm"])
                .prop_map(str::to_owned),
            ".{0,4}"
        ];
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::vec((key, inner), 0..4).prop_map(|entries| entries.into_iter().collect()),
        ]
    })
}

/// The good case with one to three values replaced or removed.
fn mutated() -> impl Strategy<Value = Value> {
    let change = (any::<prop::sample::Index>(), prop::option::weighted(0.7, any_json()));
    prop::collection::vec(change, 1..4).prop_map(|changes| {
        let mut document = good();
        for (index, value) in changes {
            let pointers = pointers(&document);
            let pointer = pointers[index.index(pointers.len())].clone();
            let (parent, _) = pointer.rsplit_once('/').unwrap();
            match value {
                Some(value) => *document.pointer_mut(&pointer).unwrap() = value,
                None if document.pointer(parent).unwrap().is_object() => remove_raw(&mut document, &pointer),
                None => *document.pointer_mut(parent).unwrap() = json!([]),
            }
        }
        document
    })
}

fn remove_raw(document: &mut Value, pointer: &str) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let map = document.pointer_mut(parent).unwrap().as_object_mut().unwrap();
    map.shift_remove(&unescape(key));
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn mutated_cases_are_read_or_refused(document in mutated()) {
        if let Err(error) = read(&document) {
            assert_well_formed(&error);
        }
    }

    #[test]
    fn damaged_bytes_are_read_or_refused(at in any::<prop::sample::Index>(), length in 0..20_usize, new in ".{0,6}") {
        let text = good().to_string();
        let start = text.floor_char_boundary_at(at.index(text.len()));
        let end = text.floor_char_boundary_at((start + length).min(text.len()));
        let damaged = format!("{}{new}{}", &text[..start], &text[end..]);
        if let Err(error) = case::from_str("damaged.json", &damaged, &[]) {
            assert_well_formed(&error);
        }
    }

    #[test]
    fn any_change_is_made_or_refused(at in any::<prop::sample::Index>(), tail in "(/[a-z0-9~]{0,3})?", value in any_json()) {
        let pointers = pointers(&good());
        let pointer = &pointers[at.index(pointers.len())];
        for change in [format!("{pointer}{tail}={value}"), format!("{pointer}{tail}")] {
            if let Err(error) = set(&change) {
                assert_well_formed(&error);
            }
        }
    }
}

trait FloorCharBoundary {
    fn floor_char_boundary_at(&self, index: usize) -> usize;
}

impl FloorCharBoundary for str {
    fn floor_char_boundary_at(&self, index: usize) -> usize {
        (0..=index).rev().find(|index| self.is_char_boundary(*index)).unwrap_or(0)
    }
}
