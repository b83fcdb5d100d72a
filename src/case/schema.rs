//! The keys of the case file for others to read: as a JSON Schema, and as pages of documentation.

use std::iter::once;

use serde_json::{Map, Value, json};

use super::error::text_of;
use super::keys::{CASE, Key, expected, keys, object, words};
use crate::markdown;

/// Properties of keys that JSON Schema does not know.
const OWN: [&str; 13] = [
    "title", "aliases", "source", "derived", "without", "where", "or", "only", "with", "group", "help", "file", "none",
];

/// The case file as a JSON Schema (2020-12): keys, types, ranges, defaults, units and meaning.
pub fn schema() -> Value {
    let mut schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "ripstop case",
        "description": "One impact of a woven fabric. Every key that is not required has a default that is named here.",
    });
    if let (Value::Object(schema), Value::Object(mut case)) = (&mut schema, published(&CASE)) {
        case.retain(|key, _| !schema.contains_key(key));
        schema.append(&mut case);
    }
    schema
}

/// A schema without properties that JSON Schema does not know, and with rules that stand for them.
fn published(node: &'static Value) -> Value {
    let mut schema = Map::new();
    for (name, value) in node.as_object().into_iter().flatten().filter(|(name, _)| !OWN.contains(&name.as_str())) {
        let value = match (name.as_str(), value) {
            ("properties", _) => keys(node).iter().map(|key| (key.name, property(key))).collect(),
            ("anyOf", Value::Array(choices)) => choices.iter().map(published).collect(),
            ("items", _) => published(value),
            ("enum", _) => words(node).into_iter().flat_map(|word| with_aliases(node, word)).collect(),
            ("default", Value::Object(_)) => continue,
            _ => value.clone(),
        };
        schema.insert(name.clone(), value);
    }
    if node.get("properties").is_some() {
        rules(&keys(node), &mut schema);
    }
    Value::Object(schema)
}

/// The schema of a key with its meaning, its unit and its default.
fn property(key: &Key) -> Value {
    let mut schema = published(key.node);
    if key.node.get("file").is_some() {
        let about = "A file with the keys of a fabric, in the case's folder.";
        let file = json!({"file": {"type": "string", "description": about}});
        let file = json!({"type": "object", "properties": file, "required": ["file"], "additionalProperties": false});
        schema = json!({"anyOf": [file, schema]});
    }
    if key.is_nullable() {
        schema["type"] = json!(["object", "null"]);
    }
    let mut text = key.text("description").to_owned();
    if !key.unit().is_empty() {
        schema["unit"] = json!(key.unit());
        text += &format!(" [{}]", key.unit());
    }
    let default = left_out(key);
    schema["description"] = json!(if default.is_empty() { text } else { format!("{text} Left out: {default}.") });
    schema
}

/// Rules on which keys of an object stand together.
fn rules(keys: &[Key], schema: &mut Map<String, Value>) {
    let is_needed = |key: &&Key| key.is_needed() && key.text("group").is_empty();
    let needed = keys.iter().filter(is_needed).filter(|key| key.condition("only").is_none());
    schema.insert("required".to_owned(), needed.map(|key| key.name).collect());
    schema.insert("additionalProperties".to_owned(), json!(false));
    let mut all = Vec::new();
    for key in keys {
        let (with, group) = (key.text("with"), key.text("group"));
        if !with.is_empty() {
            schema.entry("dependentRequired").or_insert_with(|| json!({}))[key.name] = json!([with]);
        }
        // A rule of a group stands with the first of its keys.
        let members = keys.iter().filter(|other| !group.is_empty() && other.text("group") == group);
        let members: Vec<Value> = members.map(|member| json!({"required": [member.name]})).collect();
        let is_first = members.first() == Some(&json!({"required": [key.name]}));
        let mut own = if is_needed(&key) { json!({"required": [key.name]}) } else { json!({}) };
        if is_first {
            own = json!({"oneOf": members});
        }
        if let Some((other, values)) = key.condition("only") {
            let decider = keys.iter().find(|key| key.name == other);
            let values = values.into_iter().flat_map(|value| decider.map(|key| with_aliases(key.node, value)));
            let values: Vec<Value> =
                values.flatten().map(|word| word.parse().map_or(json!(word), |flag: bool| json!(flag))).collect();
            let default = decider.and_then(|key| key.node.get("default"));
            let mut given = json!({"properties": {other: {"enum": values}}});
            if default.is_none_or(|default| !values.contains(default)) {
                given["required"] = json!([other]);
            }
            all.push(json!({"if": given, "then": own, "else": {"properties": {key.name: false}}}));
        } else if is_first {
            all.push(own);
        }
        if let (Some((other, values)), Some(or)) = (key.condition("where"), key.text("or").strip_prefix('/')) {
            let given = json!({"properties": {other: {"enum": values}}, "required": [other]});
            all.push(json!({"if": given, "else": {"anyOf": [{"required": [key.name]}, {"required": [or]}]}}));
        }
    }
    if !all.is_empty() {
        schema.insert("allOf".to_owned(), Value::Array(all));
    }
}

/// A word of the case file and others that are read as it.
fn with_aliases(node: &'static Value, word: &'static str) -> impl Iterator<Item = &'static str> {
    let aliases = node["aliases"].as_object().into_iter().flatten();
    once(word).chain(aliases.filter(move |(_, meant)| *meant == word).map(|(alias, _)| alias.as_str()))
}

/// The value of a key that is left out, and where it comes from.
fn left_out(key: &Key) -> String {
    match (key.node.get("default"), key.condition("where"), key.text("or").strip_prefix('/')) {
        (Some(_), Some((other, values)), Some(or)) => {
            format!("required, or {or}, unless {other} is {}", values.join(" or "))
        }
        (Some(Value::Object(_)), ..) => String::new(),
        (Some(value), ..) => format!("{}, {}", text_of(value), key.text("source")),
        (None, ..) => format!("{}{}", key.text("derived"), key.text("without")),
    }
}

/// Every key of the case file in Markdown: one table for each object, with the pointers where it stands.
pub fn reference() -> String {
    let mut objects: Vec<(String, &'static Value)> = vec![(String::new(), &*CASE)];
    collect("", &CASE, &mut objects);
    let mut seen: Vec<&Value> = Vec::new();
    let mut out = String::new();
    for (_, node) in &objects {
        if seen.contains(&&node["properties"]) {
            continue;
        }
        seen.push(&node["properties"]);
        let places = objects.iter().filter(|(_, other)| other["properties"] == node["properties"]);
        let places: Vec<String> = places.map(|(pointer, _)| format!("`{pointer}`")).collect();
        let title = if places == ["``"] { "The whole case".to_owned() } else { places.join(", ") };
        let rows = keys(node);
        let rows = rows.iter().map(|key| vec![format!("`{}`", key.name), value(key), default(key), meaning(key)]);
        out += &format!("\n## {title}\n\n{}", markdown::table(&["key", "value", "if left out", "meaning"], rows));
    }
    out.trim_start().to_owned()
}

/// Every object below, with its pointer; `N` stands for the place in a list.
fn collect(prefix: &str, node: &'static Value, objects: &mut Vec<(String, &'static Value)>) {
    for (key, inside) in keys(node).into_iter().filter_map(|key| Some((key, object(key.node)?))) {
        let list = if key.node["type"] == "array" { "/N" } else { "" };
        let pointer = format!("{prefix}/{}{list}", key.name);
        // A fabric inside a layup is described where the case's fabric is.
        let is_known = objects.iter().any(|(_, known)| known["properties"] == inside["properties"]);
        objects.push((pointer.clone(), inside));
        if !is_known {
            collect(&pointer, inside, objects);
        }
    }
}

/// The values of a key; of an object the keys are in a table of their own.
fn value(key: &Key) -> String {
    let text = expected(key.node);
    match text.split_once(" with \"") {
        Some((object, _)) => object.to_owned(),
        None => text,
    }
}

fn default(key: &Key) -> String {
    match (key.is_needed(), key.text("group").is_empty()) {
        (true, false) => "**one of the group**".to_owned(),
        (true, true) => "**required**".to_owned(),
        _ => left_out(key),
    }
}

fn meaning(key: &Key) -> String {
    let mut text = key.text("description").to_owned();
    if let Some((other, values)) = key.condition("only") {
        text += &format!(" Only where {other} is {}.", values.join(", "));
    }
    if !key.text("group").is_empty() {
        text += &format!(" Exactly one gives the {}.", key.text("group"));
    }
    if !key.text("with").is_empty() {
        text += &format!(" Only together with `{}`.", key.text("with"));
    }
    text
}

#[cfg(test)]
#[path = "schema_tests.rs"]
mod tests;
