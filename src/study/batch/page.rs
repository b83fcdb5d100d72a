//! `shots.html`: what the shots tell of the limit, and the distribution of what was drawn.

use super::ShotRow;
use crate::output::chart::{self, ChartAxis};
use crate::output::number::short;
use crate::study::fit::Fit;
use crate::study::fit::draw::{PANEL, PERFORATED, STOPPED};
use crate::study::fit::page::{document, figures, row, sections, table};

/// Bars of a histogram at most.
const BARS: usize = 16;

/// The page of a batch. `notes`: what its reader should know.
pub fn html(title: &str, rows: &[&ShotRow], fit: &Fit, notes: &[String]) -> String {
    let mut body = sections(fit);
    body += &notes.iter().map(|note| format!("<p class=\"note\">{}.</p>\n", chart::escape(note))).collect::<String>();
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
    let x = ChartAxis::linear([low, low + width], [64.0, PANEL[0] - 18.0]);
    let y = ChartAxis::linear(chart::rounded_up([0.0, most as f64]), [PANEL[1] - 58.0, 22.0]);
    let mut out = chart::axes(&x, &y, [name, "shots"]);
    for (n, [stopped, passed]) in counts.iter().enumerate() {
        let [left, right] = [n, n + 1].map(|n| x.at(low + width * n as f64 / bars as f64));
        for (from, to, colour) in [(0, *stopped, STOPPED), (*stopped, stopped + passed, PERFORATED)] {
            let [bottom, top] = [from, to].map(|count| y.at(count as f64));
            out += &format!(
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\"0.6\" \
                 stroke=\"white\"/>\n",
                right - left,
                bottom - top
            );
        }
    }
    out + &chart::text(x.paper[0], PANEL[1] - 8.0, "font-size=\"11\"", "orange: perforated, blue: not")
}

/// Shots without an outcome, and why.
fn failures(rows: &[&ShotRow]) -> String {
    let failed = rows.iter().filter(|row| row.perforated().is_none());
    let lines: String =
        failed.map(|shot| row(&[shot.order.shot.to_string(), short(shot.velocity, 5), shot.reason.clone()])).collect();
    if lines.is_empty() {
        lines
    } else {
        table("Shots without an outcome", &["shot", "velocity [m/s]", "reason"], &lines)
    }
}
