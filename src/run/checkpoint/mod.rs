//! Checkpoints: everything a run needs to go on as if nothing had happened, to the last bit, in one file.
//!
//! ```text
//! magic, format │ head: what run this is of │ contents, compressed │ checksum of all before
//! ```
//!
//! The contents begin with what whoever follows the run wants back: the animation of the report so far. Frames, which are many times
//! larger, lie beside the checkpoint as the files that they will be (`output::frames`).
//!
//! The head can be read without a model. Of the contents, what has a size that only the run knows (records, lists) is
//! encoded with its length; fields of nodes and elements have the size that the model gives them, and are read straight
//! into their place. Nothing is believed before the checksum of the whole file was found to hold.
//!
//! What is in the file follows from what varies: the state, the ledger, the record, and what the stepper or the
//! device remembers from step to step, the time each kernel took included. What follows from the case is not in it: a checkpoint fits one case only.

use std::io::{self, Write};

mod body;
mod clock;
#[cfg(feature = "gpu")]
mod device;
mod error;
mod file;
mod head;
mod processor;

pub(crate) use clock::LoopClock;
pub use error::{CheckpointError, CheckpointFault};
pub use file::Checkpoint;
#[doc(hidden)]
pub use file::FORMAT;
pub(crate) use file::{Reader, Writer, write};
pub use head::{BackendId, Extras, Header, Spent};

/// A run between two steps, which can be written down.
pub trait Checkpointable {
    /// Time of the positions [s].
    fn time(&self) -> f64;
    /// Writes a checkpoint; `head` says what run it is, how far it has come is added. `followed`: what whoever follows the
    /// run wants back.
    ///
    /// # Errors
    /// When the writer refuses, or a device was lost.
    fn save(&self, head: &Header, followed: &[u8], to: &mut dyn Write) -> io::Result<()>;
}

#[cfg(all(test, feature = "report"))]
mod layout_tests;
