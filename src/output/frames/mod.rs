//! Frames for ParaView: `frames.vtkhdf`, and on request `frames.pvd` with a `.vtu` file for every part and frame.
//!
//! The solver's thread only copies what has moved and sends it off; everything else happens on a thread beside it. Files
//! are written under temporary names and get theirs when the run is over, however it ended.

mod hdf;
mod parts;
mod vtu;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::{self, JoinHandle};

use tempfile::{NamedTempFile, TempDir};
use thread_priority::ThreadPriority;

use super::folder::{OutputError, temporary};
use crate::case::Case;
use crate::frame::{Camera, Snapshot};
use crate::simulation::{View, Watch};
use hdf::HdfFile;
use parts::Parts;
use vtu::{SERIES, Series};

/// The file with all frames, and the one that lists those of the series.
pub(super) const HDF: &str = "frames.vtkhdf";
pub(super) const PVD: &str = "frames.pvd";
/// What stands for the files of the series in a list of files.
const VTU: &str = "frames/*.vtu";

/// Writes the frames of a run that it watches.
pub struct Recorder {
    camera: Camera,
    /// To the writer; gone when that has failed.
    queue: Option<SyncSender<Snapshot>>,
    writer: JoinHandle<Result<Staged, OutputError>>,
}

impl Recorder {
    /// Starts the writer of the frames that a case asks for; its files go to `folder`. `vtu`: also as a series.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn start(folder: &Path, case: &Case, vtu: bool) -> io::Result<Self> {
        let (queue, snapshots) = mpsc::sync_channel(case.waiting_frames());
        let folder = folder.to_owned();
        let write = move || {
            // It may wait, the solver's threads may not. Where the system does not let it, it runs like them.
            thread_priority::set_current_thread_priority(ThreadPriority::Min).ok();
            write(&folder, vtu, &snapshots)
        };
        let writer = thread::Builder::new().name("frames".to_owned()).spawn(write)?;
        let camera = Camera::new(case.output.frames as usize, case.solver.end_time);
        Ok(Self { camera, queue: Some(queue), writer })
    }

    /// Waits for the writer; the files are complete, under temporary names.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn finish(self) -> Result<Staged, OutputError> {
        drop(self.queue);
        let stopped = |_| OutputError::new(Path::new(HDF), WRITABLE, "the writer stopped");
        self.writer.join().map_err(stopped)?
    }
}

impl Watch for Recorder {
    fn is_due(&self, time: f64, dt: f64) -> bool {
        self.queue.is_some() && self.camera.is_due(time, dt)
    }

    fn look(&mut self, view: &View<'_>) {
        let Some(queue) = &self.queue else { return };
        if queue.send(self.camera.take(view)).is_err() {
            self.queue = None;
        }
    }
}

/// Complete files under temporary names.
#[derive(Default)]
pub struct Staged {
    hdf: Option<NamedTempFile>,
    /// The list, and the series.
    vtu: Option<(NamedTempFile, Series)>,
}

/// What a place for frames has to be.
const WRITABLE: &str = "a disk that takes the frames";

fn write(folder: &Path, vtu: bool, snapshots: &Receiver<Snapshot>) -> Result<Staged, OutputError> {
    let Ok(first) = snapshots.recv() else { return Ok(Staged::default()) };
    let failed = |name: &str, error: &dyn std::fmt::Display| OutputError::new(&folder.join(name), WRITABLE, error);
    let frame = first.frame();
    let (parts, grids) = Parts::new(first.scene(), &frame);
    let mut now = parts.of(first.scene(), &frame);
    let file = temporary(folder).map_err(|error| failed(HDF, &error))?;
    let mut hdf = HdfFile::create(file.path(), &grids, &now).map_err(|error| failed(HDF, &error))?;
    let mut series = match vtu {
        true => {
            Some(hidden(folder).and_then(|own| Series::create(own, &grids)).map_err(|error| failed(SERIES, &error))?)
        }
        false => None,
    };
    let mut snapshot = first;
    loop {
        let time_us = snapshot.time() * 1e6;
        hdf.add(time_us, &now).map_err(|error| failed(HDF, &error))?;
        if let Some(series) = &mut series {
            series.add(time_us, &now).map_err(|error| failed(SERIES, &error))?;
        }
        let Ok(next) = snapshots.recv() else { break };
        now = parts.of(next.scene(), &next.frame());
        snapshot = next;
    }
    hdf.close().map_err(|error| failed(HDF, &error))?;
    let vtu = match series {
        Some(series) => Some((list(folder, &series).map_err(|error| failed(PVD, &error))?, series)),
        None => None,
    };
    Ok(Staged { hdf: Some(file), vtu })
}

/// A folder of its own, under a temporary name.
fn hidden(folder: &Path) -> io::Result<TempDir> {
    tempfile::Builder::new().prefix(".ripstop-").suffix(".tmp").tempdir_in(folder)
}

fn list(folder: &Path, series: &Series) -> io::Result<NamedTempFile> {
    let file = temporary(folder)?;
    fs::write(file.path(), series.collection())?;
    file.as_file().sync_all()?;
    Ok(file)
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

/// Removes the frames of an earlier run.
fn clear(folder: &Path) -> io::Result<()> {
    let gone = |removed: io::Result<()>| match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    };
    gone(fs::remove_file(folder.join(HDF)))?;
    gone(fs::remove_file(folder.join(PVD)))?;
    let series = folder.join(SERIES);
    let Ok(entries) = fs::read_dir(&series) else { return Ok(()) };
    for entry in entries {
        let entry = entry?;
        if vtu::is_of_series(&entry.file_name().to_string_lossy()) {
            gone(fs::remove_file(entry.path()))?;
        }
    }
    // What else lies there stays, and with it the folder.
    fs::remove_dir(&series).ok();
    Ok(())
}
