//! What is wrong with a case: where, what was expected, what was found, and help.

use std::{fmt, iter};

use serde_json::Value;

use super::set;
use super::value::number_text;

/// What a case is refused with.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub struct CaseError {
    /// The file, as the user named it.
    pub file: Box<str>,
    /// JSON pointer, `line L, column C`, or `--set /pointer`; empty where the file cannot be read at all.
    pub location: String,
    /// What may stand there.
    pub expected: String,
    /// What stands there.
    pub found: String,
    /// What to do about it, where that is known.
    pub help: Option<String>,
    /// What is wrong next.
    pub next: Option<Box<Self>>,
}

/// Errors shown; of a file that is something else, more tell nothing.
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
        Self {
            file: Box::default(),
            location: location.into(),
            expected: expected.into(),
            found: found.into(),
            help: None,
            next: None,
        }
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

/// Keys and words of earlier versions, and what they are called now.
const RENAMED: [(&str, &str); 3] = [("growth", "growth_ratio"), ("coarsest", "max_crossovers"), ("rim", "edges")];

/// The candidate that `word` was called before, or the nearest to it: fewest edits, and among those the longest common beginning.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let renamed = RENAMED.iter().find(|(old, new)| *old == word && candidates.contains(new));
    if let Some((_, new)) = renamed {
        return candidates.into_iter().find(|candidate| candidate == new);
    }
    // Beyond this length nothing resembles a key, and the table of edits would only cost time.
    let word: Vec<char> = word.chars().take(100).collect();
    candidates.into_iter().min_by_key(|candidate| {
        let candidate: Vec<char> = candidate.chars().collect();
        let common = word.iter().zip(&candidate).take_while(|(a, b)| a == b).count();
        // `mass` is meant as `mass_g`, however long the unit that was left out.
        let beginning = common == word.len().min(candidate.len()) && common >= 3;
        let edits = edits(&word, &candidate);
        (if beginning { edits.min(2) } else { edits }, std::cmp::Reverse(common))
    })
}

/// Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`.
fn edits(a: &[char], b: &[char]) -> usize {
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replace.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            row.push(best);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
#[path = "error_tests.rs"]
mod tests;
