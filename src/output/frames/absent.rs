//! Frames for ParaView in a build without the feature `frames`: none are written, and those of an earlier run go.

use std::fs;
use std::io;
use std::path::Path;

/// The file with all frames, and the one that lists those of the series.
pub(super) const HDF: &str = "frames.vtkhdf";
pub(super) const PVD: &str = "frames.pvd";

/// Complete files under temporary names: there are none.
#[derive(Debug, Default)]
pub struct Staged(());

impl Staged {
    /// Removes the frames of an earlier run from `folder`; returns the names of what was written.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn place(self, folder: &Path) -> io::Result<Vec<&'static str>> {
        for name in [HDF, PVD] {
            match fs::remove_file(folder.join(name)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(Vec::new())
    }
}

/// Removes frames that lie beside a checkpoint: there are none.
pub(super) fn clear_spool(_: &Path) -> io::Result<()> {
    Ok(())
}
