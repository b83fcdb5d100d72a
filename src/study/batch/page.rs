//! `shots.html`: what the shots tell of the limit, and the distribution of what was drawn.

use maud::html;

use super::ShotRow;
use crate::output::number::short;
use crate::output::plot::{Figure, Plot};
use crate::study::fit::draw::{PERFORATED, STOPPED};
use crate::study::fit::{Fit, sections};
use crate::study::page::{document, figures, remarks, table};

/// Bars of a histogram at most.
const BARS: usize = 16;

/// The page of a batch. `notes`: what its reader should know.
pub fn html(title: &str, rows: &[&ShotRow], fit: &Fit, notes: &[String]) -> String {
    let drawn = histograms(rows);
    let failed = rows.iter().filter(|row| row.perforated().is_none());
    let failed = failed.map(|shot| vec![shot.order.shot.to_string(), short(shot.velocity, 5), shot.reason.clone()]);
    let body = html! {
        (sections(fit))
        (remarks(notes))
        @if !drawn.is_empty() {
            h2 { "What was drawn" }
            (figures(&drawn))
        }
        (table("Shots without an outcome", &["shot", "velocity [m/s]", "reason"], failed))
    };
    document(&format!("Shots: {title}"), &body, "shots.csv")
}

/// A histogram of every value that was drawn, and of the impact velocity.
fn histograms(rows: &[&ShotRow]) -> Vec<Figure> {
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
    let figure = |(values, column): (Vec<(f64, Option<bool>)>, String)| {
        Figure::new(&column, &column, "", Some(histogram(&column, &values)))
    };
    drawn.map(figure).collect()
}

/// Counts of a value: those that were stopped below, those that perforated on top.
fn histogram(name: &str, values: &[(f64, Option<bool>)]) -> Plot {
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
    let mut plot = Plot::new([low, low + width], [0.0, most as f64], [name, "shots"]);
    for (n, [stopped, passed]) in counts.iter().enumerate() {
        let sides = [n, n + 1].map(|n| low + width * n as f64 / bars as f64);
        for (from, to, class) in [(0, *stopped, STOPPED), (*stopped, stopped + passed, PERFORATED)] {
            let ends = [from, to].map(|count| count as f64);
            plot.bar(&format!("class=\"bar {class}\""), sides, ends, &format!("{} shots", to - from));
        }
    }
    plot.name("block k1", "perforated");
    plot.name("block k0", "not");
    plot
}
