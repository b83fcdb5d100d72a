//! Frames for ParaView in a build without the feature `frames`: none are written, and those of an earlier run go.

mod earlier;

use std::io;
use std::path::Path;

pub(super) use earlier::{HDF, PVD};

/// Complete files under temporary names: there are none.
#[derive(Debug, Default)]
pub struct Staged(());

impl Staged {
    /// Removes the frames of an earlier run from `folder`; returns the names of what was written.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn place(self, folder: &Path) -> io::Result<Vec<&'static str>> {
        earlier::clear(folder)?;
        Ok(Vec::new())
    }
}

/// Removes frames that lie beside a checkpoint: there are none.
pub(super) fn clear_spool(_: &Path) -> io::Result<()> {
    Ok(())
}
