//! Frames for ParaView: `frames.pvd` and a `.vtu` file for every part and frame.
//!
//! The thread of the solver only copies what has moved. Frames wait in memory until the run is over; what has no room there waits on
//! the disk as the files that it will be, and of a run with checkpoints all of them do, for the run that goes on.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tempfile::TempDir;

use super::disk;
use super::folder::{FRAMES, Folder, OutputError, PVD, SPOOL, StagedFrames};
use super::number::us;
use super::vtu::{self, VtuWriter};
use crate::case::Case;
use crate::run::checkpoint::Header;
use crate::run::frame::{Snapshot, SnapshotTaker, even};
use crate::run::{Observer, Options, View};

/// Recorder of the frames of a run that it follows, which it writes when the run is over.
///
/// More are taken than asked for, since the end of a run is not known before ([`crate::run::frame`]).
pub struct Recorder<'a> {
    folder: &'a Folder,
    case: &'a Case,
    taker: SnapshotTaker,
    writer: Option<VtuWriter>,
    /// Frames so far, by the steps done before them.
    kept: BTreeMap<u64, KeptFrame>,
    /// Steps done before frames in the spool that are no longer kept.
    dropped: Vec<u64>,
    /// Bytes of snapshots that may be in memory.
    room: usize,
    checkpoints: bool,
    /// Folder of the files that wait, of a run without checkpoints.
    temporary: Option<TempDir>,
    /// The disk refuses frames beside the checkpoint, and the user knows.
    refused: bool,
    /// Reason why frames are lost.
    error: Option<OutputError>,
    /// Threads of the solver; `None`: one for each core.
    threads: Option<usize>,
}

/// A frame that may be written.
struct KeptFrame {
    /// [s]
    time: f64,
    /// `None`: its files lie in the spool.
    snapshot: Option<Snapshot>,
}

impl<'a> Recorder<'a> {
    /// Recorder of the frames that a case asks for. `checkpoints`: the run leaves some.
    pub fn new(folder: &'a Folder, case: &'a Case, options: &Options<'_>, checkpoints: bool) -> Self {
        Self {
            folder,
            case,
            taker: SnapshotTaker::new(case.output.frames as usize, case.solver.end_time),
            writer: None,
            kept: BTreeMap::new(),
            dropped: Vec::new(),
            room: case.waiting_frame_bytes(),
            checkpoints,
            temporary: None,
            refused: false,
            error: None,
            threads: options.threads,
        }
    }

    /// Recorder of a run that goes on from the checkpoint with this header, with the frames beside it. Where some are missing, the
    /// series begins after those; the words say so.
    pub fn resume(
        folder: &'a Folder,
        case: &'a Case,
        options: &Options<'_>,
        header: &Header,
    ) -> (Self, Option<String>) {
        let (frames, end_time) = (case.output.frames as usize, case.solver.end_time);
        let mut recorder = Self::new(folder, case, options, true);
        recorder.taker = SnapshotTaker::resume(frames, end_time, header.step, header.time_step);
        let (steps, mut from): (Vec<u64>, f64) = (recorder.taker.kept().collect(), header.time);
        let spool = recorder.spool();
        for step in steps.into_iter().rev() {
            let missing =
                vtu::parts(case).iter().map(|part| spool.join(waiting(part, step))).find(|path| !path.is_file());
            if let Some(path) = missing {
                return (recorder, Some(format!("frames before {} are lost: {} is missing", us(from), path.display())));
            }
            from = step as f64 * header.time_step;
            recorder.kept.insert(step, KeptFrame { time: from, snapshot: None });
        }
        (recorder, None)
    }

    /// Folder of the files that wait.
    fn spool(&self) -> PathBuf {
        self.temporary.as_ref().map_or_else(|| self.folder.path().join(SPOOL), |own| own.path().to_owned())
    }

    /// Puts every frame where a run that goes on finds it; what to tell the user, once, where the disk refuses.
    pub fn settle(&mut self) -> Option<String> {
        if self.refused {
            return None;
        }
        let (time, error) = self.put().err()?;
        self.refused = true;
        Some(format!("no frames are put beside the checkpoint from {} on: {error}", us(time)))
    }

    /// Moves the frames in memory to the spool. The error has the time of the first that has no place there [s].
    fn put(&mut self) -> Result<(), (f64, io::Error)> {
        let Some((first, some)) = self.kept.values().find_map(|frame| Some((frame.time, frame.snapshot.as_ref()?)))
        else {
            return Ok(());
        };
        let spool = self.spool();
        let begin = || {
            self.folder.check_identity().map_err(|error| io::Error::other(error.found))?;
            fs::create_dir(&spool).or_else(|error| if spool.is_dir() { Ok(()) } else { Err(error) })
        };
        begin().map_err(|error| (first, error))?;
        let writer = match self.writer.take() {
            Some(writer) => writer,
            None => VtuWriter::new(self.case, some.scene()).map_err(|error| (first, error))?,
        };
        let parts = vtu::parts(self.case);
        let put = |(step, frame): (&u64, &mut KeptFrame)| {
            let snapshot = frame.snapshot.as_ref()?;
            let written = write(&writer, snapshot, |part| spool.join(waiting(parts[part], *step)));
            match written {
                Ok(()) => frame.snapshot = None,
                Err(error) => return Some((frame.time, error)),
            }
            None
        };
        let first = self.kept.par_iter_mut().filter_map(put).min_by(|a, b| a.0.total_cmp(&b.0));
        self.writer = Some(writer);
        first.map_or(Ok(()), Err)
    }

    /// Drops the frames that are no longer kept.
    fn drop_unkept(&mut self) {
        let kept: Vec<u64> = self.taker.kept().collect();
        let dropped = &mut self.dropped;
        self.kept.retain(|step, frame| {
            let keep = kept.binary_search(step).is_ok();
            if !keep && frame.snapshot.is_none() {
                dropped.push(*step);
            }
            keep
        });
        if !self.checkpoints {
            self.discard();
        }
    }

    /// Removes the files of dropped frames. Of a run with checkpoints the last one may need them until there is another.
    pub fn discard(&mut self) {
        let spool = self.spool();
        for step in self.dropped.drain(..) {
            // What stays there goes with the folder.
            vtu::parts(self.case).iter().for_each(|part| drop(fs::remove_file(spool.join(waiting(part, step)))));
        }
    }

    /// Makes room in memory.
    fn spill(&mut self) -> Result<(), OutputError> {
        if !self.checkpoints && self.temporary.is_none() {
            self.temporary = Some(self.folder.temporary_folder().map_err(|error| self.failed(error))?);
        }
        self.put().map_err(|(_, error)| self.failed(error))
    }

    fn failed(&self, error: impl Display) -> OutputError {
        OutputError::new(&self.folder.path().join(PVD), "a disk that takes the frames", error)
    }

    /// Writes the frames asked for; the files are complete, under temporary names.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn finish(mut self) -> Result<StagedFrames, OutputError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        let times: Vec<f64> = self.kept.values().map(|frame| frame.time).collect();
        let chosen = even(&times, self.case.output.frames as usize);
        let kept: Vec<(&u64, &KeptFrame)> = self.kept.iter().collect();
        let chosen: Vec<(&u64, &KeptFrame)> = chosen.into_iter().map(|at| kept[at]).collect();
        if chosen.is_empty() {
            return Ok(StagedFrames::default());
        }
        // A frame takes many times the memory of a snapshot.
        let most = self.case.frames_at_once();
        let threads = self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.clamp(1, most)).build();
        let staged = pool.map_err(|error| self.failed(error))?.install(|| self.stage(&chosen));
        staged.map_err(|error| self.failed(error))
    }

    fn stage(&self, frames: &[(&u64, &KeptFrame)]) -> io::Result<StagedFrames> {
        let (parts, spool) = (vtu::parts(self.case), self.spool());
        let folder = self.folder.temporary_folder()?;
        let new = frames.iter().find_map(|(_, frame)| frame.snapshot.as_ref());
        let writer = new.map(|snapshot| VtuWriter::new(self.case, snapshot.scene())).transpose()?;
        frames.par_iter().enumerate().try_for_each(|(number, (step, frame))| {
            let to = |part: usize| folder.path().join(file(parts[part], number));
            match (&frame.snapshot, &writer) {
                (Some(snapshot), Some(writer)) => write(writer, snapshot, to),
                // A run that was interrupted may go on: its files stay in the spool.
                _ => (0..parts.len()).try_for_each(|part| link(&spool.join(waiting(parts[part], **step)), &to(part))),
            }
        })?;
        let times = frames.iter().map(|(_, frame)| frame.time * 1e6);
        let list = vtu::collection(parts, times, |part, number| format!("{FRAMES}/{}", file(part, number)));
        put_file(&folder.path().join(PVD), list.as_bytes())?;
        Ok(StagedFrames(Some(folder)))
    }

    /// Bytes of the snapshots in memory.
    fn bytes(&self) -> usize {
        self.kept.values().filter_map(|frame| frame.snapshot.as_ref()).map(Snapshot::bytes).sum()
    }

    fn keep(&mut self, snapshot: Snapshot) {
        self.kept.insert(snapshot.step(), KeptFrame { time: snapshot.time(), snapshot: Some(snapshot) });
    }
}

/// Name of a file of the series.
fn file(part: &str, number: usize) -> String {
    format!("{part}_{number:04}.vtu")
}

/// Name of a file in the spool, of the frame before a step.
fn waiting(part: &str, step: u64) -> String {
    format!("{part}_{step:08}.vtu")
}

fn write(writer: &VtuWriter, snapshot: &Snapshot, to: impl Fn(usize) -> PathBuf) -> io::Result<()> {
    let files = writer.files(snapshot.scene(), &snapshot.frame())?;
    files.iter().enumerate().try_for_each(|(part, contents)| put_file(&to(part), contents))
}

fn put_file(path: &Path, contents: &[u8]) -> io::Result<()> {
    disk::replace(path, &path.with_extension("tmp"), |file| file.write_all(contents))
}

/// A second name of a file, or a copy where the disk has none.
fn link(from: &Path, to: &Path) -> io::Result<()> {
    fs::hard_link(from, to).or_else(|_| fs::copy(from, to).map(drop))
}

impl Observer for Recorder<'_> {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.taker.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let snapshot = self.taker.take(view);
        self.keep(snapshot);
        self.drop_unkept();
        if self.error.is_none() && self.bytes() > self.room {
            self.error = self.spill().err();
        }
        if self.error.is_some() {
            // Memory would not hold them.
            self.kept.clear();
        }
    }

    fn on_end(&mut self, view: &View<'_>) {
        if let Some(snapshot) = self.taker.end(view) {
            self.keep(snapshot);
        }
    }
}
