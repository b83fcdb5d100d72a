//! `shots.html`: what the shots tell of the limit, and the distribution of what was drawn.

use super::ShotRow;
use crate::output::chart;
use crate::output::number::short;
use crate::study::fit::draw::{PERFORATED, STOPPED, below, plane};
use crate::study::fit::{Fit, sections};
use crate::study::page::{document, figures, filled_table, remarks, row};

/// Bars of a histogram at most.
const BARS: usize = 16;

/// The page of a batch. `notes`: what its reader should know.
pub fn html(title: &str, rows: &[&ShotRow], fit: &Fit, notes: &[String]) -> String {
    let mut body = sections(fit);
    body += &remarks(notes);
    let drawn = histograms(rows);
    if !drawn.is_empty() {
        body += "<h2>What was drawn</h2>\n";
        body += &figures(drawn.iter().map(|(name, drawing)| (name.as_str(), drawing.clone())));
    }
    body += &failures(rows);
    document(&format!("Shots: {title}"), &body, "shots.csv")
}

/// A histogram of every value that was drawn, and of the impact velocity: its name and what lies in the drawing.
fn histograms(rows: &[&ShotRow]) -> Vec<(String, String)> {
    let mut columns = vec!["velocity_m_s".to_owned()];
    columns.extend(rows.first().into_iter().flat_map(|row| row.drawn.iter().map(|drawn| drawn.column.clone())));
    let of = |column: &String| -> Vec<(f64, Option<bool>)> {
        let value = |row: &&ShotRow| match column.as_str() {
            "velocity_m_s" => Some(row.velocity),
            name => row.drawn.iter().find(|drawn| drawn.column == name).map(|drawn| drawn.value),
        };
        rows.iter().filter_map(|row| Some((value(row)?, row.perforated()))).collect()
    };
    let drawn = columns.into_iter().map(|column| (of(&column), column)).filter(|(values, _)| values.len() > 1);
    drawn.map(|(values, column)| (column.clone(), histogram(&column, &values))).collect()
}

/// Counts of a value: those that were stopped below, those that perforated on top.
fn histogram(name: &str, values: &[(f64, Option<bool>)]) -> String {
    let low = values.iter().map(|(value, _)| *value).fold(f64::INFINITY, f64::min);
    let high = values.iter().map(|(value, _)| *value).fold(f64::NEG_INFINITY, f64::max);
    let width = (high - low).max(1e-9 * high.abs()).max(1e-12);
    let bars = BARS.min((2.0 * (values.len() as f64).sqrt()).ceil() as usize);
    let mut counts = vec![[0_usize; 2]; bars];
    for (value, perforated) in values {
        let bar = ((value - low) / width * bars as f64) as usize;
        counts[bar.min(bars - 1)][usize::from(*perforated == Some(true))] += 1;
    }
    let most = counts.iter().map(|[stopped, passed]| stopped + passed).max().unwrap_or(1);
    let ranges = [[low, low + width], chart::rounded_up([0.0, most as f64])];
    let (x, y, mut out) = plane(64.0, ranges, [name, "shots"]);
    for (n, [stopped, passed]) in counts.iter().enumerate() {
        let sides = [n, n + 1].map(|n| x.at(low + width * n as f64 / bars as f64));
        for (from, to, colour) in [(0, *stopped, STOPPED), (*stopped, stopped + passed, PERFORATED)] {
            let style = format!("fill=\"{colour}\" fill-opacity=\"0.6\" stroke=\"white\"");
            out += &chart::area(sides, [to, from].map(|count| y.at(count as f64)), &style, "");
        }
    }
    out + &below(&x, "orange: perforated, blue: not")
}

/// Shots without an outcome, and why.
fn failures(rows: &[&ShotRow]) -> String {
    let failed = rows.iter().copied().filter(|row| row.perforated().is_none());
    let line = |shot: &ShotRow| row(&[shot.order.shot.to_string(), short(shot.velocity, 5), shot.reason.clone()]);
    let lines: String = failed.map(line).collect();
    filled_table("Shots without an outcome", &["shot", "velocity [m/s]", "reason"], &lines)
}
