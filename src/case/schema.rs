//! The keys of the case file for others to read: as a JSON Schema, and as pages of documentation.

use std::iter::once;

use serde_json::{Map, Value, json};

use super::keys::{CASE, Key, keys, object, words};
use super::text::number_text;
use crate::markdown;

/// Properties of keys that JSON Schema does not know.
const OWN: [&str; 12] =
    ["title", "aliases", "source", "derived", "without", "where", "or", "only", "with", "group", "help", "file"];

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
            ("enum", _) => words(node).into_iter().flat_map(|word| once(word).chain(aliases(node, word))).collect(),
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
    let (unit, condition) = (key.unit(), key.condition("where").filter(|_| !key.text("or").is_empty()));
    let mut text = key.text("description").to_owned();
    if !unit.is_empty() {
        schema["unit"] = json!(unit);
        text += &format!(" [{unit}]");
    }
    text += &match (condition, key.text("source"), key.text("derived"), key.text("without")) {
        (Some((other, values)), ..) => format!(" Not needed where {other} is \"{}\".", values.join("\" or \"")),
        (None, "", "", "") => String::new(),
        (None, "", "", without) => format!(" Left out: {without}."),
        (None, source, how, _) => format!(" Default: {source}{how}."),
    };
    schema["description"] = json!(text);
    schema
}

/// Rules on which keys of an object stand together.
fn rules(keys: &[Key], schema: &mut Map<String, Value>) {
    let needed = |inside: &dyn Fn(&Key) -> bool| -> Vec<&str> {
        keys.iter()
            .filter(|key| key.is_needed() && key.text("group").is_empty() && inside(key))
            .map(|key| key.name)
            .collect()
    };
    // Exactly one key of each group.
    let one_of = |inside: &dyn Fn(&Key) -> bool| -> Vec<Value> {
        let mut groups: Vec<&str> = keys.iter().filter(|key| inside(key)).map(|key| key.text("group")).collect();
        groups.dedup();
        let members = |group: &str| -> Value {
            keys.iter().filter(|key| key.text("group") == group).map(|key| json!({"required": [key.name]})).collect()
        };
        groups.into_iter().filter(|group| !group.is_empty()).map(|group| json!({"oneOf": members(group)})).collect()
    };
    let only = |key: &Key| key.condition("only");
    schema.insert("required".to_owned(), json!(needed(&|key| only(key).is_none())));
    schema.insert("additionalProperties".to_owned(), json!(false));
    let pairs = keys.iter().filter(|key| !key.text("with").is_empty());
    let pairs: Map<String, Value> = pairs.map(|key| (key.name.to_owned(), json!([key.text("with")]))).collect();
    if !pairs.is_empty() {
        schema.insert("dependentRequired".to_owned(), Value::Object(pairs));
    }
    let mut all = one_of(&|key| only(key).is_none());
    for key in keys {
        if let (Some((other, values)), Some(or)) = (key.condition("where"), key.text("or").strip_prefix('/')) {
            let given = json!({"properties": {other: {"enum": values}}, "required": [other]});
            all.push(json!({"if": given, "else": {"anyOf": [{"required": [key.name]}, {"required": [or]}]}}));
        }
    }
    // For each value of a key that decides about others: those that are required, and those that do not belong.
    for decider in
        keys.iter().filter(|key| keys.iter().any(|other| only(other).is_some_and(|(name, _)| name == key.name)))
    {
        let flags = || vec![("false", json!(false)), ("true", json!(true))];
        let values: Vec<(&str, Value)> = words(decider.node).into_iter().map(|word| (word, json!(word))).collect();
        for (name, value) in if values.is_empty() { flags() } else { values } {
            let belongs = |key: &Key| only(key).is_some_and(|(_, values)| values.contains(&name));
            let same: Vec<Value> = once(value.clone()).chain(aliases(decider.node, name).map(Value::from)).collect();
            let mut condition = json!({"properties": {decider.name: {"enum": same}}});
            if decider.node.get("default") != Some(&value) {
                condition["required"] = json!([decider.name]);
            }
            let outside = keys.iter().filter(|key| only(key).is_some() && !belongs(key));
            let refused: Map<String, Value> = outside.map(|key| (key.name.to_owned(), json!(false))).collect();
            let mut then = json!({"properties": refused, "required": needed(&belongs)});
            let groups = one_of(&belongs);
            if !groups.is_empty() {
                then["allOf"] = Value::Array(groups);
            }
            all.push(json!({"if": condition, "then": then}));
        }
    }
    if !all.is_empty() {
        schema.insert("allOf".to_owned(), Value::Array(all));
    }
}

/// Other words that are read as a word of the case file.
fn aliases(node: &'static Value, word: &str) -> impl Iterator<Item = &'static str> {
    let aliases = node["aliases"].as_object().into_iter().flatten();
    aliases.filter(move |(_, meant)| *meant == word).map(|(alias, _)| alias.as_str())
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

/// The values of a key.
fn value(key: &Key) -> String {
    let unit = if key.unit().is_empty() { String::new() } else { format!(" [{}]", key.unit()) };
    let node = key.node;
    let span = |node: &Value| match (node["minimum"].as_f64(), node["exclusiveMinimum"].as_f64()) {
        (Some(min), _) => {
            format!("{} to {}", number_text(min), number_text(node["maximum"].as_f64().unwrap_or_default()))
        }
        (_, min) => format!("above {}, to {}", number_text(min.unwrap_or_default()), node["maximum"]),
    };
    let first = node["anyOf"].get(0).unwrap_or(node);
    match (node["type"].as_str(), words(first)) {
        (None, words) if !words.is_empty() => {
            let object = if node.get("anyOf").is_some() { ", or an object" } else { "" };
            all(&words.into_iter().flat_map(|word| once(word).chain(aliases(first, word))).collect::<Vec<_>>()) + object
        }
        (None, _) if node["anyOf"][1].get("pattern").is_some() => "number, or text such as `\"1%\"`".to_owned(),
        (None, _) => "number or text".to_owned(),
        (Some("string"), _) => "text".to_owned(),
        (Some("boolean"), _) => "`true` or `false`".to_owned(),
        (Some("number"), _) => format!("number{unit}, {}", span(node)),
        (Some("integer"), _) => format!("whole number, {} to {}", node["minimum"], node["maximum"]),
        (Some("array"), _) if object(node).is_some() => format!("list of up to {} objects", node["maxItems"]),
        (Some("array"), _) if node["minItems"] == node["maxItems"] => {
            format!("{} numbers{unit}, {}", node["maxItems"], span(&node["items"]))
        }
        (Some("array"), _) => format!("up to {} numbers{unit}, {}", node["maxItems"], span(&node["items"])),
        _ if node.get("file").is_some() => "object, or `{\"file\": …}`".to_owned(),
        _ if node.get("properties").is_some() => "object".to_owned(),
        _ => "object of texts".to_owned(),
    }
}

fn all(words: &[&str]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// The value of a key that is left out.
fn default(key: &Key) -> String {
    let or = key.text("or").strip_prefix('/');
    match (key.node.get("default"), key.condition("where"), or) {
        (Some(_), Some((other, values)), Some(or)) => {
            format!("**required**, or `{or}`, unless `{other}` is {}", all(&values))
        }
        (Some(Value::Object(_)), ..) => String::new(),
        (Some(Value::String(word)), ..) => format!("`{word}`: {}", key.text("source")),
        (Some(value), ..) => format!("`{value}`: {}", key.text("source")),
        (None, ..) if key.is_needed() && !key.text("group").is_empty() => "**one of the group**".to_owned(),
        (None, ..) if key.is_needed() => "**required**".to_owned(),
        (None, ..) => format!("{}{}", key.text("derived"), key.text("without")),
    }
}

fn meaning(key: &Key) -> String {
    let mut text = key.text("description").to_owned();
    if let Some((other, values)) = key.condition("only") {
        text += &format!(" Only with `{other}`: {}.", all(&values));
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
