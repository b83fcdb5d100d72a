//! Every key of the case file: the schema of the types that hold them, and what stands in a document against it.
//!
//! A key is written once, as a field of such a type. Beside its type, its range and its doc comment the schema has, as the field says:
//! - `default` with `source`, or `derived`, or `without`: its value where it is left out, and where that comes from or what it means;
//! - `where`: the value of another key with which the default holds; `or`: what may be given in its place, as a pointer from its object;
//! - `only`: the values of another key beside which it belongs; `with`: a key that must be given beside it;
//! - `group`: a name that it shares with others, of which exactly one is given;
//! - `help`: what to say of a value out of range; `none`: the word that stands for no object.

use std::sync::LazyLock;

use schemars::generate::SchemaSettings;
use serde_json::Value;

use super::CaseKeys;
use super::error::CaseError;
use super::text::{
    describe, escape, index, is_at_or_below, json_number, list, nearest, number_text, percent, quote, text_of, whole,
};
use super::units::split_unit;

/// Keys that are gone, or those of a key's words that are, and what to do instead.
const REMOVED: [(&str, &str, &str); 4] = [
    ("unit_cell", "", "leave \"unit_cell\" out: unit cells are solved in one way"),
    ("law", "kawabata", "a case has no such law; `ripstop crossover --law kawabata` draws its curves"),
    ("membrane_force", "projected", "leave \"membrane_force\" out: the force of a case is the yarn tension"),
    ("modulus", "secant", "leave \"modulus\" out: the modulus of a case is the slope of the stress"),
];

/// The schema of a case, every object in its place.
pub(super) static CASE: LazyLock<Value> = LazyLock::new(|| {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<CaseKeys>().to_value();
    tidy(&mut schema);
    schema
});

/// Leaves out null, which stands for an optional field of Rust, formats of numbers, and line breaks of doc comments.
fn tidy(node: &mut Value) {
    match node {
        Value::Number(number) => *node = number.as_f64().map_or(Value::Null, json_number),
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Object(map) => {
            if let Some(Value::Array(choices)) = map.get_mut("anyOf") {
                choices.retain(|choice| choice["type"] != "null");
                if let [Value::Object(only)] = &mut choices[..] {
                    let only = std::mem::take(only);
                    map.remove("anyOf");
                    for (key, value) in only {
                        map.entry(key).or_insert(value);
                    }
                }
            }
            if let Some(kind) = map.get("type").and_then(|kind| kind.get(0)).cloned() {
                map.insert("type".to_owned(), kind);
            }
            if let Some(Value::Array(words)) = map.get_mut("enum") {
                words.retain(|word| !word.is_null());
            }
            if let Some(Value::String(text)) = map.get_mut("description") {
                *text = without_unit(text);
            }
            map.shift_remove("format");
            if map.contains_key("derived") {
                map.shift_remove("default");
            }
            for (name, key) in map.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten() {
                let Some(unit) = split_unit(name).1 else { continue };
                let items = key.get("items").is_some();
                (if items { &mut key["items"] } else { key })["unit"] = Value::from(unit.name);
            }
            map.values_mut().for_each(tidy);
        }
        _ => {}
    }
}

/// A doc comment in one line, without the SI unit that it ends in.
fn without_unit(text: &str) -> String {
    let text = text.replace('\n', " ");
    match text.strip_suffix("].").and_then(|text| text.rsplit_once(" [")) {
        Some((text, _)) => format!("{text}."),
        None => text,
    }
}

/// A key of an object.
#[derive(Clone, Copy)]
pub(super) struct Key {
    pub(super) name: &'static str,
    /// Schema of its value.
    pub(super) node: &'static Value,
    /// Whether its field is no optional one.
    always: bool,
}

/// Schema of the object that a value is, that its items are, or that stands in place of a word.
pub(super) fn object(node: &'static Value) -> Option<&'static Value> {
    if node.get("properties").is_some() {
        return Some(node);
    }
    node["anyOf"].as_array().into_iter().flatten().chain(node.get("items")).find_map(object)
}

/// Keys of that object.
pub(super) fn keys(node: &'static Value) -> Vec<Key> {
    let Some(object) = object(node) else { return Vec::new() };
    let required = strings(&object["required"]);
    let properties = object["properties"].as_object().into_iter().flatten();
    properties.map(|(name, node)| Key { name, node, always: required.contains(&name.as_str()) }).collect()
}

/// The strings of a list, or a string alone.
fn strings(value: &Value) -> Vec<&str> {
    value.as_str().into_iter().chain(value.as_array().into_iter().flatten().filter_map(Value::as_str)).collect()
}

impl Key {
    /// A property in words; empty where the key has none.
    pub(super) fn text(&self, property: &str) -> &'static str {
        self.node[property].as_str().unwrap_or_default()
    }

    /// The unit of the value, empty where it has none.
    pub(super) fn unit(&self) -> &'static str {
        self.node["unit"].as_str().or(self.node["items"]["unit"].as_str()).unwrap_or_default()
    }

    /// Whether null says that there is no such object.
    pub(super) fn is_nullable(&self) -> bool {
        !self.text("without").is_empty() && self.node.get("properties").is_some()
    }

    /// Another key and those of its values with which this one has a property.
    pub(super) fn condition(&self, property: &str) -> Option<(&'static str, Vec<&'static str>)> {
        self.node[property].as_object()?.iter().next().map(|(key, values)| (key.as_str(), strings(values)))
    }

    /// Whether the key has no value where it is left out, though it belongs there.
    pub(super) fn is_needed(&self) -> bool {
        let has = |property: &str| self.node.get(property).is_some();
        (self.always || has("only") || has("group")) && !["default", "derived", "without"].into_iter().any(has)
    }

    /// Whether what may stand in its place is given.
    fn is_replaced(&self, object: &Value) -> bool {
        object.pointer(self.text("or")).is_some_and(|other| other != object)
    }

    /// Whether it belongs beside the other keys of its object; one that is itself wrong decides nothing.
    pub(super) fn belongs(&self, keys: &[Self], object: &Value) -> bool {
        let Some((other, values)) = self.condition("only") else { return true };
        value_of(other, keys, object).is_none_or(|found| values.contains(&found.as_str()))
    }

    /// Whether it has to be given.
    fn is_missing(&self, keys: &[Self], object: &Value) -> bool {
        let value = |(other, values)| (value_of(other, keys, object), values);
        match (self.condition("where").map(value), self.condition("only").map(value)) {
            (Some((found, values)), _) if !self.text("or").is_empty() => {
                !self.is_replaced(object) && found.is_none_or(|found| !values.contains(&found.as_str()))
            }
            (_, only) => {
                self.is_needed() && self.text("group").is_empty() && only.is_none_or(|(found, _)| found.is_some())
            }
        }
    }

    /// The value where it is left out.
    pub(super) fn default(&self, keys: &[Self], object: &Value) -> Option<&'static Value> {
        let holds = self.condition("where").is_none_or(|(other, values)| {
            value_of(other, keys, object).is_some_and(|found| values.contains(&found.as_str()))
        });
        self.node.get("default").filter(|_| holds && !self.is_replaced(object))
    }
}

/// The value of a key that others depend on, given or by default, where it is one that may stand there.
fn value_of(name: &str, keys: &[Key], object: &Value) -> Option<String> {
    let key = keys.iter().find(|key| key.name == name)?;
    let value = object.get(name).or(key.node.get("default"))?;
    accepts(key.node, value).then(|| text_of(value))
}

/// The key that a JSON pointer names, whether or not a document has it.
pub(super) fn lookup(pointer: &str) -> Option<Key> {
    let mut found: Option<Key> = None;
    for part in pointer.strip_prefix('/')?.split('/') {
        let node = found.map_or(&*CASE, |key| key.node);
        found = match (found, index(part)) {
            (Some(list), Some(_)) if node["type"] == "array" && object(node).is_some() => {
                Some(Key { node: &list.node["items"], ..list })
            }
            _ if node["type"] == "array" => None,
            _ => keys(node).into_iter().find(|key| key.name == part),
        };
        found?;
    }
    found
}

/// Order of a pointer among the keys: the place of each of its parts.
pub(super) fn order(pointer: &str) -> Vec<usize> {
    let mut node = Some(&*CASE);
    let place = |part: &str| {
        let keys = node.map(keys).unwrap_or_default();
        let place = keys.iter().position(|key| key.name == part);
        node = place.map_or(node, |place| Some(keys[place].node));
        place.or_else(|| part.parse().ok()).unwrap_or(usize::MAX)
    };
    pointer.split('/').skip(1).map(place).collect()
}

/// Every pointer; those below a list are left out.
pub(super) fn pointers() -> Vec<String> {
    fn collect(prefix: &str, node: &'static Value, pointers: &mut Vec<String>) {
        for key in keys(node) {
            let pointer = format!("{prefix}/{}", key.name);
            if key.node["type"] != "array" {
                collect(&pointer, key.node, pointers);
            }
            pointers.push(pointer);
        }
    }
    let mut pointers = Vec::new();
    collect("", &CASE, &mut pointers);
    pointers
}

/// Whether a value may stand where a schema describes it, its own keys aside.
fn accepts(node: &Value, value: &Value) -> bool {
    if let Some(choices) = node["anyOf"].as_array() {
        return choices.iter().any(|choice| accepts(choice, value));
    }
    if let Some(words) = node["enum"].as_array() {
        return words.contains(value);
    }
    let bound = |name: &str, none: f64| node[name].as_f64().unwrap_or(none);
    let in_range = |number: f64| {
        (bound("minimum", f64::MIN)..=bound("maximum", f64::MAX)).contains(&number)
            && number > bound("exclusiveMinimum", f64::NEG_INFINITY)
    };
    match node["type"].as_str() {
        Some("string") if node.get("pattern").is_some() => value.as_str().and_then(percent).is_some(),
        Some("string") => value.as_str().is_some_and(|text| node.get("minLength").is_none() || !text.trim().is_empty()),
        Some("boolean") => value.is_boolean(),
        Some("number") => value.as_f64().is_some_and(in_range),
        Some("integer") => whole(value).is_some_and(|number| in_range(f64::from(number))),
        Some("array") => fits(node, value).is_some_and(|items| items.iter().all(|item| accepts(&node["items"], item))),
        _ => value.is_object(),
    }
}

/// The items of a list of an allowed length.
fn fits<'a>(node: &Value, value: &'a Value) -> Option<&'a Vec<Value>> {
    let bound = |name: &str, none: u64| node[name].as_u64().unwrap_or(none);
    let lengths = bound("minItems", 0)..=bound("maxItems", u64::MAX);
    value.as_array().filter(|items| lengths.contains(&(items.len() as u64)))
}

/// What may stand where a schema describes it, in words.
pub(super) fn expected(node: &'static Value) -> String {
    if let Some(choices) = node["anyOf"].as_array() {
        let or = if choices.iter().any(|choice| choice.get("pattern").is_some()) { ", or " } else { " or " };
        return choices.iter().map(expected).collect::<Vec<_>>().join(or);
    }
    if node.get("enum").is_some() {
        return list(words(node));
    }
    let number = |name: &str| number_text(node[name].as_f64().unwrap_or_default());
    let unit = |node: &Value| node["unit"].as_str().map(|unit| format!(" {unit}")).unwrap_or_default();
    match node["type"].as_str() {
        Some("string") if node.get("pattern").is_some() => {
            "a percentage from \"0%\" to \"100%\" of the value".to_owned()
        }
        Some("string") => if node.get("minLength").is_some() { "text" } else { "a word" }.to_owned(),
        Some("boolean") => "true or false".to_owned(),
        Some("number") if node.get("exclusiveMinimum").is_some() => {
            format!("a number in ({}, {}]{}", number("exclusiveMinimum"), number("maximum"), unit(node))
        }
        Some("number") => format!("a number in [{}, {}]{}", number("minimum"), number("maximum"), unit(node)),
        Some("integer") => format!("a whole number in [{}, {}]", node["minimum"], node["maximum"]),
        Some("array") => {
            let one = expected(&node["items"]);
            let many = one.replacen("a number", "numbers", 1).replacen("an object", "objects", 1);
            match (node["minItems"].as_u64(), number("maxItems")) {
                (None | Some(0), max) => format!("a list of at most {max} {many}"),
                (Some(_), max) if number("minItems") == max => format!("a list of {max} {many}"),
                (Some(min), max) => format!("a list of {min} to {max} {many}"),
            }
        }
        _ if node.get("properties").is_some() => {
            let keys = keys(node);
            let needed: Vec<&str> =
                keys.iter().filter(|key| key.is_needed() && key.text("group").is_empty()).map(|key| key.name).collect();
            let names = if needed.is_empty() { keys.iter().map(|key| key.name).collect() } else { needed };
            let file = if node.get("file").is_some() { ", or {\"file\": \"…\"}" } else { "" };
            format!("an object with {}{file}", names.into_iter().map(quote).collect::<Vec<_>>().join(", "))
        }
        _ => "an object of JSON pointers and texts".to_owned(),
    }
}

/// The words of a choice; those that are read as one of them are left out.
pub(super) fn words(node: &'static Value) -> Vec<&'static str> {
    strings(&node["enum"])
}

/// Puts the words of the case file in place of others for them.
pub(super) fn without_aliases(node: &'static Value, value: &mut Value) {
    if let Some(meant) = value.as_str().and_then(|word| node["aliases"].get(word)) {
        *value = meant.clone();
    }
    match value {
        Value::Object(map) => {
            for key in keys(node) {
                map.get_mut(key.name).into_iter().for_each(|value| without_aliases(key.node, value));
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| without_aliases(&node["items"], item)),
        _ => {}
    }
}

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
    let mut groups: Vec<&str> = Vec::new();
    for key in keys.iter().filter(|key| !key.text("group").is_empty() && key.belongs(&keys, object)) {
        if !groups.contains(&key.text("group")) {
            groups.push(key.text("group"));
        }
    }
    for group in groups {
        let names: Vec<&str> = keys.iter().filter(|key| key.text("group") == group).map(|key| key.name).collect();
        let given: Vec<&str> = names.iter().copied().filter(|name| object.get(name).is_some()).collect();
        errors.extend(match given[..] {
            [_] => None,
            [] => Some(CaseError::at(pointer, format!("a {group}: {}", list(names)), "none of them")),
            [_, second, ..] => {
                let found = format!("{} of them", given.len());
                Some(CaseError::at(format!("{pointer}/{second}"), format!("one {group}: {}", list(names)), found))
            }
        });
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

#[cfg(test)]
#[path = "keys_tests.rs"]
mod tests;
