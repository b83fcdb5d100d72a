//! `diff.svg`: every common curve of all inputs, one over the other.
//!
//! Colours are those of Okabe and Ito, which colour-blind people tell apart; dashes tell the lines apart in grey.

use super::quantity::words;
use super::{Diff, letter};
use crate::output::chart::{self, ChartAxis, escape};

/// Size of a panel.
pub(super) const PANEL: [f64; 2] = [470.0, 270.0];
/// Panels beside each other.
const ACROSS: usize = 2;
/// Points of a line at most, and up to how many each is marked.
const POINTS: usize = 600;
const MARKED: usize = 60;
/// Letters of a name in the legend at most.
const NAME: usize = 110;

/// Colour and dashes of each input's lines.
const LINES: [(&str, &str); super::MAX_INPUTS] = [
    ("#0072b2", "none"),
    ("#d55e00", "8 4"),
    ("#009e73", "2 3"),
    ("#cc79a7", "10 3 2 3"),
    ("#e69f00", "5 2"),
    ("#56b4e9", "12 5"),
    ("#000000", "1 4"),
    ("#8c7000", "8 3 2 3 2 3"),
];

/// The picture.
pub fn svg(diff: &Diff) -> String {
    let panels = panels(diff);
    let head = 24.0 + 20.0 * diff.inputs.len() as f64;
    let (width, height) = (PANEL[0] * ACROSS as f64, head + PANEL[1] * panels.len().div_ceil(ACROSS).max(1) as f64);
    let mut out = String::new();
    for input in 0..diff.inputs.len() {
        let y = 26.0 + 20.0 * input as f64;
        out += &format!("<line x1=\"24\" x2=\"64\" y1=\"{y}\" y2=\"{y}\" {}/>\n", stroke(input));
        out += &chart::text(74.0, y + 4.0, "font-size=\"13\"", &name(diff, input));
    }
    for (n, (_, drawing)) in panels.iter().enumerate() {
        let (x, y) = (PANEL[0] * (n % ACROSS) as f64, head + PANEL[1] * (n / ACROSS) as f64);
        out += &format!("<g transform=\"translate({x} {y})\">\n{drawing}</g>\n");
    }
    chart::svg([width, height], "", chart::STYLE, &out)
}

/// Letter, place and title of an input, cut to one line.
pub(super) fn name(diff: &Diff, input: usize) -> String {
    let Some(found) = diff.inputs.get(input) else { return String::new() };
    let title = found.title().map_or_else(String::new, |title| format!(": {title}"));
    let text = format!("{}  {}{title}", letter(input), found.path.display());
    let cut: String = text.chars().take(NAME).collect();
    if cut.len() < text.len() { cut + "…" } else { text }
}

/// How an input's lines look.
pub(super) fn stroke(input: usize) -> String {
    let (colour, dashes) = LINES[input % LINES.len()];
    format!("stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dashes}\"")
}

/// A panel for each curve that is not zero throughout: its name, and what lies inside.
pub(super) fn panels(diff: &Diff) -> Vec<(String, String)> {
    diff.names().iter().filter_map(|name| Some(((*name).to_owned(), panel(diff, name)?))).collect()
}

/// The curves of a name.
fn panel(diff: &Diff, name: &str) -> Option<String> {
    let curve = |input: usize| {
        let table = &diff.inputs.get(input)?.table;
        table.column(name).map(|column| (input, table.points(column)))
    };
    let curves: Vec<(usize, Vec<[f64; 2]>)> = (0..diff.inputs.len()).filter_map(curve).collect();
    let all = |of: usize| curves.iter().flat_map(move |(_, points)| points.iter().map(move |point| point[of]));
    if all(1).all(|value| value == 0.0) {
        return None;
    }
    let range = |of: usize, from: [f64; 2]| [all(of).fold(from[0], f64::min), all(of).fold(from[1], f64::max)];
    let x = ChartAxis::linear(range(0, [f64::INFINITY, f64::NEG_INFINITY]), [78.0, PANEL[0] - 16.0]);
    let y = ChartAxis::linear(chart::rounded_up(range(1, [0.0, 0.0])), [PANEL[1] - 44.0, 24.0]);
    let mut out = chart::axes(&x, &y, ["time [µs]", &words(name)]);
    for (input, points) in &curves {
        out += &chart::line(&x, &y, chart::thinned(points, POINTS).into_iter(), &stroke(*input));
        if points.len() <= MARKED {
            for [px, py] in points {
                let (cx, cy, colour) = (x.at(*px), y.at(*py), LINES[input % LINES.len()].0);
                out += &format!("<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"2.5\" fill=\"{colour}\"/>\n");
            }
        }
    }
    Some(out)
}

/// One panel as a drawing of its own.
pub(super) fn alone(name: &str, drawing: &str) -> String {
    let ([width, height], name) = (PANEL, escape(&words(name)));
    format!("<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name} over time\">\n{drawing}</svg>\n")
}
