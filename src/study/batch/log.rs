//! Rows on the disk: appended one by one as shots end, sorted once all are there.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::{BatchError, ShotOrder, ShotRow, columns};
use crate::output::{Folder, OutputError};

/// Number of the shot and its velocity, by which rows are sorted and found again.
type ShotKey = (u32, u64);

/// The rows of a batch, and the file that they are appended to.
#[derive(Debug)]
pub struct ShotLog {
    drawn: Vec<String>,
    path: PathBuf,
    file: File,
    rows: BTreeMap<ShotKey, ShotRow>,
}

fn key(order: ShotOrder) -> ShotKey {
    // Velocities are above zero: their bits are in their order.
    (order.shot, order.velocity.unwrap_or(0.0).to_bits())
}

/// Name of the table that rows are appended to.
pub(crate) fn partial(name: &str) -> String {
    format!("{name}.partial")
}

impl ShotLog {
    /// Begins a table, or goes on with the one that is there; `drawn`: its columns of what is drawn.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn open(folder: &Folder, name: &'static str, drawn: Vec<String>, resume: bool) -> Result<Self, BatchError> {
        let path = folder.path().join(partial(name));
        let whole = folder.path().join(name);
        let failed = |error: io::Error| OutputError::unwritten(&path, &error);
        let head = format!("{}\n", columns(&drawn).join(","));
        if resume && !path.exists() && whole.exists() {
            // A batch that had ended: its sorted table is where a longer one begins.
            let copy = folder.path().join(format!(".{name}.tmp"));
            fs::copy(&whole, &copy).and_then(|_| fs::rename(&copy, &path)).map_err(failed)?;
        }
        let old = if resume { complete_lines(&path).unwrap_or_default() } else { String::new() };
        let (file, rows) = if old.starts_with(&head) {
            let file = File::options().append(true).open(&path).map_err(failed)?;
            // What was being written when the batch was ended.
            file.set_len(old.len() as u64).map_err(failed)?;
            (file, read(&old))
        } else {
            (begin(&path, &head).map_err(failed)?, BTreeMap::new())
        };
        Ok(Self { drawn, file, path, rows })
    }

    fn line(&self, row: &ShotRow) -> String {
        format!("{}\n", row.line(&self.drawn))
    }

    fn append(&mut self, lines: &str) -> Result<(), BatchError> {
        let written = self.file.write_all(lines.as_bytes()).and_then(|()| self.file.sync_data());
        Ok(written.map_err(|error| OutputError::unwritten(&self.path, &error))?)
    }

    /// Adds a row; it is on the disk when this returns.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn add(&mut self, row: ShotRow) -> Result<(), BatchError> {
        let line = self.line(&row);
        self.append(&line)?;
        self.rows.insert(key(row.order), row);
        Ok(())
    }

    /// The row of a shot, if it was fired.
    pub fn find(&self, order: ShotOrder) -> Option<&ShotRow> {
        self.rows.get(&key(order))
    }

    /// All rows by shot and velocity.
    pub fn rows(&self) -> impl Iterator<Item = &ShotRow> {
        self.rows.values()
    }

    /// The table of rows that `keep` wants, sorted.
    pub fn table(&self, keep: impl Fn(&ShotRow) -> bool) -> String {
        let head = format!("{}\n", columns(&self.drawn).join(","));
        self.rows().filter(|row| keep(row)).fold(head, |text, row| text + &self.line(row))
    }

    /// Removes the appended table, once the sorted one is there.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn close(self) -> Result<(), BatchError> {
        fs::remove_file(&self.path).map_err(|error| OutputError::unwritten(&self.path, &error))?;
        Ok(())
    }
}

/// A table with its heading alone.
fn begin(path: &Path, head: &str) -> io::Result<File> {
    let mut file = File::create(path)?;
    file.write_all(head.as_bytes())?;
    Ok(file)
}

/// The lines of a file that were written to their end.
fn complete_lines(path: &Path) -> io::Result<String> {
    let bytes = fs::read(path)?;
    let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    Ok(String::from_utf8_lossy(&bytes[..end]).into_owned())
}

fn read(text: &str) -> BTreeMap<ShotKey, ShotRow> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(text.as_bytes());
    let Ok(header) = reader.headers().cloned() else { return BTreeMap::new() };
    let whole = |record: &csv::StringRecord| record.len() == header.len();
    let records = reader.records().filter_map(Result::ok).filter(whole);
    let rows = records.filter_map(|record| ShotRow::parse(&header, &record));
    rows.map(|row| (key(row.order), row)).collect()
}
