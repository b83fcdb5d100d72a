//! Shots as CSV: `velocity_m_s, perforated`, and if wanted `count` and `residual_velocity_m_s`. Other columns are left alone.
//!
//! Columns are separated by commas, semicolons or tabs; lines that begin with `#` are comments.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use ::csv::{ReaderBuilder, StringRecord, Trim};

use crate::study::error::StudyError;
use crate::study::outcomes::{Group, Outcomes};
use crate::study::residual_fit::Passed;

/// Size of a file at most [bytes].
const MAX_BYTES: u64 = 4 << 20;
/// Lines of shots at most.
const MAX_ROWS: usize = 10_000;
/// Shots of one line at most.
const MAX_COUNT: f64 = 1e6;
/// Velocities at most: squares stay finite, and no projectile is as fast.
const FASTEST: f64 = 1e6;

/// Columns, the first two of which must be there.
const COLUMNS: [&str; 4] = ["velocity_m_s", "perforated", "count", "residual_velocity_m_s"];
/// Letters of a column's name that a heading like it holds.
const STEM: usize = 7;
/// What a table looks like.
const EXAMPLE: &str = "a first line velocity_m_s,perforated and lines such as 431.5,1";

/// One line: shots that were alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRow {
    /// Impact velocity [m/s].
    pub velocity: f64,
    /// Whether they perforated.
    pub perforated: bool,
    /// How many.
    pub count: u64,
    /// Residual velocity [m/s], where it was measured.
    pub residual: Option<f64>,
}

/// What became of the shots of all lines.
pub fn outcomes(rows: &[FitRow]) -> Outcomes {
    Outcomes::new(rows.iter().map(|row| {
        let [perforated, stopped] = if row.perforated { [row.count, 0] } else { [0, row.count] };
        Group { velocity: row.velocity, perforated, stopped }
    }))
}

/// Shots that passed, and how fast they were then.
pub fn passed(rows: &[FitRow]) -> Vec<Passed> {
    let of = |row: &FitRow| row.residual.map(|residual| Passed { impact: row.velocity, residual, count: row.count });
    rows.iter().filter(|row| row.perforated && row.count > 0).filter_map(of).collect()
}

/// Reads a file.
///
/// # Errors
/// Where it cannot be read, is too large, or holds something else.
pub fn read(path: &Path) -> Result<Vec<FitRow>, StudyError> {
    let help = format!("name a CSV with {EXAMPLE}");
    let bytes = bounded(path, &help)?;
    parse(&bytes).map_err(|error| error.in_file(&path.display().to_string()))
}

/// Bytes of a file of bounded size; the size of a pipe is not known beforehand.
fn bounded(path: &Path, help: &str) -> Result<Vec<u8>, StudyError> {
    let place = path.display().to_string();
    let failed = |error: io::Error| StudyError::new(&place, "a file that can be read", error.to_string(), help);
    let large = || {
        let expected = format!("a file of at most {} MiB", MAX_BYTES >> 20);
        StudyError::new(&place, expected, "a larger one", "keep fewer lines, or fewer columns")
    };
    let file = File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.len() > MAX_BYTES {
        return Err(large());
    }
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES { Err(large()) } else { Ok(bytes) }
}

/// Text in UTF-8; every line ends with a line feed.
fn plain_text(bytes: &[u8]) -> Result<String, StudyError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let line = |at: usize| format!("line {}", bytes[..at].iter().filter(|byte| **byte == b'\n').count() + 1);
    let no_text = |at: usize, byte: u8| {
        let help = "save the table as CSV (UTF-8); a spreadsheet's own file is none";
        StudyError::new(line(at), "text in UTF-8", format!("the byte 0x{byte:02X}"), help)
    };
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        return Err(no_text(at, 0));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        no_text(at, bytes.get(at).copied().unwrap_or_default())
    })?;
    let mut text = text.replace("\r\n", "\n").replace('\r', "\n");
    text.push('\n');
    Ok(text)
}

/// Separator of the names of the heading: the most frequent of three, outside quotes.
fn separator(text: &str) -> u8 {
    let heading = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let outside: Vec<u8> = heading.split('"').step_by(2).flat_map(str::bytes).collect();
    let count = |sign: u8| outside.iter().filter(|byte| **byte == sign).count();
    // The last of equals wins: a comma where there is none at all.
    [b'\t', b';', b','].into_iter().max_by_key(|sign| count(*sign)).unwrap_or(b',')
}

/// Heading on one line, without control characters.
fn one_line(heading: &str) -> String {
    let parts = heading.split(|c: char| c.is_control() || c.is_whitespace());
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// First eight of some names, quoted.
fn few<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const SHOWN: usize = 8;
    let names: Vec<&str> = names.into_iter().collect();
    let more = names.len().saturating_sub(SHOWN);
    let shown = names[..names.len() - more].iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    match (names.is_empty(), more) {
        (true, _) => "none".to_owned(),
        (_, 0) => shown,
        _ => format!("{shown} and {more} more"),
    }
}

/// Word of a file in quotes, control characters escaped, cut at 40 characters.
fn quoted(text: &str) -> String {
    let short: String = text.chars().take(40).collect();
    let rest = if short.len() < text.len() { "…" } else { "" };
    format!("{:?}", short + rest)
}

/// Reads a table.
///
/// # Errors
/// Where something else stands there: line, column and what was expected.
pub fn parse(bytes: &[u8]) -> Result<Vec<FitRow>, StudyError> {
    let text = plain_text(bytes)?;
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).flexible(true).comment(Some(b'#')).delimiter(separator(&text)).trim(Trim::All);
    let mut reader = reader.from_reader(text.as_bytes());
    let mut record = StringRecord::new();
    let mut heading: Option<Heading> = None;
    let mut rows = Vec::new();
    let unreadable = |error: ::csv::Error| {
        StudyError::new("", "comma-separated values", error.to_string(), "save the table as CSV (UTF-8)")
    };
    while reader.read_record(&mut record).map_err(unreadable)? {
        // Every line here has an end, so the line of the record is the one before the next.
        let line = reader.position().line() - 1;
        match &heading {
            None => heading = Some(Heading::new(&record, line)?),
            Some(_) if record.iter().all(str::is_empty) => {}
            Some(heading) => rows.push(heading.row(&record, line)?),
        }
        if rows.len() > MAX_ROWS {
            let place = format!("line {line}");
            let help = "put shots that were alike on one line with a count";
            return Err(StudyError::new(place, format!("at most {MAX_ROWS} lines of shots"), "more", help));
        }
    }
    let found = match heading {
        None => "an empty file",
        Some(_) if rows.is_empty() => "a heading alone",
        Some(_) if rows.iter().all(|row| row.count == 0) => "no shot: every count is 0",
        Some(_) => return Ok(rows),
    };
    Err(StudyError::new("", "a heading and lines of shots", found, format!("write {EXAMPLE}")))
}

/// Where the columns are.
struct Heading {
    names: Vec<String>,
    places: [Option<usize>; 4],
}

impl Heading {
    fn new(record: &StringRecord, line: u64) -> Result<Self, StudyError> {
        let names: Vec<String> = record.iter().map(one_line).collect();
        let place = format!("line {line}");
        let found = || few(names.iter().map(String::as_str));
        for (n, name) in names.iter().enumerate() {
            if COLUMNS.contains(&name.as_str()) && names[..n].contains(name) {
                let found = format!("{} twice", quoted(name));
                return Err(StudyError::new(place, "each column once", found, "leave out one of them"));
            }
        }
        let places = COLUMNS.map(|column| names.iter().position(|name| name == column));
        if let Some(missing) =
            COLUMNS.iter().zip(places).take(2).find(|(_, place)| place.is_none()).map(|(name, _)| name)
        {
            // `velocity`, `Impact velocity (m/s)` or `perforation` are meant as the column they resemble.
            let stem = &missing[..STEM];
            let near =
                names.iter().find(|name| name.to_lowercase().contains(stem) && !COLUMNS.contains(&name.as_str()));
            let help = match near {
                Some(near) => format!("rename {} to {missing}", quoted(near)),
                None => format!("write {EXAMPLE}"),
            };
            return Err(StudyError::new(place, format!("a column {missing}"), found(), help));
        }
        Ok(Self { names, places })
    }

    /// A line of shots.
    fn row(&self, record: &StringRecord, line: u64) -> Result<FitRow, StudyError> {
        if record.len() != self.names.len() {
            let expected = format!("{} cells, as in the heading", self.names.len());
            let help = "numbers have a decimal point; every line has as many cells as the heading";
            return Err(StudyError::new(format!("line {line}"), expected, record.len().to_string(), help));
        }
        let cell = |column: usize| self.places[column].and_then(|place| record.get(place)).unwrap_or_default();
        let wrong = |column: usize, expected: String, help: &str| {
            let place = format!("line {line}, column {}", quoted(COLUMNS[column]));
            let found = if cell(column).is_empty() { "an empty cell".to_owned() } else { quoted(cell(column)) };
            StudyError::new(place, expected, found, help)
        };
        let number = |column: usize| cell(column).parse::<f64>().ok().filter(|value| value.is_finite());
        let velocity = number(0).filter(|velocity| (0.0..=FASTEST).contains(velocity)).ok_or_else(|| {
            wrong(
                0,
                "an impact velocity of at least 0 m/s".to_owned(),
                "write a number with a decimal point, such as 431.5",
            )
        })?;
        let perforated = match number(1) {
            Some(1.0) => true,
            Some(0.0) => false,
            _ => {
                let help = "write 1 where the projectile passed, 0 where it was stopped";
                return Err(wrong(1, "0 or 1".to_owned(), help));
            }
        };
        let count = match cell(2) {
            "" => 1,
            _ => number(2).filter(|count| count.fract() == 0.0 && (0.0..=MAX_COUNT).contains(count)).ok_or_else(
                || {
                    wrong(
                        2,
                        format!("a whole number from 0 to {MAX_COUNT}"),
                        "write how many shots were alike, or leave the cell empty: 1",
                    )
                },
            )? as u64,
        };
        let residual = match (cell(3), perforated) {
            ("", _) => None,
            (_, false) => {
                number(3).filter(|residual| *residual == 0.0).ok_or_else(|| {
                    wrong(
                        3,
                        "0 or an empty cell, for the shot was stopped".to_owned(),
                        "write perforated 1, or leave the residual velocity out",
                    )
                })?;
                None
            }
            (_, true) => Some(number(3).filter(|residual| (0.0..=velocity).contains(residual)).ok_or_else(|| {
                let expected = format!("a residual velocity from 0 to the impact velocity, {velocity} m/s");
                wrong(3, expected, "leave the cell empty where it was not measured")
            })?),
        };
        Ok(FitRow { velocity, perforated, count, residual })
    }
}
