//! A document against the keys of the case file: everything that is wrong with it, key by key, before anything is read.

use serde_json::Value;

use super::error::{CaseError, describe, escape, is_at_or_below, list, nearest, quote};
use super::keys::{CASE, Key, accepts, expected, fits, keys, lookup, object, pointers, value_of, words};

/// Keys that are gone, or those of a key's words that are, and what to do instead.
const REMOVED: [(&str, &str, &str); 4] = [
    ("unit_cell", "", "leave \"unit_cell\" out: unit cells are solved in one way"),
    ("law", "kawabata", "a case has no such law; `ripstop crossover --law kawabata` draws its curves"),
    ("membrane_force", "projected", "leave \"membrane_force\" out: the force of a case is the yarn tension"),
    ("modulus", "secant", "leave \"modulus\" out: the modulus of a case is the slope of the stress"),
];

/// Everything in a document that is not as its key says, in the order of the document.
pub(super) fn check(document: &Value) -> Vec<CaseError> {
    if !document.is_object() {
        return vec![CaseError::at("", "an object", describe(document))];
    }
    let mut errors = Vec::new();
    check_object("", &CASE, document, &mut errors);
    if let Some(given) = document.get("sources").filter(|given| given.is_object()) {
        errors.extend(check_sources(given, "", document).err());
    }
    errors
}

fn check_object(pointer: &str, node: &'static Value, object: &Value, errors: &mut Vec<CaseError>) {
    let keys = keys(node);
    let mut meant = Vec::new();
    for (name, value) in object.as_object().into_iter().flatten() {
        let Some(key) = keys.iter().find(|key| key.name == name) else {
            meant.extend(nearest(name, keys.iter().map(|key| key.name)));
            errors.push(unknown(pointer, &keys, name));
            continue;
        };
        let place = format!("{pointer}/{name}");
        match misplaced(&place, key, value, &keys, object) {
            Some(error) => errors.push(error),
            None if key.is_nullable() && value.is_null() => {}
            None => check_value(&place, key, value, errors),
        }
    }
    // Who wrote a key wrong need not hear that it is missing.
    let absent = |key: &&Key| object.get(key.name).is_none() && !meant.contains(&key.name);
    for key in keys.iter().filter(absent).filter(|key| key.belongs(&keys, object) && key.is_missing(&keys, object)) {
        let error = CaseError::at(format!("{pointer}/{}", key.name), expected(key.node), "nothing");
        let instead = key.text("or").strip_prefix('/').map(|or| format!(", or {}", quote(or))).unwrap_or_default();
        errors.push(error.help(format!("{}{instead} is required: {}", quote(key.name), key.text("description"))));
    }
    let mut grouped: Vec<Key> = keys.iter().filter(|key| !key.text("group").is_empty()).copied().collect();
    grouped.dedup_by_key(|key| key.text("group"));
    for first in grouped.into_iter().filter(|key| key.belongs(&keys, object)) {
        let group = first.text("group");
        let names: Vec<&str> = keys.iter().filter(|key| key.text("group") == group).map(|key| key.name).collect();
        let given: Vec<&str> = names.iter().copied().filter(|name| object.get(name).is_some()).collect();
        if given.is_empty() {
            errors.push(CaseError::at(pointer, format!("a {group}: {}", list(names)), "none of them"));
        } else if let Some(second) = given.get(1) {
            let found = format!("{} of them", given.len());
            errors.push(CaseError::at(format!("{pointer}/{second}"), format!("one {group}: {}", list(names)), found));
        }
    }
}

/// Checks a value, and the keys below it.
fn check_value(place: &str, key: &Key, value: &Value, errors: &mut Vec<CaseError>) {
    let items = fits(key.node, value).filter(|_| key.node["type"] == "array");
    if !accepts(key.node, value) {
        let wrong =
            items.and_then(|items| items.iter().enumerate().find(|(_, item)| !accepts(&key.node["items"], item)));
        errors.push(match wrong {
            Some((index, item)) => {
                CaseError::at(format!("{place}/{index}"), expected(&key.node["items"]), describe(item))
            }
            None => mismatch(key, value, place),
        });
        return;
    }
    if value.is_object() && object(key.node).is_some() {
        check_object(place, key.node, value, errors);
    }
    for (index, item) in items.into_iter().flatten().enumerate().filter(|(_, item)| item.is_object()) {
        check_object(&format!("{place}/{index}"), key.node, item, errors);
    }
}

/// The error of a value that may not stand at its key.
fn mismatch(key: &Key, value: &Value, place: &str) -> CaseError {
    let error = CaseError::at(place, expected(key.node), describe(value));
    let text = value.as_str().unwrap_or_default();
    let first = key.node["anyOf"].get(0).unwrap_or(key.node);
    let is_number = text.parse::<f64>().is_ok_and(f64::is_finite);
    match key.node["type"].as_str() {
        _ if first.get("enum").is_some() && !text.is_empty() => match removed(key.name, text) {
            Some(instead) => error.help(instead),
            None => match nearest(text, words(first)) {
                Some(near) => error.help(format!("did you mean {}?", quote(near))),
                None => error,
            },
        },
        Some("number" | "integer") if is_number => error.help("write the number without quotes"),
        None if key.node["anyOf"][1].get("pattern").is_some() && !text.is_empty() => error.help("for example \"1%\""),
        Some("number") if !key.text("help").is_empty() && value.as_f64().is_some_and(|number| number > 0.0) => {
            error.help(key.text("help"))
        }
        _ => error,
    }
}

/// Help for a key, or a word of it, that is gone.
fn removed(key: &str, word: &str) -> Option<&'static str> {
    REMOVED.iter().find(|gone| (gone.0, gone.1) == (key, word)).map(|(.., instead)| *instead)
}

/// The error of a key that does not belong beside what the others say, or lacks the one that belongs with it.
fn misplaced(place: &str, key: &Key, value: &Value, keys: &[Key], object: &Value) -> Option<CaseError> {
    if let Some((other, values)) = key.condition("only").filter(|_| !key.belongs(keys, object)) {
        let found = value_of(other, keys, object).unwrap_or_default();
        let expected = format!("no {} where {} is {}", quote(key.name), quote(other), quote(&found));
        let help = format!("it belongs where {} is {}", quote(other), list(values));
        return Some(CaseError::at(place, expected, describe(value)).help(help));
    }
    let with = key.text("with");
    if !with.is_empty() && object.get(with).is_none() {
        let expected = format!("{} and {} together, or none of them", quote(key.name), quote(with));
        return Some(CaseError::at(place, expected, format!("only {}", quote(key.name))));
    }
    None
}

/// The error of an unknown key. The nearest one comes first; the others are many, and the schema has them.
fn unknown(pointer: &str, keys: &[Key], name: &str) -> CaseError {
    let object = if pointer.is_empty() { "the case" } else { pointer };
    let near = nearest(name, keys.iter().map(|key| key.name));
    // A key of this object without its unit is meant before one of another object.
    let without_unit = near.is_some_and(|near| near.strip_prefix(name).is_some_and(|unit| unit.starts_with('_')));
    let elsewhere = pointers().into_iter().find(|pointer| pointer.rsplit('/').next() == Some(name));
    let expected = match (near, keys.len()) {
        (Some(near), 1) => format!("{}, the one key of {object}", quote(near)),
        (Some(near), count) => format!("{} or another of the {count} keys of {object}", quote(near)),
        (None, _) => format!("no key: {object} has none"),
    };
    let help = match (removed(name, ""), elsewhere.filter(|_| !without_unit), near) {
        (Some(instead), ..) => instead.to_owned(),
        (None, Some(pointer), _) => format!("{} belongs at {pointer}", quote(name)),
        (None, None, Some(near)) => format!("did you mean {}? `ripstop schema` lists every key", quote(near)),
        (None, None, None) => format!("leave {} out", quote(name)),
    };
    let location = format!("{pointer}/{}", escape(name));
    CaseError::at(location, expected, format!("unknown key {}", quote(name))).help(help)
}

/// Refuses a source that is no text or whose pointer names nothing; `base` is where `document` stands in a case.
pub(super) fn check_sources(sources: &Value, base: &str, document: &Value) -> Result<(), CaseError> {
    let Value::Object(sources) = sources else {
        return Err(CaseError::at("/sources", "an object of JSON pointers and texts", describe(sources)));
    };
    for (pointer, text) in sources {
        let location = format!("/sources/{}", escape(pointer));
        if !text.is_string() {
            return Err(CaseError::at(location, "text", describe(text)));
        }
        if lookup(&format!("{base}{pointer}")).is_none() && document.pointer(pointer).is_none() {
            let pointers = pointers();
            let inside = pointers.iter().filter(|known| is_at_or_below(known, base)).map(|known| &known[base.len()..]);
            let error = CaseError::at(location, "the JSON pointer of a field", quote(pointer));
            return Err(match nearest(pointer, inside.filter(|pointer| !pointer.is_empty())) {
                Some(near) => error.help(format!("did you mean {}?", quote(near))),
                None => error,
            });
        }
    }
    Ok(())
}
