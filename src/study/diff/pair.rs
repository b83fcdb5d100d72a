//! What differs between two inputs.

use serde_json::Value;

use super::curve::{self, CurveDifference};
use super::error::few;
use super::input::Input;
use super::keys::{self, KeyDifference};
use super::quantity;
use super::request::{DiffOptions, DiffRequest};
use super::summary::{self, SummaryRow};
use super::text::word;
use crate::output::number::short;
use crate::study::StudyError;

/// Curves that two inputs are judged by where none is named: what a shot is measured by.
const JUDGED: [&str; 3] = ["projectile_velocity_m_s", "projectile_displacement_mm", "max_deflection_mm"];

/// Two inputs, the first of all and another.
#[derive(Clone, Debug, PartialEq)]
pub struct RunPair {
    /// Quantities of both summaries; empty where one has none.
    pub summary: Vec<SummaryRow>,
    /// Keys of the cases that differ; `None` where one has no case.
    pub keys: Option<Vec<KeyDifference>>,
    /// What computed them, as far as that differs.
    pub machine: Vec<KeyDifference>,
    /// Columns that both have.
    pub curves: Vec<CurveRow>,
    /// Columns that only one has: the first, the other.
    pub alone: [Vec<String>; 2],
}

/// A column that both have.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveRow {
    /// Name, unit last.
    pub name: String,
    /// How it differs.
    pub difference: CurveDifference,
    /// Whether two inputs are judged by it.
    pub judged: bool,
    /// Within what was asked for; `None` where it is not judged.
    pub pass: Option<bool>,
}

impl RunPair {
    /// The judged curve that parts first, and when [µs].
    pub fn parts(&self) -> Option<(&CurveRow, f64)> {
        let parted = self.curves.iter().filter(|row| row.judged);
        let parted = parted.filter_map(|row| Some((row, row.difference.parts_at?)));
        parted.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Times that curves cover [µs], with the names of those that do; most of them first.
    pub fn spans(&self) -> Vec<([f64; 2], Vec<&str>)> {
        let mut spans: Vec<([f64; 2], Vec<&str>)> = Vec::new();
        for row in &self.curves {
            let span = row.difference.span;
            match spans.iter_mut().find(|known| known.0 == span) {
                Some((_, names)) => names.push(&row.name),
                None => spans.push((span, vec![&row.name])),
            }
        }
        spans.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
        spans
    }

    /// What is not within what was asked for, one line each.
    pub fn failures(&self) -> impl Iterator<Item = String> {
        let summary = self.summary.iter().filter(|row| row.pass == Some(false)).map(|row| match row.relative {
            Some(relative) => format!("{}: {} ({:+.3} %)", row.name, two(&row.a, &row.b), 100.0 * relative),
            None => format!("{}: {}", row.name, two(&row.a, &row.b)),
        });
        let curves = self.curves.iter().filter(|row| row.pass == Some(false)).map(|row| {
            let share = row.difference.share().map_or(String::new(), |share| format!(" ({:.3} %)", 100.0 * share));
            let unit = quantity::unit_of(&row.name);
            let largest = short(row.difference.largest, 4);
            format!("curve {}: {largest}{unit}{share} at {:.3} µs", row.name, row.difference.at)
        });
        summary.chain(curves)
    }
}

fn two(a: &Value, b: &Value) -> String {
    format!("{} and {}", word(Some(a)), word(Some(b)))
}

/// Compares two inputs.
pub(super) fn pair(first: &Input, other: &Input, request: &DiffRequest) -> Result<RunPair, StudyError> {
    let curves = curves(first, other, &common(first, other, &request.columns)?, request);
    if curves.is_empty() {
        let [[from, to], [first_from, first_to]] = [other, first].map(|input| input.table.span());
        let found = format!("{from} to {to} µs; {first_from} to {first_to} µs in the first");
        let help = "check the unit of time, or move one of them: --shift US";
        return Err(StudyError::new(other.path.display().to_string(), "times that both cover", found, help));
    }
    let only = |input: &Input, without: &Input| {
        let columns = input.table.columns.iter().map(|column| &column.name);
        columns.filter(|name| without.table.column(name).is_none()).cloned().collect()
    };
    // Where curves are named, nothing else is judged.
    let within = request.options.within.filter(|_| request.columns.is_empty());
    let both = |of: fn(&Input) -> Option<&Value>| of(first).zip(of(other));
    Ok(RunPair {
        summary: summary::rows(first, other, within),
        keys: both(|input| input.case.as_ref()).map(|(a, b)| keys::of_cases(a, b)),
        machine: both(|input| input.summary.as_ref()).map_or_else(Vec::new, |(a, b)| keys::of_machines(a, b)),
        curves,
        alone: [only(first, other), only(other, first)],
    })
}

/// The columns that both have, as far as they are wanted: those named, all where none is.
fn common<'a>(first: &'a Input, other: &Input, named: &[String]) -> Result<Vec<&'a str>, StudyError> {
    let has = |input: &Input, name: &str| input.table.column(name).is_some();
    let expected = "a column that both have";
    let missing = named.iter().flat_map(|name| [(name, first), (name, other)]).find(|(name, input)| !has(input, name));
    if let Some((name, input)) = missing {
        let place = format!("--column {name}: {}", input.path.display());
        let help = "name one of these, or say what a heading stands for: --column HEADING=NAME";
        return Err(StudyError::new(place, expected, names(input), help));
    }
    let both = first.table.columns.iter().map(|column| column.name.as_str()).filter(|name| has(other, name));
    let common: Vec<&str> = both.filter(|name| named.is_empty() || named.iter().any(|named| named == name)).collect();
    if common.is_empty() {
        let found = format!("{}; {} in the first", names(other), names(first));
        let help = "say what a heading stands for: --column HEADING=projectile_velocity_m_s";
        return Err(StudyError::new(other.path.display().to_string(), expected, found, help));
    }
    Ok(common)
}

/// How columns differ; those without common times are left out.
fn curves(first: &Input, other: &Input, common: &[&str], request: &DiffRequest) -> Vec<CurveRow> {
    let DiffOptions { within, .. } = request.options;
    let usual = common.iter().any(|name| JUDGED.contains(name));
    let all = !request.columns.is_empty() || !usual;
    let row = |name: &&str| {
        let points = |input: &Input| input.table.column(name).map(|column| input.table.points(column));
        let scale = quantity::is_share(name).then_some(1.0);
        let difference = curve::scaled(&points(first)?, &points(other)?, request.options.part(), scale)?;
        let judged = all || JUDGED.contains(name);
        let good = |within: f64| difference.share().is_some_and(|share| share <= within);
        Some(CurveRow { name: (*name).to_owned(), difference, judged, pass: within.filter(|_| judged).map(good) })
    };
    common.iter().filter_map(row).collect()
}

fn names(input: &Input) -> String {
    few(input.table.columns.iter().map(|column| column.name.as_str()))
}
