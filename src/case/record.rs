//! The fields of a case as they are read, each with its source.

use std::cell::RefCell;

use serde_json::Value;

use super::pointer::is_at_or_below;
use super::{Field, table};

/// What is gathered while a case is read.
#[derive(Default)]
pub(super) struct Provenance {
    /// The case's `sources`: pointer and text.
    sources: Vec<(String, String)>,
    fields: RefCell<Vec<Field>>,
}

impl Provenance {
    /// A record for a case with these sources.
    pub(super) fn new(sources: Option<&Value>) -> Self {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let sources = sources.and_then(Value::as_object);
        let sources = sources.into_iter().flatten().map(|(pointer, value)| (pointer.clone(), text(value))).collect();
        Self { sources, fields: RefCell::default() }
    }

    pub(super) fn push(&self, field: Field) {
        self.fields.borrow_mut().push(field);
    }

    /// Whether a field was recorded earlier.
    pub(super) fn has(&self, pointer: &str) -> bool {
        self.fields.borrow().iter().any(|field| field.pointer == pointer)
    }

    /// Whether a field recorded earlier is assumed.
    pub(super) fn is_assumed(&self, pointer: &str) -> bool {
        self.fields.borrow().iter().any(|field| field.pointer == pointer && field.assumed)
    }

    /// Whether anything recorded inside one of these objects is assumed.
    pub(super) fn any_assumed_below(&self, above: &[&str]) -> bool {
        let inside = |field: &Field| above.iter().any(|above| is_at_or_below(&field.pointer, above));
        self.fields.borrow().iter().any(|field| field.assumed && inside(field))
    }

    /// A field recorded earlier as the report shows it: value and unit.
    pub(super) fn value(&self, pointer: &str) -> String {
        let fields = self.fields.borrow();
        fields.iter().find(|field| field.pointer == pointer).map(Field::with_unit).unwrap_or_default()
    }

    /// The values of a field recorded earlier, or of those inside it, in their key's unit.
    pub(super) fn values_below(&self, above: &str) -> String {
        let fields = self.fields.borrow();
        let inside = fields.iter().filter(|field| is_at_or_below(&field.pointer, above));
        inside.map(|field| field.value.as_str()).collect::<Vec<_>>().join(", ")
    }

    /// The fields in the order of the table.
    pub(super) fn into_fields(self) -> Vec<Field> {
        let mut fields = self.fields.into_inner();
        fields.sort_by_cached_key(|field| table::order(&field.pointer));
        fields
    }

    /// The text of the nearest source at or above a pointer.
    pub(super) fn source(&self, pointer: &str) -> &str {
        let covers = |above: &str| is_at_or_below(pointer, above);
        let nearest = self.sources.iter().filter(|(above, _)| covers(above)).max_by_key(|(above, _)| above.len());
        nearest.map_or("case file", |(_, text)| text)
    }
}

/// A source text that begins with this word marks its field as assumed.
pub(super) fn is_assumed(source: &str) -> bool {
    source.starts_with("assumed")
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
