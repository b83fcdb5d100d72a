//! Frames for ParaView: `frames.vtkhdf`, and on request `frames.pvd` with a `.vtu` file for every part and frame.
//!
//! The solver's thread only copies what has moved. Everything else happens when the run is over, however it ended, on all threads:
//! files are written under temporary names and get theirs then.

mod hdf;
mod parts;
mod recorder;
mod spool;
mod vtu;
mod writer;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::{NamedTempFile, TempDir};

use super::folder::UNFINISHED;
use vtu::{SERIES, VtuSeries};

pub use recorder::Recorder;
pub(super) use spool::clear as clear_spool;

/// The file with all frames, and the one that lists those of the series.
pub(super) const HDF: &str = "frames.vtkhdf";
pub(super) const PVD: &str = "frames.pvd";
/// What stands for the files of the series in a list of files.
const VTU: &str = "frames/*.vtu";
/// What a place for frames has to be.
const WRITABLE: &str = "a disk that takes the frames";

/// Complete files under temporary names.
#[derive(Default)]
pub struct Staged {
    hdf: Option<NamedTempFile>,
    /// The list, and the series.
    vtu: Option<(NamedTempFile, VtuSeries)>,
}

impl Staged {
    /// Gives the files their names in `folder`, where those of an earlier run go first; returns the names.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn place(self, folder: &Path) -> io::Result<Vec<&'static str>> {
        clear(folder)?;
        let mut names = Vec::new();
        if let Some(hdf) = self.hdf {
            hdf.persist(folder.join(HDF)).map_err(|error| error.error)?;
            names.push(HDF);
        }
        if let Some((list, series)) = self.vtu {
            let target: PathBuf = folder.join(SERIES);
            fs::create_dir_all(&target)?;
            for name in &series.names {
                fs::rename(series.path().join(name), target.join(name))?;
            }
            list.persist(folder.join(PVD)).map_err(|error| error.error)?;
            names.extend([PVD, VTU]);
        }
        Ok(names)
    }
}

/// A folder of its own, under a temporary name.
fn hidden(folder: &Path) -> io::Result<TempDir> {
    tempfile::Builder::new().prefix(UNFINISHED[0]).suffix(UNFINISHED[1]).tempdir_in(folder)
}

/// Removes the frames of an earlier run.
fn clear(folder: &Path) -> io::Result<()> {
    gone(fs::remove_file(folder.join(HDF)))?;
    gone(fs::remove_file(folder.join(PVD)))?;
    clear_folder(&folder.join(SERIES), vtu::is_of_series)
}

/// Removes the files of a folder that are `own` by name, and the folder unless something else lies there.
fn clear_folder(folder: &Path, own: impl Fn(&str) -> bool) -> io::Result<()> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let entry = entry?;
        if own(&entry.file_name().to_string_lossy()) {
            gone(fs::remove_file(entry.path()))?;
        }
    }
    fs::remove_dir(folder).ok();
    Ok(())
}

/// What is not there need not be removed.
fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
