//! Provenance: the fields of a case, each with where its value came from. And the keys of all cases for others to read: as a JSON Schema, and
//! as a page of documentation.

use std::cell::RefCell;

use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::changes::{BY, FLAG};
use super::error::{is_at_or_below, short_number_text, text_of, whole};
use super::keys::{CASE, Key, choices, expected, keys, lookup, object, order, walk};
use super::units::split_unit;
use super::{Case, CaseError, Layer};

/// One field of the case and where its value came from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Field {
    /// JSON pointer, e.g. `/fabric/warp/modulus_gpa`.
    pub pointer: String,
    /// Value in the key's unit, as text.
    pub value: String,
    /// Unit, empty when dimensionless.
    pub unit: &'static str,
    /// Read, defaulted or derived.
    pub origin: Origin,
    /// Where the value comes from: the case's `sources`, the default's source, or the formula.
    pub source: String,
    /// True when the value is assumed rather than published.
    pub assumed: bool,
}

choices! {
    /// Where a field's value came from.
    pub enum Origin {
        /// From the case file or `--set`.
        Read = "read",
        /// Not given: the documented default.
        Default = "default",
        /// Computed from other fields.
        Derived = "derived",
    }
}

impl Field {
    /// The value with its unit.
    pub fn with_unit(&self) -> String {
        let unit = if self.value == "none" { "" } else { self.unit };
        format!("{} {unit}", self.value).trim_end().to_owned()
    }
}

/// Whether a source text marks its field as assumed.
pub(super) fn is_assumed(source: &str) -> bool {
    source.starts_with("assumed")
}

/// The text of the nearest source at or above a pointer.
pub(super) fn source<'a>(sources: &'a Map<String, Value>, pointer: &str) -> Option<&'a str> {
    let above = sources.iter().filter(|(above, _)| is_at_or_below(pointer, above));
    above.max_by_key(|(above, _)| above.len())?.1.as_str()
}

/// Fields of a case that is being read.
pub(super) struct Provenance {
    /// The case's `sources`: pointer and text.
    sources: Map<String, Value>,
    fields: RefCell<Vec<Field>>,
}

impl Provenance {
    /// A record for a document that has been checked; its values are recorded, and defaults put where a key is left out.
    pub(super) fn of(document: &mut Value) -> Self {
        let sources = document["sources"].as_object().cloned().unwrap_or_default();
        let record = Self { sources, fields: RefCell::default() };
        record.complete("", &CASE, document);
        record
    }

    /// Records the values of an object, and completes it with defaults.
    fn complete(&self, pointer: &str, node: &'static Value, object: &mut Value) {
        let keys = keys(node);
        for key in &keys {
            let place = format!("{pointer}/{}", key.name);
            match object.get_mut(key.name) {
                None => self.complete_key(&place, key, &keys, object),
                Some(Value::Null) => {
                    self.note(&place, "none".to_owned(), key.unit(), Origin::Read, key.text("without"));
                }
                Some(inside @ Value::Object(_)) => self.complete(&place, key.node, inside),
                Some(Value::Array(items)) if key.name == "layup" => {
                    let groups = items.iter_mut().enumerate();
                    groups.for_each(|(index, group)| self.complete(&format!("{place}/{index}"), key.node, group));
                }
                Some(value) if super::keys::object(key.node).is_none() || value.is_string() => {
                    self.note(&place, text_of(value), key.unit(), Origin::Read, self.source(&place, key));
                    if let Some(number) = whole(value).filter(|_| key.node["type"] == "integer") {
                        // 2.0 is a whole number.
                        *value = json!(number);
                    }
                }
                Some(_) => {}
            }
        }
    }

    /// Records the default of a key that is left out, and puts it in its place.
    fn complete_key(&self, place: &str, key: &Key, keys: &[Key], object: &mut Value) {
        if !key.belongs(keys, object) {
            return;
        }
        if let Some(default) = key.default(keys, object) {
            let mut value = default.clone();
            if value.is_object() {
                self.complete(place, key.node, &mut value);
            } else {
                self.note(place, text_of(default), key.unit(), Origin::Default, key.text("source"));
            }
            object[key.name] = value;
        } else if !key.text("without").is_empty() {
            self.note(place, "none".to_owned(), key.unit(), Origin::Default, key.text("without"));
        }
    }

    /// The keys of the object at a pointer, all by default.
    pub(super) fn defaults<K: DeserializeOwned>(&self, pointer: &str) -> Result<K, CaseError> {
        let mut object = json!({});
        if let Some(key) = lookup(pointer) {
            self.complete(pointer, key.node, &mut object);
            in_si(key.node, &mut object);
        }
        typed(pointer, object)
    }

    /// Records a value; it is assumed where its source says so.
    pub(super) fn note(&self, pointer: &str, value: String, unit: &'static str, origin: Origin, source: &str) {
        let (pointer, source, assumed) = (pointer.to_owned(), source.to_owned(), is_assumed(source));
        self.fields.borrow_mut().push(Field { pointer, value, unit, origin, source, assumed });
    }

    /// Puts a number [SI] computed into the place of one that was left out, and records it; `how` is empty where the key says it.
    pub(super) fn fill(&self, pointer: &str, value: &mut f64, si: f64, how: &str, assumed: bool) {
        if !self.has(pointer) {
            *value = self.derive(pointer, si, how, assumed);
        }
    }

    /// Records a number [SI] computed for a key that was left out; `how` is empty where the key says it.
    pub(super) fn derive(&self, pointer: &str, si: f64, how: &str, assumed: bool) -> f64 {
        let value = split_unit(pointer).1.map_or(si, |unit| unit.of_si(si));
        self.derive_text(pointer, short_number_text(value), how, assumed);
        si
    }

    /// Records a value computed for a key that was left out, as text; `how` is empty where the key says it.
    pub(super) fn derive_text(&self, pointer: &str, value: impl ToString, how: &str, assumed: bool) {
        let (unit, derived) = lookup(pointer).map_or(("", ""), |key| (key.unit(), key.text("derived")));
        let value = value.to_string();
        // A word has no unit.
        let unit = if value.contains(|c: char| c.is_ascii_digit()) { unit } else { "" };
        self.note(pointer, value, unit, Origin::Derived, if how.is_empty() { derived } else { how });
        if let Some(field) = self.fields.borrow_mut().last_mut() {
            field.assumed = assumed;
        }
    }

    /// Fields recorded earlier at or below a pointer.
    fn below<T>(&self, above: &str, of: impl Fn(&Field) -> T) -> Vec<T> {
        self.fields.borrow().iter().filter(|field| is_at_or_below(&field.pointer, above)).map(of).collect()
    }

    /// Whether a field was recorded earlier, at or below a pointer.
    pub(super) fn has(&self, pointer: &str) -> bool {
        !self.below(pointer, |_| ()).is_empty()
    }

    /// Whether a field recorded earlier at or below a pointer is assumed.
    pub(super) fn is_assumed(&self, above: &str) -> bool {
        self.below(above, |field| field.assumed).contains(&true)
    }

    /// A number recorded earlier [SI].
    pub(super) fn si(&self, pointer: &str) -> Option<f64> {
        let number = self.below(pointer, |field| field.value.parse().ok()).into_iter().next().flatten()?;
        Some(split_unit(pointer).1.map_or(number, |unit| unit.to_si(number)))
    }

    /// Values recorded earlier at or below a pointer, in the units of their keys.
    pub(super) fn value(&self, above: &str) -> String {
        self.below(above, |field| field.value.clone()).join(", ")
    }

    /// The fields in the order of the keys.
    pub(super) fn into_fields(self) -> Vec<Field> {
        let mut fields = self.fields.into_inner();
        fields.sort_by_cached_key(|field| order(&field.pointer));
        fields
    }

    /// The text of the nearest source at or above the pointer of a key; of a key that needs a source of its own, that one.
    fn source(&self, pointer: &str, key: &Key) -> &str {
        if key.has("own_source") {
            let own = self.sources.get(pointer).and_then(Value::as_str).filter(|text| ![FLAG, BY].contains(text));
            return own.unwrap_or("assumed: the case names no source");
        }
        source(&self.sources, pointer).unwrap_or("case file")
    }
}

/// Turns a completed document into SI units; its keys lose their units, and words for no object become null.
pub(super) fn in_si(node: &'static Value, value: &mut Value) {
    match value {
        Value::Object(map) if object(node).is_some() => {
            for key in keys(node) {
                let Some(mut inside) = map.remove(key.name) else { continue };
                let (name, unit) = split_unit(key.name);
                match (unit, &mut inside) {
                    (Some(unit), Value::Array(items)) => items.iter_mut().for_each(|item| unit.convert(item)),
                    (Some(unit), number) => unit.convert(number),
                    (None, inside) => in_si(key.node, inside),
                }
                map.insert(name.to_owned(), inside);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| in_si(&node["items"], item)),
        Value::String(word) if node["none"] == *word => *value = Value::Null,
        _ => {}
    }
}

/// The keys of an object that has been checked and completed.
pub(super) fn typed<K: DeserializeOwned>(pointer: &str, object: Value) -> Result<K, CaseError> {
    serde_json::from_value(object).map_err(|error| CaseError::at(pointer, "the keys of a case", error.to_string()))
}

/// Values longer than this do not widen their column.
const WIDEST_VALUE: usize = 20;

/// The title, the mesh, and every field: pointer, value, origin and source. Assumed fields begin with `*`.
pub fn report(case: &Case) -> String {
    let row = |field: &Field| {
        let mark = if field.assumed { "* " } else { "  " };
        [format!("{mark}{}", field.pointer), field.with_unit(), field.origin.word().to_owned(), field.source.clone()]
    };
    let mut rows = vec![["  field", "value", "origin", "source"].map(str::to_owned)];
    rows.extend(case.fields.iter().map(row));
    let width = |column: usize, widest: usize| {
        rows.iter().map(|row| row[column].chars().count()).filter(|width| *width <= widest).max().unwrap_or(0)
    };
    let (pointers, values) = (width(0, usize::MAX), width(1, WIDEST_VALUE));
    let mut text = format!("{}\n{}\n\n", case.title, mesh(case));
    let mut group = "";
    for [pointer, value, origin, source] in &rows {
        let top = pointer.split('/').nth(1).unwrap_or_default();
        if top != group && !group.is_empty() {
            text.push('\n');
        }
        group = top;
        text += format!("{pointer:pointers$}  {value:values$}  {origin:7}  {source}").trim_end();
        text.push('\n');
    }
    let assumed = case.fields.iter().filter(|field| field.assumed).count();
    if assumed > 0 {
        text += &format!("\n* {assumed} of {} fields are assumed, not published\n", case.fields.len());
    }
    text
}

/// The mesh of the pack; of a layup in one line per group, from the struck side.
pub(crate) fn mesh(case: &Case) -> String {
    let line = |layer: &Layer| {
        let plies = format!("{} {}", layer.plies, if layer.plies == 1 { "ply" } else { "plies" });
        let turned = short_number_text(layer.orientation.to_degrees());
        let of =
            if case.pack.layup.is_empty() { plies } else { format!("{plies} of {} at {turned}°", layer.fabric.name) };
        let [x, y] = layer.mesh.length.map(|length| length * 1e3);
        let [width, height] = [layer.mesh.count[0] as f64 * x, layer.mesh.count[1] as f64 * y];
        let [columns, rows] = layer.counts();
        let (from, grown) = layer.mesh.grading.map_or(("of", String::new()), |g| ("from", format!(" ({})", g.words())));
        format!("{of}, {columns} × {rows} elements {from} {x:.4} × {y:.4} mm{grown}: {width:.2} × {height:.2} mm")
    };
    case.layers().iter().map(line).collect::<Vec<_>>().join("\n")
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

/// Adds other words that are read as those of a choice, and units as part of numbers.
fn publish(node: &mut Value) {
    match node {
        Value::Array(items) => items.iter_mut().for_each(publish),
        Value::Object(map) => {
            let aliases: Vec<Value> = map
                .get("aliases")
                .and_then(Value::as_object)
                .into_iter()
                .flatten()
                .map(|(alias, _)| json!(alias))
                .collect();
            map.get_mut("enum")
                .and_then(Value::as_array_mut)
                .into_iter()
                .for_each(|words| words.extend(aliases.clone()));
            if map.get("type").is_some_and(|kind| kind == "number") {
                map.insert("type".to_owned(), json!(["number", "string"]));
                map.insert("pattern".to_owned(), json!(r"^\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*[^0-9\s].*$"));
            }
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
        _ if key.is_needed() => {
            key.node["group"].as_str().map_or("**required**".to_owned(), |group| format!("**one gives the {group}**"))
        }
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
    let with = key.node["with"].as_str().map(|with| format!(" Only together with `{with}`."));
    [Some(key.text("description").to_owned()), only, with].into_iter().flatten().collect()
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
