//! What reads files of users, fed with any bytes: it may refuse them, but it never panics and never runs on for ever.
//!
//! The programs in `fuzz/` feed these functions with what a fuzzer makes up, the suite with the corpora beside this file.

mod case;
mod checkpoint;
mod frames;
mod sealed;

use std::fs;
use std::path::Path;

use tempfile::TempDir;

pub(crate) use case::case;
pub(crate) use checkpoint::checkpoint;
pub(crate) use frames::frames;
pub(crate) use sealed::Plain;

/// What separates the files in one input.
const CUT: &[u8] = b"\n----\n";

/// The files in one input.
pub(crate) fn parts(bytes: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    let mut rest = bytes;
    while let Some(at) = rest.windows(CUT.len()).position(|window| window == CUT) {
        parts.push(&rest[..at]);
        rest = &rest[at + CUT.len()..];
    }
    parts.push(rest);
    parts
}

/// A folder in memory where the system has such a place: a fuzzer makes thousands a second.
pub(crate) fn folder() -> TempDir {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    folder.expect("a folder for temporary files")
}

fn write(path: &Path, bytes: &[u8]) {
    fs::create_dir_all(path.parent().expect("a file in a folder")).expect("a folder");
    fs::write(path, bytes).expect("a disk that takes the input");
}

/// An error says where, what was expected, what was found, each on one line.
fn assert_told(text: &str) {
    assert!(text.starts_with("error: "), "{text}");
    for word in ["  expected: ", "  found: "] {
        let line = text.lines().find(|line| line.starts_with(word));
        assert!(line.is_some_and(|line| line.len() > word.len()), "{word} in {text}");
    }
}
