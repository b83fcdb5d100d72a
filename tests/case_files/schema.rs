//! The JSON Schema agrees with the reader.

use super::any_bytes::{config, mutated};
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
        ("/projectile/shape", json!("ogiv")),
        ("/projectile/nose_flat_mm", json!(1)),
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
        ("/pack/layup", json!([])),
        ("/pack/layup/0", json!({"ply": 1})),
        ("/pack/layup/0/plies", json!(0)),
        ("/pack/layup/0/fabric", json!({"name": "f"})),
        ("/pack/layup/1/fabric/warp/crimp", json!(-1)),
        ("/pack/layup/1/orientation_deg", json!(361)),
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
