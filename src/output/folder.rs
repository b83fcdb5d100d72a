//! The output folder: one run holds it, and a file in it is complete or not there. Of its checkpoints the last stays.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use same_file::Handle;
use serde_json::Value;
use tempfile::NamedTempFile;

use super::{csv, figures};
use crate::case::{Case, CaseError};
use crate::run::checkpoint::{Checkpointable, Header};
use crate::run::{Run, interval_over};

const CASE: &str = "case.json";
const SUMMARY: &str = "summary.json";
/// Files that are only there when profiles were asked for, for packs of several plies, and where a report is asked for.
const PROFILES: &str = "profiles.csv";
const PLIES: &str = "plies.csv";
const REPORT: &str = "report.html";
/// The last checkpoint of a run that has not ended.
pub const CHECKPOINT: &str = "checkpoint.bin";
/// List of the frames for ParaView, and the folder of its files.
pub(super) const PVD: &str = "frames.pvd";
pub(super) const FRAMES: &str = "frames";
/// Folder of frames that a run which goes on from the checkpoint needs.
pub(super) const SPOOL: &str = "checkpoint.frames";
/// All files this module may write.
const FILES: [&str; 10] =
    [CASE, "history.csv", "events.csv", PLIES, PROFILES, PVD, "shot.svg", REPORT, SUMMARY, CHECKPOINT];
/// Lock file. A process that was killed leaves it, unlocked.
const LOCK: &str = ".ripstop.lock";
/// Begin and end of the names of unfinished files.
const UNFINISHED: [&str; 2] = [".ripstop-", ".tmp"];

/// Complete frames elsewhere; none by default.
#[derive(Debug, Default)]
pub struct StagedFrames {
    /// Path of each file, and its name in the series.
    pub(super) files: Vec<(PathBuf, String)>,
    /// Text of the list.
    pub(super) list: String,
}

/// Advice on a folder that cannot take results.
pub(super) const ANOTHER: &str = "choose another folder with --out DIR";

/// A folder that exists and can be written.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Folders made for it, outermost first.
    made: Vec<PathBuf>,
    /// Lock file in it, which goes with a folder that is removed or replaced meanwhile.
    held: Option<Handle>,
}

impl Drop for Folder {
    fn drop(&mut self) {
        self.release();
    }
}

impl Folder {
    /// Folder of a run, made where it is missing and tried, so that the run does not end in vain. Until it is dropped no other run gets it.
    ///
    /// # Errors
    /// When it is a file, cannot be made or written, another run has it, or when results would replace the case file itself.
    pub fn prepare(path: &Path, case: &Case) -> Result<Self, CaseError> {
        Self::prepare_for(path, &FILES, &[case.path.as_path()])
    }

    /// Folder of a run that goes on; its case lies there.
    ///
    /// # Errors
    /// As [`Folder::prepare`].
    pub fn reopen(path: &Path) -> Result<Self, CaseError> {
        let help = "wait for the end of a run that writes to it, or see to it that it can be written";
        Self::prepare_for(path, &FILES, &[]).map_err(|error| error.help(help))
    }

    /// Folder of these files, none of which may replace one of those that were read.
    ///
    /// # Errors
    /// As [`Folder::prepare`].
    pub fn prepare_for(path: &Path, files: &[&str], read: &[&Path]) -> Result<Self, CaseError> {
        if path.exists() && !path.is_dir() {
            return Err(CaseError::of_path(path, "a folder for the results", "a file", ANOTHER));
        }
        let missing = |folder: &&Path| *folder != Path::new("") && !folder.exists();
        let mut made: Vec<PathBuf> = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        made.reverse();
        let mut folder = Self { path: path.to_owned(), made, held: None };
        match folder.take(files, read) {
            Ok(()) => Ok(folder),
            Err(error) => {
                folder.abandon();
                Err(error)
            }
        }
    }

    /// Makes the folder, tries and locks it.
    fn take(&mut self, files: &[&str], read: &[&Path]) -> Result<(), CaseError> {
        let path = self.path.as_path();
        let unwritable = |error: io::Error| CaseError::of_path(path, "a folder that can be written", error, ANOTHER);
        fs::create_dir_all(path).and_then(|()| temporary(path)).map(drop).map_err(unwritable)?;
        self.keeps(files, read)?;
        let Some(held) = hold(path).map_err(unwritable)? else {
            let help = "wait for its end, or choose another folder with --out DIR";
            let (expected, found) = ("a folder that no other run writes to", "another run, which is still going on");
            return Err(CaseError::of_path(path, expected, found, help));
        };
        self.held = Some(held);
        // A run that was killed had no time to do that.
        remove_unfinished(path).map_err(unwritable)
    }

    /// Refuses to write over what was read.
    fn keeps(&self, files: &[&str], read: &[&Path]) -> Result<(), CaseError> {
        // A built-in case has no file.
        let read: Vec<PathBuf> = read.iter().filter_map(|path| path.canonicalize().ok()).collect();
        for name in files {
            let path = self.path.join(name);
            if path.is_dir() {
                return Err(CaseError::of_path(&path, "a file or nothing", "a folder", ANOTHER));
            }
            if path.canonicalize().is_ok_and(|path| read.contains(&path)) {
                let (expected, found) = ("a folder where no result replaces a file that was read", "which was read");
                return Err(CaseError::of_path(&self.path, expected, format!("{name}, {found}"), ANOTHER));
            }
        }
        Ok(())
    }

    /// Path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the folder is still the one that was prepared.
    pub(super) fn check_identity(&self) -> Result<(), CaseError> {
        if self.held.as_ref().is_none_or(|held| is_at(held, &self.path.join(LOCK))) {
            return Ok(());
        }
        let found = if self.path.exists() { "another one of this name" } else { "none: it was removed meanwhile" };
        let help = "run it again, and leave its folder until it has ended";
        Err(CaseError::of_path(&self.path, "the folder that the run began with", found, help))
    }

    /// Removes the lock file while it is locked, so that no other run's is removed.
    fn release(&mut self) {
        let (held, path) = (self.held.take(), self.path.join(LOCK));
        if held.as_ref().is_some_and(|held| is_at(held, &path)) {
            fs::remove_file(&path).ok(); // one that stays has no effect
        }
    }

    /// Takes back the folders made by [`Folder::prepare`], as far as they are empty.
    pub fn abandon(mut self) {
        self.release();
        // One that something else lies in by now stays, and so do those around it.
        self.made.iter().rev().take_while(|folder| fs::remove_dir(folder).is_ok()).for_each(drop);
    }

    /// Writes all results of a run, the page that reports them where there is one, and its frames; returns the names of the files.
    ///
    /// # Errors
    /// When the disk refuses; what lay in the folder before is then still there as long as no file was complete.
    pub fn write(
        &self,
        case: &Case,
        run: &Run,
        summary: &Value,
        report: Option<String>,
        frames: &StagedFrames,
    ) -> Result<Vec<&'static str>, CaseError> {
        let mut texts = vec![
            (CASE, pretty(&case.as_run)),
            ("history.csv", csv::history(&run.history)),
            ("events.csv", csv::events(case, &run.events, run.time_step)),
        ];
        if run.plies > 1 {
            texts.push((PLIES, csv::plies(&run.ply_history)));
        }
        if !case.output.profile_times.is_empty() {
            texts.push((PROFILES, csv::profiles(&run.profiles)));
        }
        texts.push(("shot.svg", figures::shot(case, run)));
        texts.extend(report.map(|page| (REPORT, page)));
        // Last, so that a summary speaks of the files around it.
        texts.push((SUMMARY, pretty(summary)));
        let complete = self.complete(&texts)?;
        let has_frames = self.place_frames(frames).map_err(|error| self.refused(FRAMES, &error))?;
        let mut names = self.place(complete, &[SUMMARY, PLIES, PROFILES, REPORT])?;
        names.extend(has_frames.then_some([PVD, "frames/*.vtu"]).into_iter().flatten());
        Ok(names)
    }

    /// Puts frames in place of those of an earlier run; whether there are any.
    fn place_frames(&self, staged: &StagedFrames) -> io::Result<bool> {
        let folder = self.path.join(FRAMES);
        remove(&self.path.join(PVD))?;
        for entry in fs::read_dir(&folder).into_iter().flatten() {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.ends_with(".vtu") && ["fabric_", "projectile_"].iter().any(|part| name.starts_with(part)) {
                fs::remove_file(entry.path())?;
            }
        }
        // It stays where a user keeps something else there.
        fs::remove_dir(&folder).ok();
        if staged.files.is_empty() {
            return Ok(false);
        }
        fs::create_dir_all(&folder)?;
        for (from, name) in &staged.files {
            // A run that was interrupted may go on, and needs what is staged: a second name, or a copy where the disk has none.
            let to = folder.join(name);
            fs::hard_link(from, &to).or_else(|_| fs::copy(from, &to).map(drop))?;
        }
        write_whole(&self.path.join(PVD), |file| file.write_all(staged.list.as_bytes()))?;
        Ok(true)
    }

    /// Removes the checkpoint of a run that has ended, or of one whose results are no longer here, with its frames.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn forget(&self) -> Result<(), CaseError> {
        let [checkpoint, spool] = [CHECKPOINT, SPOOL].map(|name| self.path.join(name));
        let frames = if spool.is_dir() { fs::remove_dir_all(&spool) } else { Ok(()) };
        let removed = remove(&checkpoint).and(frames);
        removed.map_err(|error| CaseError::of_path(&checkpoint, "a file that can be removed", error, ANOTHER))
    }

    /// Writes files, all complete before the first gets its name; `stale` ones of an earlier time go before that.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn put<'a>(&self, files: &[(&'a str, impl AsRef<[u8]>)], stale: &[&str]) -> Result<Vec<&'a str>, CaseError> {
        self.place(self.complete(files)?, stale)
    }

    /// Complete files under temporary names.
    fn complete<'a, T: AsRef<[u8]>>(&self, files: &[(&'a str, T)]) -> Result<Vec<(&'a str, NamedTempFile)>, CaseError> {
        self.check_identity()?;
        let stage = |(name, content): &(&'a str, T)| {
            let staged = complete(&self.path, |file| file.write_all(content.as_ref()));
            staged.map(|file| (*name, file)).map_err(|error| self.refused(name, &error))
        };
        files.iter().map(stage).collect()
    }

    /// Gives files their names, after `stale` ones of an earlier time are gone.
    fn place<'a>(&self, files: Vec<(&'a str, NamedTempFile)>, stale: &[&str]) -> Result<Vec<&'a str>, CaseError> {
        for name in stale {
            remove(&self.path.join(name)).map_err(|error| self.refused(name, &error))?;
        }
        let mut names = Vec::new();
        for (name, file) in files {
            file.persist(self.path.join(name)).map_err(|error| self.refused(name, &error.error))?;
            names.push(name);
        }
        self.flush().map_err(|error| self.refused("", &error))?;
        Ok(names)
    }

    fn refused(&self, name: &str, error: &io::Error) -> CaseError {
        CaseError::of_path(&self.path.join(name), "a disk that takes the results", error, ANOTHER)
    }

    /// Flushes the renames.
    fn flush(&self) -> io::Result<()> {
        if cfg!(unix) { File::open(&self.path)?.sync_all() } else { Ok(()) }
    }
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
        interval_over(self.head.every, self.tried, time, dt)
    }

    /// Writes a checkpoint in place of the one before. `followed`: state of the observer; `loop_seconds`: time
    /// in the loop so far, all parts of the run [s].
    ///
    /// # Errors
    /// When it could not be written, in words; the one before is still there.
    pub fn write(&mut self, run: &dyn Checkpointable, followed: &[u8], loop_seconds: f64) -> Result<(), String> {
        let head = Header { wall_seconds: self.wall_seconds(), loop_seconds, ..self.head.clone() };
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

    /// Time that all parts of the run have taken [s].
    pub fn wall_seconds(&self) -> f64 {
        self.head.wall_seconds + self.start.elapsed().as_secs_f64()
    }
}

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}

/// File of a folder, locked until it is closed, however the process ends; `None` where another run has it.
fn hold(folder: &Path) -> io::Result<Option<Handle>> {
    let path = folder.join(LOCK);
    let file = File::options().write(true).create(true).truncate(false).open(&path)?;
    // Some file systems have no locks: a run without one is better than none.
    if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
        return Ok(None);
    }
    let file = Handle::from_file(file)?;
    // A run that ended may have removed it between its opening and its locking.
    Ok(Some(file).filter(|file| is_at(file, &path)))
}

/// Whether an open file is the one at a path.
fn is_at(file: &Handle, path: &Path) -> bool {
    Handle::from_path(path).is_ok_and(|there| there == *file)
}

/// An empty file in `folder` with the rights of any new file, to be renamed when it is whole.
///
/// # Errors
/// Where the folder cannot be written.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED[0]).suffix(UNFINISHED[1]);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// A file in `folder` under a temporary name, once it is on the disk.
fn complete(folder: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<NamedTempFile> {
    let mut file = temporary(folder)?;
    write(file.as_file_mut())?;
    file.as_file().sync_all()?;
    Ok(file)
}

/// Writes a file; it takes the place of an older one once it is on the disk.
///
/// # Errors
/// When the disk refuses; the older one is then still there.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    complete(path.parent().unwrap_or(Path::new("")), write)?.persist(path)?;
    Ok(())
}

/// Removes what an earlier run has not finished.
fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(UNFINISHED[0]) && name.ends_with(UNFINISHED[1]) {
            remove(&entry.path())?; // another run may try the folder meanwhile
        }
    }
    Ok(())
}

/// Removes a file that may not be there.
fn remove(path: &Path) -> io::Result<()> {
    fs::remove_file(path).or_else(|error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) })
}
