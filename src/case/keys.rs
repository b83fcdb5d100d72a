//! Every key of the case file: the schema of the types that hold them, and what stands in a document against it.
//!
//! A key is written once, as a field of such a type, with its range and its doc comment. Its unit is the end of its name; the SI unit that the
//! comment ends in is that of the field. A last paragraph says what holds where the key is left out: "Default:" and the source of the
//! default, "Otherwise:" and how the value is computed, or "Left out:" and what that means. Besides the schema has, as the field says:
//! - `default`: the value where the key is left out; `where`: the value of another key with which that holds;
//! - `or`: what may be given in its place, as a pointer from its object;
//! - `only`: the values of another key beside which it belongs; `with`: a key that must be given beside it;
//! - `group`: a name that it shares with others, of which exactly one is given;
//! - `help`: what to say of a value out of range; `none`: the word that stands for no object.

use std::f64::consts::PI;
use std::sync::LazyLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::CaseKeys;
use super::error::{index, json_number, list, number_text, percent, quote, text_of, whole};

/// Unit of a key: SI = value · numerator / denominator, so that decimal factors round once.
pub(super) struct Unit {
    /// End of the names of its keys.
    end: &'static str,
    /// Sign of the unit.
    pub(super) name: &'static str,
    numerator: f64,
    denominator: f64,
}

/// Units by the ends of the names of their keys; of several that fit the first is meant.
#[rustfmt::skip]
const UNITS: [Unit; 18] = [
    Unit { end: "_deg", name: "deg", numerator: PI, denominator: 180.0 },
    Unit { end: "_mm", name: "mm", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_mm_n13", name: "mm·N^(1/3)", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_us", name: "µs", numerator: 1.0, denominator: 1e6 },
    Unit { end: "_m_s", name: "m/s", numerator: 1.0, denominator: 1.0 },
    Unit { end: "_rad_s", name: "rad/s", numerator: 1.0, denominator: 1.0 },
    Unit { end: "_g", name: "g", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_g_mm2", name: "g·mm²", numerator: 1.0, denominator: 1e9 },
    Unit { end: "_kg_m3", name: "kg/m³", numerator: 1.0, denominator: 1.0 },
    Unit { end: "_g_m2", name: "g/m²", numerator: 1.0, denominator: 1e3 },
    Unit { end: "_denier", name: "denier", numerator: 1.0, denominator: 9e6 },
    Unit { end: "_tex", name: "tex", numerator: 1.0, denominator: 1e6 },
    Unit { end: "_dtex", name: "dtex", numerator: 1.0, denominator: 1e7 },
    Unit { end: "_per_inch", name: "1/inch", numerator: 1e4, denominator: 254.0 },
    Unit { end: "_per_cm", name: "1/cm", numerator: 100.0, denominator: 1.0 },
    Unit { end: "_gpa", name: "GPa", numerator: 1e9, denominator: 1.0 },
    Unit { end: "_mpa", name: "MPa", numerator: 1e6, denominator: 1.0 },
    Unit { end: "_n_per_m", name: "N/m", numerator: 1.0, denominator: 1.0 },
];

/// A key's name without its unit, and the unit.
pub(super) fn split_unit(key: &str) -> (&str, Option<&'static Unit>) {
    let found = UNITS.iter().find_map(|unit| Some((key.strip_suffix(unit.end)?, Some(unit))));
    found.unwrap_or((key, None))
}

impl Unit {
    pub(super) fn to_si(&self, value: f64) -> f64 {
        value * self.numerator / self.denominator
    }

    pub(super) fn of_si(&self, si: f64) -> f64 {
        si * self.denominator / self.numerator
    }
}

/// A word, or the object that stands in its place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum WordOr<W, K> {
    Word(W),
    Keys(K),
}

/// A choice that the case file names by a word.
pub(crate) trait Word: Copy {
    /// The word of the case file.
    fn word(self) -> &'static str;
}

/// Choices with the word of the case file for each, and other words that are read as it.
macro_rules! choices {
    ($($(#[$doc:meta])* $vis:vis enum $name:ident {
        $($(#[$about:meta])* $variant:ident = $word:literal $(or $alias:literal)*,)+
    })+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Deserialize)]
        $vis enum $name {
            $($(#[$about])* #[serde(rename = $word)] $variant,)+
        }

        impl $crate::case::keys::Word for $name {
            fn word(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)+
                }
            }
        }

        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({"enum": [$($word),+], "aliases": {$($($alias: $word,)*)+}})
            }
        }
    )+};
}
pub(super) use choices;

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
            if let Some(text) = map.get("description").and_then(Value::as_str).map(str::to_owned) {
                document(map, &text);
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

/// Puts what a doc comment says into a schema: what the key means, without the SI unit, and what holds where it is left out.
fn document(map: &mut Map<String, Value>, text: &str) {
    for paragraph in text.split("\n\n").map(|paragraph| paragraph.replace('\n', " ")) {
        let without = [("Default: ", "source"), ("Otherwise: ", "derived"), ("Left out: ", "without")];
        let found = without.iter().find_map(|(word, property)| Some((property, paragraph.strip_prefix(word)?)));
        let (property, text) = match (found, paragraph.strip_suffix("].").and_then(|text| text.rsplit_once(" ["))) {
            (Some((property, text)), _) => (*property, text.strip_suffix('.').unwrap_or(text).to_owned()),
            (None, Some((text, _))) => ("description", format!("{text}.")),
            (None, None) => ("description", paragraph),
        };
        map.insert(property.to_owned(), Value::from(text));
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
    pub(super) fn is_missing(&self, keys: &[Self], object: &Value) -> bool {
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
pub(super) fn value_of(name: &str, keys: &[Key], object: &Value) -> Option<String> {
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
pub(super) fn accepts(node: &Value, value: &Value) -> bool {
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
pub(super) fn fits<'a>(node: &Value, value: &'a Value) -> Option<&'a Vec<Value>> {
    let bound = |name: &str, none: u64| node[name].as_u64().unwrap_or(none);
    let lengths = bound("minItems", 0)..=bound("maxItems", u64::MAX);
    value.as_array().filter(|items| lengths.contains(&(items.len() as u64)))
}

/// Values that a schema describes, in words.
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

#[cfg(test)]
#[path = "keys_tests.rs"]
mod tests;
