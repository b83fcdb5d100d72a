//! Writer of the checkpoints of a run.

use std::time::Instant;

use super::{CHECKPOINT, Folder};
use crate::case::Case;
use crate::run::checkpoint::{Checkpointable, Header, Spent};

/// Rounding allowed in comparing times, in steps.
const SLACK: f64 = 1e-6;

/// Reason why there is no checkpoint of a time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no checkpoint at {time}: {reason}; {last}")]
#[non_exhaustive]
pub struct CheckpointWriteError {
    /// Time of the run, with its unit.
    pub time: String,
    /// Words of the disk or the device.
    pub reason: String,
    /// Fate of the checkpoint before.
    pub last: String,
}

/// Writer of checkpoints, of which the last stays.
pub struct CheckpointWriter<'a> {
    folder: &'a Folder,
    case: &'a Case,
    head: Header,
    /// Begin of this command.
    start: Instant,
    /// Whether the folder is this run's.
    begun: bool,
    /// Times of the last checkpoint tried, and of the last written [s].
    tried: f64,
    kept: Option<f64>,
    failed: Option<String>,
}

impl<'a> CheckpointWriter<'a> {
    /// Writer of a run that begins, or that goes on if `head` has come from a checkpoint in the folder.
    pub fn new(folder: &'a Folder, case: &'a Case, head: Header, start: Instant) -> Self {
        let resumed = head.step > 0;
        let kept = resumed.then_some(head.time);
        Self { folder, case, start, begun: resumed, tried: head.time, kept, failed: None, head }
    }

    /// Whether there should be a checkpoint before the step from `time` [s], `dt` [s] long.
    pub fn is_due(&self, time: f64, dt: f64) -> bool {
        let intervals = (self.tried / self.head.every + 1e-9).floor() + 1.0;
        time >= intervals * self.head.every - SLACK * dt
    }

    /// Writes a checkpoint in place of the one before. `followed`: state of the observer; `loop_seconds`: time
    /// in the loop so far, all parts of the run [s].
    ///
    /// # Errors
    /// When it could not be written; the one before is still there.
    pub fn write(
        &mut self,
        run: &dyn Checkpointable,
        followed: &[u8],
        loop_seconds: f64,
    ) -> Result<(), CheckpointWriteError> {
        let head = Header { spent: self.spent(loop_seconds), ..self.head.clone() };
        let (time, folder) = (run.time(), self.folder);
        self.tried = time;
        let write =
            || folder.replace(CHECKPOINT, |file| run.save(&head, followed, file)).map_err(|error| error.to_string());
        let result = self.begin().and_then(|()| write()).map_err(|reason| self.complaint(time, reason));
        match &result {
            Ok(()) => self.kept = Some(time),
            Err(error) => self.failed = Some(error.to_string()),
        }
        result
    }

    /// Makes the folder that of this run: files of an earlier one go.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn begin(&mut self) -> Result<(), String> {
        if !self.begun {
            self.folder.begin(self.case).map_err(|error| error.found)?;
            self.begun = true;
        }
        Ok(())
    }

    fn complaint(&self, time: f64, reason: String) -> CheckpointWriteError {
        let is_there = self.folder.path().join(CHECKPOINT).exists();
        let last = match self.kept {
            Some(kept) if is_there => format!("the one of {:.3} µs is still there", kept * 1e6),
            Some(_) => "the one before is gone".to_owned(),
            None => "there is none so far".to_owned(),
        };
        CheckpointWriteError { time: format!("{:.3} µs", time * 1e6), reason, last }
    }

    /// Time that all parts of the run have taken, so much of it in the loop [s].
    pub fn spent(&self, loop_seconds: f64) -> Spent {
        let wall = self.head.spent.wall + self.start.elapsed().as_secs_f64();
        Spent { wall, r#loop: loop_seconds, ..self.head.spent }
    }

    /// The last checkpoint that could not be written.
    pub fn failed(&self) -> Option<&str> {
        self.failed.as_deref()
    }

    /// Whether the folder holds a checkpoint of this run.
    pub fn has_kept(&self) -> bool {
        self.kept.is_some()
    }
}
