//! Values of the case file against the table: what is accepted, what is said where it is not.

use serde_json::Value;

use super::error::{CaseError, describe, list, nearest, quote};
use super::fields::{CaseKey, KeyType, NumberRange, Presence};

impl CaseKey {
    /// Whether a value may stand at this key, its own keys aside.
    pub(super) fn accepts(&self, value: &Value) -> bool {
        let in_range = |value: &Value, range: NumberRange| value.as_f64().is_some_and(|number| range.contains(number));
        match self.kind {
            KeyType::Text => value.as_str().is_some_and(|text| !text.trim().is_empty()),
            KeyType::Flag => value.is_boolean(),
            KeyType::Number(_, range) => in_range(value, range),
            KeyType::Whole(min, max) => whole(value).is_some_and(|number| (min..=max).contains(&number)),
            KeyType::Numbers(_, range, [min, max]) => value.as_array().is_some_and(|items| {
                (min..=max).contains(&items.len()) && items.iter().all(|item| in_range(item, range))
            }),
            KeyType::Word(words) => value.as_str().is_some_and(|word| words.contains(&word)),
            KeyType::Object(_) | KeyType::ObjectOrFile(_) | KeyType::Sources => value.is_object(),
            KeyType::WordOrObject(words, _) => {
                value.is_object() || value.as_str().is_some_and(|word| words.contains(&word))
            }
            KeyType::Items(_, [min, max]) => value
                .as_array()
                .is_some_and(|items| (min..=max).contains(&items.len()) && items.iter().all(Value::is_object)),
            KeyType::NumberOrText(range) => value.is_string() || in_range(value, range),
            KeyType::NumberOrPercent(range) => in_range(value, range) || percent(value).is_some(),
        }
    }

    /// What may stand at this key, in words.
    pub(super) fn expected(&self) -> String {
        let unit = if self.unit().is_empty() { String::new() } else { format!(" {}", self.unit()) };
        match self.kind {
            KeyType::Text => "text".to_owned(),
            KeyType::Flag => "true or false".to_owned(),
            KeyType::Number(_, range) => format!("a number in {range}{unit}"),
            KeyType::Whole(min, max) => format!("a whole number in [{min}, {max}]"),
            KeyType::Numbers(_, range, [min, max]) if min == max => format!("a list of {max} numbers in {range}{unit}"),
            KeyType::Numbers(_, range, [_, max]) => format!("a list of at most {max} numbers in {range}{unit}"),
            KeyType::Word(words) => list(words.iter().copied()),
            KeyType::Object(keys) => format!("an object with {}", names(keys)),
            KeyType::ObjectOrFile(keys) => format!("an object with {}, or {{\"file\": \"…\"}}", names(keys)),
            KeyType::WordOrObject(words, keys) => {
                format!("{} or an object with {}", list(words.iter().copied()), names(keys))
            }
            KeyType::Items(keys, [0, max]) => format!("a list of at most {max} objects with {}", names(keys)),
            KeyType::Items(keys, [min, max]) => format!("a list of {min} to {max} objects with {}", names(keys)),
            KeyType::NumberOrText(range) => format!("a number in {range} or a word"),
            KeyType::NumberOrPercent(range) => {
                format!("a number in {range}, or a percentage from \"0%\" to \"100%\" of the value")
            }
            KeyType::Sources => "an object of JSON pointers and texts".to_owned(),
        }
    }
}

/// Refuses a value that the table does not allow, naming the item of a list.
pub(super) fn check(key: &CaseKey, value: &Value, pointer: &str) -> Result<(), CaseError> {
    if key.accepts(value) {
        return Ok(());
    }
    if let (KeyType::Numbers(unit, range, [min, max]), Some(items)) = (key.kind, value.as_array())
        && (min..=max).contains(&items.len())
        && let Some((index, item)) =
            items.iter().enumerate().find(|(_, item)| !item.as_f64().is_some_and(|number| range.contains(number)))
    {
        let expected = format!("a number in {range} {}", unit.name);
        return Err(CaseError::at(format!("{pointer}/{index}"), expected, describe(item)));
    }
    if let (KeyType::Items(keys, [_, max]), Some(items)) = (key.kind, value.as_array())
        && items.len() <= max
        && let Some((index, item)) = items.iter().enumerate().find(|(_, item)| !item.is_object())
    {
        let expected = format!("an object with {}", names(keys));
        return Err(CaseError::at(format!("{pointer}/{index}"), expected, describe(item)));
    }
    Err(mismatch(key, value, pointer))
}

pub(super) fn mismatch(key: &CaseKey, value: &Value, pointer: &str) -> CaseError {
    let error = CaseError::at(pointer, key.expected(), describe(value));
    let text = value.as_str().unwrap_or_default();
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    match key.kind {
        KeyType::Word(words) | KeyType::WordOrObject(words, _) if !text.is_empty() => {
            match nearest(text, words.to_vec()) {
                Some(near) => error.help(format!("did you mean {}?", quote(near))),
                None => error,
            }
        }
        KeyType::Number(..) | KeyType::Whole(..) if is_number(text) => error.help("write the number without quotes"),
        KeyType::NumberOrPercent(_) if !text.is_empty() => error.help("for example \"1%\""),
        KeyType::Number(..) if !key.help.is_empty() && value.as_f64().is_some_and(|number| number > 0.0) => {
            error.help(key.help)
        }
        _ => error,
    }
}

/// A value as the report shows it.
pub(super) fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => format!("[{}]", items.iter().map(text_of).collect::<Vec<_>>().join(", ")),
        other => describe(other),
    }
}

/// The keys that an object needs, or may have where it needs none.
fn names(keys: &[CaseKey]) -> String {
    let needed = |key: &&CaseKey| matches!(key.presence, Presence::Required) && key.group.is_empty();
    let needed: Vec<String> = keys.iter().filter(needed).map(|key| quote(key.name)).collect();
    if needed.is_empty() {
        keys.iter().map(|key| quote(key.name)).collect::<Vec<_>>().join(", ")
    } else {
        needed.join(", ")
    }
}

/// A whole number that fits; 2.0 is one.
pub(super) fn whole(value: &Value) -> Option<u32> {
    let number = value.as_f64().filter(|number| number.fract() == 0.0)?;
    (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as u32)
}

/// The fraction meant by `"1%"`.
pub(super) fn percent(value: &Value) -> Option<f64> {
    let number: f64 = value.as_str()?.strip_suffix('%')?.trim().parse().ok()?;
    (0.0..=100.0).contains(&number).then_some(number / 100.0)
}

/// A number in the fewest digits that read back as itself.
pub(super) fn number_text(number: f64) -> String {
    if number == 0.0 || (1e-4..1e7).contains(&number.abs()) { format!("{number}") } else { format!("{number:e}") }
}

/// A computed number to six digits: without the dust of unit conversion.
pub(super) fn short_number_text(number: f64) -> String {
    number_text(format!("{number:.5e}").parse().unwrap_or(number))
}

/// A length [m] in millimetres, for messages.
pub(super) fn millimetres(length: f64) -> String {
    format!("{} mm", short_number_text(length * 1e3))
}
