//! `fit.svg`: chance of a perforation over velocity, with the shots and the intervals; beside it residual velocities.

use std::fmt::Write as _;

use super::Fit;
use crate::output::chart::{self, ChartAxis};
use crate::output::number::short;
use crate::study::residual_fit::{Passed, ResidualFit, ResidualModel, TooFew};

/// Size of a panel.
pub(in crate::study) const PANEL: [f64; 2] = [520.0, 340.0];
/// Points of a curve.
const POINTS: usize = 240;
/// Colours of Okabe and Ito, which colour-blind people tell apart: perforations, stops, curves.
pub(in crate::study) const PERFORATED: &str = "#d55e00";
pub(in crate::study) const STOPPED: &str = "#0072b2";
pub(in crate::study) const CURVE: &str = "#222";
const COMPUTED: &str = "#009e73";
/// Dashes of the second curve.
const DASHES: &str = "7 4";

/// The picture.
pub fn svg(fit: &Fit, title: &str) -> String {
    let panels = panels(fit);
    let (width, height) = (PANEL[0] * panels.len() as f64, PANEL[1] + 40.0);
    let mut out = chart::text(24.0, 26.0, "font-size=\"14\" font-weight=\"bold\"", title);
    for (n, (_, drawing)) in panels.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "<g transform=\"translate({} 40)\">\n{drawing}</g>", PANEL[0] * n as f64);
    }
    chart::svg([width, height], "", chart::STYLE, &out)
}

/// A panel with these ranges: its axes, and their drawing. `left`: room for the labels of the upright one.
pub(in crate::study) fn plane(left: f64, ranges: [[f64; 2]; 2], titles: [&str; 2]) -> (ChartAxis, ChartAxis, String) {
    let x = ChartAxis::linear(ranges[0], [left, PANEL[0] - 18.0]);
    let y = ChartAxis::linear(ranges[1], [PANEL[1] - 58.0, 22.0]);
    let drawing = chart::axes(&x, &y, titles);
    (x, y, drawing)
}

/// Words under the axes of a panel.
pub(in crate::study) fn below(x: &ChartAxis, words: &str) -> String {
    chart::text(x.paper[0], PANEL[1] - 8.0, "font-size=\"11\"", words)
}

/// What each panel shows, and what lies inside; nothing of shots without an outcome.
pub(in crate::study) fn panels(fit: &Fit) -> Vec<(&'static str, String)> {
    let mut panels = Vec::new();
    if !fit.outcomes.groups().is_empty() {
        panels.push(("chance of a perforation over impact velocity", chance(fit)));
    }
    if !fit.passed.is_empty() {
        panels.push(("residual over impact velocity", residual_panel(&fit.passed, &fit.residual)));
    }
    panels
}

/// Velocities shown: those of the shots and of the quantiles, and of intervals what lies near them.
fn velocities(fit: &Fit) -> [f64; 2] {
    let [low, high] = fit.outcomes.range();
    let reach = 0.6 * (high - low).max(1e-3 * high.abs()).max(1e-9);
    let computed = fit.computed.iter().flat_map(|found| [Some(found.v50), found.bounds.low, found.bounds.high]);
    let ends = fit.quantiles.iter().flat_map(|quantile| [quantile.value, quantile.bounds.low, quantile.bounds.high]);
    let near = ends.chain(computed).flatten().map(|velocity| velocity.clamp(low - reach, high + reach));
    let [low, high] = near.fold([low, high], |[low, high], velocity| [low.min(velocity), high.max(velocity)]);
    let room = 0.04 * (high - low).max(reach);
    [low - room, high + room]
}

pub(in crate::study) fn evenly([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=POINTS).map(move |n| low + (high - low) * n as f64 / POINTS as f64)
}

/// A dot for shots of one kind; larger where they are many.
pub(in crate::study) fn dot(at: [f64; 2], count: u64, colour: &str) -> String {
    let (radius, words) = (
        3.5 * (count as f64).powf(0.25),
        if count > 1 { format!("<title>{count} shots</title>") } else { String::new() },
    );
    format!(
        "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\" fill=\"{colour}\" fill-opacity=\"0.35\" stroke=\"{colour}\">{words}</circle>\n",
        at[0], at[1]
    )
}

fn chance(fit: &Fit) -> String {
    let range = velocities(fit);
    let titles = ["impact velocity [m/s]", "chance of a perforation"];
    let (x, y, mut out) = plane(64.0, [range, [0.0, 1.0]], titles);
    for quantile in &fit.quantiles {
        let ends = [quantile.bounds.low.unwrap_or(range[0]), quantile.bounds.high.unwrap_or(range[1])];
        let [from, to] = ends.map(|end| x.at(end.clamp(range[0], range[1])));
        let at = y.at(quantile.p);
        if quantile.value.is_some() {
            let style = format!("stroke=\"{CURVE}\" stroke-opacity=\"0.45\" stroke-width=\"3\"");
            let _ = writeln!(out, "<line x1=\"{from:.1}\" x2=\"{to:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\" {style}/>");
        }
    }
    if let Ok(found) = &fit.estimate {
        let points = evenly(range).map(|velocity| [velocity, found.probability(velocity)]);
        out += &chart::line(&x, &y, points, &format!("stroke=\"{CURVE}\" stroke-width=\"2\""));
    }
    if let Some(computed) = &fit.computed {
        let points = evenly(range).map(|velocity| [velocity, computed.probability(velocity)]);
        let style = format!("stroke=\"{COMPUTED}\" stroke-width=\"2\" stroke-dasharray=\"{DASHES}\"");
        out += &chart::line(&x, &y, points, &style);
    }
    for group in fit.outcomes.groups() {
        let at = |height: f64| [x.at(group.velocity), y.at(height)];
        if group.perforated > 0 {
            out += &dot(at(1.0), group.perforated, PERFORATED);
        }
        if group.stopped > 0 {
            out += &dot(at(0.0), group.stopped, STOPPED);
        }
    }
    let computed = if fit.computed.is_some() { "; dashed green: computed" } else { "" };
    let level = short(100.0 * fit.request.level, 3);
    let legend = format!("orange: perforated, blue: stopped; bars: {level} % intervals{computed}");
    out + &below(&x, &legend)
}

/// Residual over impact velocity, with the curves fitted to it.
pub(in crate::study) fn residual_panel(
    passed: &[Passed],
    curves: &[(ResidualModel, Result<ResidualFit, TooFew>)],
) -> String {
    let fits = || curves.iter().filter_map(|(_, found)| found.as_ref().ok());
    let fastest = passed.iter().map(|shot| shot.impact).fold(0.0, f64::max);
    let slowest = passed.iter().map(|shot| shot.impact).chain(fits().map(|found| found.limit)).fold(fastest, f64::min);
    let room = 0.05 * (fastest - slowest).max(1e-3 * fastest).max(1e-9);
    let range = [slowest - room, fastest + room];
    let highest =
        passed.iter().map(|shot| shot.residual).chain(fits().map(|found| found.residual(range[1]))).fold(0.0, f64::max);
    let titles = ["impact velocity [m/s]", "residual velocity [m/s]"];
    let (x, y, mut out) = plane(78.0, [range, chart::rounded_up([0.0, highest])], titles);
    for found in fits() {
        // The curve rises from the limit with an infinite slope: its points are dense there.
        let squared = evenly([0.0, 1.0]).map(|share| found.limit + (range[1] - found.limit) * share * share);
        let points = squared.filter(|impact| *impact >= range[0]).map(|impact| [impact, found.residual(impact)]);
        let dashes = if found.curve == ResidualModel::RechtIpson { "none" } else { DASHES };
        let style = format!("stroke=\"{CURVE}\" stroke-width=\"2\" stroke-dasharray=\"{dashes}\"");
        out += &chart::line(&x, &y, points, &style);
    }
    for shot in passed {
        out += &dot([x.at(shot.impact), y.at(shot.residual)], shot.count, PERFORATED);
    }
    out + &below(&x, "line: Recht-Ipson; dashed: Lambert-Jonas")
}
