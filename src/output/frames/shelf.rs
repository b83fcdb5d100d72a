//! Frames beside a checkpoint, from which a run that goes on writes the files of the whole.
//!
//! A file of frames is finished when its run is; before that, what has been taken lies here, frame by frame, each in a file
//! like a checkpoint with a checksum of its own. The same run gives the same frames, so that what is of it is right whoever has
//! written it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::clear_folder;
use crate::checkpoint::{self, Checkpoint, CheckpointError, Fault, Head, Reader, Writer};
use crate::frame::{Frame, Scene};
use crate::output::number::us;

/// Folder of the frames, beside the checkpoint.
const SHELF: &str = "checkpoint.frames";
const ENDING: &str = ".bin";

/// Puts the frames of a run down.
pub(super) struct Shelf {
    folder: PathBuf,
    head: Head,
    /// Whether the disk has refused a frame: from then on none is put down.
    gone: Mutex<Gone>,
}

/// What there is to say of a shelf.
#[derive(Debug)]
enum Gone {
    No,
    /// From the frame of this time on [s], and why.
    Untold(f64, io::Error),
    Told,
}

impl Shelf {
    /// A shelf in the folder of a run.
    pub(super) fn new(folder: &Path, head: &Head) -> Self {
        Self { folder: folder.join(SHELF), head: head.clone(), gone: Mutex::new(Gone::No) }
    }

    fn path(&self, index: usize) -> PathBuf {
        self.folder.join(format!("{index:04}{ENDING}"))
    }

    fn gone(&self) -> MutexGuard<'_, Gone> {
        self.gone.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Puts a frame down, on the disk, unless the disk has refused one.
    pub(super) fn keep(&self, frame: &Frame) {
        if matches!(*self.gone(), Gone::No) {
            let put = self.put(frame);
            let mut gone = self.gone();
            if let (Gone::No, Err(error)) = (&*gone, put) {
                *gone = Gone::Untold(frame.time, error);
            }
        }
        // Frames are put down several at a time: an earlier one may come later.
        if let Gone::Untold(from, _) = &mut *self.gone() {
            *from = from.min(frame.time);
        }
    }

    /// Why there is no shelf any more, told once.
    pub(super) fn complaint(&self) -> Option<String> {
        let mut gone = self.gone();
        let Gone::Untold(from, error) = &*gone else { return None };
        let words = format!("no frames are put beside the checkpoint from {} on: {error}", us(*from));
        *gone = Gone::Told;
        Some(words)
    }

    /// Writes a frame; it is on the disk when this returns.
    fn put(&self, frame: &Frame) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let head = Head { step: frame.step, time: frame.time, ..self.head.clone() };
        let mut file = File::create(self.path(frame.index))?;
        checkpoint::write(&mut file, &head, &[], |contents| write(frame, contents))?;
        file.sync_data()
    }

    /// The frames that the run has taken before these steps; of several rows, where some are missing, the last one.
    pub(super) fn last_row(&self, steps: &[u64]) -> Row {
        let mut row = Row { files: Vec::new(), lost: None };
        let mut from = self.head.time;
        for (index, step) in steps.iter().enumerate().rev() {
            let path = self.path(index);
            if let Err(reason) = self.check(&path, *step) {
                row.lost = Some(format!("frames before {} are lost: {reason}", us(from)));
                break;
            }
            row.files.push(path);
            from = *step as f64 * self.head.time_step;
        }
        row.files.reverse();
        row
    }

    /// Whether a file holds the frame before a step of this run.
    fn check(&self, path: &Path, step: u64) -> Result<(), String> {
        let own = |what: &str| format!("{} {what}", path.display());
        let head = match Checkpoint::open(path) {
            Ok(file) => file.head().clone(),
            Err(CheckpointError { fault: Fault::Unreadable(_), .. }) => return Err(own("cannot be read")),
            Err(_) => return Err(own("is damaged")),
        };
        match head.is_of_run(&self.head) && head.step == step {
            true => Ok(()),
            false => Err(own("is of another run")),
        }
    }
}

/// Frames that follow each other without a gap up to a checkpoint.
pub(super) struct Row {
    /// Where they lie.
    pub(super) files: Vec<PathBuf>,
    /// Why there are none before these.
    pub(super) lost: Option<String>,
}

fn write(frame: &Frame, contents: &mut Writer<'_>) -> io::Result<()> {
    contents.value(&frame.projectile)?;
    for vectors in [&frame.displacement, &frame.velocity] {
        contents.numbers(bytemuck::cast_slice::<_, f32>(vectors))?;
    }
    for numbers in frame.tension.iter().chain(&frame.strain).chain(&frame.height).chain([&frame.shear_angle]) {
        contents.numbers(numbers)?;
    }
    frame.alive.iter().try_for_each(|alive| contents.numbers(alive))
}

/// Reads a frame of a scene.
pub(super) fn read(path: &Path, scene: &Scene) -> Result<Frame, CheckpointError> {
    let file = Checkpoint::open(path)?;
    file.contents(|contents| {
        let mut frame = Frame { step: file.head().step, time: file.head().time, ..Frame::empty(scene) };
        fill(&mut frame, contents)?;
        match frame.projectile.is_some() == scene.projectile.is_some() {
            true => Ok(frame),
            false => Err(Fault::Contents("a projectile")),
        }
    })
}

fn fill(frame: &mut Frame, contents: &mut Reader<'_>) -> Result<(), Fault> {
    frame.projectile = contents.value("a projectile")?;
    for vectors in [&mut frame.displacement, &mut frame.velocity] {
        contents.numbers(bytemuck::cast_slice_mut::<_, f32>(vectors), "nodes")?;
    }
    let Frame { tension, strain, height, shear_angle, alive, .. } = frame;
    for numbers in tension.iter_mut().chain(strain).chain(height).chain([shear_angle]) {
        contents.numbers(numbers, "elements")?;
    }
    alive.iter_mut().try_for_each(|alive| contents.numbers(alive, "elements"))
}

/// Removes what a run has left.
pub(in crate::output) fn clear(folder: &Path) -> io::Result<()> {
    let is_frame = |name: &str| name.strip_suffix(ENDING).is_some_and(|number| number.parse::<usize>().is_ok());
    clear_folder(&folder.join(SHELF), is_frame)
}
