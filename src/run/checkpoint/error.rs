//! Why a checkpoint is not taken.

use std::path::Path;

/// A file that no run goes on from.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("error: {path}\n  expected: {}\n  found: {}\n  help: {}", self.words()[0], self.words()[1], self.words()[2])]
#[non_exhaustive]
pub struct CheckpointError {
    /// The file.
    pub path: String,
    /// What is wrong with it.
    pub fault: CheckpointFault,
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CheckpointFault {
    /// It cannot be read, for this reason.
    Unreadable(String),
    /// It is something else.
    Foreign,
    /// It has the format of this number.
    Format(u32),
    /// Its checksum does not hold: bits have changed, or the end is missing.
    Damaged,
    /// It was written by this version of the program.
    Version(String),
    /// It belongs to a case of this fingerprint.
    Case {
        /// Of the checkpoint.
        checkpoint: String,
        /// Of the case at hand.
        case: String,
    },
    /// It is of a run on this backend, in these numbers.
    Backend(String),
    /// Its contents do not fit the model of the case: this part.
    Contents(&'static str),
}

impl CheckpointError {
    pub(super) fn new(path: &Path, fault: CheckpointFault) -> Self {
        Self { path: path.display().to_string(), fault }
    }

    /// What was expected, what was found, what to do.
    fn words(&self) -> [String; 3] {
        let (expected, found, help) = match &self.fault {
            CheckpointFault::Unreadable(reason) => {
                ("a checkpoint that can be read", reason.clone(), "see whether the file is there")
            }
            CheckpointFault::Foreign => {
                ("a checkpoint of ripstop", "another kind of file".to_owned(), "run the case again")
            }
            CheckpointFault::Format(format) => {
                return [
                    format!("a checkpoint of format {}", super::FORMAT),
                    format!("format {format}"),
                    "resume with the version of ripstop that wrote it, or run the case again".to_owned(),
                ];
            }
            CheckpointFault::Damaged => (
                "a checkpoint whose checksum holds",
                "one that is damaged or cut short".to_owned(),
                "run the case again",
            ),
            CheckpointFault::Version(version) => {
                return [
                    format!("a checkpoint of ripstop {}", env!("CARGO_PKG_VERSION")),
                    format!("one of ripstop {version}"),
                    format!("resume with ripstop {version}, or run the case again"),
                ];
            }
            CheckpointFault::Case { checkpoint, case } => {
                return [
                    format!("the case that the run began with (case_hash {checkpoint})"),
                    format!("one that computes something else (case_hash {case})"),
                    "undo the change of the case, or run it anew with `ripstop run`".to_owned(),
                ];
            }
            CheckpointFault::Backend(backend) => {
                ("the backend and precision that the run began with", backend.clone(), "let `ripstop resume` choose it")
            }
            CheckpointFault::Contents(part) => {
                ("contents that fit the model of the case", format!("{part} that do not"), "run the case again")
            }
        };
        [expected.to_owned(), found, help.to_owned()]
    }
}
