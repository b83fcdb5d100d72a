//! Frames for ParaView: `frames.vtkhdf`, and on request `frames.pvd` with a `.vtu` file for every part and frame.
//!
//! The solver's thread only copies what has moved and sends it off; everything else happens on a thread beside it. Files
//! are written under temporary names and get theirs when the run is over, however it ended. Of a run that leaves checkpoints
//! every frame lies on a shelf as well, for the run that goes on.

mod hdf;
mod parts;
mod shelf;
mod vtu;

use std::fmt::Display;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread::{self, JoinHandle};

use tempfile::{NamedTempFile, TempDir};
use thread_priority::ThreadPriority;

use super::folder::{OutputError, UNFINISHED, temporary};
use super::number::us;
use crate::case::Case;
use crate::checkpoint::Head;
use crate::frame::{Camera, Frame, Scene, Snapshot};
use crate::simulation::{View, Watch};
use hdf::HdfFile;
use parts::Parts;
use shelf::{Row, Shelf};
use vtu::{SERIES, Series};

pub(super) use shelf::clear as clear_shelf;

/// The file with all frames, and the one that lists those of the series.
pub(super) const HDF: &str = "frames.vtkhdf";
pub(super) const PVD: &str = "frames.pvd";
/// What stands for the files of the series in a list of files.
const VTU: &str = "frames/*.vtu";

/// Writes the frames of a run that it watches.
pub struct Recorder {
    camera: Camera,
    /// To the writer; gone when that has failed.
    queue: Option<SyncSender<Order>>,
    writer: JoinHandle<Result<Staged, OutputError>>,
}

/// What the writer begins with.
struct Beginning {
    folder: PathBuf,
    vtu: bool,
    shelf: Option<Shelf>,
    /// Frames of the run so far.
    before: Vec<PathBuf>,
}

/// What the writer is to do.
enum Order {
    /// Write a frame.
    Write(Snapshot),
    /// Say when everything before is on the disk, or what was not put there.
    Tell(SyncSender<Option<String>>),
}

impl Recorder {
    /// Starts the writer of the frames that a case asks for; its files go to `folder`. `vtu`: also as a series; `head`: of the run,
    /// where it leaves checkpoints.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn start(folder: &Path, case: &Case, vtu: bool, head: Option<&Head>) -> io::Result<Self> {
        let camera = Camera::new(case.output.frames as usize, case.solver.end_time);
        let shelf = head.map(|head| Shelf::new(folder, head));
        Self::spawn(case, camera, Beginning { folder: folder.to_owned(), vtu, shelf, before: Vec::new() })
    }

    /// The same of a run that goes on from the checkpoint with this head: the frames that it had taken come first. Where some
    /// are lost, the files begin after those; the words say so.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn resume(folder: &Path, case: &Case, vtu: bool, head: &Head) -> io::Result<(Self, Option<String>)> {
        let (frames, end_time) = (case.output.frames as usize, case.solver.end_time);
        let (camera, steps) = Camera::resume(frames, end_time, head.step, head.time_step);
        let shelf = Shelf::new(folder, head);
        let Row { files, lost } = shelf.last_row(&steps);
        let beginning = Beginning { folder: folder.to_owned(), vtu, shelf: Some(shelf), before: files };
        Ok((Self::spawn(case, camera, beginning)?, lost))
    }

    fn spawn(case: &Case, camera: Camera, beginning: Beginning) -> io::Result<Self> {
        let (queue, orders) = mpsc::sync_channel(case.waiting_frames());
        let case = case.clone();
        let work = move || {
            step_back();
            let Beginning { folder, vtu, shelf, before } = beginning;
            let mut writer = Writer { folder, vtu, shelf, complaint: None, files: None };
            writer.copy(&case, &before)?;
            writer.follow(&orders)
        };
        let writer = thread::Builder::new().name("frames".to_owned()).spawn(work)?;
        Ok(Self { camera, queue: Some(queue), writer })
    }

    /// Waits until every frame taken lies where a run that goes on finds it; what to tell the user where none will any more.
    pub fn settle(&mut self) -> Option<String> {
        let (done, told) = mpsc::sync_channel(1);
        self.order(Order::Tell(done));
        // A writer that has failed drops the other end, and says why when it is asked to finish.
        told.recv().ok().flatten()
    }

    fn order(&mut self, order: Order) {
        if self.queue.as_ref().is_some_and(|queue| queue.send(order).is_err()) {
            self.queue = None;
        }
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

/// Lets this thread run where no other wants to: it may wait, the solver's threads may not. Where the system does not let it, it runs
/// like them.
fn step_back() {
    thread_priority::set_current_thread_priority(ThreadPriority::Min).ok();
    // Linux lets a thread of low priority finish its turn of some milliseconds before one that wakes, unless it is an idle one.
    #[cfg(target_os = "linux")]
    {
        use thread_priority::{NormalThreadSchedulePolicy, ThreadSchedulePolicy, unix};
        let idle = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
        unix::set_thread_priority_and_policy(unix::thread_native_id(), ThreadPriority::Min, idle).ok();
    }
}

impl Watch for Recorder {
    fn is_due(&self, time: f64, dt: f64) -> bool {
        self.queue.is_some() && self.camera.is_due(time, dt)
    }

    fn look(&mut self, view: &View<'_>) {
        let snapshot = self.camera.take(view);
        self.order(Order::Write(snapshot));
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

/// The thread beside the solver.
struct Writer {
    folder: PathBuf,
    vtu: bool,
    /// Where the run leaves checkpoints.
    shelf: Option<Shelf>,
    /// Why there is no shelf any more.
    complaint: Option<String>,
    /// From the first frame on.
    files: Option<Files>,
}

impl Writer {
    /// Writes what the part of the run before has taken.
    fn copy(&mut self, case: &Case, files: &[PathBuf]) -> Result<(), OutputError> {
        if files.is_empty() {
            return Ok(());
        }
        let path = self.folder.join(HDF);
        let failed = |error: &dyn Display| OutputError::new(&path, "frames of the run so far", error);
        let scene = Scene::of(case).map_err(|error| failed(&error))?;
        for path in files {
            let frame = shelf::read(path, &scene).map_err(|error| failed(&error))?;
            self.add(&scene, &frame)?;
        }
        Ok(())
    }

    /// Writes what comes until the run is over.
    fn follow(mut self, orders: &Receiver<Order>) -> Result<Staged, OutputError> {
        for order in orders {
            match order {
                Order::Write(snapshot) => {
                    let frame = snapshot.frame();
                    if let Some(Err(error)) = self.shelf.as_ref().map(|shelf| shelf.put(&frame)) {
                        let from = us(frame.time);
                        self.complaint =
                            Some(format!("no frames are put beside the checkpoint from {from} on: {error}"));
                        self.shelf = None;
                    }
                    self.add(snapshot.scene(), &frame)?;
                }
                // Nobody waits any more where this fails.
                Order::Tell(done) => drop(done.send(self.complaint.take())),
            }
        }
        self.files.map_or_else(|| Ok(Staged::default()), |files| files.close(&self.folder))
    }

    fn add(&mut self, scene: &Scene, frame: &Frame) -> Result<(), OutputError> {
        let files = match &mut self.files {
            Some(files) => files,
            none => none.insert(Files::create(&self.folder, self.vtu, scene, frame)?),
        };
        files.add(&self.folder, scene, frame)
    }
}

/// Files in the making, under temporary names.
struct Files {
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
        Ok(Self { parts, file, hdf, series })
    }

    fn add(&mut self, folder: &Path, scene: &Scene, frame: &Frame) -> Result<(), OutputError> {
        let (time_us, now) = (frame.time * 1e6, self.parts.of(scene, frame));
        self.hdf.add(time_us, &now).map_err(failed(folder, HDF))?;
        match &mut self.series {
            Some(series) => series.add(time_us, &now).map_err(failed(folder, SERIES)),
            None => Ok(()),
        }
    }

    fn close(self, folder: &Path) -> Result<Staged, OutputError> {
        self.hdf.close().map_err(failed(folder, HDF))?;
        let vtu = match self.series {
            Some(series) => Some((list(folder, &series).map_err(failed(folder, PVD))?, series)),
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
