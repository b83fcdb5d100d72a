//! Checkpoints of a run in its output folder: when they are due, and the last one written.

use std::time::Instant;

use super::folder::{CASE, CHECKPOINT, FILES, Folder, pretty, write_whole};
use crate::case::Case;
use crate::run::checkpoint::{Checkpointable, Header, Spent};

/// Rounding allowed in comparing times, in steps.
const SLACK: f64 = 1e-6;

/// Writer of checkpoints, of which the last stays.
pub struct CheckpointWriter<'a> {
    folder: &'a Folder,
    case: &'a Case,
    head: Header,
    /// Begin of this command.
    start: Instant,
    /// Whether the folder is this run's.
    begun: bool,
    /// Time of the last checkpoint tried [s].
    tried: f64,
    /// Time of the checkpoint of this run in the folder [s].
    pub kept: Option<f64>,
    /// The last checkpoint that could not be written, and why.
    pub failed: Option<String>,
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
    /// When it could not be written, in words; the one before is still there.
    pub fn write(&mut self, run: &dyn Checkpointable, followed: &[u8], loop_seconds: f64) -> Result<(), String> {
        let head = Header { spent: self.spent(loop_seconds), ..self.head.clone() };
        let (time, folder) = (run.clock()[0], self.folder);
        self.tried = time;
        let write = || {
            folder.check_identity().map_err(|error| error.found)?;
            let written = write_whole(&folder.path().join(CHECKPOINT), |file| run.save(&head, followed, file));
            written.and_then(|()| folder.flush()).map_err(|error| error.to_string())
        };
        if let Err(reason) = self.begin().and_then(|()| write()) {
            let last = self.kept.map_or_else(
                || "there is none so far".to_owned(),
                |kept| format!("the one of {:.3} µs is still there", kept * 1e6),
            );
            let error = format!("no checkpoint at {:.3} µs: {reason}; {last}", time * 1e6);
            self.failed = Some(error.clone());
            return Err(error);
        }
        self.kept = Some(time);
        Ok(())
    }

    /// Makes the folder that of this run: its case is there, nothing of an earlier run is.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn begin(&mut self) -> Result<(), String> {
        if !self.begun {
            let case = [(CASE, pretty(&self.case.as_run))];
            self.folder.put(&case, &FILES).map_err(|error| error.found)?;
            self.begun = true;
        }
        Ok(())
    }

    /// Time that all parts of the run have taken, so much of it in the loop [s].
    pub fn spent(&self, loop_seconds: f64) -> Spent {
        let wall = self.head.spent.wall + self.start.elapsed().as_secs_f64();
        Spent { wall, r#loop: loop_seconds }
    }
}
