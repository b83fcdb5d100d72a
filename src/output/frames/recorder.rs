//! Takes the frames of a run and keeps them until it is over.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::spool::{Spool, SpooledFrames};
use super::writer::{Files, failed};
use super::{HDF, Staged};
use crate::case::Case;
use crate::output::folder::OutputError;
use crate::run::checkpoint::Header;
use crate::run::frame::{self, Frame, Scene, Snapshot, SnapshotTaker};
use crate::run::{Observer, Options, View};

/// A frame that waits to be written.
struct Waiting {
    /// [s]
    time: f64,
    /// `None`: on the disk alone.
    snapshot: Option<Snapshot>,
    /// It lies on the disk.
    spooled: bool,
}

/// Takes the frames of a run that it watches, and writes them when the run is over.
///
/// More are taken than asked for, since nobody knows when a run ends ([`crate::run::frame`]). They wait in memory; what has no room there
/// waits on the disk, and of a run with checkpoints all of them lie there, for the run that goes on.
pub struct Recorder {
    folder: PathBuf,
    case: Case,
    vtu: bool,
    camera: SnapshotTaker,
    /// By the steps done before them.
    waiting: BTreeMap<u64, Waiting>,
    /// The state after the last step.
    end: Option<Snapshot>,
    /// Bytes of snapshots that may be in memory.
    room: usize,
    head: Header,
    checkpoints: bool,
    spool: Option<Spool>,
    /// Steps done before frames on the disk that are no longer kept.
    given_up: Vec<u64>,
    /// Why frames are lost.
    refused: Option<OutputError>,
    /// Threads of the solver; `None`: one for each core.
    threads: Option<usize>,
}

impl Recorder {
    /// For the frames that a case asks for; their files go to `folder`. `vtu`: also as a series; `head`: of the run, where it leaves
    /// checkpoints.
    pub fn new(folder: &Path, case: &Case, options: &Options<'_>, vtu: bool, head: Option<&Header>) -> Self {
        Self {
            folder: folder.to_owned(),
            case: case.clone(),
            vtu,
            camera: SnapshotTaker::new(case.output.frames as usize, case.solver.end_time),
            waiting: BTreeMap::new(),
            end: None,
            room: case.waiting_frame_bytes(),
            head: head.cloned().unwrap_or_else(|| Header::new(case, options, 0.0)),
            checkpoints: head.is_some(),
            spool: head.map(|head| Spool::beside(folder, head)),
            given_up: Vec::new(),
            refused: None,
            threads: options.threads,
        }
    }

    /// The same of a run that goes on from the checkpoint with this head: with the frames that it had kept. Where some are lost, the
    /// files begin after those; the words say so.
    pub fn resume(
        folder: &Path,
        case: &Case,
        options: &Options<'_>,
        vtu: bool,
        head: &Header,
    ) -> (Self, Option<String>) {
        let (frames, end_time) = (case.output.frames as usize, case.solver.end_time);
        let camera = SnapshotTaker::resume(frames, end_time, head.step, head.time_step);
        let spool = Spool::beside(folder, head);
        let SpooledFrames { steps, lost } = spool.found(&camera.kept().collect::<Vec<_>>());
        let of = |step| {
            let time = step as f64 * head.time_step;
            (step, Waiting { time, snapshot: None, spooled: true })
        };
        let waiting = steps.into_iter().map(of).collect();
        let new = Self::new(folder, case, options, vtu, Some(head));
        (Self { camera, waiting, spool: Some(spool), ..new }, lost)
    }

    /// Puts every frame where a run that goes on finds it; what to tell the user where none will be any more.
    pub fn settle(&mut self) -> Option<String> {
        self.put();
        self.spool.as_ref()?.complaint()
    }

    /// Writes all frames to the disk that are not there yet.
    fn put(&mut self) {
        let Some(spool) = &self.spool else { return };
        self.waiting.par_iter_mut().filter(|(_, frame)| !frame.spooled).for_each(|(_, frame)| {
            frame.spooled = frame.snapshot.as_ref().is_some_and(|snapshot| spool.put(&snapshot.frame()));
        });
    }

    /// Gives up what the camera no longer keeps.
    fn give_up(&mut self) {
        let mut kept = self.camera.kept().peekable();
        let given_up = &mut self.given_up;
        self.waiting.retain(|step, frame| {
            while kept.next_if(|kept| kept < step).is_some() {}
            let keep = kept.next_if_eq(step).is_some();
            if !keep && frame.spooled {
                given_up.push(*step);
            }
            keep
        });
        if !self.checkpoints {
            drop(kept);
            self.discard();
        }
    }

    /// Removes from the disk what has been given up. Of a run with checkpoints the last one may need it until there is another.
    pub fn discard(&mut self) {
        for step in std::mem::take(&mut self.given_up) {
            self.spool.iter().for_each(|spool| spool.remove(step));
        }
    }

    /// Bytes of the snapshots in memory.
    fn bytes(&self) -> usize {
        self.waiting.values().filter_map(|frame| frame.snapshot.as_ref()).map(Snapshot::bytes).sum()
    }

    /// Moves what is in memory to the disk.
    fn spill(&mut self) -> Result<(), OutputError> {
        if self.spool.is_none() {
            self.spool = Some(Spool::temporary(&self.folder, &self.head).map_err(failed(&self.folder, HDF))?);
        }
        self.put();
        // What the disk refuses is lost: memory would not hold it.
        self.waiting.values_mut().for_each(|frame| frame.snapshot = None);
        self.spool.as_ref().and_then(Spool::reason).map_or(Ok(()), |reason| Err(failed(&self.folder, HDF)(reason)))
    }

    /// Writes the frames asked for; the files are complete, under temporary names.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn finish(mut self) -> Result<Staged, OutputError> {
        if let Some(error) = self.refused.take() {
            return Err(error);
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.threads.unwrap_or(0)).build();
        pool.map_err(failed(&self.folder, HDF))?.install(|| self.write())
    }

    fn write(self) -> Result<Staged, OutputError> {
        let mut all: Vec<(u64, Waiting)> = self.waiting.into_iter().collect();
        if let Some(end) = self.end {
            all.push((end.step(), Waiting { time: end.time(), snapshot: Some(end), spooled: false }));
        }
        let times: Vec<f64> = all.iter().map(|(_, frame)| frame.time).collect();
        let chosen = frame::even(&times, self.case.output.frames as usize);
        if chosen.is_empty() {
            return Ok(Staged::default());
        }
        let scene = match all.iter().find_map(|(_, frame)| frame.snapshot.as_ref()) {
            Some(snapshot) => snapshot.scene().clone(),
            None => Scene::of(&self.case).map_err(failed(&self.folder, HDF))?,
        };
        let read = |at: &usize| -> Result<Frame, OutputError> {
            let (step, waiting) = &all[*at];
            match (&waiting.snapshot, &self.spool) {
                (Some(snapshot), _) => Ok(snapshot.frame()),
                (None, Some(spool)) => spool.read(*step, &scene).map_err(failed(&self.folder, HDF)),
                (None, None) => Err(failed(&self.folder, HDF)("a frame is lost")),
            }
        };
        let mut files: Option<Files> = None;
        let at_once = (2 * rayon::current_num_threads()).min(self.case.frames_at_once());
        for some in chosen.chunks(at_once) {
            let frames = some.par_iter().map(read).collect::<Result<Vec<_>, _>>()?;
            let files = match &mut files {
                Some(files) => files,
                none => none.insert(Files::create(&self.folder, self.vtu, &scene, &frames[0])?),
            };
            let packed = frames.par_iter().map(|frame| files.pack(&scene, frame)).collect::<Result<Vec<_>, _>>()?;
            packed.iter().try_for_each(|frame| files.add(frame))?;
        }
        files.map_or_else(|| Ok(Staged::default()), Files::close)
    }
}

impl Observer for Recorder {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.camera.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let snapshot = self.camera.take(view);
        let (step, time) = (snapshot.step(), snapshot.time());
        self.waiting.insert(step, Waiting { time, snapshot: Some(snapshot), spooled: false });
        self.give_up();
        if self.bytes() > self.room && self.refused.is_none() {
            self.refused = self.spill().err();
        }
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.end = self.camera.end(view);
    }
}

#[cfg(test)]
#[path = "recorder_tests.rs"]
mod tests;
