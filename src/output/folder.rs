//! The output folder.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::{NamedTempFile, TempDir};

use super::disk::{self, Lock, temporary};
use super::{csv, figures};
use crate::case::Case;
use crate::run::Run;

/// The file that is only there when profiles were asked for.
const PROFILES: &str = "profiles.csv";
/// The file that is only there for packs of several plies.
const PLIES: &str = "plies.csv";
/// The file that is only there where it is asked for.
const REPORT: &str = "report.html";
/// The case as run.
const CASE: &str = "case.json";
/// The results in one object.
const SUMMARY: &str = "summary.json";
/// The last checkpoint of a run that has not ended.
pub const CHECKPOINT: &str = "checkpoint.bin";
/// List of the frames for ParaView, and the folder of its files.
pub(super) const PVD: &str = "frames.pvd";
pub(super) const FRAMES: &str = "frames";
/// Folder of frames that a run which goes on from the checkpoint needs.
pub(super) const SPOOL: &str = "checkpoint.frames";
/// Expectation of a folder.
const WRITABLE: &str = "a folder that can be written";
/// All files this module may write.
const FILES: [&str; 10] =
    [CASE, "history.csv", "events.csv", PLIES, PROFILES, PVD, "shot.svg", REPORT, SUMMARY, CHECKPOINT];

/// Complete frames under a temporary name; none by default.
#[derive(Debug, Default)]
pub struct StagedFrames(pub(super) Option<TempDir>);

/// Reason why results could not be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("error: {path}\n  expected: {expected}\n  found: {found}\n  help: {help}")]
#[non_exhaustive]
pub struct OutputError {
    /// File or folder.
    pub path: String,
    /// Expectation.
    pub expected: &'static str,
    /// Words of the system.
    pub found: String,
    /// Advice.
    pub help: &'static str,
}

impl OutputError {
    pub(super) fn new(path: &Path, expected: &'static str, found: impl ToString) -> Self {
        let help = "choose another folder with --out DIR";
        Self { path: path.display().to_string(), expected, found: found.to_string(), help }
    }

    /// Error of a file of results that the disk refuses.
    pub(crate) fn unwritten(path: &Path, error: &io::Error) -> Self {
        Self {
            help: "make room there, then go on with --resume",
            ..Self::new(path, "a disk that takes the results", error)
        }
    }

    /// Error of a folder that another run writes to.
    fn taken(path: &Path) -> Self {
        let help = "wait for its end, or choose another folder with --out DIR";
        let expected = "a folder that no other run writes to";
        Self { help, ..Self::new(path, expected, "another run, which is still going on") }
    }

    /// Error of a folder that was removed.
    fn gone(path: &Path) -> Self {
        let expected = "the folder that the run began with";
        let found = if path.exists() { "another one of this name" } else { "none: it was removed meanwhile" };
        Self { help: "run it again, and leave its folder until it has ended", ..Self::new(path, expected, found) }
    }
}

/// A folder that exists and can be written.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Folders made for it, outermost first.
    made: Vec<PathBuf>,
    /// Lock against other runs; `None` before it is taken and after it is given up.
    lock: Option<Lock>,
}

impl Folder {
    /// Folder of a run, made where it is missing and tried, so that the run does not end in vain. Until it is dropped no other run gets it.
    ///
    /// # Errors
    /// When it is a file, cannot be made or written, another run has it, or when results would replace the case file itself.
    pub fn prepare(path: &Path, case: &Case) -> Result<Self, OutputError> {
        Self::prepare_for(path, &FILES, &[case.path.as_path()])
    }

    /// Folder of a run that goes on; its case lies there.
    ///
    /// # Errors
    /// As [`Folder::prepare`].
    pub fn reopen(path: &Path) -> Result<Self, OutputError> {
        let help = "wait for the end of a run that writes to it, or see to it that it can be written";
        let folder = Self::prepare_for(path, &FILES, &[]).map_err(|error| OutputError { help, ..error })?;
        // A run that was killed had no time to do that.
        disk::remove_unfinished(path).map_err(|error| folder.refused("", &error))?;
        Ok(folder)
    }

    /// Folder of these files, none of which may replace one of those that were read.
    ///
    /// # Errors
    /// As [`Folder::prepare`].
    pub fn prepare_for(path: &Path, files: &[&str], read: &[&Path]) -> Result<Self, OutputError> {
        if path.exists() && !path.is_dir() {
            return Err(OutputError::new(path, "a folder for the results", "a file"));
        }
        let missing = |folder: &&Path| *folder != Path::new("") && !folder.exists();
        let mut made: Vec<PathBuf> = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        made.reverse();
        let mut folder = Self { path: path.to_owned(), made, lock: None };
        match folder.take(files, read) {
            Ok(()) => Ok(folder),
            Err(error) => {
                folder.abandon();
                Err(error)
            }
        }
    }

    /// Makes the folder, tries and locks it.
    fn take(&mut self, files: &[&str], read: &[&Path]) -> Result<(), OutputError> {
        let path = self.path.as_path();
        let unwritable = |error| OutputError::new(path, WRITABLE, error);
        fs::create_dir_all(path).and_then(|()| temporary(path)).map(drop).map_err(unwritable)?;
        self.keeps(files, read)?;
        let lock = Lock::take(path).map_err(unwritable)?.ok_or_else(|| OutputError::taken(path))?;
        self.lock = Some(lock);
        Ok(())
    }

    /// Refuses to write over what was read.
    fn keeps(&self, files: &[&str], read: &[&Path]) -> Result<(), OutputError> {
        // A built-in case has no file.
        let read: Vec<PathBuf> = read.iter().filter_map(|path| path.canonicalize().ok()).collect();
        for name in files {
            let path = self.path.join(name);
            if path.is_dir() {
                return Err(OutputError::new(&path, "a file or nothing", "a folder"));
            }
            if path.canonicalize().is_ok_and(|path| read.contains(&path)) {
                let (expected, found) = ("a folder where no result replaces a file that was read", "which was read");
                return Err(OutputError::new(&self.path, expected, format!("{name}, {found}")));
            }
        }
        Ok(())
    }

    /// Path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the folder is still the one that was prepared.
    pub(super) fn check_identity(&self) -> Result<(), OutputError> {
        let stands = self.lock.as_ref().is_none_or(|lock| lock.has_folder(&self.path));
        if stands { Ok(()) } else { Err(OutputError::gone(&self.path)) }
    }

    /// Takes back the folders made by [`Folder::prepare`], as far as they are empty.
    pub fn abandon(mut self) {
        self.lock = None; // with its file
        for folder in self.made.iter().rev() {
            if fs::remove_dir(folder).is_err() {
                return; // something else lies there by now
            }
        }
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
        frames: StagedFrames,
    ) -> Result<Vec<&'static str>, OutputError> {
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
        let frames = self.place_frames(frames).map_err(|error| self.refused(FRAMES, &error))?;
        let mut names = self.place(complete, &[SUMMARY, PLIES, PROFILES, REPORT])?;
        names.extend(frames);
        Ok(names)
    }

    /// Makes the folder that of a run which will leave checkpoints: the case is there, nothing of an earlier run is.
    ///
    /// # Errors
    /// When the disk refuses.
    pub(crate) fn begin(&self, case: &Case) -> Result<(), OutputError> {
        self.put(&[(CASE, pretty(&case.as_run))], &FILES)?;
        self.clear_series(SPOOL).map_err(|error| self.refused(SPOOL, &error))
    }

    /// Gives frames their names, where those of an earlier run go first; returns the names.
    fn place_frames(&self, frames: StagedFrames) -> io::Result<Vec<&'static str>> {
        disk::remove(&self.path.join(PVD))?;
        self.clear_series(FRAMES)?;
        let Some(staged) = frames.0 else { return Ok(Vec::new()) };
        fs::create_dir_all(self.path.join(FRAMES))?;
        for entry in fs::read_dir(staged.path())? {
            let name = entry?.file_name();
            let to = if name == PVD { self.path.clone() } else { self.path.join(FRAMES) };
            fs::rename(staged.path().join(&name), to.join(&name))?;
        }
        Ok(vec![PVD, "frames/*.vtu"])
    }

    /// Removes the frames in a folder of them, and the folder unless something else lies there.
    fn clear_series(&self, name: &str) -> io::Result<()> {
        let Ok(entries) = fs::read_dir(self.path.join(name)) else { return Ok(()) };
        let is_frame = |name: &str| {
            // Killed while it wrote, a run leaves a file without its ending.
            let name = name.strip_suffix(".vtu").or_else(|| name.strip_suffix(".tmp"));
            let number = name.and_then(|name| name.split_once('_'));
            number
                .is_some_and(|(part, number)| ["fabric", "projectile"].contains(&part) && number.parse::<u64>().is_ok())
        };
        for entry in entries {
            let entry = entry?;
            if is_frame(&entry.file_name().to_string_lossy()) {
                fs::remove_file(entry.path())?;
            }
        }
        // It stays where a user keeps something else there.
        fs::remove_dir(self.path.join(name)).ok();
        Ok(())
    }

    /// A folder of its own under a temporary name.
    pub(super) fn temporary_folder(&self) -> io::Result<TempDir> {
        self.check_identity().map_err(|error| io::Error::other(error.found))?;
        disk::temporary_folder(&self.path)
    }

    /// Writes a file piece by piece; it takes the place of an older one once it is complete. What a run that was killed
    /// leaves of it is written over by the next.
    ///
    /// # Errors
    /// When the disk refuses, or `write` does; the older one is then still there.
    pub(crate) fn replace(&self, name: &str, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
        self.check_identity().map_err(|error| io::Error::other(error.found))?;
        disk::replace(&self.path.join(name), &self.path.join(staged(name)), write).and_then(|()| self.flush())
    }

    /// Removes the checkpoint of a run that has ended, or of one whose results are no longer here.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn forget(&self) -> Result<(), OutputError> {
        let remove = |name: &str| {
            let path = self.path.join(name);
            disk::remove(&path).map_err(|error| OutputError::new(&path, "a file that can be removed", error))
        };
        remove(&staged(CHECKPOINT)).and_then(|()| remove(CHECKPOINT))?;
        self.clear_series(SPOOL).map_err(|error| self.refused(SPOOL, &error))
    }

    /// Writes files, all complete before the first gets its name; `stale` ones of an earlier time go before that.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn put<'a>(&self, files: &[(&'a str, impl AsRef<[u8]>)], stale: &[&str]) -> Result<Vec<&'a str>, OutputError> {
        self.place(self.complete(files)?, stale)
    }

    /// Complete files under temporary names.
    fn complete<'a, T: AsRef<[u8]>>(
        &self,
        files: &[(&'a str, T)],
    ) -> Result<Vec<(&'a str, NamedTempFile)>, OutputError> {
        self.check_identity()?;
        let stage = |content: &[u8]| {
            let mut file = temporary(&self.path)?;
            file.write_all(content)?;
            file.as_file().sync_all()?;
            Ok(file)
        };
        let staged = files.iter().map(|(name, content)| {
            stage(content.as_ref()).map(|file| (*name, file)).map_err(|error| self.refused(name, &error))
        });
        staged.collect()
    }

    /// Gives files their names, after `stale` ones of an earlier time are gone.
    fn place<'a>(&self, files: Vec<(&'a str, NamedTempFile)>, stale: &[&str]) -> Result<Vec<&'a str>, OutputError> {
        for name in stale {
            disk::remove(&self.path.join(name)).map_err(|error| self.refused(name, &error))?;
        }
        let mut names = Vec::new();
        for (name, file) in files {
            file.persist(self.path.join(name)).map_err(|error| self.refused(name, &error.error))?;
            names.push(name);
        }
        self.flush().map_err(|error| self.refused("", &error))?;
        Ok(names)
    }

    fn refused(&self, name: &str, error: &io::Error) -> OutputError {
        OutputError::new(&self.path.join(name), "a disk that takes the results", error)
    }

    /// Flushes the renames.
    fn flush(&self) -> io::Result<()> {
        if cfg!(unix) { File::open(&self.path)?.sync_all() } else { Ok(()) }
    }
}

fn pretty(value: &Value) -> String {
    format!("{value:#}\n")
}

/// Name of a file that is being written.
fn staged(name: &str) -> String {
    format!(".{name}.tmp")
}
