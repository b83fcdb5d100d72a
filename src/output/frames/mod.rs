//! Frames for ParaView: `frames.vtkhdf`, and on request `frames.pvd` with a `.vtu` file for every part and frame.
//!
//! The solver's thread only copies what has moved and puts it into a queue; everything else happens on a thread beside it where
//! there is a core for that, else after the run. Files are written under temporary names and get theirs when the run is over,
//! however it ended. Of a run that leaves checkpoints every frame lies on a shelf as well, for the run that goes on.

mod hdf;
mod parts;
mod queue;
mod shelf;
mod vtu;
mod writer;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use rayon::prelude::*;
use tempfile::NamedTempFile;
use thread_priority::ThreadPriority;

use super::folder::OutputError;
use crate::case::Case;
use crate::checkpoint::Head;
use crate::frame::Camera;
use crate::simulation::{Options, View, Watch};
use queue::Queue;
use shelf::{Row, Shelf};
use vtu::{SERIES, Series};
use writer::Writer;

pub(super) use shelf::clear as clear_shelf;

/// The file with all frames, and the one that lists those of the series.
pub(super) const HDF: &str = "frames.vtkhdf";
pub(super) const PVD: &str = "frames.pvd";
/// What stands for the files of the series in a list of files.
const VTU: &str = "frames/*.vtu";
/// What a place for frames has to be.
const WRITABLE: &str = "a disk that takes the frames";

/// Writes the frames of a run that it watches.
pub struct Recorder {
    camera: Camera,
    queue: Arc<Queue>,
    shelf: Option<Arc<Shelf>>,
    beside: JoinHandle<Result<Writer, OutputError>>,
    /// Threads of the solver; `None`: one for each core.
    threads: Option<usize>,
}

impl Recorder {
    /// Begins to take the frames that a case asks for; their files go to `folder`. `vtu`: also as a series; `head`: of the run,
    /// where it leaves checkpoints.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn start(
        folder: &Path,
        case: &Case,
        options: &Options<'_>,
        vtu: bool,
        head: Option<&Head>,
    ) -> io::Result<Self> {
        let camera = Camera::new(case.output.frames as usize, case.solver.end_time);
        let shelf = head.map(|head| Shelf::new(folder, head));
        Self::spawn(case, options, camera, shelf, Writer::new(folder, case, vtu, Vec::new()))
    }

    /// The same of a run that goes on from the checkpoint with this head: the frames that it had taken come first. Where some
    /// are lost, the files begin after those; the words say so.
    ///
    /// # Errors
    /// When the system has no thread for it.
    pub fn resume(
        folder: &Path,
        case: &Case,
        options: &Options<'_>,
        vtu: bool,
        head: &Head,
    ) -> io::Result<(Self, Option<String>)> {
        let (frames, end_time) = (case.output.frames as usize, case.solver.end_time);
        let (camera, steps) = Camera::resume(frames, end_time, head.step, head.time_step);
        let shelf = Shelf::new(folder, head);
        let Row { files, lost } = shelf.last_row(&steps);
        let writer = Writer::new(folder, case, vtu, files);
        Ok((Self::spawn(case, options, camera, Some(shelf), writer)?, lost))
    }

    fn spawn(
        case: &Case,
        options: &Options<'_>,
        camera: Camera,
        shelf: Option<Shelf>,
        mut writer: Writer,
    ) -> io::Result<Self> {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        // What computes on a device leaves the cores alone.
        let spare = options.device.is_some() || options.threads.is_some_and(|threads| threads < cores);
        let queue = Arc::new(Queue::new(case.waiting_frame_bytes(), spare));
        let shelf = shelf.map(Arc::new);
        let work = {
            let (queue, shelf) = (queue.clone(), shelf.clone());
            move || {
                step_back();
                let written = writer.follow(&queue, shelf.as_deref());
                queue.close();
                written.map(|()| writer)
            }
        };
        let beside = thread::Builder::new().name("frames".to_owned()).spawn(work)?;
        Ok(Self { camera, queue, shelf, beside, threads: options.threads })
    }

    /// Puts every frame taken where a run that goes on finds it; what to tell the user where none will be any more.
    pub fn settle(&self) -> Option<String> {
        let shelf = self.shelf.as_ref()?;
        self.queue.hold(|waiting| {
            waiting.par_iter_mut().filter(|frame| !frame.shelved).for_each(|frame| {
                shelf.keep(&frame.snapshot.frame());
                frame.shelved = true;
            });
        });
        shelf.complaint()
    }

    /// Writes what is left; the files are complete, under temporary names.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn finish(self) -> Result<Staged, OutputError> {
        let stopped = |reason: &dyn std::fmt::Display| OutputError::new(Path::new(HDF), WRITABLE, reason);
        self.queue.close();
        let writer = self.beside.join().map_err(|_| stopped(&"the writer stopped"))??;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads.unwrap_or(0)).build();
        let rest: Vec<_> = self.queue.rest().into_iter().map(|frame| frame.snapshot).collect();
        pool.map_err(|error| stopped(&error))?.install(|| writer.finish(rest))
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
        self.camera.is_due(time, dt)
    }

    fn look(&mut self, view: &View<'_>) {
        self.queue.push(self.camera.take(view));
    }
}

/// Complete files under temporary names.
#[derive(Default)]
pub struct Staged {
    hdf: Option<NamedTempFile>,
    /// The list, and the series.
    vtu: Option<(NamedTempFile, Series)>,
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
