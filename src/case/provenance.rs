//! Provenance: the fields of a case, each with where its value came from.

use std::cell::RefCell;

use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::error::{is_at_or_below, short_number_text, text_of, whole};
use super::keys::split_unit;
use super::keys::{Key, keys, lookup, order};
use super::{Case, CaseError, Layer, grading};

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

/// Where a field's value came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// From the case file or `--set`.
    Read,
    /// Not given: the documented default.
    Default,
    /// Computed from other fields.
    Derived,
}

impl Origin {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Default => "default",
            Self::Derived => "derived",
        }
    }
}

impl Field {
    /// The value with its unit.
    pub(crate) fn with_unit(&self) -> String {
        if self.unit.is_empty() || self.value == "none" {
            self.value.clone()
        } else {
            format!("{} {}", self.value, self.unit)
        }
    }
}

/// Whether a source text marks its field as assumed.
pub(super) fn is_assumed(source: &str) -> bool {
    source.starts_with("assumed")
}

/// Fields of a case in the making.
pub(super) struct Provenance {
    /// The case's `sources`: pointer and text.
    sources: Vec<(String, String)>,
    fields: RefCell<Vec<Field>>,
}

impl Provenance {
    /// A record for a document that has been checked; its values are recorded, and defaults put where a key is left out.
    pub(super) fn of(document: &mut Value) -> Self {
        let sources = document["sources"].as_object().into_iter().flatten();
        let sources = sources.map(|(pointer, text)| (pointer.clone(), text_of(text))).collect();
        let record = Self { sources, fields: RefCell::default() };
        record.complete("", &super::keys::CASE, document);
        record
    }

    /// Records the values of an object, and completes it with defaults.
    fn complete(&self, pointer: &str, node: &'static Value, object: &mut Value) {
        let keys = keys(node);
        for key in &keys {
            let place = format!("{pointer}/{}", key.name);
            let Some(value) = object.get_mut(key.name) else {
                self.complete_key(&place, key, &keys, object);
                continue;
            };
            if value.is_null() {
                self.note(&place, key, "none".to_owned(), Origin::Read, key.text("without"));
            } else if value.is_object() {
                self.complete(&place, key.node, value);
            } else if super::keys::object(key.node).is_none() || value.is_string() {
                self.note(&place, key, text_of(value), Origin::Read, self.source(&place));
                if let Some(number) = whole(value).filter(|_| key.node["type"] == "integer") {
                    // 2.0 is a whole number.
                    *value = json!(number);
                }
            } else if key.name == "layup" {
                for (index, item) in value.as_array_mut().into_iter().flatten().enumerate() {
                    self.complete(&format!("{place}/{index}"), key.node, item);
                }
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
                self.note(place, key, text_of(default), Origin::Default, key.text("source"));
            }
            object[key.name] = value;
        } else if !key.text("without").is_empty() {
            self.note(place, key, "none".to_owned(), Origin::Default, key.text("without"));
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

    fn note(&self, pointer: &str, key: &Key, value: String, origin: Origin, source: &str) {
        self.push(pointer, value, key.unit(), origin, source, is_assumed(source));
    }

    fn push(&self, pointer: &str, value: String, unit: &'static str, origin: Origin, source: &str, assumed: bool) {
        let (pointer, source) = (pointer.to_owned(), source.to_owned());
        self.fields.borrow_mut().push(Field { pointer, value, unit, origin, source, assumed });
    }

    /// Records an item of a list in one line.
    pub(super) fn summarise(&self, pointer: &str, value: String, source: &str) {
        self.push(pointer, value, "", Origin::Read, source, is_assumed(source));
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
        let (value, how) = (value.to_string(), if how.is_empty() { derived } else { how });
        // A word has no unit.
        let unit = if value.contains(|c: char| c.is_ascii_digit()) { unit } else { "" };
        self.push(pointer, value, unit, Origin::Derived, how, assumed);
    }

    /// The field at a pointer; of several recorded there the first.
    fn field<T>(&self, pointer: &str, of: impl Fn(&Field) -> T) -> Option<T> {
        self.fields.borrow().iter().find(|field| field.pointer == pointer).map(of)
    }

    /// Whether a field was recorded earlier.
    pub(super) fn has(&self, pointer: &str) -> bool {
        self.field(pointer, |_| ()).is_some()
    }

    /// Whether a field recorded earlier is assumed.
    pub(super) fn is_assumed(&self, pointer: &str) -> bool {
        self.field(pointer, |field| field.assumed).unwrap_or(false)
    }

    /// Whether any field recorded at or below a pointer is assumed.
    pub(super) fn is_any_assumed(&self, above: &str) -> bool {
        self.fields.borrow().iter().any(|field| field.assumed && is_at_or_below(&field.pointer, above))
    }

    /// A field recorded earlier: its value in its key's unit.
    pub(super) fn number(&self, pointer: &str) -> String {
        self.field(pointer, |field| field.value.clone()).unwrap_or_default()
    }

    /// A number recorded earlier [SI].
    pub(super) fn si(&self, pointer: &str) -> f64 {
        let number = self.number(pointer).parse().unwrap_or_default();
        split_unit(pointer).1.map_or(number, |unit| unit.to_si(number))
    }

    /// A field recorded earlier as the report shows it: value and unit.
    pub(super) fn value(&self, pointer: &str) -> String {
        self.field(pointer, Field::with_unit).unwrap_or_default()
    }

    /// The values of a field recorded earlier, or of those inside it, in their key's unit.
    pub(super) fn values_below(&self, above: &str) -> String {
        let fields = self.fields.borrow();
        let inside = fields.iter().filter(|field| is_at_or_below(&field.pointer, above));
        inside.map(|field| field.value.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The fields in the order of the keys.
    pub(super) fn into_fields(self) -> Vec<Field> {
        let mut fields = self.fields.into_inner();
        fields.sort_by_cached_key(|field| order(&field.pointer));
        fields
    }

    /// The text of the nearest source at or above a pointer.
    fn source(&self, pointer: &str) -> &str {
        let covers = |above: &str| is_at_or_below(pointer, above);
        let nearest = self.sources.iter().filter(|(above, _)| covers(above)).max_by_key(|(above, _)| above.len());
        nearest.map_or("case file", |(_, text)| text)
    }
}

/// Turns a completed document into SI units; its keys lose their units, and words for no object become null.
pub(super) fn in_si(node: &'static Value, value: &mut Value) {
    let is_none = |word: &String| node.get("none").is_some_and(|none| none == word);
    match value {
        Value::Object(map) if super::keys::object(node).is_some() => {
            for key in keys(node) {
                let Some(mut inside) = map.remove(key.name) else { continue };
                match (split_unit(key.name), inside.as_f64()) {
                    ((_, Some(unit)), Some(number)) => inside = json!(unit.to_si(number)),
                    ((_, Some(unit)), None) => inside
                        .as_array_mut()
                        .into_iter()
                        .flatten()
                        .for_each(|item| *item = json!(unit.to_si(item.as_f64().unwrap_or_default()))),
                    ((_, None), _) => in_si(key.node, &mut inside),
                }
                map.insert(split_unit(key.name).0.to_owned(), inside);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| in_si(&node["items"], item)),
        Value::String(word) if is_none(word) => *value = Value::Null,
        _ => {}
    }
}

/// The keys of an object that has been checked and completed.
pub(super) fn typed<K: DeserializeOwned>(pointer: &str, object: Value) -> Result<K, CaseError> {
    serde_json::from_value(object).map_err(|error| CaseError::at(pointer, "the keys of a case", error.to_string()))
}

/// Values longer than this do not widen their column.
const WIDEST_VALUE: usize = 40;

/// The title, the mesh, and every field: pointer, value, origin and source. Assumed fields begin with `*`.
pub fn report(case: &Case) -> String {
    let mut lines = vec![case.title.clone(), mesh(case), String::new()];
    let pointers = case.fields.iter().map(|field| field.pointer.chars().count()).max().unwrap_or(0);
    let values = case.fields.iter().map(|field| field.with_unit().chars().count());
    let values = values.filter(|width| *width <= WIDEST_VALUE).max().unwrap_or(0).max("value".len());
    lines.push(line("  field", "value", "origin", "source", [pointers + 2, values]));
    let mut group = "";
    for field in &case.fields {
        let top = field.pointer.split('/').nth(1).unwrap_or_default();
        if top != group && !group.is_empty() {
            lines.push(String::new());
        }
        group = top;
        let mark = if field.assumed { "* " } else { "  " };
        let pointer = format!("{mark}{}", field.pointer);
        lines.push(line(&pointer, &field.with_unit(), field.origin.word(), &field.source, [pointers + 2, values]));
    }
    let assumed = case.fields.iter().filter(|field| field.assumed).count();
    if assumed > 0 {
        lines.push(format!("\n* {assumed} of {} fields are assumed, not published", case.fields.len()));
    }
    lines.join("\n") + "\n"
}

/// The mesh of the pack; of a layup in one line per group, from the struck side.
pub(crate) fn mesh(case: &Case) -> String {
    let pack = &case.pack;
    if pack.layup.is_empty() {
        let mesh: Vec<String> = case.layers().iter().map(elements).collect();
        return format!("{}, {}", plies(pack.plies), mesh.join(""));
    }
    let line = |layer: &Layer| {
        let mesh = elements(layer);
        let turned = short_number_text(layer.orientation.to_degrees());
        format!("{} of {} at {turned}°, {mesh}", plies(layer.plies), layer.fabric.name)
    };
    pack.layup.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn plies(count: u32) -> String {
    format!("{count} {}", if count == 1 { "ply" } else { "plies" })
}

fn elements(layer: &Layer) -> String {
    let [x, y] = [layer.element_length_x, layer.element_length_y].map(|length| length * 1e3);
    let [width, height] = [layer.columns as f64 * x, layer.rows as f64 * y];
    let [columns, rows] = layer.counts();
    let from = if layer.grading.is_some() { "from " } else { "of " };
    let grown = layer.grading.map_or(String::new(), |g| format!(" ({})", grading::words(&g)));
    format!("{columns} × {rows} elements {from}{x:.4} × {y:.4} mm{grown}: {width:.2} × {height:.2} mm")
}

fn line(pointer: &str, value: &str, origin: &str, source: &str, [pointers, values]: [usize; 2]) -> String {
    let line = format!("{pointer:pointers$}  {value:values$}  {origin:7}  {source}");
    line.trim_end().to_owned()
}
