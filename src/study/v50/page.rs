//! `v50.html`: the answer, the curve of V0 to V100 with the thresholds, residual velocities, tables.

use super::report::{ARITHMETIC_OF, notes};
use super::{V50Request, V50Result};
use crate::case::Case;
use crate::output::chart::{self, escape};
use crate::output::number::short;
use crate::study::fit::draw::{CURVE, STOPPED, below, dot, evenly, plane, residual_panel};
use crate::study::page::{
    arithmetic_table, document, figures, filled_table, quantile_row, remarks, residual_table, row, table,
};

/// The page.
pub fn html(case: &Case, request: &V50Request, seed: u32, result: &V50Result) -> String {
    let mut body = format!("<p class=\"answer\">{}</p>\n", escape(&answer(request, result)));
    body += &format!("<p>{}</p>\n", escape(&parts(result)));
    body += &remarks(&notes(case, result));
    let mut panels = Vec::new();
    if !sorted(result).is_empty() {
        panels.push(("chance of a perforation over impact velocity", chance(result)));
    }
    if !result.passed.is_empty() {
        panels.push(("residual over impact velocity", residual_panel(&result.passed, &result.residual)));
    }
    body += &figures(panels);
    body += &quantiles(result);
    body += &arithmetic_table(&format!("Arithmetic V50 of {}", ARITHMETIC_OF), &result.arithmetic);
    body += &residual_table("Residual velocity: Vr = a (Vs^p − V0^p)^(1/p)", "limit [m/s]", &result.residual);
    body += &bands(result);
    body += &thresholds(result);
    body += &format!("<p class=\"note\">Seed {seed}.</p>\n");
    document(&format!("V50: {}", case.title), &body, "v50.json and v50.csv")
}

fn answer(request: &V50Request, result: &V50Result) -> String {
    let Some(v50) = result.v50 else { return format!("{} shots give no V50.", result.shots) };
    let [low, high] = result.bounds.words();
    let sigma = result.sigma.map_or_else(String::new, |sigma| format!("; σ {} m/s", short(sigma, 3)));
    let level = short(100.0 * request.level, 3);
    format!("V50 {} m/s, {level} % interval {low} to {high} m/s{sigma}.", short(v50, 4))
}

/// What the interval is made of.
fn parts(result: &V50Result) -> String {
    let metres = |width: f64| format!("± {} m/s", short(width, 2));
    let sampling = result.width.sampling.map_or_else(|| "no end".to_owned(), metres);
    format!(
        "Of its width, sampling: {sampling}; mesh and time step: {}; brackets: {}.",
        metres(result.width.numerical),
        metres(result.width.bracket)
    )
}

/// Thresholds as a staircase of their distribution, and the curve fitted to them.
fn chance(result: &V50Result) -> String {
    let middles: Vec<f64> = sorted(result);
    let ends = [result.bounds.low, result.bounds.high].into_iter().flatten();
    let all = || middles.iter().copied().chain(ends.clone());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let room = (0.15 * (high - low)).max(2e-3 * high.abs()).max(1e-9);
    let range = [low - room, high + room];
    let titles = ["impact velocity [m/s]", "chance of a perforation"];
    let (x, y, mut out) = plane(64.0, [range, [0.0, 1.0]], titles);
    if let (Some(low), Some(high)) = (result.bounds.low, result.bounds.high) {
        let sides = [x.at(low.max(range[0])), x.at(high.min(range[1]))];
        let style = format!("fill=\"{CURVE}\" fill-opacity=\"0.08\"");
        out += &chart::area(sides, [y.paper[1], y.paper[0]], &style, "");
    }
    let points = evenly(range).filter_map(|velocity| Some([velocity, result.probability(velocity)?]));
    out += &chart::line(&x, &y, points, &format!("stroke=\"{CURVE}\" stroke-width=\"2\""));
    let n = middles.len() as f64;
    for (rank, threshold) in middles.iter().enumerate() {
        out += &dot([x.at(*threshold), y.at((rank as f64 + 0.5) / n)], 1, STOPPED);
    }
    let legend = "dots: thresholds of realisations; line: normal; band: interval of V50";
    out + &below(&x, legend)
}

/// Thresholds, ascending.
fn sorted(result: &V50Result) -> Vec<f64> {
    let mut middles = result.middles();
    middles.sort_by(f64::total_cmp);
    middles
}

fn quantiles(result: &V50Result) -> String {
    let range = result.sample.filter(|sample| sample.count > 1).map(|sample| sample.range);
    let seen = |name: &str, end: usize| {
        let cells = range.map(|range| [name.to_owned(), short(range[end], 5), String::new(), String::new()]);
        cells.map_or_else(String::new, |cells| row(&cells))
    };
    let mut rows = seen("V0: slowest threshold seen", 0);
    rows.extend(result.quantiles.iter().map(|of| quantile_row(format!("V{}", short(100.0 * of.p, 3)), of)));
    rows += &seen("V100: fastest threshold seen", 1);
    let heads = ["", "velocity [m/s]", "low [m/s]", "high [m/s]"];
    table("Velocities by chance; intervals of the sampling alone", &heads, &rows)
}

fn bands(result: &V50Result) -> String {
    let one = |band: &super::ResidualBand| {
        let [from, to] = band.impact.map(|velocity| short(velocity, 4));
        let [least, largest] = band.range.map(|velocity| short(velocity, 4));
        row(&[format!("{from} to {to}"), band.count.to_string(), short(band.mean, 4), least, largest])
    };
    let rows: String = result.bands.iter().map(one).collect();
    let heads = ["impact velocity [m/s]", "perforations", "mean residual [m/s]", "least [m/s]", "largest [m/s]"];
    filled_table("Residual velocities by impact velocity", &heads, &rows)
}

fn thresholds(result: &V50Result) -> String {
    let one = |(number, found): (usize, &Result<[f64; 2], String>)| {
        let mark = if result.non_monotone.contains(&number) { "not monotone" } else { "" };
        match found {
            Ok([low, high]) => row(&[number.to_string(), short(*low, 6), short(*high, 6), mark.to_owned()]),
            Err(reason) => row(&[number.to_string(), String::new(), String::new(), reason.clone()]),
        }
    };
    let rows: String = result.thresholds.iter().enumerate().map(one).collect();
    filled_table("Thresholds", &["realisation", "highest stop [m/s]", "lowest perforation [m/s]", ""], &rows)
}
