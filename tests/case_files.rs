//! Case files: what is read, what is refused and how that is said. Public API only.
//!
//! Promise: any bytes whatever give a checked case or one error with place, expectation and finding; never a panic. The words of
//! refusals and the fields of cases are those of `snapshots/`.

mod changes;
mod reading;
mod refusing;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use ripstop::case::{self, BuiltInFabric, Case, CaseError, Edge, Field};
use ripstop::physics::projectile_body::Body;
use serde_json::{Map, Value, json};

/// A case that gives every key that a free cylinder and a pack of two kinds of plies can have.
fn good() -> Value {
    serde_json::from_str(include_str!("case_files/good.json")).unwrap()
}

/// A shot with as few keys as can be.
fn plain() -> Value {
    json!({
        "title": "plain",
        "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 50, "height_mm": 50},
        "projectile": {"shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 100},
    })
}

/// A case of 3 mm by 2 mm elements, 30 mm along warp 10 of them, 8 mm along weft 4; its second group has half as many along the warp.
fn laid() -> Value {
    let yarn = |count: f64| {
        json!({"linear_density_denier": 1420, "modulus_gpa": 96, "failure_strain": 0.035, "count_per_cm": count,
            "crimp": 0.01})
    };
    let mut document = good();
    put(&mut document, "/fabric/warp", yarn(10.0 / 3.0));
    put(&mut document, "/fabric/weft", yarn(5.0));
    let mut coarse = document["fabric"].clone();
    put(&mut coarse, "/name", json!("coarse"));
    put(&mut coarse, "/warp", yarn(10.0 / 6.0));
    put(&mut document, "/pack", json!({"width_mm": 30, "height_mm": 8, "layup": [{}, {"fabric": coarse, "plies": 2}]}));
    remove(&mut document, "/sources");
    document
}

/// A document and changes from the command line, of a line such as `good & /pack/plies=2 & -/title & --set /pack/friction=0`: a case, then
/// what is changed in it. `-/pointer` leaves a key out, `--set` is a change from the command line, all else is put into the file.
fn document_of(line: &str) -> (Value, Vec<String>) {
    let mut parts = line.split(" & ");
    let mut document = match parts.next().unwrap() {
        "good" => good(),
        "laid" => laid(),
        shape => {
            let mut document = plain();
            if shape != "plain" {
                put(&mut document, "/projectile/shape", json!(shape));
                put(&mut document, "/projectile/length_mm", json!(12));
            }
            document
        }
    };
    let mut sets = Vec::new();
    for part in parts {
        match (part.strip_prefix("--set "), part.strip_prefix('-'), part.split_once('=')) {
            (Some(set), ..) => sets.push(set.to_owned()),
            (_, Some(pointer), _) => remove(&mut document, pointer),
            (.., Some((pointer, value))) => put(&mut document, pointer, serde_json::from_str(value).unwrap()),
            _ => panic!("{line}"),
        }
    }
    (document, sets)
}

/// The case of such a line.
fn case_of(line: &str) -> Result<Case, CaseError> {
    let (document, sets) = document_of(line);
    case::from_str("case.json", &document.to_string(), &sets)
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

fn remove(document: &mut Value, pointer: &str) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    document.pointer_mut(parent).unwrap().as_object_mut().unwrap().shift_remove(&unescape(key));
}

fn unescape(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
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

/// One line for each part of each error, none of them empty.
#[track_caller]
fn assert_well_formed(error: &CaseError) {
    for error in error.all() {
        for part in [&*error.file, &error.expected, &error.found, error.help.as_deref().unwrap_or("none")] {
            assert!(!part.trim().is_empty() && !part.contains('\n'), "{error:?}");
        }
        assert!(!error.location.contains('\n'), "{error:?}");
    }
    assert!(error.to_string().starts_with("error: "), "{error}");
}

#[track_caller]
fn refused(result: Result<Case, CaseError>, location: &str, words: &str) {
    let error = result.map(|_| format!("accepted, but {location}: {words}")).unwrap_err();
    assert_well_formed(&error);
    assert_eq!(error.location, location, "{error}");
    assert!(error.to_string().contains(words), "{words:?} is not in\n{error}");
}

#[track_caller]
fn close(got: f64, expected: f64, relative: f64) {
    assert!((got - expected).abs() <= relative * expected.abs(), "{got} is not {expected}");
}

fn field<'a>(case: &'a Case, pointer: &str) -> &'a Field {
    case.fields.iter().find(|field| field.pointer == pointer).unwrap_or_else(|| panic!("no field {pointer}"))
}
