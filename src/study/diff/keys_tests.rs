use serde_json::json;

use super::*;

#[test]
fn only_what_differs_is_named_by_its_pointer() {
    let a = json!({"title": "x", "pack": {"plies": 1, "a/b": [1, 2]}, "solver": {"courant": 0.9}, "sources": {"/pack": "y"}});
    let b = json!({"title": "z", "pack": {"plies": 1.0, "a/b": [1, 3, 4]}, "solver": {}});
    let found: Vec<(String, Option<Value>, Option<Value>)> =
        of_cases(&a, &b).into_iter().map(|key| (key.pointer, key.a, key.b)).collect();
    let expected = [
        ("/pack/a~1b/1", Some(json!(2)), Some(json!(3))),
        ("/pack/a~1b/2", None, Some(json!(4))),
        ("/solver", None, Some(json!({}))),
        ("/solver/courant", Some(json!(0.9)), None),
    ];
    assert_eq!(found, expected.map(|(pointer, a, b)| (pointer.to_owned(), a, b)));
    assert!(of_cases(&a, &a).is_empty());
}
