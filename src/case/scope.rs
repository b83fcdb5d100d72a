//! Typed reading of one object of a case that has been checked against the table, recording every value with where it came from.

use std::borrow::Cow;

use serde_json::{Map, Value};

use super::check::plain;
use super::error::CaseError;
use super::fields::{CaseKey, KeyType, Literal, Presence};
use super::record::{Provenance, is_assumed};
use super::value::{mismatch, short_number_text, text_of, whole};
use super::words::Word;
use super::{Field, Origin, table};

/// A word, or the object that stands in its place.
pub(super) enum WordOrObject<'a> {
    Word(String),
    Keys(ObjectReader<'a>),
}

/// One object of the case and the keys it may have.
pub(super) struct ObjectReader<'a> {
    record: &'a Provenance,
    pub(super) pointer: String,
    keys: &'static [CaseKey],
    /// `None` where the object itself was left out.
    map: Option<&'a Map<String, Value>>,
    /// Values are not recorded one by one.
    quiet: bool,
}

impl<'a> ObjectReader<'a> {
    /// The whole document.
    pub(super) fn root(record: &'a Provenance, map: &'a Map<String, Value>) -> Self {
        Self { record, pointer: String::new(), keys: table::CASE, map: Some(map), quiet: false }
    }

    fn below(&self, key: &CaseKey, map: Option<&'a Map<String, Value>>) -> Self {
        Self { record: self.record, pointer: self.at(key.name), keys: key.keys(), map, quiet: self.quiet }
    }

    pub(super) fn at(&self, name: &str) -> String {
        format!("{}/{name}", self.pointer)
    }

    /// Whether a value read earlier is assumed.
    pub(super) fn is_assumed(&self, name: &str) -> bool {
        self.record.is_assumed(&self.at(name))
    }

    pub(super) fn given(&self, name: &str) -> Option<&'a Value> {
        self.map.and_then(|map| map.get(name))
    }

    fn key(&self, name: &str) -> Result<&'static CaseKey, CaseError> {
        let missing = || CaseError::at(self.at(name), "a key that the table of the case file has", "none");
        self.keys.iter().find(|key| key.name == name).ok_or_else(missing)
    }

    /// The value of a key, given or by default, recorded. The document has been checked against the table.
    fn take(&self, name: &str) -> Result<(&'static CaseKey, Option<Cow<'a, Value>>), CaseError> {
        let key = self.key(name)?;
        if let Some(value) = self.given(name) {
            let recorded = key.keys().is_empty() && !matches!(key.kind, KeyType::Sources);
            if recorded || value.is_string() {
                let source = self.record.source(&self.at(name));
                self.note(key, text_of(value), Origin::Read, source, is_assumed(source));
            }
            return Ok((key, Some(Cow::Borrowed(value))));
        }
        let default = |literal: Literal, source: &str| {
            self.note(key, text_of(&literal.value()), Origin::Default, source, is_assumed(source));
            Some(Cow::Owned(literal.value()))
        };
        let value = match key.presence {
            Presence::Default(literal, source) => default(literal, source),
            Presence::RequiredUnless(other, word, literal, source)
                if self.map.and_then(|map| plain(other, self.keys, map)).is_some_and(|found| found == word) =>
            {
                default(literal, source)
            }
            Presence::RequiredUnless(..) if self.given(key.instead).is_some() => None,
            Presence::Required | Presence::RequiredUnless(..) => {
                return Err(CaseError::at(self.at(name), key.expected(), "nothing"));
            }
            Presence::Optional("") | Presence::Derived(_) => None,
            Presence::Optional(without) => {
                self.note(key, "none".to_owned(), Origin::Default, without, false);
                None
            }
        };
        Ok((key, value))
    }

    fn note(&self, key: &CaseKey, value: String, origin: Origin, source: &str, assumed: bool) {
        self.note_as(key.name, value, key.unit(), origin, source.to_owned(), assumed);
    }

    fn note_as(&self, name: &str, value: String, unit: &'static str, origin: Origin, source: String, assumed: bool) {
        if !self.quiet {
            let pointer = self.at(name);
            self.record.push(Field { pointer, value, unit, origin, source, assumed });
        }
    }

    /// Records a number [SI] computed, as the table says, for a key that was left out.
    pub(super) fn derive(&self, name: &str, si: f64, assumed: bool) -> Result<f64, CaseError> {
        self.derive_as(name, si, self.key(name)?.derivation(), assumed)
    }

    /// Records a number [SI] computed for a key that was left out.
    pub(super) fn derive_as(&self, name: &str, si: f64, how: &str, assumed: bool) -> Result<f64, CaseError> {
        let key = self.key(name)?;
        if let KeyType::Number(unit, _) = key.kind {
            self.note(key, short_number_text(unit.of_si(si)), Origin::Derived, how, assumed);
        }
        Ok(si)
    }

    /// Records a value that is no single number, computed, as the table says, for a key that was left out.
    pub(super) fn derive_value(&self, name: &str, value: String, assumed: bool) -> Result<(), CaseError> {
        self.derive_value_as(name, value, self.key(name)?.derivation(), assumed)
    }

    /// Records a value that is no single number, computed for a key that was left out.
    pub(super) fn derive_value_as(&self, name: &str, value: String, how: &str, assumed: bool) -> Result<(), CaseError> {
        self.note(self.key(name)?, value, Origin::Derived, how, assumed);
        Ok(())
    }

    /// Records something computed that is no number of the table.
    pub(super) fn derive_text(&self, name: &str, value: String, how: &str) {
        self.note_as(name, value, "", Origin::Derived, how.to_owned(), false);
    }

    /// Records an item of a list in one line.
    pub(super) fn summarise(&self, value: String, source: &str) {
        let field = Field {
            pointer: self.pointer.clone(),
            value,
            unit: "",
            origin: Origin::Read,
            source: source.to_owned(),
            assumed: is_assumed(source),
        };
        self.record.push(field);
    }

    /// A number in SI units.
    pub(super) fn number(&self, name: &str) -> Result<f64, CaseError> {
        self.number_if_given(name)?.ok_or_else(|| CaseError::at(self.at(name), "a number", "nothing"))
    }

    /// A number in SI units, where the case or the table has one.
    pub(super) fn number_if_given(&self, name: &str) -> Result<Option<f64>, CaseError> {
        let (key, value) = self.take(name)?;
        let Some(value) = value else { return Ok(None) };
        match (key.kind, value.as_f64()) {
            (KeyType::Number(unit, _), Some(number)) => Ok(Some(unit.to_si(number))),
            _ => Err(mismatch(key, &value, &self.at(name))),
        }
    }

    /// A number in SI units, or one that follows, as the table says, from other keys where it is left out.
    pub(super) fn number_or(&self, name: &str, otherwise: f64, assumed: bool) -> Result<f64, CaseError> {
        match self.number_if_given(name)? {
            Some(given) => Ok(given),
            None => self.derive(name, otherwise, assumed),
        }
    }

    /// The one given number of a group of keys, in SI units.
    pub(super) fn one_of(&self, group: &str) -> Result<f64, CaseError> {
        let given = self.keys.iter().find(|key| key.group == group && self.given(key.name).is_some());
        given.map_or_else(|| Err(CaseError::at(&self.pointer, group, "nothing")), |key| self.number(key.name))
    }

    pub(super) fn whole(&self, name: &str) -> Result<u32, CaseError> {
        let (key, value) = self.take(name)?;
        let value = value.unwrap_or_default();
        whole(&value).ok_or_else(|| mismatch(key, &value, &self.at(name)))
    }

    pub(super) fn flag(&self, name: &str) -> Result<bool, CaseError> {
        let (key, value) = self.take(name)?;
        let value = value.unwrap_or_default();
        value.as_bool().ok_or_else(|| mismatch(key, &value, &self.at(name)))
    }

    pub(super) fn text(&self, name: &str) -> Result<String, CaseError> {
        let (key, value) = self.take(name)?;
        let value = value.unwrap_or_default();
        value.as_str().map(str::to_owned).ok_or_else(|| mismatch(key, &value, &self.at(name)))
    }

    pub(super) fn word<W: Word>(&self, name: &str) -> Result<W, CaseError> {
        let (key, value) = self.take(name)?;
        let value = value.unwrap_or_default();
        value.as_str().and_then(W::from_word).ok_or_else(|| mismatch(key, &value, &self.at(name)))
    }

    /// A list of numbers in SI units.
    pub(super) fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, CaseError> {
        let (key, value) = self.take(name)?;
        let Some(value) = value else { return Ok(None) };
        match (key.kind, value.as_array()) {
            (KeyType::Numbers(unit, ..), Some(items)) => {
                Ok(Some(items.iter().filter_map(Value::as_f64).map(|number| unit.to_si(number)).collect()))
            }
            _ => Err(mismatch(key, &value, &self.at(name))),
        }
    }

    pub(super) fn vector<const N: usize>(&self, name: &str) -> Result<[f64; N], CaseError> {
        let numbers = self.numbers(name)?.unwrap_or_default();
        let count = numbers.len();
        let error = |_| CaseError::at(self.at(name), format!("{N} numbers"), count.to_string());
        numbers.try_into().map_err(error)
    }

    /// A value of more than one kind, checked against the table.
    pub(super) fn raw(&self, name: &str) -> Result<Option<&'a Value>, CaseError> {
        self.take(name).map(|_| self.given(name))
    }

    /// An object; the defaults of its keys hold where it was left out.
    pub(super) fn object(&self, name: &str) -> Result<Self, CaseError> {
        let (key, _) = self.take(name)?;
        Ok(self.below(key, self.given(name).and_then(Value::as_object)))
    }

    /// An object, where it was given.
    pub(super) fn object_if_given(&self, name: &str) -> Result<Option<Self>, CaseError> {
        let key = self.key(name)?;
        if key.is_nullable() && self.given(name).is_some_and(Value::is_null) {
            if let Presence::Optional(without) = key.presence {
                self.note(key, "none".to_owned(), Origin::Read, without, false);
            }
            return Ok(None);
        }
        self.take(name)?;
        Ok(self.given(name).and_then(Value::as_object).map(|map| self.below(key, Some(map))))
    }

    /// The defaults of an object's keys, where a word stands for them.
    pub(super) fn defaults(&self, name: &str) -> Result<Self, CaseError> {
        Ok(self.below(self.key(name)?, None))
    }

    pub(super) fn choice(&self, name: &str) -> Result<WordOrObject<'a>, CaseError> {
        let (key, value) = self.take(name)?;
        match value.as_deref().and_then(Value::as_str) {
            Some(word) => Ok(WordOrObject::Word(word.to_owned())),
            None => Ok(WordOrObject::Keys(self.below(key, self.given(name).and_then(Value::as_object)))),
        }
    }

    /// The objects of a list, every value of theirs recorded.
    pub(super) fn items(&self, name: &str) -> Result<Vec<Self>, CaseError> {
        self.list(name, self.quiet)
    }

    /// The objects of a list, each to be recorded as a whole with [`ObjectReader::summarise`].
    pub(super) fn quiet_items(&self, name: &str) -> Result<Vec<Self>, CaseError> {
        self.list(name, true)
    }

    fn list(&self, name: &str, quiet: bool) -> Result<Vec<Self>, CaseError> {
        let (key, _) = self.take(name)?;
        let items = self.given(name).and_then(Value::as_array);
        let item = |(index, value): (usize, &'a Value)| {
            let pointer = format!("{}/{index}", self.at(name));
            let map = value.as_object();
            Self { record: self.record, pointer, keys: key.keys(), map, quiet }
        };
        Ok(items.into_iter().flatten().enumerate().map(item).collect())
    }
}
