//! The JSON Schema of the case file, from the table that the reader uses.

use serde_json::{Map, Value, json};

use super::fields::{AppliesIf, CaseKey, KeyType, NumberRange, Presence};
use super::table;
use super::words::aliases;

/// The case file as a JSON Schema (2020-12): keys, types, ranges, defaults, units and meaning.
pub fn schema() -> Value {
    let mut schema = object(table::CASE);
    let head = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "ripstop case",
        "description": "One impact of a woven fabric. Every key that is not required has a default that is named here.",
    });
    if let (Value::Object(schema), Value::Object(mut head)) = (&mut schema, head) {
        head.append(schema);
        return Value::Object(head);
    }
    schema
}

fn object(keys: &[CaseKey]) -> Value {
    let mut schema = Map::new();
    schema.insert("type".to_owned(), json!("object"));
    let properties: Map<String, Value> = keys.iter().map(|key| (key.name.to_owned(), property(key))).collect();
    schema.insert("properties".to_owned(), Value::Object(properties));
    schema.insert("required".to_owned(), json!(required(keys.iter().filter(|key| key.only.is_none()))));
    schema.insert("additionalProperties".to_owned(), json!(false));
    let pairs: Map<String, Value> =
        keys.iter().filter(|key| !key.with.is_empty()).map(|key| (key.name.to_owned(), json!([key.with]))).collect();
    if !pairs.is_empty() {
        schema.insert("dependentRequired".to_owned(), Value::Object(pairs));
    }
    let mut rules = groups(keys.iter().filter(|key| key.only.is_none()));
    rules.extend(keys.iter().filter_map(required_unless));
    rules.extend(discriminators(keys).into_iter().flat_map(|key| variants(key, keys)));
    if !rules.is_empty() {
        schema.insert("allOf".to_owned(), Value::Array(rules));
    }
    Value::Object(schema)
}

fn required<'a>(keys: impl Iterator<Item = &'a CaseKey>) -> Vec<&'static str> {
    keys.filter(|key| matches!(key.presence, Presence::Required) && key.group.is_empty()).map(|key| key.name).collect()
}

/// Exactly one key of each group.
fn groups<'a>(keys: impl Iterator<Item = &'a CaseKey>) -> Vec<Value> {
    let mut groups: Vec<(&str, Vec<Value>)> = Vec::new();
    for key in keys.filter(|key| !key.group.is_empty()) {
        let one = json!({"required": [key.name]});
        match groups.iter_mut().find(|(group, _)| *group == key.group) {
            Some((_, members)) => members.push(one),
            None => groups.push((key.group, vec![one])),
        }
    }
    groups.into_iter().map(|(_, members)| json!({"oneOf": members})).collect()
}

fn required_unless(key: &CaseKey) -> Option<Value> {
    let Presence::RequiredUnless(other, word, ..) = key.presence else { return None };
    let needed = match key.instead {
        "" => json!({"required": [key.name]}),
        instead => json!({"anyOf": [{"required": [key.name]}, {"required": [instead]}]}),
    };
    Some(json!({"if": {"properties": {other: {"const": word}}, "required": [other]}, "else": needed}))
}

/// The keys that decide which others belong.
fn discriminators(keys: &[CaseKey]) -> Vec<&CaseKey> {
    let decides = |key: &&CaseKey| keys.iter().any(|other| other.only.is_some_and(|only| only.key == key.name));
    keys.iter().filter(decides).collect()
}

/// For each value of a deciding key: the keys that are required and those that do not belong.
fn variants(decider: &CaseKey, keys: &[CaseKey]) -> Vec<Value> {
    let values: Vec<(&str, Value)> = match decider.kind {
        KeyType::Word(words) => words.iter().map(|word| (*word, json!(word))).collect(),
        _ => vec![("false", json!(false)), ("true", json!(true))],
    };
    let default = if let Presence::Default(literal, _) = decider.presence { Some(literal.value()) } else { None };
    let belongs = |key: &&CaseKey, value: &str| match key.only {
        Some(AppliesIf { key, values }) => key == decider.name && values.contains(&value),
        None => false,
    };
    let variant = |(name, value): (&str, Value)| {
        let values: Vec<Value> = std::iter::once(value.clone()).chain(aliases(name).map(Value::from)).collect();
        let mut condition = json!({"properties": {decider.name: {"enum": values}}});
        if default.as_ref() != Some(&value) {
            condition["required"] = json!([decider.name]);
        }
        let inside: Vec<&CaseKey> = keys.iter().filter(|key| belongs(key, name)).collect();
        let outside = keys.iter().filter(|key| key.only.is_some() && !belongs(key, name));
        let refused: Map<String, Value> = outside.map(|key| (key.name.to_owned(), json!(false))).collect();
        let required = required(inside.iter().copied());
        let groups = groups(inside.iter().copied());
        let mut then = json!({"properties": refused, "required": required});
        if !groups.is_empty() {
            then["allOf"] = Value::Array(groups);
        }
        json!({"if": condition, "then": then})
    };
    values.into_iter().map(variant).collect()
}

fn property(key: &CaseKey) -> Value {
    let mut schema = match key.kind {
        KeyType::Text => json!({"type": "string", "minLength": 1}),
        KeyType::Flag => json!({"type": "boolean"}),
        KeyType::Number(_, range) => number(range),
        KeyType::Whole(min, max) => json!({"type": "integer", "minimum": min, "maximum": max}),
        KeyType::Numbers(_, range, [min, max]) => {
            json!({"type": "array", "items": number(range), "minItems": min, "maxItems": max})
        }
        KeyType::Word(words) => {
            json!({"enum": words.iter().flat_map(|word| std::iter::once(*word).chain(aliases(word))).collect::<Vec<_>>()})
        }
        KeyType::Object(keys) => object(keys),
        KeyType::WordOrObject(words, keys) => json!({"anyOf": [{"enum": words}, object(keys)]}),
        KeyType::ObjectOrFile(keys) => json!({"anyOf": [file(), object(keys)]}),
        KeyType::Items(keys, [min, max]) => {
            json!({"type": "array", "items": object(keys), "minItems": min, "maxItems": max})
        }
        KeyType::NumberOrText(range) => json!({"anyOf": [number(range), {"type": "string"}]}),
        KeyType::NumberOrPercent(range) => json!({"anyOf": [number(range), {"type": "string", "pattern": "%$"}]}),
        KeyType::Sources => json!({
            "type": "object",
            "propertyNames": {"pattern": "^(/.*)?$"},
            "additionalProperties": {"type": "string"},
        }),
    };
    if key.is_nullable() {
        schema["type"] = json!(["object", "null"]);
    }
    if let Presence::Default(literal, _) | Presence::RequiredUnless(_, _, literal, _) = key.presence {
        schema["default"] = literal.value();
    }
    if !key.unit().is_empty() {
        schema["unit"] = json!(key.unit());
    }
    schema["description"] = json!(description(key));
    schema
}

fn number(range: NumberRange) -> Value {
    let minimum = if range.min_included { "minimum" } else { "exclusiveMinimum" };
    json!({"type": "number", minimum: range.min, "maximum": range.max})
}

fn file() -> Value {
    json!({
        "type": "object",
        "properties": {"file": {"type": "string", "description": "A file with the keys of a fabric, in the case's folder."}},
        "required": ["file"],
        "additionalProperties": false,
    })
}

/// The meaning of a key with its unit and its default.
fn description(key: &CaseKey) -> String {
    let mut text = key.doc.to_owned();
    if !key.unit().is_empty() {
        text += &format!(" [{}]", key.unit());
    }
    match key.presence {
        Presence::Default(_, source) => text += &format!(" Default: {source}."),
        Presence::Derived(how) => text += &format!(" Default: {how}."),
        Presence::Optional(without) if !without.is_empty() => text += &format!(" Left out: {without}."),
        Presence::RequiredUnless(other, word, ..) => text += &format!(" Not needed where {other} is \"{word}\"."),
        Presence::Required | Presence::Optional(_) => {}
    }
    text
}
