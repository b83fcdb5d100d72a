//! Refusal of a case: where, what was expected, what was found, and help; and the words for values, numbers, lists and JSON pointers.

use std::{fmt, iter};

use serde_json::{Number, Value};

use super::set;

/// Refusal of a case.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub struct CaseError {
    /// The file, as the user named it.
    pub file: Box<str>,
    /// JSON pointer, `line L, column C`, or `--set /pointer`; empty where the file cannot be read at all.
    pub location: String,
    /// Values that may stand there.
    pub expected: String,
    /// The value that stands there.
    pub found: String,
    /// Remedy, where one is known.
    pub help: Option<String>,
    /// The next error of the same case.
    pub next: Option<Box<Self>>,
}

/// Errors shown; of a file that is something else, more say nothing.
const SHOWN: usize = 12;

impl fmt::Display for CaseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.all().take(SHOWN).enumerate() {
            let Self { file, location, expected, found, help, .. } = error;
            let [line, colon] = [if index > 0 { "\n" } else { "" }, if location.is_empty() { "" } else { ": " }];
            write!(f, "{line}error: {file}{colon}{location}\n  expected: {expected}\n  found: {found}")?;
            if let Some(help) = help {
                write!(f, "\n  help: {help}")?;
            }
        }
        match self.all().count().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, "\n{more} more"),
        }
    }
}

impl CaseError {
    /// The pointer of the change by `--set` that caused it.
    pub fn of_set(&self) -> Option<&str> {
        self.location.strip_prefix(set::FLAG).map(str::trim_start)
    }

    /// An error in a file, at a JSON pointer of it.
    pub fn new(
        file: &str,
        location: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self::at(location, expected, found).help(help).in_file(file)
    }

    /// An error at `location` of a file that the caller names with [`CaseError::in_file`].
    pub(super) fn at(location: impl Into<String>, expected: impl Into<String>, found: impl Into<String>) -> Self {
        let (location, expected, found) = (location.into(), expected.into(), found.into());
        Self { file: Box::default(), location, expected, found, help: None, next: None }
    }

    /// This one and all that are wrong besides.
    pub fn all(&self) -> impl Iterator<Item = &Self> {
        iter::successors(Some(self), |error| error.next.as_deref())
    }

    /// The first of some errors, with the others behind it.
    pub(super) fn first_of(errors: Vec<Self>) -> Self {
        let chained = errors.into_iter().rev().reduce(|next, error| Self { next: Some(Box::new(next)), ..error });
        chained.unwrap_or_else(|| Self::at("", "a case", "nothing"))
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Names the file, unless an inner reader already did.
    pub(super) fn in_file(mut self, file: &str) -> Self {
        if self.file.is_empty() {
            self.file = file.into();
        }
        self
    }
}

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
#[path = "error_tests.rs"]
mod tests;
