//! `ripstop fit`: from a table of shots, as it is written at a range, to a ballistic limit in the unit of their velocities.
//!
//! The table is CSV with a heading. Commas, semicolons or tabs separate columns; beside semicolons a number may have a decimal comma.
//! Lines that begin with `#` are comments. Columns are found by the words that people use for them, with the unit in their names.

use std::fs;
use std::path::Path;

use csv::{Reader, ReaderBuilder, StringRecord, Trim};
use serde::Serialize;
use serde_json::{Value, json};

use super::binary_response::{self, Estimate, Group, Outcomes, interval};
use super::limit::{Limit, Passed, QUANTILES, Quantile};
use super::report::{Report, ReportTable, chance_panel, headline, residual_panel};
use crate::case::CaseError;
use crate::output::number::short;

/// Shots of one line, and velocities, at most: squares stay finite, and no projectile is as fast.
const MOST: f64 = 1e6;
/// Remedy: sketch of a table.
const HELP: &str = "write a CSV (UTF-8) with a first line velocity_m_s,perforated and lines such as 431.5,1; numbers have a decimal point, \
                    or a comma beside semicolons; --column and --unit say what headings do not";
/// Names of columns by their kind, without unit and signs; the first that is there is taken.
const NAMES: [&[&str]; 4] = [
    &["velocity", "impactvelocity", "strikingvelocity", "strikevelocity", "vs", "vi", "v"],
    &["perforated", "perforation", "outcome", "result", "penetration"],
    &["count"],
    &["residualvelocity", "exitvelocity", "residual", "vr"],
];
/// Marks of a shot that was stopped, and of one that passed.
const MARKS: [&[&str]; 2] = [
    &["0", "pp", "no", "n", "false", "stopped", "rebounded", "partial", "partial penetration"],
    &["1", "cp", "yes", "y", "true", "perforated", "complete", "complete penetration"],
];
const PASSED: &str = "1, CP, yes or perforated where the projectile passed, 0, PP, no or stopped where it was stopped";
/// Cells that say nothing.
const NOTHING: [&str; 5] = ["", "na", "n/a", "-", "null"];
/// Ends of column names that are a unit, by unit.
const UNITS: [(VelocityUnit, &[&str]); 2] = [
    (VelocityUnit::MetresPerSecond, &[" m s", " m s 1", " mps"]),
    (VelocityUnit::FeetPerSecond, &[" ft s", " ft s 1", " ft sec", " fps"]),
];

/// Unit of velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum VelocityUnit {
    /// Metres per second.
    #[default]
    #[value(name = "m/s")]
    MetresPerSecond,
    /// Feet per second.
    #[value(name = "ft/s")]
    FeetPerSecond,
}

impl VelocityUnit {
    /// Symbol.
    pub fn symbol(self) -> &'static str {
        ["m/s", "ft/s"][self as usize]
    }

    /// Size \[m/s\].
    pub fn size(self) -> f64 {
        [1.0, 0.3048][self as usize]
    }
}

/// Kind of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ColumnKind {
    /// Impact velocity.
    Velocity,
    /// Whether the projectile passed.
    Perforated,
    /// How many shots were alike.
    Count,
    /// Residual velocity.
    Residual,
}

/// One line: shots that were alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRow {
    /// Impact velocity, in the unit of the table.
    pub velocity: f64,
    /// Whether they perforated.
    pub perforated: bool,
    /// Number of shots.
    pub count: u64,
    /// Residual velocity in the same unit, where it was measured.
    pub residual: Option<f64>,
}

/// Shots of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RangeData {
    /// Unit of their velocities.
    pub unit: VelocityUnit,
    /// Lines.
    pub rows: Vec<FitRow>,
    /// Number of lines without a velocity or an outcome.
    pub left_out: usize,
}

/// Shots of a file. `unit`, `columns`: what its heading does not say.
///
/// # Errors
/// Where it cannot be read, or something else stands there: line, column and what was expected.
pub fn read(path: &Path, unit: Option<VelocityUnit>, columns: &[(ColumnKind, String)]) -> Result<RangeData, CaseError> {
    let file = path.display().to_string();
    let wrong = |place: &str, expected: &str, found: String| CaseError::new(&file, place, expected, found, HELP);
    let text =
        fs::read_to_string(path).map_err(|error| wrong("", "a table of shots, as text in UTF-8", error.to_string()))?;
    // Every line has one end, so the line of a record is the one before the next.
    let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n") + "\n";
    let heading = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let separator = [b';', b'\t'].into_iter().find(|sign| heading.contains(char::from(*sign))).unwrap_or(b',');
    let mut reader = ReaderBuilder::new();
    reader.comment(Some(b'#')).delimiter(separator).trim(Trim::All);
    let mut reader = reader.from_reader(text.as_bytes());
    let unreadable = |error: csv::Error| {
        let found = error.to_string().replace("CSV error: ", "");
        wrong("", "as many cells on every line as in the heading", found)
    };
    let heading = reader.headers().map_err(unreadable)?.clone();
    let line = |reader: &Reader<&[u8]>| format!("line {}", reader.position().line() - 1);
    let table = Table::new(&heading, unit, columns, separator == b';').map_err(|expected| {
        let names = heading.iter().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", ");
        wrong(&line(&reader), &expected, format!("{} columns: {names}", heading.len()))
    })?;
    let mut data = RangeData { unit: table.unit, ..RangeData::default() };
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(unreadable)? {
        let row = table.row(&record).map_err(|(kind, expected)| {
            let [name, cell] = [&heading, &record].map(|of| table.cell(of, kind));
            wrong(&format!("{}, column {name}", line(&reader)), &expected, format!("{cell:?}"))
        })?;
        data.left_out += usize::from(row.is_none());
        data.rows.extend(row);
    }
    let is_empty = data.rows.iter().all(|row| row.count == 0);
    if is_empty { Err(wrong("", "lines of shots below a heading", "no shot".to_owned())) } else { Ok(data) }
}

/// Meaning of the columns of a table.
struct Table {
    /// Places of the columns by their kind.
    places: [Option<usize>; 4],
    unit: VelocityUnit,
    /// Factor that turns residual velocities into that unit.
    residual_factor: f64,
    has_decimal_comma: bool,
}

impl Table {
    /// Table with this heading.
    ///
    /// # Errors
    /// What was expected of the heading.
    fn new(
        heading: &StringRecord,
        asked: Option<VelocityUnit>,
        columns: &[(ColumnKind, String)],
        has_decimal_comma: bool,
    ) -> Result<Self, String> {
        let names: Vec<(String, Option<VelocityUnit>)> = heading.iter().map(name_and_unit).collect();
        let mut places =
            NAMES.map(|known| known.iter().find_map(|word| names.iter().position(|(name, _)| name == word)));
        for (kind, name) in columns {
            let place = heading.iter().position(|other| other == name).ok_or_else(|| format!("a column {name}"))?;
            places[*kind as usize] = Some(place);
        }
        let [velocity, perforated, _, residual] = places;
        let velocity = velocity.ok_or("a column velocity_m_s, or velocity_ft_s")?;
        if perforated.or(residual).is_none() {
            return Err("a column perforated, or residual_velocity_m_s".to_owned());
        }
        let unit = match (names[velocity].1, asked) {
            (Some(named), Some(asked)) if named != asked => {
                return Err(format!("velocities in {}, as --unit says", asked.symbol()));
            }
            (named, asked) => named.or(asked).ok_or("a column velocity_m_s or velocity_ft_s, or --unit")?,
        };
        let of_residual = residual.and_then(|place| names[place].1).unwrap_or(unit);
        let residual_factor = of_residual.size() / unit.size();
        Ok(Self { places, unit, residual_factor, has_decimal_comma })
    }

    /// Cell of a column; empty where there is none.
    fn cell<'a>(&self, record: &'a StringRecord, kind: ColumnKind) -> &'a str {
        self.places[kind as usize].map_or("", |place| &record[place])
    }

    /// Row of a line, `None` without a velocity or an outcome; or the column that holds something else, and what was expected of it.
    fn row(&self, record: &StringRecord) -> Result<Option<FitRow>, (ColumnKind, String)> {
        let cell = |kind: ColumnKind| {
            let cell = self.cell(record, kind).to_lowercase();
            (!NOTHING.contains(&&*cell)).then_some(cell)
        };
        let number = |kind: ColumnKind, is_right: &dyn Fn(f64) -> bool, expected: &str| {
            let Some(cell) = cell(kind) else { return Ok(None) };
            let text = if self.has_decimal_comma { cell.replace(',', ".") } else { cell };
            let value = text.parse().ok().filter(|value: &f64| value.is_finite() && is_right(*value));
            value.map(Some).ok_or_else(|| (kind, expected.to_owned()))
        };
        let in_range = |value: f64| (0.0..=MOST).contains(&value);
        let is_count = |count: f64| count.fract() == 0.0 && in_range(count);
        let symbol = self.unit.symbol();
        let velocity =
            number(ColumnKind::Velocity, &in_range, &format!("an impact velocity from 0 to 1000000 {symbol}"))?;
        let alike = "how many shots were alike, from 0 to 1000000, or nothing for 1";
        let count = number(ColumnKind::Count, &is_count, alike)?.unwrap_or(1.0) as u64;
        let residual = number(ColumnKind::Residual, &|_| true, "a residual velocity, or nothing")?;
        let residual = residual.map(|residual| residual * self.residual_factor);
        let has_outcome = self.places[ColumnKind::Perforated as usize].is_some();
        let perforated = match cell(ColumnKind::Perforated) {
            Some(mark) => {
                let outcome = MARKS.iter().position(|marks| marks.contains(&mark.trim_end_matches(".0")));
                Some(outcome.ok_or((ColumnKind::Perforated, PASSED.to_owned()))? == 1)
            }
            None => residual.filter(|_| !has_outcome).map(|residual| residual > 0.0),
        };
        let (Some(velocity), Some(perforated)) = (velocity, perforated) else { return Ok(None) };
        let upto = format!("a residual velocity from 0 to the impact velocity, {velocity} {symbol}, or nothing");
        let (most, expected) =
            if perforated { (velocity, &*upto) } else { (0.0, "0 or nothing, for the shot was stopped") };
        if has_outcome && residual.is_some_and(|residual| !(0.0..=most).contains(&residual))
            || residual > Some(velocity)
        {
            return Err((ColumnKind::Residual, expected.to_owned()));
        }
        Ok(Some(FitRow { velocity, perforated, count, residual: residual.filter(|_| perforated) }))
    }
}

/// Name of a column without its unit, in small letters and digits alone, and the unit.
fn name_and_unit(name: &str) -> (String, Option<VelocityUnit>) {
    let name = name.to_lowercase().replace(|c: char| !c.is_alphanumeric(), " ");
    let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
    let ends = UNITS.iter().flat_map(|(unit, ends)| ends.iter().map(move |end| (end, *unit)));
    let mut found = ends.filter_map(|(end, unit)| Some((name.strip_suffix(end)?, Some(unit))));
    let (stem, unit) = found.next().unwrap_or((&name, None));
    (stem.replace(' ', ""), unit)
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
    /// Limit by every method but the arithmetic one.
    pub limit: Limit,
    /// Arithmetic V50 of each rule.
    pub arithmetic: Vec<ArithmeticV50>,
    /// Number of lines without a velocity or an outcome.
    left_out: usize,
}

/// Shots that perforated with a known residual velocity.
pub(super) fn passed(rows: &[FitRow]) -> Vec<Passed> {
    let of = |row: &FitRow| row.residual.map(|residual| Passed { impact: row.velocity, residual, count: row.count });
    rows.iter().filter(|row| row.perforated && row.count > 0).filter_map(of).collect()
}

/// Rules in use: standard, number of perforations and of stops, and largest less smallest velocity of all of them at most, in m/s and in ft/s.
/// MIL-STD-662F leaves the choice to the specification of the armour.
const RULES: [(&str, u64, [f64; 2]); 4] = [
    ("MIL-STD-662F", 2, [18.0, 60.0]),
    ("MIL-STD-662F", 3, [38.0, 125.0]),
    ("MIL-STD-662F", 5, [38.0, 125.0]),
    ("STANAG 2920", 3, [40.0, 131.2]),
];

/// Arithmetic V50 of a standard: mean of equally many lowest perforations and highest stops that lie close together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArithmeticV50 {
    /// Rule in words.
    pub rule: String,
    /// Standard that has it; `own` of a spread that was asked for.
    pub standard: &'static str,
    /// Mean velocity; `None` where it is refused.
    pub value: Option<f64>,
    /// Largest less smallest velocity, where there are enough shots.
    pub spread: Option<f64>,
    /// Reason of a refusal: too few shots, or too wide a spread.
    pub refused: Option<String>,
}

/// Arithmetic V50 by every rule, and with a spread of one's own.
pub fn arithmetic_v50(outcomes: &Outcomes, unit: VelocityUnit, spread: Option<f64>) -> Vec<ArithmeticV50> {
    let (counts, symbol) = (outcomes.counts(), unit.symbol());
    let by = |(standard, pairs, most): (&'static str, u64, f64)| {
        let rule = format!("{pairs} + {pairs} within {most} {symbol}");
        if counts.iter().any(|count| *count < pairs) {
            let refused = Some(format!("perforations: {}, stops: {}", counts[0], counts[1]));
            return ArithmeticV50 { rule, standard, value: None, spread: None, refused };
        }
        let lowest = first(outcomes.groups().iter(), |group| group.perforated, pairs);
        let highest = first(outcomes.groups().iter().rev(), |group| group.stopped, pairs);
        let all = || lowest.iter().chain(&highest).copied();
        let mean = all().sum::<f64>() / (2 * pairs) as f64;
        let spread = all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min);
        // A spread that is met to the last digit written is met.
        let is_met = spread <= most * (1.0 + 1e-12);
        let refused =
            (!is_met).then(|| format!("spread {} {symbol}, mean {} {symbol}", short(spread, 4), short(mean, 4)));
        ArithmeticV50 { rule, standard, value: is_met.then_some(mean), spread: Some(spread), refused }
    };
    let rules = RULES.map(|(standard, pairs, most)| (standard, pairs, most[unit as usize]));
    let own = spread.map(|most| [2, 3, 5].map(|pairs| ("own", pairs, most)));
    rules.into_iter().chain(own.into_iter().flatten()).map(by).collect()
}

/// Velocities of the first `count` shots of an outcome.
fn first<'a>(groups: impl Iterator<Item = &'a Group>, of: fn(&Group) -> u64, count: u64) -> Vec<f64> {
    let shots = groups.flat_map(|group| (0..of(group)).map(|_| group.velocity));
    shots.take(count as usize).collect()
}

/// Fit of all that shots allow. `level`: two-sided confidence of intervals; `spread`: another one for the arithmetic V50, in the unit of the
/// velocities.
pub fn fit(data: &RangeData, level: f64, spread: Option<f64>) -> Fit {
    let outcomes = Outcomes::new(data.rows.iter().map(|row| {
        let [perforated, stopped] = if row.perforated { [row.count, 0] } else { [0, row.count] };
        Group { velocity: row.velocity, perforated, stopped }
    }));
    let estimate = binary_response::fit(&outcomes);
    let found = estimate.as_ref().ok();
    let quantile = |p: f64| {
        let bounds = interval(&outcomes, found, p, level);
        Quantile { p, value: found.map(|found| found.velocity(p)), bounds }
    };
    let limit = Limit::new(data.unit, QUANTILES.map(quantile).to_vec(), passed(&data.rows), level);
    let arithmetic = arithmetic_v50(&outcomes, data.unit, spread);
    Fit { level, estimate, limit, arithmetic, outcomes, left_out: data.left_out }
}

impl Fit {
    /// Fit in JSON.
    pub fn json(&self) -> Value {
        let estimate = self.estimate.as_ref().ok();
        let [perforated, stopped] = self.outcomes.counts();
        let [quantiles, residual] = self.limit.json();
        json!({
            "unit": self.limit.unit.symbol(),
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
            "arithmetic": self.arithmetic,
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
        if self.left_out > 0 {
            notes.push(format!("lines without a velocity or an outcome: {}, left out", self.left_out));
        }
        notes
    }

    /// Fit in words, tables and drawings. `name`: of its shots.
    pub fn report(&self, name: &str) -> Report {
        let [perforated, stopped] = self.outcomes.counts();
        let (count, unit) = (perforated + stopped, self.limit.unit.symbol());
        let zone = match (self.outcomes.slowest_perforation(), self.outcomes.fastest_stop()) {
            (Some(perforation), Some(stop)) => {
                let mixed = if self.outcomes.overlap() { "mixed results" } else { "no mixed results" };
                let [perforation, stop] = [perforation, stop].map(|velocity| short(velocity, 4));
                format!("slowest perforation: {perforation} {unit}, fastest stop {stop} {unit}: {mixed}")
            }
            _ => "one outcome only".to_owned(),
        };
        let rule = |found: &ArithmeticV50| {
            let words = match (&found.refused, found.value, found.spread) {
                (None, Some(value), Some(spread)) => {
                    format!("{} {unit}, spread {} {unit}", short(value, 4), short(spread, 3))
                }
                (why, ..) => format!("none: {}", why.as_deref().unwrap_or_default()),
            };
            vec![found.standard.to_owned(), found.rule.clone(), words]
        };
        let arithmetic = ReportTable::new("arithmetic V50", &[], 3).rows(self.arithmetic.iter().map(rule), "");
        let [quantiles, residual] = self.limit.tables(self.level);
        Report {
            title: String::new(),
            counts: vec![format!("{name}: {count} shots, {perforated} perforated, {stopped} stopped"), zone],
            answer: self.answer(),
            notes: self.notes(),
            tables: vec![quantiles, arithmetic, residual],
            panels: (count > 0).then(|| chance_panel(self)).into_iter().chain(residual_panel(&self.limit)).collect(),
        }
    }

    /// V50 and σ; nothing without an estimate.
    fn answer(&self) -> Vec<String> {
        let (Ok(found), Some((_, bounds))) = (&self.estimate, self.limit.v50()) else { return Vec::new() };
        let by = if found.firth { ", with Firth's penalty" } else { "" };
        let (sigma, deviance, unit) = (short(found.sigma, 3), short(found.deviance(), 4), self.limit.unit);
        let headline = headline(found.mu, unit, self.level, bounds.words());
        vec![headline, format!("σ {sigma} {}{by}, deviance {deviance}", unit.symbol())]
    }
}
