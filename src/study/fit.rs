//! `ripstop fit`: from a table of shots to a ballistic limit.
//!
//! The table is CSV with the columns `velocity_m_s` and `perforated`, and if wanted `count` and `residual_velocity_m_s`. Other columns are
//! left alone. Commas, semicolons or tabs separate columns; lines that begin with `#` are comments.

use std::fs;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use serde_json::{Value, json};

use super::binary_response::{self, Estimate, Group, Outcomes};
use super::interval::interval;
use super::limit::{Limit, Passed, QUANTILES, Quantile};
use super::report::{Report, chance_panel, headline, residual_panel};
use crate::case::CaseError;
use crate::output::number::short;

/// Shots of one line, and velocities [m/s], at most: squares stay finite, and no projectile is as fast.
const MOST: f64 = 1e6;
/// Columns, the first two of which must be there.
const COLUMNS: [&str; 4] = ["velocity_m_s", "perforated", "count", "residual_velocity_m_s"];
/// Remedy: sketch of a table.
const HELP: &str = "write a CSV (UTF-8) with a first line velocity_m_s,perforated and lines such as 431.5,1; numbers have a decimal point";

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
/// Where it cannot be read, or something else stands there: line, column and what was expected.
pub fn read(path: &Path) -> Result<Vec<FitRow>, CaseError> {
    let file = path.display().to_string();
    let wrong =
        |place: &str, expected: &str, found: String| CaseError::new(&file, place, expected, found, HELP.to_owned());
    let text =
        fs::read_to_string(path).map_err(|error| wrong("", "a table of shots, as text in UTF-8", error.to_string()))?;
    // Every line has one end, so the line of a record is the one before the next.
    let text = text.replace("\r\n", "\n") + "\n";
    let heading = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let separator = [b';', b'\t'].into_iter().find(|sign| heading.contains(char::from(*sign))).unwrap_or(b',');
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).comment(Some(b'#')).delimiter(separator).trim(Trim::All);
    let mut reader = reader.from_reader(text.as_bytes());
    let mut record = StringRecord::new();
    let mut places = None;
    let mut rows = Vec::new();
    let unreadable = |error: csv::Error| {
        let found = error.to_string().replace("CSV error: ", "");
        wrong("", "as many cells on every line as in the heading", found)
    };
    while reader.read_record(&mut record).map_err(unreadable)? {
        let line = format!("line {}", reader.position().line() - 1);
        let Some(places) = places else {
            let found = COLUMNS.map(|column| record.iter().position(|name| name == column));
            if let Some(missing) = (0..2).find(|column| found[*column].is_none()) {
                let names = record.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
                return Err(wrong(&line, &format!("a column {}", COLUMNS[missing]), names));
            }
            places = Some(found);
            continue;
        };
        rows.push(row(places, &record).map_err(|(column, expected)| {
            let found = places[column].map_or("", |place| &record[place]);
            wrong(&format!("{line}, column {}", COLUMNS[column]), &expected, format!("{found:?}"))
        })?);
    }
    if rows.iter().all(|row: &FitRow| row.count == 0) {
        return Err(wrong("", "a heading and lines of shots", "no shot".to_owned()));
    }
    Ok(rows)
}

/// Row of a line with its columns at these places; or the column that holds something else, and what was expected of it.
fn row(places: [Option<usize>; 4], record: &StringRecord) -> Result<FitRow, (usize, String)> {
    let cell = |column: usize| places[column].map_or("", |place| &record[place]);
    let number = |column: usize, is_right: &dyn Fn(f64) -> bool, expected: &str| {
        let value = cell(column).parse().ok().filter(|value: &f64| value.is_finite() && is_right(*value));
        value.ok_or_else(|| (column, expected.to_owned()))
    };
    let in_range = |value: f64| (0.0..=MOST).contains(&value);
    let velocity = number(0, &in_range, "an impact velocity from 0 to 1000000 m/s")?;
    let passed = "1 where the projectile passed, 0 where it was stopped";
    let perforated = number(1, &|outcome| outcome == 0.0 || outcome == 1.0, passed)? == 1.0;
    let is_count = |count: f64| count.fract() == 0.0 && in_range(count);
    let count = match cell(2) {
        "" => 1,
        _ => number(2, &is_count, "how many shots were alike, from 0 to 1000000, or nothing for 1")? as u64,
    };
    let residual = match (cell(3), perforated) {
        ("", _) => None,
        (_, true) => {
            let expected = format!("a residual velocity from 0 to the impact velocity, {velocity} m/s, or nothing");
            Some(number(3, &|residual| (0.0..=velocity).contains(&residual), &expected)?)
        }
        (_, false) => {
            number(3, &|residual| residual == 0.0, "0 or nothing, for the shot was stopped")?;
            None
        }
    };
    Ok(FitRow { velocity, perforated, count, residual })
}

/// Ballistic limit fitted to shots.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Two-sided confidence of intervals.
    pub level: f64,
    /// Outcomes of the shots.
    pub outcomes: Outcomes,
    /// μ and σ, or why there are none.
    pub estimate: Result<Estimate, &'static str>,
    /// Limit by every method.
    pub limit: Limit,
}

/// Shots that perforated with a known residual velocity.
pub(super) fn passed(rows: &[FitRow]) -> Vec<Passed> {
    let of = |row: &FitRow| row.residual.map(|residual| Passed { impact: row.velocity, residual, count: row.count });
    rows.iter().filter(|row| row.perforated && row.count > 0).filter_map(of).collect()
}

/// Fit of all that shots allow; `level`: two-sided confidence of intervals.
pub fn fit(rows: &[FitRow], level: f64) -> Fit {
    let outcomes = Outcomes::new(rows.iter().map(|row| {
        let [perforated, stopped] = if row.perforated { [row.count, 0] } else { [0, row.count] };
        Group { velocity: row.velocity, perforated, stopped }
    }));
    let estimate = binary_response::fit(&outcomes);
    let found = estimate.as_ref().ok();
    let quantile = |p: f64| {
        let bounds = interval(&outcomes, found, p, level);
        Quantile { p, value: found.map(|found| found.velocity(p)), bounds }
    };
    let limit = Limit::new(QUANTILES.map(quantile).to_vec(), Some(&outcomes), passed(rows), level);
    Fit { level, estimate, limit, outcomes }
}

impl Fit {
    /// Fit in JSON; velocities in m/s.
    pub fn json(&self) -> Value {
        let estimate = self.estimate.as_ref().ok();
        let [perforated, stopped] = self.outcomes.counts();
        let [quantiles, arithmetic, residual] = self.limit.json();
        json!({
            "mu": estimate.map(|found| found.mu),
            "sigma": estimate.map(|found| found.sigma),
            "deviance": estimate.map(Estimate::deviance),
            "quantiles": quantiles,
            "overlap": self.outcomes.overlap(),
            "method": estimate.map(|found| if found.firth { "Firth's penalised likelihood" } else { "maximum likelihood" }),
            "no_estimate": self.estimate.err(),
            "level": self.level,
            "shots": perforated + stopped,
            "perforated": perforated,
            "stopped": stopped,
            "slowest_perforation": self.outcomes.slowest_perforation(),
            "fastest_stop": self.outcomes.fastest_stop(),
            "arithmetic": arithmetic,
            "residual": residual,
            "notes": self.notes(),
        })
    }

    /// Notes that a reader should know before the numbers are used.
    fn notes(&self) -> Vec<String> {
        let mut notes = match &self.estimate {
            Err(why) => vec![format!("no estimate: {why}")],
            Ok(found) if found.firth => vec![
                "no overlap: no stop was faster than a perforation. The likelihood then has no maximum; the estimate is the one with \
                 Firth's penalty. Shoot where both outcomes are likely"
                    .to_owned(),
            ],
            Ok(_) => Vec::new(),
        };
        let open = |of: &Quantile| of.value.is_some() && (of.bounds.low.is_none() || of.bounds.high.is_none());
        if self.limit.quantiles.iter().any(open) {
            notes.push(
                "an interval without an end: a chance that does not depend on velocity explains the shots well enough. Shoot more"
                    .to_owned(),
            );
        }
        notes.extend(self.limit.note());
        notes
    }

    /// Fit in words, tables and drawings. `name`: of its shots.
    pub fn report(&self, name: &str) -> Report {
        let [perforated, stopped] = self.outcomes.counts();
        let count = perforated + stopped;
        let zone = match (self.outcomes.slowest_perforation(), self.outcomes.fastest_stop()) {
            (Some(perforation), Some(stop)) => {
                let mixed = if self.outcomes.overlap() { "mixed results" } else { "no mixed results" };
                let [perforation, stop] = [perforation, stop].map(|velocity| short(velocity, 4));
                format!("{mixed}: slowest perforation {perforation} m/s, fastest stop {stop} m/s")
            }
            _ => "one outcome only".to_owned(),
        };
        Report {
            title: String::new(),
            counts: vec![format!("{name}: {count} shots, {perforated} perforated, {stopped} stopped"), zone],
            answer: self.answer(),
            notes: self.notes(),
            tables: self.limit.tables(self.level),
            panels: (count > 0).then(|| chance_panel(self)).into_iter().chain(residual_panel(&self.limit)).collect(),
        }
    }

    /// V50 and σ; nothing without an estimate.
    fn answer(&self) -> Vec<String> {
        let (Ok(found), Some((_, bounds))) = (&self.estimate, self.limit.v50()) else { return Vec::new() };
        let by = if found.firth { ", with Firth's penalty" } else { "" };
        let (sigma, deviance) = (short(found.sigma, 3), short(found.deviance(), 4));
        vec![headline(found.mu, self.level, bounds.words()), format!("σ {sigma} m/s{by}, deviance {deviance}")]
    }
}
