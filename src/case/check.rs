//! A document against the table: everything that is wrong with it, key by key, before anything is read.

use serde_json::{Map, Value};

use super::error::{CaseError, describe, list, nearest, quote};
use super::fields::{CaseKey, KeyType, Presence};
use super::pointer::escape;
use super::value::{check, text_of};
use super::{sources, table};

/// Everything in a document that the table does not allow, in the order of the document.
pub(super) fn document(document: &Value) -> Vec<CaseError> {
    let Value::Object(map) = document else {
        return vec![CaseError::at("", "an object", describe(document))];
    };
    let mut errors = Vec::new();
    object("", table::CASE, map, &mut errors);
    if let Some(given) = map.get("sources").filter(|given| given.is_object()) {
        errors.extend(sources::check(given, "", document).err());
    }
    errors
}

fn object(pointer: &str, keys: &'static [CaseKey], map: &Map<String, Value>, errors: &mut Vec<CaseError>) {
    let mut meant = Vec::new();
    for (name, value) in map {
        let Some(key) = keys.iter().find(|key| key.name == name) else {
            meant.extend(nearest(name, keys.iter().map(|key| key.name)));
            errors.push(unknown(pointer, keys, name));
            continue;
        };
        let place = format!("{pointer}/{name}");
        match misplaced(&place, key, value, keys, map) {
            Some(error) => errors.push(error),
            None => below(&place, key, value, errors),
        }
    }
    // Who wrote a key wrong need not hear that it is missing.
    let absent = |key: &&CaseKey| !map.contains_key(key.name) && !meant.contains(&key.name);
    for key in keys.iter().filter(absent).filter(|key| belongs(key, keys, map)) {
        errors.extend(missing(pointer, key, keys, map));
    }
    errors.extend(groups(pointer, keys, map));
}

/// A value, and the keys below it.
fn below(place: &str, key: &'static CaseKey, value: &Value, errors: &mut Vec<CaseError>) {
    if key.is_nullable() && value.is_null() {
        return;
    }
    if let Err(error) = check(key, value, place) {
        errors.push(error);
        return;
    }
    match (key.kind, value) {
        (KeyType::Sources, _) => {}
        (_, Value::Object(inside)) => object(place, key.keys(), inside, errors),
        (KeyType::Items(keys, _), Value::Array(items)) => {
            for (index, item) in items.iter().enumerate() {
                object(&format!("{place}/{index}"), keys, item.as_object().unwrap_or(&Map::new()), errors);
            }
        }
        _ => {}
    }
}

/// A key that does not belong beside what the others say, or lacks the one that goes with it.
fn misplaced(
    place: &str,
    key: &CaseKey,
    value: &Value,
    keys: &[CaseKey],
    map: &Map<String, Value>,
) -> Option<CaseError> {
    if !belongs(key, keys, map)
        && let Some(only) = key.only
    {
        let found = plain(only.key, keys, map).unwrap_or_default();
        let expected = format!("no {} where {} is {}", quote(key.name), quote(only.key), quote(&found));
        let help = format!("it belongs where {} is {}", quote(only.key), list(only.values.iter().copied()));
        return Some(CaseError::at(place, expected, describe(value)).help(help));
    }
    if !key.with.is_empty() && !map.contains_key(key.with) {
        let expected = format!("{} and {} together, or none of them", quote(key.name), quote(key.with));
        return Some(CaseError::at(place, expected, format!("only {}", quote(key.name))));
    }
    None
}

/// Whether the key that decides about this one has one of the values it belongs with; one that is itself wrong decides nothing.
fn belongs(key: &CaseKey, keys: &[CaseKey], map: &Map<String, Value>) -> bool {
    let Some(only) = key.only else { return true };
    plain(only.key, keys, map).is_none_or(|found| only.values.contains(&found.as_str()))
}

/// The value of a key that other keys depend on, given or by default, where it is one that may stand there.
pub(super) fn plain(name: &str, keys: &[CaseKey], map: &Map<String, Value>) -> Option<String> {
    let key = keys.iter().find(|key| key.name == name)?;
    match (map.get(name), key.presence) {
        (Some(value), _) => key.accepts(value).then(|| text_of(value)),
        (None, Presence::Default(literal, _)) => Some(text_of(&literal.value())),
        (None, _) => None,
    }
}

fn missing(pointer: &str, key: &CaseKey, keys: &[CaseKey], map: &Map<String, Value>) -> Option<CaseError> {
    let decided = |name: &str| key.only.is_none_or(|only| only.key != name || plain(name, keys, map).is_some());
    let required = match key.presence {
        Presence::Required => key.group.is_empty() && key.only.is_none_or(|only| decided(only.key)),
        Presence::RequiredUnless(other, word, ..) => {
            !map.contains_key(key.instead) && plain(other, keys, map).is_none_or(|found| found != word)
        }
        _ => false,
    };
    required.then(|| {
        let error = CaseError::at(format!("{pointer}/{}", key.name), key.expected(), "nothing");
        let instead = if key.instead.is_empty() { String::new() } else { format!(", or {}", quote(key.instead)) };
        error.help(format!("{}{instead} is required: {}", quote(key.name), key.doc))
    })
}

/// Groups of keys of which one is needed.
fn groups(pointer: &str, keys: &[CaseKey], map: &Map<String, Value>) -> Vec<CaseError> {
    let mut groups: Vec<&str> = Vec::new();
    for key in keys.iter().filter(|key| !key.group.is_empty() && belongs(key, keys, map)) {
        if !groups.contains(&key.group) {
            groups.push(key.group);
        }
    }
    let wrong = |group: &str| {
        let names: Vec<&str> = keys.iter().filter(|key| key.group == group).map(|key| key.name).collect();
        let given: Vec<&str> = names.iter().copied().filter(|name| map.contains_key(*name)).collect();
        match given[..] {
            [_] => None,
            [] => Some(CaseError::at(pointer, format!("a {group}: {}", list(names)), "none of them")),
            [_, second, ..] => {
                let found = format!("{} of them", given.len());
                Some(CaseError::at(format!("{pointer}/{second}"), format!("one {group}: {}", list(names)), found))
            }
        }
    };
    groups.into_iter().filter_map(wrong).collect()
}

/// The nearest key comes first; the others are many, and the schema has them.
fn unknown(pointer: &str, keys: &[CaseKey], name: &str) -> CaseError {
    let object = if pointer.is_empty() { "the case" } else { pointer };
    let near = nearest(name, keys.iter().map(|key| key.name));
    // A key of this object without its unit is meant before one of another object.
    let without_unit = near.is_some_and(|near| near.strip_prefix(name).is_some_and(|unit| unit.starts_with('_')));
    let elsewhere = table::pointers().into_iter().find(|pointer| pointer.rsplit('/').next() == Some(name));
    let elsewhere = elsewhere.filter(|_| !without_unit);
    let expected = match (near, keys.len()) {
        (Some(near), 1) => format!("{}, the one key of {object}", quote(near)),
        (Some(near), count) => format!("{} or another of the {count} keys of {object}", quote(near)),
        (None, _) => format!("no key: {object} has none"),
    };
    let help = match (elsewhere, near) {
        (Some(pointer), _) => format!("{} belongs at {pointer}", quote(name)),
        (None, Some(near)) => format!("did you mean {}? `ripstop schema` lists every key", quote(near)),
        (None, None) => format!("leave {} out", quote(name)),
    };
    let location = format!("{pointer}/{}", escape(name));
    CaseError::at(location, expected, format!("unknown key {}", quote(name))).help(help)
}
