//! Keys by which two JSON objects differ.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use serde_json::Value;

use crate::case::CASE_WORDS;
use crate::case::escape_pointer;

/// What computed a run: keys of `summary.json`.
const MACHINE: [&str; 5] = ["backend", "adapter", "precision", "threads", "version"];

/// A key whose value differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyDifference {
    /// JSON pointer.
    pub pointer: String,
    /// What the first has there; `None` where it has nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub a: Option<Value>,
    /// What the other has there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub b: Option<Value>,
}

/// What differs between two cases, but for the words around what is computed.
pub(super) fn of_cases(a: &Value, b: &Value) -> Vec<KeyDifference> {
    let without_words = |case: &Value| {
        let mut case = case.clone();
        if let Some(map) = case.as_object_mut() {
            map.retain(|key, _| !CASE_WORDS.contains(&key.as_str()));
        }
        case
    };
    differing(&without_words(a), &without_words(b))
}

/// What differs in what computed two runs.
pub(super) fn of_machines(a: &Value, b: &Value) -> Vec<KeyDifference> {
    let of = |summary: &Value| {
        MACHINE.iter().map(|key| ((*key).to_owned(), summary[*key].clone())).collect::<serde_json::Map<_, _>>().into()
    };
    differing(&of(a), &of(b))
}

/// Leaves that are not the same in both, by pointer.
fn differing(a: &Value, b: &Value) -> Vec<KeyDifference> {
    let (mut left, mut right) = (BTreeMap::new(), BTreeMap::new());
    leaves(a, String::new(), &mut left);
    leaves(b, String::new(), &mut right);
    let pointers: BTreeSet<&String> = left.keys().chain(right.keys()).collect();
    let rows = pointers.into_iter().map(|pointer| {
        let [a, b] = [&left, &right].map(|side| side.get(pointer).map(|value| (*value).clone()));
        KeyDifference { pointer: pointer.clone(), a, b }
    });
    rows.filter(|key| !same(key.a.as_ref(), key.b.as_ref())).collect()
}

/// 1 and 1.0 are the same.
fn same(a: Option<&Value>, b: Option<&Value>) -> bool {
    match (a.and_then(Value::as_f64), b.and_then(Value::as_f64)) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

fn leaves<'a>(value: &'a Value, pointer: String, out: &mut BTreeMap<String, &'a Value>) {
    match value {
        Value::Object(map) if !map.is_empty() => {
            for (key, value) in map {
                leaves(value, format!("{pointer}/{}", escape_pointer(key)), out);
            }
        }
        Value::Array(items) if !items.is_empty() => {
            for (index, value) in items.iter().enumerate() {
                leaves(value, format!("{pointer}/{index}"), out);
            }
        }
        leaf => {
            out.insert(pointer, leaf);
        }
    }
}

#[cfg(test)]
#[path = "keys_tests.rs"]
mod tests;
