//! JSON text to a value: like `serde_json`, but a key given twice is an error, and errors say what to do.

use std::fmt;

use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use super::error::{CaseError, quote};

const DUPLICATE: &str = "duplicate key ";

/// Parses one JSON document; errors are located by line and column.
pub(super) fn parse(text: &str) -> Result<Value, CaseError> {
    let start = "line 1, column 1";
    if text.starts_with('\u{feff}') {
        let error = CaseError::at(start, "a JSON document", "a byte order mark (BOM)");
        return Err(error.help("save the file as UTF-8 without BOM"));
    }
    if text.trim().is_empty() {
        return Err(CaseError::at(start, "a JSON document", "an empty file"));
    }
    serde_json::from_str::<Unique>(text).map(|unique| unique.0).map_err(|error| explain(text, &error))
}

/// `line L, column C` of a byte offset, both from 1.
pub(super) fn line_column(bytes: &[u8], offset: usize) -> String {
    let before = &bytes[..offset.min(bytes.len())];
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|byte| **byte != b'\n').count() + 1;
    format!("line {line}, column {column}")
}

fn explain(text: &str, error: &serde_json::Error) -> CaseError {
    let location = format!("line {}, column {}", error.line(), error.column().max(1));
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
    let token = token_at(text, error.line(), error.column());
    let found = if token.is_empty() { "the end of the line".to_owned() } else { quote(&token) };
    if message.starts_with(DUPLICATE) {
        return CaseError::at(location, "each key once in an object", message)
            .help("remove one of the two, or rename it");
    }
    if error.is_eof() {
        return CaseError::at(location, "the rest of the document", format!("the end of the text ({message})"))
            .help("a closing brace, bracket or quote is missing; was the file cut off?");
    }
    match message {
        "recursion limit exceeded" => {
            CaseError::at(location, "objects and lists nested at most 127 deep", "deeper nesting")
        }
        "number out of range" => CaseError::at(location, "a number that fits in 64 bits (below 1.8e308)", found),
        "trailing comma" => CaseError::at(location, "another item or the closing bracket", "a comma before it")
            .help("JSON has no comma after the last item"),
        "trailing characters" => CaseError::at(location, "the end of the text after the document", found),
        "key must be a string" => CaseError::at(location, "a key in double quotes", found),
        _ => {
            let expected = message.strip_prefix("expected ").unwrap_or("valid JSON").replace("ident", "a JSON value");
            let found = if message.starts_with("expected ") { found } else { format!("{message}: {found}") };
            with_help(CaseError::at(location, expected, found), &token)
        }
    }
}

fn with_help(error: CaseError, token: &str) -> CaseError {
    let word = token.trim_start_matches(['-', '+']).to_lowercase();
    if ["nan", "inf", "infinity"].contains(&word.as_str()) {
        error.help("JSON has no NaN or Infinity; every number of a case is finite")
    } else if word.starts_with("//") || word.starts_with("/*") || word.starts_with('#') {
        error.help("JSON has no comments; put them under \"notes\"")
    } else if word.starts_with('\'') {
        error.help("JSON strings stand in double quotes")
    } else if word.starts_with('.') || token.starts_with('+') {
        error.help("JSON numbers begin with a digit or a minus")
    } else {
        error
    }
}

/// The word, number or sign at a position of the text, for people.
fn token_at(text: &str, line: usize, column: usize) -> String {
    let Some(line) = text.lines().nth(line.saturating_sub(1)) else {
        return String::new();
    };
    let part = |c: char| c.is_alphanumeric() || "+-._".contains(c);
    let mut start = column.saturating_sub(1).min(line.len());
    while !line.is_char_boundary(start) {
        start -= 1;
    }
    while let Some(before) = line[..start].chars().next_back().filter(|c| part(*c)) {
        start -= before.len_utf8();
    }
    let rest = &line[start..];
    match rest.chars().next() {
        Some(first) if part(first) => rest.chars().take_while(|c| part(*c)).take(40).collect(),
        Some('/') => rest.chars().take(2).collect(),
        Some(first) => first.to_string(),
        None => String::new(),
    }
}

/// A value whose objects had each key once.
struct Unique(Value);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Read.deserialize(deserializer).map(Unique)
    }
}

struct Read;

impl<'de> DeserializeSeed<'de> for Read {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Read {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Value, E> {
        Ok(Value::Bool(flag))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::from(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::from(number))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Value, E> {
        Number::from_f64(number).map(Value::Number).ok_or_else(|| E::custom("number out of range"))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::from(text))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        while let Some(item) = items.next_element_seed(Read)? {
            list.push(item);
        }
        Ok(Value::Array(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut map = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            if map.contains_key(&key) {
                return Err(A::Error::custom(format!("{DUPLICATE}{}", quote(&key))));
            }
            map.insert(key, entries.next_value_seed(Read)?);
        }
        Ok(Value::Object(map))
    }
}

#[cfg(test)]
#[path = "json_tests.rs"]
mod tests;
