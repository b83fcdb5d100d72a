//! Files and folders on the disk: the lock on a folder, files that are complete or not there.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use same_file::Handle;
use tempfile::{NamedTempFile, TempDir};

/// Name of the lock file. A process that was killed leaves it, unlocked, and it has no effect.
pub(super) const LOCK: &str = ".ripstop.lock";
/// Attempts to lock a file that others lock and remove at the same time.
const ATTEMPTS: usize = 10;

/// A folder that is held. The system lets it go when the process ends, however that ends.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    file: Handle,
    /// The folder, which may be removed or replaced meanwhile.
    folder: Handle,
}

impl Lock {
    /// Holds a folder; `None` where another process, or another run of this one, does.
    ///
    /// # Errors
    /// When the folder cannot be read or written.
    pub(super) fn take(folder: &Path) -> io::Result<Option<Self>> {
        let path = folder.join(LOCK);
        for _ in 0..ATTEMPTS {
            let file = File::options().write(true).create(true).truncate(false).open(&path)?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => return Ok(None),
                // Some file systems have no locks: a run without one is better than none.
                Ok(()) | Err(TryLockError::Error(_)) => {}
            }
            let lock = Self { path: path.clone(), file: Handle::from_file(file)?, folder: Handle::from_path(folder)? };
            // The holder before may have removed the file between its opening and its locking.
            if lock.has_file() {
                return Ok(Some(lock));
            }
        }
        Ok(None)
    }

    /// Whether the file that is locked is the one that others find.
    fn has_file(&self) -> bool {
        Handle::from_path(&self.path).is_ok_and(|there| there == self.file)
    }

    /// Whether the folder is still the one that was taken.
    pub(super) fn has_folder(&self, folder: &Path) -> bool {
        Handle::from_path(folder).is_ok_and(|there| there == self.folder)
    }
}

impl Drop for Lock {
    /// Removes the file while it is locked, so that no other run's is removed.
    fn drop(&mut self) {
        if self.has_file() {
            // A file that stays has no effect.
            fs::remove_file(&self.path).ok();
        }
    }
}

/// Begin and end of the names of unfinished files and folders.
const UNFINISHED: [&str; 2] = [".ripstop-", ".tmp"];

fn builder<'a>() -> tempfile::Builder<'a, 'a> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED[0]).suffix(UNFINISHED[1]);
    builder
}

/// An empty file in `folder` with the rights of any new file, to be renamed when it is whole.
///
/// # Errors
/// Where the folder cannot be written.
pub fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = builder();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// A folder in `folder` under a temporary name.
pub(super) fn temporary_folder(folder: &Path) -> io::Result<TempDir> {
    builder().tempdir_in(folder)
}

/// Removes what an earlier run has not finished.
pub(super) fn remove_unfinished(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(UNFINISHED[0]) && name.ends_with(UNFINISHED[1]) {
            let is_folder = entry.file_type()?.is_dir();
            if is_folder { fs::remove_dir_all(entry.path())? } else { fs::remove_file(entry.path())? }
        }
    }
    Ok(())
}

/// Removes a file that may not be there.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    fs::remove_file(path).or_else(|error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) })
}

/// Writes a file through `unfinished`, a name beside its own; it takes the place of an older one once it is on the disk.
///
/// # Errors
/// When the disk refuses, or `write` does; the older one is then still there.
pub(super) fn replace(
    path: &Path,
    unfinished: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let written = File::create(unfinished).and_then(|mut file| {
        write(&mut file)?;
        file.sync_all()
    });
    // Room for what comes; where even that fails, the first reason is the one to tell.
    written.and_then(|()| fs::rename(unfinished, path)).inspect_err(|_| drop(fs::remove_file(unfinished)))
}

#[cfg(test)]
#[path = "disk_tests.rs"]
mod tests;
