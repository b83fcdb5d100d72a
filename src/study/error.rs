//! Why a study cannot be made: a table, a curve or an option that is none.

/// What was wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("error: {place}\n  expected: {expected}\n  found: {found}\n  help: {help}")]
pub struct StudyError {
    /// File, with line and column where there are some; or option.
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
