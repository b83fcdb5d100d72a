//! Frames that wait on the disk: those that memory has no room for, and those that a run which goes on from a checkpoint needs.
//!
//! A file of frames is written when its run is over. Until then each frame lies here in a file like a checkpoint, with a checksum of its
//! own, named by the steps done before it. The same run gives the same frames, so what is of the run is right whoever has written it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use same_file::Handle;
use tempfile::TempDir;

use super::earlier::clear_folder;
use super::hidden;
use crate::output::number::us;
use crate::run::checkpoint::{self, Checkpoint, CheckpointError, CheckpointFault, Header, Reader, Writer};
use crate::run::frame::{Frame, Scene};

/// Folder of the frames, beside the checkpoint.
const FOLDER: &str = "checkpoint.frames";
const ENDING: &str = ".bin";

/// A folder of frames.
pub(super) struct Spool {
    folder: PathBuf,
    /// Folder of the run, around it; `None` where it could not be opened.
    around: Option<Handle>,
    head: Header,
    /// Removes the folder of a run without checkpoints.
    temporary: Option<TempDir>,
    /// Whether the disk has refused a frame: from then on none is written.
    refused: Mutex<Refused>,
}

#[derive(Debug)]
enum Refused {
    No,
    /// From the frame of this time on [s], and why.
    From(f64, String),
    /// The user knows.
    Told(String),
}

impl Spool {
    /// Beside the checkpoints of a run.
    pub(super) fn beside(folder: &Path, head: &Header) -> Self {
        let (around, refused) = (Handle::from_path(folder).ok(), Mutex::new(Refused::No));
        Self { folder: folder.join(FOLDER), around, head: head.clone(), temporary: None, refused }
    }

    /// In a temporary folder, of a run without checkpoints.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(super) fn temporary(folder: &Path, head: &Header) -> io::Result<Self> {
        let own = hidden(folder)?;
        Ok(Self { folder: own.path().to_owned(), temporary: Some(own), ..Self::beside(folder, head) })
    }

    /// Where the frames lie.
    #[cfg(test)]
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The file of the frame before a step.
    fn path(&self, step: u64) -> PathBuf {
        self.folder.join(format!("{step:08}{ENDING}"))
    }

    fn refused(&self) -> MutexGuard<'_, Refused> {
        self.refused.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes a frame, unless the disk has refused one; whether it is there.
    pub(super) fn put(&self, frame: &Frame) -> bool {
        let mut error = None;
        if matches!(*self.refused(), Refused::No) {
            match self.write(frame) {
                Ok(()) => return true,
                Err(refused) => error = Some(refused.to_string()),
            }
        }
        let mut refused = self.refused();
        match (&mut *refused, error) {
            (now @ Refused::No, Some(error)) => *now = Refused::From(frame.time, error),
            // Frames are written several at a time: an earlier one may come later.
            (Refused::From(from, _), _) => *from = from.min(frame.time),
            _ => {}
        }
        false
    }

    /// Why frames are no longer written, told once.
    pub(super) fn complaint(&self) -> Option<String> {
        let mut refused = self.refused();
        let Refused::From(from, error) = &*refused else { return None };
        let words = format!("no frames are put beside the checkpoint from {} on: {error}", us(*from));
        *refused = Refused::Told(error.clone());
        Some(words)
    }

    /// Why frames are no longer written.
    pub(super) fn reason(&self) -> Option<String> {
        match &*self.refused() {
            Refused::No => None,
            Refused::From(_, error) | Refused::Told(error) => Some(error.clone()),
        }
    }

    /// Makes the folder in the folder of the run, not in one that took its place.
    fn begin(&self) -> io::Result<()> {
        let around = self.folder.parent().map(Handle::from_path).transpose()?;
        if around != self.around {
            return Err(io::Error::other("another folder took the place of that of the run"));
        }
        match fs::create_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && self.folder.is_dir() => Ok(()),
            made => made,
        }
    }

    /// Writes a frame; beside a checkpoint it is on the disk when this returns.
    fn write(&self, frame: &Frame) -> io::Result<()> {
        self.begin()?;
        let head = Header { step: frame.step, time: frame.time, ..self.head.clone() };
        let mut file = File::create(self.path(frame.step))?;
        checkpoint::write(&mut file, &head, &[], |contents| write(frame, contents))?;
        if self.temporary.is_some() { Ok(()) } else { file.sync_data() }
    }

    /// The frame before a step of a scene.
    pub(super) fn read(&self, step: u64, scene: &Scene) -> Result<Frame, CheckpointError> {
        let file = Checkpoint::open(&self.path(step))?;
        file.contents(|contents| {
            let mut frame = Frame { step: file.head().step, time: file.head().time, ..Frame::empty(scene) };
            fill(&mut frame, contents)?;
            match frame.projectile.is_some() == scene.projectile.is_some() {
                true => Ok(frame),
                false => Err(CheckpointFault::Contents("a projectile")),
            }
        })
    }

    /// Removes the frame before a step, which may not be there.
    pub(super) fn remove(&self, step: u64) {
        fs::remove_file(self.path(step)).ok();
    }

    /// Of the frames before these steps, those that follow each other without a gap up to the checkpoint.
    pub(super) fn found(&self, steps: &[u64]) -> SpooledFrames {
        let mut found = SpooledFrames { steps: Vec::new(), lost: None };
        let mut from = self.head.time;
        for step in steps.iter().rev() {
            if let Err(reason) = self.check(*step) {
                found.lost = Some(format!("frames before {} are lost: {reason}", us(from)));
                break;
            }
            found.steps.push(*step);
            from = *step as f64 * self.head.time_step;
        }
        found.steps.reverse();
        found
    }

    /// Whether the file of the frame before a step is of this run.
    fn check(&self, step: u64) -> Result<(), String> {
        let path = self.path(step);
        let own = |what: &str| format!("{} {what}", path.display());
        let head = match Checkpoint::open(&path) {
            Ok(file) => file.head().clone(),
            Err(CheckpointError { fault: CheckpointFault::Unreadable(_), .. }) => return Err(own("cannot be read")),
            Err(_) => return Err(own("is damaged")),
        };
        match head.is_of_run(&self.head) && head.step == step {
            true => Ok(()),
            false => Err(own("is of another run")),
        }
    }
}

/// Frames that follow each other without a gap up to a checkpoint.
pub(super) struct SpooledFrames {
    /// Steps done before them.
    pub(super) steps: Vec<u64>,
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

fn fill(frame: &mut Frame, contents: &mut Reader<'_>) -> Result<(), CheckpointFault> {
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
    let is_frame = |name: &str| name.strip_suffix(ENDING).is_some_and(|number| number.parse::<u64>().is_ok());
    clear_folder(&folder.join(FOLDER), is_frame)
}
