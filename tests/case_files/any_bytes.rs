//! Cases at random: anything at all is read or refused, never a panic, and the JSON Schema agrees.

use super::*;

/// Words of cases.
const WORDS: [&str; 12] =
    ["free", "none", "rigid", "cone", "ogive", "fragment", "bar", "sphere", "5%", "weft", "prescribed", ""];

/// Any JSON, with a liking for the words and numbers that cases are made of.
fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        (0.0..1000.0).prop_map(Value::from),
        (0..5).prop_map(Value::from),
        prop::sample::select(&WORDS[..]).prop_map(Value::from),
        ".{0,8}".prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 12, 4, |inner| {
        let keys = ["file", "a_mm", "left", "shape", "absent", "count_per_cm"].map(str::to_owned);
        let key = prop_oneof![prop::sample::select(keys.to_vec()), ".{0,4}"];
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
                None if document.pointer(parent).unwrap().is_object() => remove(&mut document, &pointer),
                None => *document.pointer_mut(parent).unwrap() = json!([]),
            }
        }
        document
    })
}

fn validator() -> jsonschema::Validator {
    let schema = case::schema();
    jsonschema::draft202012::meta::validate(&schema).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

#[test]
fn every_shipped_case_is_read_and_is_valid() {
    let validator = validator();
    let folders =
        ["cases", "cases/verify", "cases/stress"].into_iter().flat_map(|folder| fs::read_dir(folder).unwrap());
    let paths = folders.map(|entry| entry.unwrap().path());
    let paths: Vec<_> = paths.filter(|path| path.extension().is_some_and(|extension| extension == "json")).collect();
    assert!(paths.len() > 30, "{paths:?}");
    for path in paths {
        let value: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
        let case = case::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        for value in [&value, &case.as_run] {
            let errors: Vec<String> = validator.iter_errors(value).map(|error| error.to_string()).collect();
            assert!(errors.is_empty(), "{}: {errors:?}", path.display());
        }
    }
    assert!(validator.is_valid(&good()));
}

/// Changes of the good case that the schema refuses; see [`document_of`].
const BAD: &str = r#"/zzz=1
/projectile/mass_gg=1
/projectile/shape="ogiv"
/projectile/velocity_m_s=0
/projectile/offset_mm=[0]
/solver/courant=0
/solver/courant=1.5
/fabric/file="f.json"
/fabric/crossover/compression="soft"
/pack/plies=65
/pack/edges/left="open"
/pack/layup=[]
/pack/layup/0={"ply": 1}
/pack/layup/0/plies=0
/pack/layup/0/fabric={"name": "f"}
/pack/layup/1/fabric/warp/crimp=-1
/pack/layup/1/orientation_deg=361
/sources/x="no pointer"
/title=""
-/title"#;

#[test]
fn bad_cases_are_not() {
    let validator = validator();
    for line in BAD.lines() {
        assert!(!validator.is_valid(&document_of(&format!("good & {line}")).0), "{line}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    /// The schema never refuses what the reader accepts. Damaged bytes and changes at random are the fuzz targets'.
    #[test]
    fn mutated_cases_are_refused_in_words_or_are_valid(document in mutated()) {
        thread_local!(static VALIDATOR: jsonschema::Validator = validator());
        match read(&document) {
            Ok(_) => prop_assert!(VALIDATOR.with(|validator| validator.is_valid(&document)), "{document}"),
            Err(error) => assert_well_formed(&error),
        }
    }
}
