//! Anything at all is read or refused, never a panic: cases at random.

use super::*;

pub(super) fn config() -> ProptestConfig {
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
        prop::sample::select(vec![
            "free",
            "none",
            "rigid",
            "cone",
            "ogive",
            "fragment",
            "bar",
            "sphere",
            "5%",
            "weft",
            "prescribed",
            ""
        ])
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
pub(super) fn mutated() -> impl Strategy<Value = Value> {
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
