//! Cases as the command line names them: files, and `-` for standard input.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use ripstop::case::{self, Case, CaseError};

use super::failure::CommandFailure;

/// No case comes near this size [bytes].
const MAX_BYTES: u64 = 1 << 20;

/// Reads a case, named after what was changed in it; of one from standard input, files of fabrics lie in the current folder.
pub(crate) fn read(path: &Path, sets: &[String]) -> Result<Case, CommandFailure> {
    Ok(Source::open(path)?.case(sets)?)
}

/// Where cases with different changes come from. Standard input can be read once alone.
pub(crate) enum Source<'a> {
    /// A file.
    File(&'a Path),
    /// Text from standard input.
    Piped(String),
}

impl<'a> Source<'a> {
    /// The source that the command line names.
    pub(crate) fn open(path: &'a Path) -> Result<Self, CommandFailure> {
        if path == Path::new("-") { piped().map(Self::Piped) } else { Ok(Self::File(path)) }
    }

    /// As the user named it.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::File(path) => path.display().to_string(),
            Self::Piped(_) => "-".to_owned(),
        }
    }

    /// The case with changes, named after them.
    pub(crate) fn case(&self, sets: &[String]) -> Result<Case, CaseError> {
        let mut case = match self {
            Self::File(path) => case::read(path, sets),
            Self::Piped(text) => case::from_text("stdin", text, Path::new("."), sets),
        }?;
        case.name_changes(sets);
        Ok(case)
    }
}

/// The folder of a file.
pub(crate) fn folder(file: &Path) -> &Path {
    file.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

/// The text of a file, which is none of those that a program would read for ever.
pub(crate) fn text(path: &str) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(MAX_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MAX_BYTES { Err(io::Error::other("more than 1 MiB")) } else { Ok(text) }
}

/// The text of the case on standard input.
fn piped() -> Result<String, CommandFailure> {
    let failed = |error: io::Error| CommandFailure::expected("standard input", "a case", error);
    let mut text = String::new();
    io::stdin().take(MAX_BYTES + 1).read_to_string(&mut text).map_err(failed)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(CommandFailure::expected("standard input", "at most 1 MiB", "more"));
    }
    Ok(text)
}
