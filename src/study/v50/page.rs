//! `v50.html`: the answer, the curve of V0 to V100 with the thresholds, residual velocities, tables.

use maud::{Markup, html};

use super::report::{ARITHMETIC_OF, notes};
use super::{V50Request, V50Result};
use crate::case::Case;
use crate::output::number::short;
use crate::output::plot::{Figure, Plot};
use crate::study::fit::draw::{STOPPED, evenly, residual_figure, shots};
use crate::study::page::{arithmetic_table, document, figures, quantile_row, remarks, residual_table, table};

/// The page.
pub fn html(case: &Case, request: &V50Request, seed: u32, result: &V50Result) -> String {
    let plots: Vec<Figure> =
        chance(result).into_iter().chain(residual_figure(&result.passed, &result.residual)).collect();
    let body = html! {
        p class="answer" { (answer(request, result)) }
        p { (parts(result)) }
        (remarks(&notes(case, result)))
        (figures(&plots))
        (quantiles(result))
        (arithmetic_table(&format!("Arithmetic V50 of {ARITHMETIC_OF}"), &result.arithmetic))
        (residual_table("Residual velocity: Vr = a (Vs^p − V0^p)^(1/p)", "limit [m/s]", &result.residual))
        (bands(result))
        (thresholds(result))
        p class="note" { "Seed " (seed) "." }
    };
    document(&format!("V50: {}", case.title), &body, "v50.json and v50.csv")
}

fn answer(request: &V50Request, result: &V50Result) -> String {
    let Some(v50) = result.v50 else { return format!("{} shots give no V50.", result.shots) };
    let [low, high] = result.bounds.words();
    let sigma = result.sigma.map_or_else(String::new, |sigma| format!("; σ {} m/s", short(sigma, 3)));
    let level = short(100.0 * request.level, 3);
    format!("V50 {} m/s, {level} % interval {low} to {high} m/s{sigma}.", short(v50, 4))
}

/// Parts of the interval.
fn parts(result: &V50Result) -> String {
    let metres = |width: f64| format!("± {} m/s", short(width, 2));
    let sampling = result.width.sampling.map_or_else(|| "no end".to_owned(), metres);
    format!(
        "Of its width, sampling: {sampling}; mesh and time step: {}; brackets: {}.",
        metres(result.width.numerical),
        metres(result.width.bracket)
    )
}

/// Thresholds as a staircase of their distribution, and the curve fitted to them; none without thresholds.
fn chance(result: &V50Result) -> Option<Figure> {
    let mut middles = result.middles();
    middles.sort_by(f64::total_cmp);
    let ends = [result.bounds.low, result.bounds.high].into_iter().flatten();
    let all = || middles.iter().copied().chain(ends.clone());
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    let room = (0.15 * (high - low)).max(2e-3 * high.abs()).max(1e-9);
    let range = [low - room, high + room];
    let mut plot = Plot::new(range, [0.0, 1.0], ["impact velocity [m/s]", "chance of a perforation"]);
    if let (Some(low), Some(high)) = (result.bounds.low, result.bounds.high) {
        let sides = [low.max(range[0]), high.min(range[1])];
        plot.bar("class=\"bar ink\" fill-opacity=\"0.08\"", sides, [0.0, 1.0], "interval of V50");
    }
    let points = evenly(range).filter_map(|velocity| Some([velocity, result.probability(velocity)?]));
    plot.line("ink", "normal", &points.collect::<Vec<_>>());
    for (rank, threshold) in middles.iter().enumerate() {
        shots(&mut plot, STOPPED, [*threshold, (rank as f64 + 0.5) / middles.len() as f64], 1);
    }
    plot.name("dot k0", "thresholds of realisations");
    let figure = Figure::new("chance", "Chance of a perforation", "Band: interval of V50.", Some(plot));
    (!middles.is_empty()).then_some(figure)
}

fn quantiles(result: &V50Result) -> Markup {
    let range = result.sample.filter(|sample| sample.count > 1).map(|sample| sample.range);
    let seen = |name: &str, end: usize| {
        range.map(|range| vec![name.to_owned(), short(range[end], 5), String::new(), String::new()])
    };
    let fitted = result.quantiles.iter().map(|of| quantile_row(format!("V{}", short(100.0 * of.p, 3)), of));
    let slowest = seen("V0: slowest threshold seen", 0).into_iter();
    let rows = slowest.chain(fitted).chain(seen("V100: fastest threshold seen", 1));
    let heads = ["", "velocity [m/s]", "low [m/s]", "high [m/s]"];
    table("Velocities by chance; intervals of the sampling alone", &heads, rows)
}

fn bands(result: &V50Result) -> Markup {
    let row = |band: &super::ResidualBand| {
        let [from, to] = band.impact.map(|velocity| short(velocity, 4));
        let [least, largest] = band.range.map(|velocity| short(velocity, 4));
        vec![format!("{from} to {to}"), band.count.to_string(), short(band.mean, 4), least, largest]
    };
    let heads = ["impact velocity [m/s]", "perforations", "mean residual [m/s]", "least [m/s]", "largest [m/s]"];
    table("Residual velocities by impact velocity", &heads, result.bands.iter().map(row))
}

fn thresholds(result: &V50Result) -> Markup {
    let row = |(number, found): (usize, &Result<[f64; 2], String>)| {
        let mark = if result.non_monotone.contains(&number) { "not monotone" } else { "" };
        match found {
            Ok([low, high]) => vec![number.to_string(), short(*low, 6), short(*high, 6), mark.to_owned()],
            Err(reason) => vec![number.to_string(), String::new(), String::new(), reason.clone()],
        }
    };
    let heads = ["realisation", "highest stop [m/s]", "lowest perforation [m/s]", ""];
    table("Thresholds", &heads, result.thresholds.iter().enumerate().map(row))
}
