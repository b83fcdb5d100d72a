//! Every key of the case file: the schema of the types that hold them, and the errors of a document that breaks it.
//!
//! A key is written once, as a field of such a type, with its range and its doc comment. Its unit is the end of its name; the SI unit that the
//! comment ends in is that of the field. A last paragraph says what holds where the key is left out: "Default:" and the source of the
//! default, "Otherwise:" and how the value is computed, or "Left out:" and what that means. Properties of the schema that a field may state:
//! - `default`: the value where the key is left out; `where`: the value of another key with which that holds;
//! - `or`: what may be given in its place, as a pointer from its object;
//! - `only`: the values of another key beside which it belongs; `with`: a key that must be given beside it;
//! - `at_most`: another key, whose value is the largest;
//! - `group`: a name that it shares with others, of which exactly one is given;
//! - `own_source`: that it is assumed where only its object has a source;
//! - `help`: what to say of a value out of range; `none`: the word that stands for no object.

use std::sync::LazyLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::Case;
use super::error::{index, list, number_text, percent, quote, text_of, whole};
use super::units::split_unit;

/// A word, or the object that stands in its place.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum WordOr<W, K> {
    Word(W),
    Keys(K),
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

        impl $name {
            /// The word of the case file.
            #[allow(dead_code, unreachable_pub, reason = "some choices are read alone")]
            pub fn word(self) -> &'static str {
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
                schemars::json_schema!({"type": "string", "enum": [$($word),+], "aliases": {$($($alias: $word,)*)+}})
            }
        }
    )+};
}
pub(super) use choices;

/// The schema of a case, every object in its place.
pub(super) static CASE: LazyLock<Value> = LazyLock::new(|| {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<Case>().to_value();
    tidy(&mut schema);
    schema
});

/// Leaves out null, which stands for an optional field of Rust, and formats of numbers; reads doc comments; completes objects.
fn tidy(node: &mut Value) {
    let map = match node {
        Value::Object(map) => map,
        Value::Array(items) => return items.iter_mut().for_each(tidy),
        _ => return,
    };
    if let Some(choices) = map.get("anyOf").and_then(|optional| optional[0].get("anyOf")).cloned() {
        map.insert("anyOf".to_owned(), choices);
    }
    if let Some(Value::Array(words)) = map.get_mut("enum") {
        words.retain(|word| !word.is_null());
    }
    if let Some(kind) = map.get("type").and_then(|kind| kind.get(0)).cloned() {
        map.insert("type".to_owned(), kind);
    }
    if let Some(text) = map.get("description").and_then(Value::as_str).map(str::to_owned) {
        document(map, &text);
    }
    if map.contains_key("derived") {
        map.shift_remove("default");
    }
    if map.contains_key("without") && map.contains_key("properties") {
        map.insert("type".to_owned(), json!(["object", "null"]));
    }
    map.values_mut().for_each(tidy);
    let mut required = map.get("required").and_then(Value::as_array).cloned().unwrap_or_default();
    let Some(Value::Object(keys)) = map.get_mut("properties") else { return };
    for (name, key) in keys.iter_mut() {
        let Some(unit) = split_unit(name).1 else { continue };
        (if key.get("items").is_some() { &mut key["items"] } else { key })["unit"] = json!(unit.sign());
    }
    let has_value = |key: &Value| ["default", "derived", "without", "only"].iter().any(|word| key.get(word).is_some());
    required.retain(|name| name.as_str().is_none_or(|name| !has_value(&keys[name])));
    map.insert("required".to_owned(), Value::Array(required));
    map.insert("additionalProperties".to_owned(), json!(false));
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
    /// Whether it has to be given in any case.
    required: bool,
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
    properties.map(|(name, node)| Key { name, node, required: required.contains(&name.as_str()) }).collect()
}

/// The strings of a list, or a string alone.
pub(super) fn strings(value: &Value) -> Vec<&str> {
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

    /// Another key and those of its values with which this one has a property.
    pub(super) fn condition(&self, property: &str) -> Option<(&'static str, Vec<&'static str>)> {
        self.node[property].as_object()?.iter().next().map(|(key, values)| (key.as_str(), strings(values)))
    }

    /// Whether such a condition holds; `None` where there is none, or where the other key is itself wrong.
    fn holds(&self, property: &str, keys: &[Self], object: &Value) -> Option<bool> {
        let (other, values) = self.condition(property)?;
        value_of(other, keys, object).map(|found| values.contains(&found.as_str()))
    }

    pub(super) fn has(&self, property: &str) -> bool {
        self.node.get(property).is_some()
    }

    /// Whether the key has no value where it is left out, though it belongs there.
    pub(super) fn is_needed(&self) -> bool {
        let depends = self.has("only") || self.has("group");
        self.required || depends && !["default", "derived", "without"].into_iter().any(|property| self.has(property))
    }

    /// Whether what may stand in its place is given.
    fn is_replaced(&self, object: &Value) -> bool {
        object.pointer(self.text("or")).is_some_and(|other| other != object)
    }

    /// Whether it belongs beside the other keys of its object; one that is itself wrong decides nothing.
    pub(super) fn belongs(&self, keys: &[Self], object: &Value) -> bool {
        self.holds("only", keys, object) != Some(false)
    }

    /// Whether it has to be given.
    pub(super) fn is_missing(&self, keys: &[Self], object: &Value) -> bool {
        if self.has("where") && self.has("or") {
            return !self.is_replaced(object) && self.holds("where", keys, object) != Some(true);
        }
        let is_decided = !self.has("only") || self.holds("only", keys, object).is_some();
        self.is_needed() && !self.has("group") && is_decided
    }

    /// The value where it is left out.
    pub(super) fn default(&self, keys: &[Self], object: &Value) -> Option<&'static Value> {
        let holds = !self.has("where") || self.holds("where", keys, object) == Some(true);
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

/// Visits every key below an object with its pointer, in which `N` stands for the place in a list; below a key where `visit` says so.
pub(super) fn walk(prefix: &str, node: &'static Value, visit: &mut dyn FnMut(&str, &Key) -> bool) {
    for key in keys(node) {
        let pointer = format!("{prefix}/{}", key.name);
        if visit(&pointer, &key) {
            let list = if key.node["type"] == "array" { "/N" } else { "" };
            walk(&format!("{pointer}{list}"), key.node, visit);
        }
    }
}

/// Every pointer; those below a list are left out.
pub(super) fn pointers() -> Vec<String> {
    let mut pointers = Vec::new();
    walk("", &CASE, &mut |pointer, key| {
        pointers.push(pointer.to_owned());
        key.node["type"] != "array"
    });
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
        Some("array") => fits(node, value).is_some(),
        _ => value.is_object(),
    }
}

/// The items of a list, its own, of an allowed length.
pub(super) fn fits<'a>(node: &Value, value: &'a Value) -> Option<&'a Vec<Value>> {
    let bound = |name: &str, none: u64| node[name].as_u64().unwrap_or(none);
    let lengths = bound("minItems", 0)..=bound("maxItems", u64::MAX);
    value.as_array().filter(|items| node["type"] == "array" && lengths.contains(&(items.len() as u64)))
}

/// Values that a schema describes, in words.
pub(super) fn expected(node: &'static Value) -> String {
    if let Some(choices) = node["anyOf"].as_array() {
        let or = if choices.iter().any(|choice| choice.get("pattern").is_some()) { ", or " } else { " or " };
        return choices.iter().map(expected).collect::<Vec<_>>().join(or);
    }
    if node.get("enum").is_some() {
        return list(strings(&node["enum"]));
    }
    let number = |name: &str| number_text(node[name].as_f64().unwrap_or_default());
    let unit = node["unit"].as_str().map(|unit| format!(" {unit}")).unwrap_or_default();
    let names = |keys: Vec<Key>| keys.iter().map(|key| quote(key.name)).collect::<Vec<_>>().join(", ");
    match node["type"].as_str() {
        Some("string") if node.get("pattern").is_some() => {
            "a percentage from \"0%\" to \"100%\" of the value".to_owned()
        }
        Some("string") => if node.get("minLength").is_some() { "text" } else { "a word" }.to_owned(),
        Some("boolean") => "true or false".to_owned(),
        Some("number") if node.get("exclusiveMinimum").is_some() => {
            format!("a number in ({}, {}]{unit}", number("exclusiveMinimum"), number("maximum"))
        }
        Some("number") => format!("a number in [{}, {}]{unit}", number("minimum"), number("maximum")),
        Some("integer") => format!("a whole number in [{}, {}]", node["minimum"], node["maximum"]),
        Some("array") => {
            let one = expected(&node["items"]);
            let many = one
                .replacen("a number", "numbers", 1)
                .replacen("an object", "objects", 1)
                .replacen("a list", "lists", 1);
            match (number("minItems"), number("maxItems")) {
                (min, max) if min == "0" => format!("a list of at most {max} {many}"),
                (min, max) if min == max => format!("a list of {max} {many}"),
                (min, max) => format!("a list of {min} to {max} {many}"),
            }
        }
        _ if node.get("properties").is_some() => {
            let needed: Vec<Key> = keys(node).into_iter().filter(|key| key.is_needed() && !key.has("group")).collect();
            format!("an object with {}", names(if needed.is_empty() { keys(node) } else { needed }))
        }
        _ => "an object of JSON pointers and texts".to_owned(),
    }
}
