//! What differs between two inputs.

use super::curve::{self, Difference};
use super::error::{DiffError, few};
use super::input::Input;
use super::keys::{self, Key};
use super::quantity;
use super::request::Request;
use super::summary::{self, SummaryRow};

/// Curves that two inputs are judged by where none is named: what a shot is measured by.
const JUDGED: [&str; 3] = ["projectile_velocity_m_s", "projectile_displacement_mm", "max_deflection_mm"];

/// Two inputs, the first of all and another.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Quantities of both summaries; empty where one has none.
    pub summary: Vec<SummaryRow>,
    /// Keys of the cases that differ; `None` where one has no case.
    pub keys: Option<Vec<Key>>,
    /// What computed them, as far as that differs.
    pub machine: Vec<Key>,
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
    pub difference: Difference,
    /// Whether two inputs are judged by it.
    pub judged: bool,
    /// Within what was asked for; `None` where it is not judged.
    pub pass: Option<bool>,
}

impl Pair {
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
            let largest = crate::output::number::short(row.difference.largest, 4);
            format!("curve {}: {largest}{unit}{share} at {:.3} µs", row.name, row.difference.at)
        });
        summary.chain(curves)
    }
}

fn two(a: &serde_json::Value, b: &serde_json::Value) -> String {
    let text = |value: &serde_json::Value| if value.is_null() { "none".to_owned() } else { value.to_string() };
    format!("{} and {}", text(a), text(b))
}

/// Compares two inputs.
pub(super) fn pair(first: &Input, other: &Input, request: &Request) -> Result<Pair, DiffError> {
    let options = request.options;
    let named = &request.columns;
    let has = |input: &Input, name: &str| input.table.column(name).is_some();
    for name in named {
        for input in [first, other].into_iter().filter(|input| !has(input, name)) {
            let place = format!("--column {name}: {}", input.path.display());
            let found = names(input);
            return Err(DiffError::new(
                place,
                "a column that both have",
                found,
                "or say which it is: --column HEADING=NAME",
            ));
        }
    }
    let wanted = |name: &str| named.is_empty() || named.iter().any(|named| named == name);
    let common: Vec<&str> =
        first.table.columns.iter().map(|column| column.name.as_str()).filter(|n| has(other, n)).collect();
    if common.is_empty() {
        let found = format!("{} in the first", names(first));
        let help = "say what a heading stands for: --column HEADING=projectile_velocity_m_s";
        let place = other.path.display().to_string();
        return Err(DiffError::new(place, "a column that both have", format!("{}; {found}", names(other)), help));
    }
    let usual = common.iter().any(|name| JUDGED.contains(name));
    let judged = |name: &str| !named.is_empty() || !usual || JUDGED.contains(&name);
    let mut curves = Vec::new();
    for name in common.iter().filter(|name| wanted(name)) {
        let [a, b] = [first, other].map(|input| input.table.column(name).map(|column| input.table.points(column)));
        let scale = quantity::is_share(name).then_some(1.0);
        let difference = a.zip(b).and_then(|(a, b)| curve::scaled(&a, &b, options.part(), scale));
        let Some(difference) = difference else { continue };
        let good = |within: f64| difference.share().is_some_and(|share| share <= within);
        let judged = judged(name);
        let pass = options.within.filter(|_| judged).map(good);
        curves.push(CurveRow { name: (*name).to_owned(), difference, judged, pass });
    }
    if curves.is_empty() {
        let [[from, to], [first_from, first_to]] = [other, first].map(|input| input.table.span());
        let found = format!("{from} to {to} µs; {first_from} to {first_to} µs in the first");
        let help = "check the unit of time, or move one of them: --shift US";
        return Err(DiffError::new(other.path.display().to_string(), "times that both cover", found, help));
    }
    let only = |input: &Input, without: &Input| {
        let columns = input.table.columns.iter().map(|column| &column.name);
        columns.filter(|name| !has(without, name)).cloned().collect()
    };
    // Where curves are named, nothing else is judged.
    let summary = summary::rows(first, other, options.within.filter(|_| named.is_empty()));
    Ok(Pair {
        summary,
        keys: first.case.as_ref().zip(other.case.as_ref()).map(|(a, b)| keys::of_cases(a, b)),
        machine: first
            .summary
            .as_ref()
            .zip(other.summary.as_ref())
            .map_or_else(Vec::new, |(a, b)| keys::of_machines(a, b)),
        curves,
        alone: [only(first, other), only(other, first)],
    })
}

fn names(input: &Input) -> String {
    few(input.table.columns.iter().map(|column| column.name.as_str()))
}
