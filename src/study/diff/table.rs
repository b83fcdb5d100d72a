//! A table of numbers over time, as CSV: `history.csv`, or what a camera measured.
//!
//! Columns are separated by commas, semicolons or tabs, whichever the heading has; cells may be quoted (RFC 4180); lines that begin with
//! `#` are comments; a byte order mark and any ends of lines are taken. Numbers have a point.

use ::csv::{ByteRecord, ReaderBuilder, Trim};

use super::curve::Points;
use super::error::{few, quoted};
use super::quantity::{self, Quantity, TIME};
use super::request::Mapping;
use crate::study::StudyError;

/// Size of a file at most [bytes].
pub(super) const MAX_BYTES: u64 = 32 << 20;
/// Columns, rows, and both together, at most.
const MAX_COLUMNS: usize = 256;
const MAX_ROWS: usize = 200_000;
const MAX_CELLS: usize = 5_000_000;
/// Magnitude of a number at most: squares of differences stay finite.
const LARGEST: f64 = 1e100;

/// Columns over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeSeries {
    /// Times [µs], ascending.
    pub times: Vec<f64>,
    /// Every other column that holds numbers.
    pub columns: Vec<TableColumn>,
    /// What a reader should know of how it was read.
    pub notes: Vec<String>,
    /// Headings as the file has them.
    pub(super) headings: Vec<String>,
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// A name of `history.csv`, or the heading where it has none like it.
    pub name: String,
    /// One for each time, in the unit of the name; NaN where the cell is empty.
    pub values: Vec<f64>,
}

impl TimeSeries {
    /// First and last time [µs].
    pub fn span(&self) -> [f64; 2] {
        [self.times.first(), self.times.last()].map(|time| time.copied().unwrap_or(f64::NAN))
    }

    /// Column of a name.
    pub fn column(&self, name: &str) -> Option<&TableColumn> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The points of a column; times without a value are left out.
    pub fn points(&self, column: &TableColumn) -> Points {
        let rows = self.times.iter().zip(&column.values);
        rows.filter(|(_, value)| value.is_finite()).map(|(time, value)| [*time, *value]).collect()
    }

    /// The first contact force of a run is an impulse over one step, all others are means between rows: it is no point of the curve.
    fn without_first_force(&mut self) {
        let is_of_a_run = ["energy_error", "kinetic_energy_j"].iter().all(|name| self.column(name).is_some());
        let force = self.columns.iter_mut().find(|column| column.name == "contact_force_n");
        if let Some(first) = force.filter(|_| is_of_a_run).and_then(|force| force.values.first_mut()) {
            *first = f64::NAN;
        }
    }

    /// Adds to every time [µs].
    pub(super) fn shift(&mut self, by: f64) {
        self.times.iter_mut().for_each(|time| *time += by);
    }
}

/// A column as it is read.
struct Raw {
    heading: String,
    quantity: Option<Quantity>,
    values: Vec<f64>,
    /// Line and text of the first cell that is no number.
    words: Option<(u64, String)>,
}

/// Reads a table. `mappings`: what headings stand for.
pub(super) fn read(bytes: &[u8], mappings: &[Mapping]) -> Result<TimeSeries, StudyError> {
    let text = text(bytes)?;
    let separator = separator(&text);
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).flexible(true).comment(Some(b'#')).delimiter(separator).trim(Trim::All);
    let mut reader = reader.from_reader(text.as_bytes());
    let mut record = ByteRecord::new();
    let mut columns: Option<Vec<Raw>> = None;
    let mut lines = Vec::new();
    while reader.read_byte_record(&mut record).map_err(|error| unreadable(&error))? {
        // The place of a record is that of what is skipped before it; every line here has an end, so the next one is known.
        let line = reader.position().line() - 1;
        let cells: Vec<&str> = record.iter().map(|cell| std::str::from_utf8(cell).unwrap_or_default()).collect();
        match &mut columns {
            None => {
                let cells: Vec<String> = cells.iter().map(|cell| one_line(cell)).collect();
                columns = Some(headings(&cells.iter().map(String::as_str).collect::<Vec<_>>(), line, mappings)?);
            }
            Some(_) if cells.iter().all(|cell| cell.is_empty()) => {}
            Some(columns) => add(&mut lines, columns, &cells, line, separator)?,
        }
    }
    let Some(columns) = columns else { return Err(empty("an empty file")) };
    if lines.is_empty() {
        return Err(empty("a heading alone"));
    }
    table(columns, &lines)
}

fn empty(found: &str) -> StudyError {
    StudyError::new(
        "",
        "a heading and lines of numbers",
        found,
        "take history.csv of a run, or a CSV with times and values",
    )
}

fn unreadable(error: &::csv::Error) -> StudyError {
    StudyError::new("", "comma-separated values", error.to_string(), "save the table as CSV (UTF-8)")
}

/// The text, every line of which ends with a line feed.
pub(crate) fn text(bytes: &[u8]) -> Result<String, StudyError> {
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

/// What separates the names of the heading: the most frequent of three, outside quotes.
pub(crate) fn separator(text: &str) -> u8 {
    let heading = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let outside: Vec<u8> = heading.split('"').step_by(2).flat_map(str::bytes).collect();
    let count = |sign: u8| outside.iter().filter(|byte| **byte == sign).count();
    // The last of equals wins: a comma where there is none at all.
    [b'\t', b';', b','].into_iter().max_by_key(|sign| count(*sign)).unwrap_or(b',')
}

/// A heading on one line, without what would steer a terminal.
pub(crate) fn one_line(heading: &str) -> String {
    heading
        .split(|c: char| c.is_control() || c.is_whitespace())
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// The columns that a heading names.
fn headings(cells: &[&str], line: u64, mappings: &[Mapping]) -> Result<Vec<Raw>, StudyError> {
    let place = format!("line {line}");
    if cells.len() > MAX_COLUMNS {
        let expected = format!("at most {MAX_COLUMNS} columns");
        return Err(StudyError::new(place, expected, cells.len().to_string(), "leave out what is not compared"));
    }
    if cells.iter().all(|cell| cell.is_empty() || cell.parse::<f64>().is_ok()) {
        let help = "write a first line such as time_us,velocity_m_s";
        return Err(StudyError::new(place, "a heading that names the columns", few(cells.iter().copied()), help));
    }
    for (n, cell) in cells.iter().enumerate() {
        if !cell.is_empty() && cells[..n].contains(cell) {
            let found = format!("{} twice", quoted(cell));
            return Err(StudyError::new(place, "each column once", found, "rename or leave out one of them"));
        }
    }
    let column = |cell: &&str| {
        let mapped = mappings.iter().find(|mapping| mapping.heading == *cell).map(|mapping| mapping.quantity);
        let quantity = mapped.or_else(|| quantity::of(cell));
        Raw { heading: (*cell).to_owned(), quantity, values: Vec::new(), words: None }
    };
    let columns: Vec<Raw> = cells.iter().map(column).collect();
    once(&columns, &place)?;
    Ok(columns)
}

/// Refuses two columns for one quantity, and a table without time.
fn once(columns: &[Raw], place: &str) -> Result<(), StudyError> {
    let of = |name: &str| {
        let same = columns.iter().filter(|column| column.quantity.is_some_and(|quantity| quantity.name == name));
        same.map(|column| column.heading.as_str()).collect::<Vec<_>>()
    };
    for name in columns.iter().filter_map(|column| column.quantity).map(|quantity| quantity.name) {
        let found = of(name);
        if found.len() > 1 {
            let expected = format!("one column for {name}");
            return Err(StudyError::new(place, expected, few(found), "leave out or rename all but one"));
        }
    }
    if of(TIME).is_empty() {
        let found = few(columns.iter().map(|column| column.heading.as_str()));
        let help = "call it time_us, time_ms or time_s, or say which it is: --column HEADING=time_ms";
        return Err(StudyError::new(place, "a column of times", found, help));
    }
    Ok(())
}

/// Adds the cells of a line to the columns. `lines`: those read so far.
fn add(lines: &mut Vec<u64>, columns: &mut [Raw], cells: &[&str], line: u64, separator: u8) -> Result<(), StudyError> {
    let place = format!("line {line}");
    if cells.len() != columns.len() {
        let help = match (separator, cells.len() > columns.len()) {
            (b',', true) => "numbers have a decimal point; a comma separates columns",
            _ => "every line has as many cells as the heading; an empty cell is a value that is missing",
        };
        let expected = format!("{} cells, as in the heading", columns.len());
        return Err(StudyError::new(place, expected, cells.len().to_string(), help));
    }
    lines.push(line);
    if lines.len() > MAX_ROWS || lines.len() * columns.len() > MAX_CELLS {
        let expected = format!("at most {MAX_ROWS} lines, and {MAX_CELLS} cells");
        return Err(StudyError::new(place, expected, "more", "keep fewer lines"));
    }
    for (column, cell) in columns.iter_mut().zip(cells) {
        let value = match *cell {
            "" => Some(f64::NAN),
            cell => cell.parse::<f64>().ok(),
        };
        if value.is_none() && column.words.is_none() {
            column.words = Some((line, (*cell).to_owned()));
        }
        let factor = column.quantity.map_or(1.0, |quantity| quantity.factor);
        column.values.push(value.unwrap_or(f64::NAN) * factor);
    }
    Ok(())
}

/// What the columns are, once all lines are read. `lines`: line of each row.
fn table(columns: Vec<Raw>, lines: &[u64]) -> Result<TimeSeries, StudyError> {
    let headings = columns.iter().map(|column| column.heading.clone()).collect();
    let mut table = TimeSeries { headings, ..TimeSeries::default() };
    for column in columns {
        let Raw { heading, quantity, values, words } = column;
        let name = quantity.map_or(heading.as_str(), |quantity| quantity.name);
        match words {
            Some((line, found)) if quantity.is_some() || is_decimal_comma(&found) => {
                return Err(no_number(line, &heading, &found));
            }
            Some((line, found)) => {
                let left_out = format!("column {} is left out: line {line} holds {}", quoted(&heading), quoted(&found));
                table.notes.push(left_out);
                continue;
            }
            None if name == TIME => {
                check_times(&values, lines, &heading)?;
                table.times = values;
                continue;
            }
            None if heading.is_empty() => continue,
            None => {}
        }
        if let Some(at) = values.iter().position(|value| value.abs() > LARGEST) {
            return Err(no_number(lines[at], &heading, &format!("{:?}", values[at])));
        }
        let missing = values.iter().filter(|value| value.is_nan()).count();
        if missing > 0 && missing < values.len() {
            let found = format!("column {} has no value in {missing} of {} lines", quoted(&heading), values.len());
            table.notes.push(format!("{found}; it is taken as straight between its values"));
        }
        if missing < values.len() {
            table.columns.push(TableColumn { name: name.to_owned(), values });
        }
    }
    table.without_first_force();
    Ok(table)
}

fn check_times(times: &[f64], lines: &[u64], heading: &str) -> Result<(), StudyError> {
    let place = |n: usize| format!("line {}, column {}", lines[n], quoted(heading));
    if let Some(n) = times.iter().position(|time| time.is_nan() || time.abs() > LARGEST) {
        let found = if times[n].is_nan() { "none".to_owned() } else { format!("{:?}", times[n]) };
        return Err(StudyError::new(place(n), "a time", found, "leave out lines without one"));
    }
    if let Some(n) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
        let expected = format!("a time after that of the line before, {} µs", times[n]);
        return Err(StudyError::new(
            place(n + 1),
            expected,
            format!("{} µs", times[n + 1]),
            "sort the lines by time, each time once",
        ));
    }
    Ok(())
}

fn no_number(line: u64, heading: &str, found: &str) -> StudyError {
    let help = match found {
        found if is_decimal_comma(found) => "write a decimal point instead of the comma",
        found if found.parse::<f64>().is_ok() => {
            "no number here is beyond 1e100; a value that is missing is an empty cell"
        }
        _ => "a line of units or remarks begins with #; a value that is missing is an empty cell",
    };
    StudyError::new(format!("line {line}, column {}", quoted(heading)), "a number", quoted(found), help)
}

/// `12,5`
fn is_decimal_comma(cell: &str) -> bool {
    cell.matches(',').count() == 1 && cell.replace(',', ".").parse::<f64>().is_ok()
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
