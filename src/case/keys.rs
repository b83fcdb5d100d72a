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
use serde_json::{Map, Value, json};

use super::Case;
use super::error::{index, list, number_text, percent, quote, text_of, whole};

/// Unit of a key: its sign; SI = value · numerator / denominator, so that decimal factors round once.
pub(super) struct Unit(&'static str, f64, f64);

/// Units by the ends of the names of their keys; of several that fit the first is meant.
const UNITS: [(&str, Unit); 18] = [
    ("_deg", Unit("deg", PI, 180.0)),
    ("_mm", Unit("mm", 1.0, 1e3)),
    ("_mm_n13", Unit("mm·N^(1/3)", 1.0, 1e3)),
    ("_us", Unit("µs", 1.0, 1e6)),
    ("_m_s", Unit("m/s", 1.0, 1.0)),
    ("_rad_s", Unit("rad/s", 1.0, 1.0)),
    ("_g", Unit("g", 1.0, 1e3)),
    ("_g_mm2", Unit("g·mm²", 1.0, 1e9)),
    ("_kg_m3", Unit("kg/m³", 1.0, 1.0)),
    ("_g_m2", Unit("g/m²", 1.0, 1e3)),
    ("_denier", Unit("denier", 1.0, 9e6)),
    ("_tex", Unit("tex", 1.0, 1e6)),
    ("_dtex", Unit("dtex", 1.0, 1e7)),
    ("_per_inch", Unit("1/inch", 1e4, 254.0)),
    ("_per_cm", Unit("1/cm", 100.0, 1.0)),
    ("_gpa", Unit("GPa", 1e9, 1.0)),
    ("_mpa", Unit("MPa", 1e6, 1.0)),
    ("_n_per_m", Unit("N/m", 1.0, 1.0)),
];

/// A key's name without its unit, and the unit.
pub(super) fn split_unit(key: &str) -> (&str, Option<&'static Unit>) {
    let found = UNITS.iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?, Some(unit))));
    found.unwrap_or((key, None))
}

impl Unit {
    pub(super) fn to_si(&self, value: f64) -> f64 {
        value * self.1 / self.2
    }

    pub(super) fn of_si(&self, si: f64) -> f64 {
        si * self.2 / self.1
    }

    /// Turns a number of a document into SI units.
    pub(super) fn convert(&self, value: &mut Value) {
        if let Some(number) = value.as_f64() {
            *value = json!(self.to_si(number));
        }
    }
}

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
            #[allow(dead_code, reason = "of some choices nobody asks")]
            pub(crate) fn word(self) -> &'static str {
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
    if map.contains_key("without") && map.contains_key("properties") {
        map.insert("type".to_owned(), json!(["object", "null"]));
    }
    map.values_mut().for_each(tidy);
    let mut required = map.get("required").and_then(Value::as_array).cloned().unwrap_or_default();
    let Some(Value::Object(keys)) = map.get_mut("properties") else { return };
    for (name, key) in keys.iter_mut() {
        let Some(unit) = split_unit(name).1 else { continue };
        (if key.get("items").is_some() { &mut key["items"] } else { key })["unit"] = json!(unit.0);
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
        self.node["type"].is_array()
    }

    /// Another key and those of its values with which this one has a property.
    pub(super) fn condition(&self, property: &str) -> Option<(&'static str, Vec<&'static str>)> {
        self.node[property].as_object()?.iter().next().map(|(key, values)| (key.as_str(), strings(values)))
    }

    /// Whether the key has no value where it is left out, though it belongs there.
    pub(super) fn is_needed(&self) -> bool {
        let has = |property: &str| self.node.get(property).is_some();
        let depends = has("only") || has("group");
        self.required || depends && !["default", "derived", "without"].into_iter().any(has)
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
    collect("", &CASE, &mut objects);
    // A bar inside a cell does not end it.
    let cell =
        |text: String| if text.is_empty() { "| ".to_owned() } else { format!("| {} ", text.replace('|', "\\|")) };
    let row = |key: &Key| {
        let cells = [format!("`{}`", key.name), value(key), left_out(key), meaning(key)];
        cells.map(cell).concat() + "|\n"
    };
    let head = "| key | value | if left out | meaning |\n|---|---|---|---|\n";
    let rows = |node| keys(node).iter().map(row).collect::<String>();
    let tables: Vec<String> =
        objects.iter().map(|(title, node)| format!("## {title}\n\n{head}{}", rows(*node))).collect();
    tables.join("\n")
}

/// Every object below, with the pointers where it stands; `N` stands for the place in a list.
fn collect(prefix: &str, node: &'static Value, objects: &mut Vec<(String, &'static Value)>) {
    for (key, inside) in keys(node).into_iter().filter_map(|key| Some((key, object(key.node)?))) {
        let list = if key.node["type"] == "array" { "/N" } else { "" };
        let pointer = format!("{prefix}/{}{list}", key.name);
        match objects.iter_mut().find(|(_, known)| known["properties"] == inside["properties"]) {
            // A fabric inside a layup is described where the case's fabric is.
            Some((title, _)) => *title += &format!(", `{pointer}`"),
            None => {
                objects.push((format!("`{pointer}`"), inside));
                collect(&pointer, inside, objects);
            }
        }
    }
}

/// The values of a key; of an object the keys are in a table of their own.
fn value(key: &Key) -> String {
    let text = expected(key.node);
    text.split_once(" with \"").map_or(text.clone(), |(object, _)| object.to_owned())
}

/// The value of a key that is left out, and where it comes from.
fn left_out(key: &Key) -> String {
    match (key.node.get("default"), key.condition("where"), key.text("or").strip_prefix('/')) {
        _ if key.is_needed() && key.text("group").is_empty() => "**required**".to_owned(),
        _ if key.is_needed() => "**one of the group**".to_owned(),
        (Some(_), Some((other, values)), Some(or)) => {
            format!("required, or {or}, unless {other} is {}", values.join(" or "))
        }
        (Some(Value::Object(_)), ..) => String::new(),
        (Some(value), ..) => format!("{}, {}", text_of(value), key.text("source")),
        (None, ..) => format!("{}{}", key.text("derived"), key.text("without")),
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
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

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

    #[test]
    fn pointers_are_looked_up() {
        for (pointer, name) in
            [("/expect/3/at_us", "at_us"), ("/expect/0", "expect"), ("/pack/layup/12/fabric/warp/crimp", "crimp")]
        {
            assert_eq!(lookup(pointer).unwrap().name, name);
        }
        for pointer in ["/pack/layup/fabric", "/pack/layup/0/1", "/pack/layup/01", "", "/", "/title/0", "pack"] {
            assert!(lookup(pointer).is_none(), "{pointer}");
        }
    }
}
