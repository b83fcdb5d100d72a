//! Frames for ParaView: `frames.vtkhdf`, and on request `frames.pvd` with a `.vtu` file for every part and frame.
//!
//! The solver's thread only copies what has moved. Everything else happens when the run is over, however it ended, on all threads:
//! files are written under temporary names and get theirs then.

mod earlier;
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
use earlier::{SERIES, clear};
use vtu::VtuSeries;

pub(super) use earlier::{HDF, PVD};
pub use recorder::Recorder;
pub(super) use spool::clear as clear_spool;

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
