//! JSON text to a value: like `serde_json`, but a key given twice is an error, and errors say what to do.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

use super::error::CaseError;
use super::text::quote;

const DUPLICATE: &str = "duplicate key ";

/// Parses one JSON document; errors are located by line and column.
pub(super) fn parse(text: &str) -> Result<Value, CaseError> {
    let refused = |found| CaseError::at("line 1, column 1", "a JSON document", found);
    if text.starts_with('\u{feff}') {
        return Err(refused("a byte order mark (BOM)").help("save the file as UTF-8 without BOM"));
    }
    if text.trim().is_empty() {
        return Err(refused("an empty file"));
    }
    let mut reader = serde_json::Deserializer::from_str(text);
    let value = Unique.deserialize(&mut reader).and_then(|value| reader.end().map(|()| value));
    value.map_err(|error| explain(text, &error))
}

/// `line L, column C` of a byte offset, both from 1.
pub(super) fn line_column(bytes: &[u8], offset: usize) -> String {
    let before = &bytes[..offset.min(bytes.len())];
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|byte| **byte != b'\n').count() + 1;
    format!("line {line}, column {column}")
}

fn explain(text: &str, error: &serde_json::Error) -> CaseError {
    let at = |expected: &str, found: &str| {
        CaseError::at(format!("line {}, column {}", error.line(), error.column().max(1)), expected, found)
    };
    let message = error.to_string();
    let message = message.rsplit_once(" at line ").map_or(message.as_str(), |(what, _)| what);
    let token = token_at(text, error.line(), error.column());
    let found = if token.is_empty() { "the end of the line".to_owned() } else { quote(&token) };
    if error.is_eof() {
        return at("the rest of the document", &format!("the end of the text ({message})"))
            .help("a closing brace, bracket or quote is missing; was the file cut off?");
    }
    match message {
        _ if message.starts_with(DUPLICATE) => {
            at("each key once in an object", message).help("remove one of the two, or rename it")
        }
        "recursion limit exceeded" => at("objects and lists nested at most 127 deep", "deeper nesting"),
        "number out of range" => at("a number that fits in 64 bits (below 1.8e308)", &found),
        "trailing comma" => {
            at("another item or the closing bracket", "a comma before it").help("JSON has no comma after the last item")
        }
        "trailing characters" => at("the end of the text after the document", &found),
        "key must be a string" => at("a key in double quotes", &found),
        _ => {
            let (expected, found) = match message.strip_prefix("expected ") {
                Some(expected) => (expected.replace("ident", "a JSON value"), found),
                None => ("valid JSON".to_owned(), format!("{message}: {found}")),
            };
            let error = at(&expected, &found);
            match help(&token) {
                Some(help) => error.help(help),
                None => error,
            }
        }
    }
}

/// Help for something that people write and JSON does not have.
fn help(token: &str) -> Option<&'static str> {
    let word = token.trim_start_matches(['-', '+']).to_lowercase();
    let begins = |with: &[&str]| with.iter().any(|with| word.starts_with(with));
    if ["nan", "inf", "infinity"].contains(&word.as_str()) {
        Some("JSON has no NaN or Infinity; every number of a case is finite")
    } else if begins(&["//", "/*", "#"]) {
        Some("JSON has no comments; put them under \"notes\"")
    } else if begins(&["'"]) {
        Some("JSON strings stand in double quotes")
    } else if begins(&["."]) || token.starts_with('+') {
        Some("JSON numbers begin with a digit or a minus")
    } else {
        None
    }
}

/// The word, number or sign at a position of the text, for people.
fn token_at(text: &str, line: usize, column: usize) -> String {
    let line = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let part = |c: char| c.is_alphanumeric() || "+-._".contains(c);
    let mut start = column.saturating_sub(1).min(line.len());
    while !line.is_char_boundary(start) {
        start -= 1;
    }
    let before = line[..start].chars().rev().take_while(|c| part(*c)).map(char::len_utf8).sum::<usize>();
    let rest = &line[start - before..];
    match rest.chars().next() {
        Some(first) if part(first) => rest.chars().take_while(|c| part(*c)).take(40).collect(),
        Some('/') => rest.chars().take(2).collect(),
        first => first.into_iter().collect(),
    }
}

/// Reader of a value whose objects have each key once.
struct Unique;

impl<'de> DeserializeSeed<'de> for Unique {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Unique {
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
        while let Some(item) = items.next_element_seed(Self)? {
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
            map.insert(key, entries.next_value_seed(Self)?);
        }
        Ok(Value::Object(map))
    }
}
