//! From frames to files.

use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::earlier::SERIES;
use super::hdf::{self, HdfFile};
use super::parts::Parts;
use super::vtu::VtuSeries;
use super::{HDF, PVD, Staged, WRITABLE, hidden};
use crate::output::folder::{OutputError, temporary};
use crate::run::frame::{Frame, Scene};

/// A frame as the files hold it, compressed.
pub(super) struct PackedFrame {
    time_us: f64,
    hdf: Vec<hdf::PackedPart>,
    vtu: Vec<Vec<u8>>,
}

/// Files in the making, under temporary names.
pub(super) struct Files {
    folder: PathBuf,
    parts: Parts,
    file: NamedTempFile,
    hdf: HdfFile,
    series: Option<VtuSeries>,
}

/// What is said where a file of frames cannot be written.
pub(super) fn failed<E: Display>(folder: &Path, name: &'static str) -> impl Fn(E) -> OutputError {
    let path = folder.join(name);
    move |error| OutputError::new(&path, WRITABLE, error)
}

impl Files {
    pub(super) fn create(folder: &Path, vtu: bool, scene: &Scene, first: &Frame) -> Result<Self, OutputError> {
        let (parts, grids) = Parts::new(scene, first);
        let file = temporary(folder).map_err(failed(folder, HDF))?;
        let hdf = HdfFile::create(file.path(), &grids, &parts.of(scene, first)).map_err(failed(folder, HDF))?;
        let series = || hidden(folder).and_then(|own| VtuSeries::create(own, &grids)).map_err(failed(folder, SERIES));
        let series = if vtu { Some(series()?) } else { None };
        Ok(Self { folder: folder.to_owned(), parts, file, hdf, series })
    }

    pub(super) fn pack(&self, scene: &Scene, frame: &Frame) -> Result<PackedFrame, OutputError> {
        let (time_us, now) = (frame.time * 1e6, self.parts.of(scene, frame));
        let hdf = now.iter().map(hdf::pack).collect::<io::Result<_>>().map_err(failed(&self.folder, HDF))?;
        let vtu = match &self.series {
            Some(series) => series.pack(time_us, &now).map_err(failed(&self.folder, SERIES))?,
            None => Vec::new(),
        };
        Ok(PackedFrame { time_us, hdf, vtu })
    }

    pub(super) fn add(&mut self, frame: &PackedFrame) -> Result<(), OutputError> {
        self.hdf.add(frame.time_us, &frame.hdf).map_err(failed(&self.folder, HDF))?;
        match &mut self.series {
            Some(series) => series.add(frame.time_us, &frame.vtu).map_err(failed(&self.folder, SERIES)),
            None => Ok(()),
        }
    }

    pub(super) fn close(self) -> Result<Staged, OutputError> {
        self.hdf.close().map_err(failed(&self.folder, HDF))?;
        let vtu = match self.series {
            Some(series) => Some((list(&self.folder, &series).map_err(failed(&self.folder, PVD))?, series)),
            None => None,
        };
        Ok(Staged { hdf: Some(self.file), vtu })
    }
}

fn list(folder: &Path, series: &VtuSeries) -> io::Result<NamedTempFile> {
    let file = temporary(folder)?;
    fs::write(file.path(), series.collection())?;
    file.as_file().sync_all()?;
    Ok(file)
}
