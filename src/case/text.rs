//! Words of errors and reports: values, numbers, lists, the nearest key, and JSON pointers.

use serde_json::{Number, Value};

/// A JSON value in words, short enough for one line.
pub(super) fn describe(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Bool(flag) => flag.to_string(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), number_text),
        Value::String(text) => quote(text),
        Value::Array(items) => format!("a list of {}", items.len()),
        Value::Object(map) => match map.keys().next() {
            Some(key) => format!("an object with {}", quote(key)),
            None => "an empty object".to_owned(),
        },
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

/// Text in quotes, control characters escaped, cut at 60 characters.
pub(super) fn quote(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    format!("{short:?}")
}

/// `"a", "b" or "c"`.
pub(super) fn list<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<String> = words.into_iter().map(quote).collect();
    match words.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        Some((last, _)) => last.clone(),
        None => "nothing".to_owned(),
    }
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

/// A number as people write it: 0 and 155, not 0.0 and 155.0.
pub(super) fn json_number(number: f64) -> Value {
    if number.fract() == 0.0 && number.abs() < 1e15 {
        Value::from(number as i64)
    } else {
        Number::from_f64(number).map_or(Value::Null, Value::Number)
    }
}

/// A whole number that fits; 2.0 is one.
pub(super) fn whole(value: &Value) -> Option<u32> {
    let number = value.as_f64().filter(|number| number.fract() == 0.0)?;
    (0.0..=f64::from(u32::MAX)).contains(&number).then_some(number as u32)
}

/// The fraction meant by `1%`.
pub(super) fn percent(text: &str) -> Option<f64> {
    let number: f64 = text.strip_suffix('%')?.trim().parse().ok()?;
    (0.0..=100.0).contains(&number).then_some(number / 100.0)
}

/// Keys and words of earlier versions, and what they are called now.
const RENAMED: [(&str, &str); 3] = [("growth", "growth_ratio"), ("coarsest", "max_crossovers"), ("rim", "edges")];

/// The candidate that `word` was called before, or the nearest to it: fewest edits, and among those the longest common beginning.
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    if let Some((_, new)) = RENAMED.iter().find(|(old, new)| *old == word && candidates.contains(new)) {
        return Some(new);
    }
    // Beyond this length nothing resembles a key, and the table of edits would only cost time.
    let word: String = word.chars().take(100).collect();
    candidates.into_iter().min_by_key(|candidate| {
        let common = word.chars().zip(candidate.chars()).take_while(|(a, b)| a == b).count();
        // `mass` is meant as `mass_g`, however long the unit that was left out.
        let beginning = common == word.chars().count().min(candidate.chars().count()) && common >= 3;
        let edits = strsim::osa_distance(&word, candidate);
        (if beginning { edits.min(2) } else { edits }, std::cmp::Reverse(common))
    })
}

/// Whether `pointer` is `above` or something inside it.
pub(super) fn is_at_or_below(pointer: &str, above: &str) -> bool {
    pointer.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// The index that a part of a pointer stands for: digits without a leading zero.
pub(super) fn index(part: &str) -> Option<usize> {
    let canonical = part == "0" || part.starts_with(|c: char| ('1'..='9').contains(&c));
    part.parse().ok().filter(|_| canonical)
}

/// A key as part of a JSON pointer; control characters are escaped, for an error is one line per part.
pub(super) fn escape(key: &str) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().collect() } else { vec![c] };
    key.chars().take(200).collect::<String>().replace('~', "~0").replace('/', "~1").chars().flat_map(shown).collect()
}

/// A part of a JSON pointer as the key it stands for.
pub(super) fn unescape(part: &str) -> String {
    part.replace("~1", "/").replace("~0", "~")
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
