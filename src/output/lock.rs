//! The lock on an output folder: one run at a time writes there.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use same_file::Handle;

/// The file that is locked. A process that was killed leaves it, unlocked, which keeps nobody away.
pub(super) const LOCK: &str = ".ripstop.lock";
/// Attempts to lock a file that others lock and remove at the same time.
const ATTEMPTS: usize = 10;

/// A folder that is held. The system lets it go when the process ends, however that ends.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    file: Handle,
    /// The folder, which somebody may remove or replace meanwhile.
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
            // Whoever held it before may have removed the file between its opening and its locking.
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
    /// Removes the file while it is locked, so that nobody else's is removed.
    fn drop(&mut self) {
        if self.has_file() {
            // Where that fails, the file stays, which keeps nobody away.
            fs::remove_file(&self.path).ok();
        }
    }
}

#[cfg(test)]
#[path = "lock_tests.rs"]
mod tests;
