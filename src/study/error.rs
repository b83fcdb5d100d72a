//! Why shots cannot be read.

use crate::study::diff::DiffError;

/// What was wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("error: {place}\n  expected: {expected}\n  found: {found}\n  help: {help}")]
pub struct StudyError {
    /// File, with line and column where there are some.
    pub place: String,
    /// What may stand there.
    pub expected: String,
    /// What stands there.
    pub found: String,
    /// What to do.
    pub help: String,
}

impl StudyError {
    pub(super) fn new(
        place: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self { place: place.into(), expected: expected.into(), found: found.into(), help: help.into() }
    }

    /// The same in a file.
    pub(super) fn in_file(self, file: &str) -> Self {
        let place = if self.place.is_empty() { file.to_owned() } else { format!("{file}: {}", self.place) };
        Self { place, ..self }
    }
}

/// Tables of shots and of curves are read from the same kind of text.
impl From<DiffError> for StudyError {
    fn from(error: DiffError) -> Self {
        Self { place: error.place, expected: error.expected, found: error.found, help: error.help }
    }
}
