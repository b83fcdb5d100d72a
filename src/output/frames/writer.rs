//! From snapshots to files.

use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tempfile::{NamedTempFile, TempDir};

use super::hdf::{self, HdfFile};
use super::parts::Parts;
use super::queue::{Queue, Waiting};
use super::shelf::{self, Shelf};
use super::vtu::{SERIES, Series};
use super::{HDF, PVD, Staged, WRITABLE};
use crate::case::Case;
use crate::frame::{Frame, Scene, Snapshot};
use crate::output::folder::{OutputError, UNFINISHED, temporary};

/// Writes frames in their order.
pub(super) struct Writer {
    folder: PathBuf,
    case: Case,
    vtu: bool,
    /// Frames of the run so far, not yet written.
    before: Vec<PathBuf>,
    /// From the first frame on.
    files: Option<Files>,
}

impl Writer {
    /// `before`: files with the frames of the run so far, on the shelf.
    pub(super) fn new(folder: &Path, case: &Case, vtu: bool, before: Vec<PathBuf>) -> Self {
        Self { folder: folder.to_owned(), case: case.clone(), vtu, before, files: None }
    }

    /// Writes what may be taken from a queue, until that is closed.
    pub(super) fn follow(&mut self, queue: &Queue, shelf: Option<&Shelf>) -> Result<(), OutputError> {
        while let Some(Waiting { snapshot, shelved }) = queue.take() {
            self.copy()?;
            let frame = snapshot.frame();
            if let Some(shelf) = shelf.filter(|_| !shelved) {
                shelf.keep(&frame);
            }
            self.add(snapshot.scene(), &frame)?;
        }
        Ok(())
    }

    /// Writes the rest of a run, on all threads.
    pub(super) fn finish(mut self, rest: Vec<Snapshot>) -> Result<Staged, OutputError> {
        self.copy()?;
        let at_once = (2 * rayon::current_num_threads()).min(self.case.frames_at_once());
        for some in rest.chunks(at_once) {
            let (scene, frames) = (some[0].scene(), some.par_iter().map(Snapshot::frame).collect::<Vec<_>>());
            let files = self.files(scene, &frames[0])?;
            let packed = frames.par_iter().map(|frame| files.pack(scene, frame));
            let packed = packed.collect::<Result<Vec<_>, _>>()?;
            packed.iter().try_for_each(|frame| files.add(frame))?;
        }
        self.files.map_or_else(|| Ok(Staged::default()), Files::close)
    }

    /// Writes what the part of the run before has taken.
    fn copy(&mut self) -> Result<(), OutputError> {
        let before = std::mem::take(&mut self.before);
        if before.is_empty() {
            return Ok(());
        }
        let path = self.folder.join(HDF);
        let failed = |error: &dyn Display| OutputError::new(&path, "frames of the run so far", error);
        let scene = Scene::of(&self.case).map_err(|error| failed(&error))?;
        for path in before {
            let frame = shelf::read(&path, &scene).map_err(|error| failed(&error))?;
            self.add(&scene, &frame)?;
        }
        Ok(())
    }

    /// Writes one frame, on this thread alone.
    fn add(&mut self, scene: &Scene, frame: &Frame) -> Result<(), OutputError> {
        let files = self.files(scene, frame)?;
        let packed = files.pack(scene, frame)?;
        files.add(&packed)
    }

    /// The files, begun with the first frame.
    fn files(&mut self, scene: &Scene, first: &Frame) -> Result<&mut Files, OutputError> {
        match &mut self.files {
            Some(files) => Ok(files),
            none => Ok(none.insert(Files::create(&self.folder, self.vtu, scene, first)?)),
        }
    }
}

/// A frame as the files hold it, compressed.
struct Packed {
    time_us: f64,
    hdf: Vec<hdf::Packed>,
    vtu: Vec<Vec<u8>>,
}

/// Files in the making, under temporary names.
struct Files {
    folder: PathBuf,
    parts: Parts,
    file: NamedTempFile,
    hdf: HdfFile,
    series: Option<Series>,
}

fn failed<E: Display>(folder: &Path, name: &'static str) -> impl Fn(E) -> OutputError {
    let path = folder.join(name);
    move |error| OutputError::new(&path, WRITABLE, error)
}

impl Files {
    fn create(folder: &Path, vtu: bool, scene: &Scene, first: &Frame) -> Result<Self, OutputError> {
        let (parts, grids) = Parts::new(scene, first);
        let file = temporary(folder).map_err(failed(folder, HDF))?;
        let hdf = HdfFile::create(file.path(), &grids, &parts.of(scene, first)).map_err(failed(folder, HDF))?;
        let series = || hidden(folder).and_then(|own| Series::create(own, &grids)).map_err(failed(folder, SERIES));
        let series = if vtu { Some(series()?) } else { None };
        Ok(Self { folder: folder.to_owned(), parts, file, hdf, series })
    }

    fn pack(&self, scene: &Scene, frame: &Frame) -> Result<Packed, OutputError> {
        let (time_us, now) = (frame.time * 1e6, self.parts.of(scene, frame));
        let hdf = now.iter().map(hdf::pack).collect::<io::Result<_>>().map_err(failed(&self.folder, HDF))?;
        let vtu = match &self.series {
            Some(series) => series.pack(time_us, &now).map_err(failed(&self.folder, SERIES))?,
            None => Vec::new(),
        };
        Ok(Packed { time_us, hdf, vtu })
    }

    fn add(&mut self, frame: &Packed) -> Result<(), OutputError> {
        self.hdf.add(frame.time_us, &frame.hdf).map_err(failed(&self.folder, HDF))?;
        match &mut self.series {
            Some(series) => series.add(frame.time_us, &frame.vtu).map_err(failed(&self.folder, SERIES)),
            None => Ok(()),
        }
    }

    fn close(self) -> Result<Staged, OutputError> {
        self.hdf.close().map_err(failed(&self.folder, HDF))?;
        let vtu = match self.series {
            Some(series) => Some((list(&self.folder, &series).map_err(failed(&self.folder, PVD))?, series)),
            None => None,
        };
        Ok(Staged { hdf: Some(self.file), vtu })
    }
}

/// A folder of its own, under a temporary name.
fn hidden(folder: &Path) -> io::Result<TempDir> {
    tempfile::Builder::new().prefix(UNFINISHED[0]).suffix(UNFINISHED[1]).tempdir_in(folder)
}

fn list(folder: &Path, series: &Series) -> io::Result<NamedTempFile> {
    let file = temporary(folder)?;
    fs::write(file.path(), series.collection())?;
    file.as_file().sync_all()?;
    Ok(file)
}
