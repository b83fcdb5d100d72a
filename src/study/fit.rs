//! `ripstop fit`: from a table of shots to a ballistic limit.
//!
//! The table is CSV with the columns `velocity_m_s` and `perforated`, and if wanted `count` and `residual_velocity_m_s`. Other columns are
//! left alone. Commas, semicolons or tabs separate columns; lines that begin with `#` are comments.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use ::csv::{ReaderBuilder, StringRecord, Trim};
use serde_json::{Value, json};

use super::StudyError;
use super::binary_response::{self, Estimate};
use super::interval::interval;
use super::limit::{ComputedLimit, Limit, QUANTILES, Quantile, quantile_row};
use super::outcomes::{Group, Outcomes};
use super::report::{Report, ReportTable, chance_panel, headline, residual_panel};
use super::residual_fit::Passed;
use crate::num::link::Link;
use crate::output::number::short;

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
/// Names of a heading that an error shows at most.
const SHOWN: usize = 8;
/// Sketch of a table.
const EXAMPLE: &str = "a first line velocity_m_s,perforated and lines such as 431.5,1";

/// One line: shots that were alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRow {
    /// Impact velocity [m/s].
    pub velocity: f64,
    /// Whether they perforated.
    pub perforated: bool,
    /// Number of shots.
    pub count: u64,
    /// Residual velocity [m/s], where it was measured.
    pub residual: Option<f64>,
}

/// Rows of a file.
///
/// # Errors
/// Where it cannot be read, is too large, or holds something else.
pub fn read(path: &Path) -> Result<Vec<FitRow>, StudyError> {
    let place = path.display().to_string();
    let help = format!("name a CSV with {EXAMPLE}");
    let failed = |error: io::Error| StudyError::new(&place, "a file that can be read", error.to_string(), &help);
    let mut bytes = Vec::new();
    // A pipe has no size beforehand.
    File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        let expected = format!("a file of at most {} MiB", MAX_BYTES >> 20);
        return Err(StudyError::new(place, expected, "a larger one", "keep fewer lines, or fewer columns"));
    }
    parse(&bytes).map_err(|error| {
        let place = if error.place.is_empty() { place } else { format!("{place}: {}", error.place) };
        StudyError { place, ..error }
    })
}

/// Rows of a table.
///
/// # Errors
/// Where something else stands there: line, column and what was expected.
pub fn parse(bytes: &[u8]) -> Result<Vec<FitRow>, StudyError> {
    let text = plain_text(bytes)?;
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).flexible(true).comment(Some(b'#')).delimiter(separator(&text)).trim(Trim::All);
    let mut reader = reader.from_reader(text.as_bytes());
    let mut record = StringRecord::new();
    let (mut places, mut cells) = (None, 0);
    let mut rows = Vec::new();
    let unreadable = |error: ::csv::Error| {
        StudyError::new("", "comma-separated values", error.to_string(), "save the table as CSV (UTF-8)")
    };
    while reader.read_record(&mut record).map_err(unreadable)? {
        // Every line here has an end, so the line of the record is the one before the next.
        let line = reader.position().line() - 1;
        let place = format!("line {line}");
        match places {
            None => (places, cells) = (Some(columns(&record, line)?), record.len()),
            Some(_) if record.iter().all(str::is_empty) => {}
            Some(_) if record.len() != cells => {
                let expected = format!("{cells} cells, as in the heading");
                let help = "numbers have a decimal point; every line has as many cells as the heading";
                return Err(StudyError::new(place, expected, record.len().to_string(), help));
            }
            Some(places) => rows.push(row(places, &record, line)?),
        }
        if rows.len() > MAX_ROWS {
            let help = "put shots that were alike on one line with a count";
            return Err(StudyError::new(place, format!("at most {MAX_ROWS} lines of shots"), "more", help));
        }
    }
    let found = match places {
        None => "an empty file",
        Some(_) if rows.is_empty() => "a heading alone",
        Some(_) if rows.iter().all(|row| row.count == 0) => "no shot: every count is 0",
        Some(_) => return Ok(rows),
    };
    Err(StudyError::new("", "a heading and lines of shots", found, format!("write {EXAMPLE}")))
}

/// Text in UTF-8; every line ends with a line feed.
fn plain_text(bytes: &[u8]) -> Result<String, StudyError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let valid = std::str::from_utf8(bytes);
    let wrong = valid.err().map(|error| error.valid_up_to());
    if let Some(at) = bytes.iter().position(|byte| *byte == 0).or(wrong) {
        let line = bytes[..at].iter().filter(|byte| **byte == b'\n').count() + 1;
        let help = "save the table as CSV (UTF-8); a spreadsheet's own file is none";
        let found = format!("the byte 0x{:02X}", bytes.get(at).copied().unwrap_or_default());
        return Err(StudyError::new(format!("line {line}"), "text in UTF-8", found, help));
    }
    Ok(valid.unwrap_or_default().replace("\r\n", "\n").replace('\r', "\n") + "\n")
}

/// Separator of the names of the heading: the most frequent of three, outside quotes.
fn separator(text: &str) -> u8 {
    let heading = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let outside: Vec<u8> = heading.split('"').step_by(2).flat_map(str::bytes).collect();
    let count = |sign: u8| outside.iter().filter(|byte| **byte == sign).count();
    // The last of equals wins: a comma where there is none at all.
    [b'\t', b';', b','].into_iter().max_by_key(|sign| count(*sign)).unwrap_or(b',')
}

/// Word of a file in quotes, control characters escaped, cut at 40 characters.
fn quoted(text: &str) -> String {
    let short: String = text.chars().take(40).collect();
    let rest = if short.len() < text.len() { "…" } else { "" };
    format!("{:?}", short + rest)
}

/// Places of the columns in a heading.
fn columns(record: &StringRecord, line: u64) -> Result<[Option<usize>; 4], StudyError> {
    // Without what would steer a terminal.
    let parts = |name: &str| name.replace(|c: char| c.is_control(), " ");
    let one_line = |name: &str| parts(name).split_whitespace().collect::<Vec<_>>().join(" ");
    let names: Vec<String> = record.iter().map(one_line).collect();
    let place = format!("line {line}");
    let is_column = |name: &str| COLUMNS.contains(&name);
    let twice = names.iter().enumerate().find(|(n, name)| is_column(name) && names[..*n].contains(name));
    if let Some((_, name)) = twice {
        let found = format!("{} twice", quoted(name));
        return Err(StudyError::new(place, "each column once", found, "leave out one of them"));
    }
    let places = COLUMNS.map(|column| names.iter().position(|name| name == column));
    let Some(missing) = COLUMNS.iter().zip(places).take(2).find(|(_, place)| place.is_none()).map(|(name, _)| *name)
    else {
        return Ok(places);
    };
    // `velocity`, `Impact velocity (m/s)` or `perforation` are meant as the column they resemble.
    let near = names.iter().find(|name| name.to_lowercase().contains(&missing[..STEM]) && !is_column(name));
    let help = match near {
        Some(near) => format!("rename {} to {missing}", quoted(near)),
        None => format!("write {EXAMPLE}"),
    };
    let more = names.len().saturating_sub(SHOWN);
    let shown = names.iter().take(SHOWN).map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
    let found = if more > 0 { format!("{shown} and {more} more") } else { shown };
    Err(StudyError::new(place, format!("a column {missing}"), found, help))
}

/// Row of a line of shots with its columns at these places.
fn row(places: [Option<usize>; 4], record: &StringRecord, line: u64) -> Result<FitRow, StudyError> {
    let cell = |column: usize| places[column].and_then(|place| record.get(place)).unwrap_or_default();
    let number = |column: usize, is_right: &dyn Fn(f64) -> bool, expected: &str, help: &str| {
        let value = cell(column).parse::<f64>().ok().filter(|value| value.is_finite() && is_right(*value));
        value.ok_or_else(|| {
            let place = format!("line {line}, column {}", quoted(COLUMNS[column]));
            let found = if cell(column).is_empty() { "an empty cell".to_owned() } else { quoted(cell(column)) };
            StudyError::new(place, expected, found, help)
        })
    };
    let help = "write a number with a decimal point, such as 431.5";
    let velocity = number(0, &|v| (0.0..=FASTEST).contains(&v), "an impact velocity of at least 0 m/s", help)?;
    let help = "write 1 where the projectile passed, 0 where it was stopped";
    let perforated = number(1, &|outcome| outcome == 0.0 || outcome == 1.0, "0 or 1", help)? == 1.0;
    let is_count = |count: f64| count.fract() == 0.0 && (0.0..=MAX_COUNT).contains(&count);
    let expected = format!("a whole number from 0 to {MAX_COUNT}");
    let help = "write how many shots were alike, or leave the cell empty: 1";
    let count = if cell(2).is_empty() { 1 } else { number(2, &is_count, &expected, help)? as u64 };
    let residual = match (cell(3), perforated) {
        ("", _) => None,
        (_, true) => {
            let expected = format!("a residual velocity from 0 to the impact velocity, {velocity} m/s");
            let help = "leave the cell empty where it was not measured";
            Some(number(3, &|residual| (0.0..=velocity).contains(&residual), &expected, help)?)
        }
        (_, false) => {
            let help = "write perforated 1, or leave the residual velocity out";
            number(3, &|residual| residual == 0.0, "0 or an empty cell, for the shot was stopped", help)?;
            None
        }
    };
    Ok(FitRow { velocity, perforated, count, residual })
}

/// Request of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRequest {
    /// Distribution of the thresholds.
    pub link: Link,
    /// Two-sided confidence of intervals.
    pub level: f64,
}

/// Ballistic limit fitted to shots.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Request of the fit.
    pub request: FitRequest,
    /// Outcomes of the shots.
    pub outcomes: Outcomes,
    /// μ and σ, or why there are none.
    pub estimate: Result<Estimate, &'static str>,
    /// Limit by every method.
    pub limit: Limit,
    /// Computed limit beside it.
    pub computed: Option<ComputedLimit>,
}

/// Shots that perforated with a known residual velocity.
pub(super) fn passed(rows: &[FitRow]) -> Vec<Passed> {
    let of = |row: &FitRow| row.residual.map(|residual| Passed { impact: row.velocity, residual, count: row.count });
    rows.iter().filter(|row| row.perforated && row.count > 0).filter_map(of).collect()
}

/// Fit of all that shots allow.
pub fn fit(rows: &[FitRow], request: FitRequest) -> Fit {
    let outcomes = Outcomes::new(rows.iter().map(|row| {
        let [perforated, stopped] = if row.perforated { [row.count, 0] } else { [0, row.count] };
        Group { velocity: row.velocity, perforated, stopped }
    }));
    let estimate = binary_response::fit(request.link, &outcomes);
    let found = estimate.as_ref().ok();
    let quantile = |p: f64| {
        let bounds = interval(request.link, &outcomes, found, p, request.level);
        Quantile { p, value: found.map(|found| found.velocity(p)), bounds }
    };
    let limit = Limit::new(QUANTILES.map(quantile).to_vec(), &outcomes, passed(rows), request.level);
    Fit { request, estimate, limit, outcomes, computed: None }
}

impl Fit {
    /// Fit in JSON; velocities in m/s.
    pub fn json(&self) -> Value {
        let estimate = self.estimate.as_ref().ok();
        let [perforated, stopped] = self.outcomes.counts();
        let errors = |found: &Estimate| {
            let [[mu, _], [_, sigma]] = found.covariance;
            json!({ "mu": mu.sqrt(), "sigma": sigma.sqrt(), "information": "expected" })
        };
        let [quantiles, arithmetic, residual] = self.limit.json();
        json!({
            "mu": estimate.map(|found| found.mu),
            "sigma": estimate.map(|found| found.sigma),
            "deviance": estimate.map(Estimate::deviance),
            "quantiles": quantiles,
            "overlap": self.outcomes.overlap(),
            "method": estimate.map(|found| if found.firth { "Firth's penalised likelihood" } else { "maximum likelihood" }),
            "no_estimate": self.estimate.err(),
            "standard_errors": estimate.map(errors),
            "link": self.request.link.word(),
            "level": self.request.level,
            "interval": "likelihood",
            "shots": perforated + stopped,
            "perforated": perforated,
            "stopped": stopped,
            "slowest_perforation": self.outcomes.slowest_perforation(),
            "fastest_stop": self.outcomes.fastest_stop(),
            "arithmetic": arithmetic,
            "residual": residual,
            "computed": self.computed.map(|found| json!({
                "v50_m_s": found.v50, "low_m_s": found.bounds.low, "high_m_s": found.bounds.high, "sigma_m_s": found.sigma,
            })),
            "notes": self.notes(),
        })
    }

    /// Notes that a reader should know before the numbers are used.
    fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.computed.iter().map(|computed| computed.words(self.limit.v50())).collect();
        match &self.estimate {
            Err(why) => notes.push(format!("no estimate: {why}")),
            Ok(found) if found.firth => notes.push(
                "no overlap: no stop was faster than a perforation. The likelihood then has no maximum; the estimate is the one with \
                 Firth's penalty. Shoot where both outcomes are likely"
                    .to_owned(),
            ),
            Ok(_) => {}
        }
        let open = |of: &Quantile| of.value.is_some() && (of.bounds.low.is_none() || of.bounds.high.is_none());
        if self.limit.quantiles.iter().any(open) {
            notes.push(
                "an interval without an end: a chance that does not depend on velocity explains the shots well enough. Shoot more"
                    .to_owned(),
            );
        }
        notes.extend(self.limit.notes());
        notes
    }

    /// Fit in words, tables and drawings. `name`: of its shots.
    pub fn report(&self, name: &str) -> Report {
        let [perforated, stopped] = self.outcomes.counts();
        let count = perforated + stopped;
        let mixed = if self.outcomes.overlap() { "mixed results" } else { "no mixed results" };
        let zone = match (self.outcomes.slowest_perforation(), self.outcomes.fastest_stop()) {
            (Some(perforation), Some(stop)) => {
                let [perforation, stop] = [perforation, stop].map(|velocity| short(velocity, 4));
                format!("{mixed}: slowest perforation {perforation} m/s, fastest stop {stop} m/s")
            }
            _ => "one outcome only".to_owned(),
        };
        let rows = self.limit.quantiles.iter().map(|of| quantile_row(format!("{} %", short(100.0 * of.p, 3)), of));
        let quantiles =
            ReportTable::new("velocity by chance of a perforation", &["chance", "m/s", "low", "high"], 0, rows);
        let level = short(100.0 * self.request.level, 3);
        let mut panels = Vec::new();
        if count > 0 {
            panels.push(chance_panel(self));
        }
        panels.extend(residual_panel(&self.limit));
        Report {
            counts: vec![format!("{name}: {count} shots, {perforated} perforated, {stopped} stopped"), zone],
            answer: self.answer(),
            notes: self.notes(),
            tables: vec![
                quantiles.foot(&format!("{level} % intervals, likelihood ratio")),
                self.limit.arithmetic_table(""),
                self.limit.residual_table(),
            ],
            panels,
            ..Report::default()
        }
    }

    /// V50 and σ; nothing without an estimate.
    fn answer(&self) -> Vec<String> {
        let (Ok(found), Some((_, bounds))) = (&self.estimate, self.limit.v50()) else { return Vec::new() };
        let by = if found.firth { ", with Firth's penalty" } else { "" };
        let (sigma, link, deviance) = (short(found.sigma, 3), self.request.link.word(), short(found.deviance(), 4));
        vec![
            headline(found.mu, self.request.level, bounds.words()),
            format!("σ {sigma} m/s, {link}{by}, deviance {deviance}"),
        ]
    }
}
