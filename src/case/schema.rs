//! The keys of the case file for others to read: as a JSON Schema, and as a page of documentation.

use serde_json::{Value, json};

use super::error::text_of;
use super::keys::{CASE, Key, expected, keys, object, walk};

/// The case file as a JSON Schema (2020-12): keys, types, ranges, defaults, units and meaning.
pub fn schema() -> Value {
    let mut schema = CASE.clone();
    publish(&mut schema);
    schema["title"] = json!("ripstop case");
    schema["description"] =
        json!("One impact of a woven fabric. Every key that is not required has a default that is named here.");
    let file = json!({"type": "string", "description": "A file with the keys of a fabric, in the case's folder."});
    let file = json!({"properties": {"file": file}, "required": ["file"], "additionalProperties": false});
    for place in ["/properties/fabric", "/properties/pack/properties/layup/items/properties/fabric"] {
        if let Some(fabric) = schema.pointer_mut(place) {
            *fabric = json!({"anyOf": [file, fabric.take()]});
        }
    }
    schema
}

/// Adds other words that are read as those of a choice.
fn publish(node: &mut Value) {
    match node {
        Value::Array(items) => items.iter_mut().for_each(publish),
        Value::Object(map) => {
            let aliases = map.get("aliases").and_then(Value::as_object).into_iter().flatten();
            let aliases: Vec<Value> = aliases.map(|(alias, _)| json!(alias)).collect();
            map.get_mut("enum")
                .and_then(Value::as_array_mut)
                .into_iter()
                .for_each(|words| words.extend(aliases.clone()));
            map.values_mut().for_each(publish);
        }
        _ => {}
    }
}

/// Every key of the case file in Markdown: one table for each object, with the pointers where it stands.
pub fn reference() -> String {
    let mut objects = vec![("The whole case".to_owned(), &*CASE)];
    walk("", &CASE, &mut |pointer, key| {
        let Some(inside) = object(key.node) else { return false };
        let place = format!("`{pointer}{}`", if key.node["type"] == "array" { "/N" } else { "" });
        // A fabric inside a layup is described where the case's fabric is.
        let known = objects.iter_mut().find(|(_, known)| known["properties"] == inside["properties"]);
        let is_new = known.map(|(title, _)| *title += &format!(", {place}")).is_none();
        if is_new {
            objects.push((place, inside));
        }
        is_new
    });
    // A bar inside a cell does not end it.
    let cell =
        |text: String| if text.is_empty() { "| ".to_owned() } else { format!("| {} ", text.replace('|', "\\|")) };
    let row = |key: Key| [format!("`{}`", key.name), value(&key), left_out(&key), meaning(&key)].map(cell).concat();
    let table = |(title, node): (String, &'static Value)| {
        let rows: String = keys(node).into_iter().map(|key| row(key) + "|\n").collect();
        format!("## {title}\n\n| key | value | if left out | meaning |\n|---|---|---|---|\n{rows}")
    };
    objects.into_iter().map(table).collect::<Vec<_>>().join("\n")
}

/// The values of a key; of an object the keys are in a table of their own.
fn value(key: &Key) -> String {
    let text = expected(key.node);
    text.split_once(" with \"").map_or(text.clone(), |(object, _)| object.to_owned())
}

/// The value of a key that is left out, and where it comes from.
fn left_out(key: &Key) -> String {
    match (key.node.get("default"), key.condition("where"), key.text("or").strip_prefix('/')) {
        _ if key.is_needed() => format!("**{}**", if key.has("group") { "one of the group" } else { "required" }),
        (Some(_), Some((other, values)), Some(or)) => {
            format!("required, or {or}, unless {other} is {}", values.join(" or "))
        }
        (Some(Value::Object(_)), ..) => String::new(),
        (Some(value), ..) => format!("{}, {}", text_of(value), key.text("source")),
        (None, ..) => format!("{}{}", key.text("derived"), key.text("without")),
    }
}

/// Meaning of a key, and the keys beside which it stands.
fn meaning(key: &Key) -> String {
    let only = key.condition("only").map(|(other, values)| format!(" Only where {other} is {}.", values.join(", ")));
    let group = key.node["group"].as_str().map(|group| format!(" Exactly one gives the {group}."));
    let with = key.node["with"].as_str().map(|with| format!(" Only together with `{with}`."));
    [Some(key.text("description").to_owned()), only, group, with].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::case::keys::{accepts, lookup, pointers};

    #[test]
    fn every_key_has_a_row_and_every_default_is_a_value_of_its_key_with_a_source() {
        let (all, reference) = (pointers(), reference());
        assert!(all.len() > 100, "{}", all.len());
        for pointer in all {
            let key = lookup(&pointer).unwrap();
            assert!(key.text("description").ends_with('.'), "{pointer}");
            assert!(reference.contains(&format!("\n| `{}` |", key.name)), "{pointer}");
            if let Some(default) = key.node.get("default") {
                assert!(accepts(key.node, default), "{pointer}");
                assert!(default.is_object() || !key.text("source").is_empty(), "{pointer}");
            }
        }
    }
}
