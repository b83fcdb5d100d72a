//! What is compared: the folder of a run, or a table of numbers over time.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::request::DiffRequest;
use super::table::{self, MAX_BYTES, TimeSeries};
use crate::output::CHECKPOINT;
use crate::study::StudyError;

/// Size of `summary.json` and `case.json` at most [bytes].
const MAX_JSON: u64 = 8 << 20;

/// What an input is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputKind {
    /// The folder of a run.
    Run,
    /// A table alone.
    Curve,
}

impl InputKind {
    /// The word in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Run => "run",
            Self::Curve => "curve",
        }
    }
}

/// One of the things that are compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// As the user named it.
    pub path: PathBuf,
    /// What it is.
    pub kind: InputKind,
    /// Its columns over time.
    pub table: TimeSeries,
    /// `summary.json` of a run.
    pub summary: Option<Value>,
    /// `case.json` of a run.
    pub case: Option<Value>,
    /// What a reader should know of it.
    pub notes: Vec<String>,
}

impl Input {
    /// Title of the case.
    pub fn title(&self) -> Option<&str> {
        self.summary.as_ref().and_then(|summary| summary["title"].as_str())
    }

    /// Files that were read.
    pub fn files(&self) -> Vec<PathBuf> {
        match self.kind {
            InputKind::Curve => vec![self.path.clone()],
            InputKind::Run => ["history.csv", "summary.json", "case.json"].map(|name| self.path.join(name)).to_vec(),
        }
    }
}

/// Reads an input. `request` says what headings stand for.
///
/// # Errors
/// Where it cannot be read, is too large, or holds something else.
pub fn read(path: &Path, request: &DiffRequest) -> Result<Input, StudyError> {
    if path.is_dir() { run(path, request) } else { curve(path, request) }
}

fn curve(path: &Path, request: &DiffRequest) -> Result<Input, StudyError> {
    let table = table_of(path, request)?;
    let notes = named(path, &table);
    Ok(Input { path: path.to_owned(), kind: InputKind::Curve, table, summary: None, case: None, notes })
}

fn run(folder: &Path, request: &DiffRequest) -> Result<Input, StudyError> {
    let place = folder.display().to_string();
    let summary = folder.join("summary.json");
    if !summary.exists() {
        let checkpoint = folder.join(CHECKPOINT).exists();
        let (found, help) = match (checkpoint, folder.join("case.json").exists()) {
            (true, _) => ("a checkpoint: the run has not ended", format!("`ripstop resume {place}` goes on with it")),
            (_, true) => ("a case alone: the run has not ended", "wait for its end, or run it again".to_owned()),
            _ => ("no summary.json", "name the folder of a run, or a CSV of a measured curve".to_owned()),
        };
        return Err(StudyError::new(place, "a folder of a run that has ended", found, help));
    }
    let summary = object(&summary)?;
    let cut = summary["interrupted"] == true || !summary["device_lost"].is_null();
    if cut {
        let found = format!("one that was broken off at {} µs", summary["time_us"]);
        let help = format!("run it again; {place}/history.csv can be compared up to there");
        return Err(StudyError::new(place, "a folder of a run that has ended", found, help));
    }
    let case = folder.join("case.json");
    let case = if case.exists() { Some(object(&case)?) } else { None };
    let history = folder.join("history.csv");
    let table = table_of(&history, request)?;
    let mut notes = named(&history, &table);
    if !summary["unstable"].is_null() {
        notes.push(format!("{place}: the run became unstable at {} µs", summary["time_us"]));
    }
    Ok(Input { path: folder.to_owned(), kind: InputKind::Run, table, summary: Some(summary), case, notes })
}

fn table_of(path: &Path, request: &DiffRequest) -> Result<TimeSeries, StudyError> {
    let help = "name the folder of a run, its history.csv, or a CSV of a measured curve";
    let bytes = bounded(path, MAX_BYTES, help)?;
    table::read(&bytes, &request.mappings).map_err(|error| error.in_file(&path.display().to_string()))
}

fn named(path: &Path, table: &TimeSeries) -> Vec<String> {
    table.notes.iter().map(|note| format!("{}: {note}", path.display())).collect()
}

/// A JSON object in a file.
fn object(path: &Path) -> Result<Value, StudyError> {
    let place = path.display().to_string();
    let help = "run the case again: ripstop writes this file";
    let bytes = bounded(path, MAX_JSON, help)?;
    match serde_json::from_slice(&bytes) {
        Ok(value @ Value::Object(_)) => Ok(value),
        Ok(_) => Err(StudyError::new(place, "a JSON object", "another JSON value", help)),
        Err(error) => Err(StudyError::new(place, "a JSON object", error.to_string(), help)),
    }
}

/// A file of a bounded size; a pipe has none beforehand.
pub(crate) fn bounded(path: &Path, most: u64, help: &str) -> Result<Vec<u8>, StudyError> {
    let place = path.display().to_string();
    let failed = |error: io::Error| StudyError::new(&place, "a file that can be read", error.to_string(), help);
    let large = || {
        let expected = format!("a file of at most {} MiB", most >> 20);
        StudyError::new(&place, expected, "a larger one", "keep fewer lines, or fewer columns")
    };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.len() > most {
        return Err(large());
    }
    let mut bytes = Vec::new();
    file.take(most + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > most { Err(large()) } else { Ok(bytes) }
}
