//! Names of the files of frames, and how those of an earlier run go.

use std::fs;
use std::io;
use std::path::Path;

/// The file with all frames, and the one that lists those of the series.
pub(in crate::output) const HDF: &str = "frames.vtkhdf";
pub(in crate::output) const PVD: &str = "frames.pvd";
/// Folder of the series, beside the `.pvd` file.
pub(super) const SERIES: &str = "frames";

/// Removes the frames of an earlier run.
pub(super) fn clear(folder: &Path) -> io::Result<()> {
    gone(fs::remove_file(folder.join(HDF)))?;
    gone(fs::remove_file(folder.join(PVD)))?;
    clear_folder(&folder.join(SERIES), is_of_series)
}

/// Removes the files of a folder that are `own` by name, and the folder unless something else lies there.
pub(super) fn clear_folder(folder: &Path, own: impl Fn(&str) -> bool) -> io::Result<()> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let entry = entry?;
        if own(&entry.file_name().to_string_lossy()) {
            gone(fs::remove_file(entry.path()))?;
        }
    }
    fs::remove_dir(folder).ok();
    Ok(())
}

/// What is not there need not be removed.
fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Whether a file of that name is one of a series.
fn is_of_series(name: &str) -> bool {
    let number = ["fabric_", "projectile_"].iter().find_map(|part| name.strip_prefix(part)?.strip_suffix(".vtu"));
    number.is_some_and(|number| number.len() >= 4 && number.bytes().all(|byte| byte.is_ascii_digit()))
}
