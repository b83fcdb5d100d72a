//! Refusal of a case: where, what was expected, what was found, and help.

use std::{fmt, iter};

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
