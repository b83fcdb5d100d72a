//! Figures of a fit: chance of a perforation over velocity, with the shots and the intervals; residual velocities.

use super::Fit;
use crate::output::number::short;
use crate::output::plot::{self, Figure, Plot};
use crate::study::residual_fit::{Passed, ResidualFit, ResidualModel, TooFew};

/// Points of a curve.
const POINTS: usize = 240;
/// Classes of what perforated, and of what was stopped.
pub(in crate::study) const PERFORATED: &str = "k1";
pub(in crate::study) const STOPPED: &str = "k0";

/// `fit.svg`.
pub fn svg(fit: &Fit, title: &str) -> String {
    let plots: Vec<Plot> = plots(fit).into_iter().filter_map(|figure| figure.plot).collect();
    plot::file(title, "", &plots)
}

/// The figures; none of shots without an outcome.
pub(in crate::study) fn plots(fit: &Fit) -> Vec<Figure> {
    let mut figures = Vec::new();
    if !fit.outcomes.groups().is_empty() {
        let level = short(100.0 * fit.request.level, 3);
        let caption = format!("Bars: {level} % intervals.");
        figures.push(Figure::new("chance", "Chance of a perforation", caption, Some(chance(fit))));
    }
    figures.extend(residual_figure(&fit.passed, &fit.residual));
    figures
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

/// Values that lie evenly in a range.
pub(in crate::study) fn evenly([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..=POINTS).map(move |n| low + (high - low) * n as f64 / POINTS as f64)
}

/// Adds a dot for shots of one kind; larger where they are many.
pub(in crate::study) fn shots(plot: &mut Plot, class: &str, at: [f64; 2], count: u64) {
    let words = if count == 1 { "1 shot".to_owned() } else { format!("{count} shots") };
    plot.dot(class, at, 3.5 * (count as f64).powf(0.25), &words);
}

fn chance(fit: &Fit) -> Plot {
    let range = velocities(fit);
    let mut plot = Plot::new(range, [0.0, 1.0], ["impact velocity [m/s]", "chance of a perforation"]);
    for quantile in fit.quantiles.iter().filter(|quantile| quantile.value.is_some()) {
        let ends = [quantile.bounds.low.unwrap_or(range[0]), quantile.bounds.high.unwrap_or(range[1])];
        plot.line("ink interval", "", &ends.map(|end| [end.clamp(range[0], range[1]), quantile.p]));
    }
    if let Ok(found) = &fit.estimate {
        let points: Vec<[f64; 2]> = evenly(range).map(|velocity| [velocity, found.probability(velocity)]).collect();
        plot.line("ink", fit.request.link.word(), &points);
    }
    if let Some(computed) = &fit.computed {
        let points: Vec<[f64; 2]> = evenly(range).map(|velocity| [velocity, computed.probability(velocity)]).collect();
        plot.line("k2 dashed", "computed", &points);
    }
    for group in fit.outcomes.groups() {
        for (count, height, class) in [(group.perforated, 1.0, PERFORATED), (group.stopped, 0.0, STOPPED)] {
            if count > 0 {
                shots(&mut plot, class, [group.velocity, height], count);
            }
        }
    }
    plot.name("dot k1", "perforated");
    plot.name("dot k0", "stopped");
    plot
}

/// Residual over impact velocity, with the curves fitted to it; none where nothing passed.
pub(in crate::study) fn residual_figure(
    passed: &[Passed],
    curves: &[(ResidualModel, Result<ResidualFit, TooFew>)],
) -> Option<Figure> {
    let fits = || curves.iter().filter_map(|(_, found)| found.as_ref().ok());
    let fastest = passed.iter().map(|shot| shot.impact).reduce(f64::max)?;
    let slowest = passed.iter().map(|shot| shot.impact).chain(fits().map(|found| found.limit)).fold(fastest, f64::min);
    let room = 0.05 * (fastest - slowest).max(1e-3 * fastest).max(1e-9);
    let range = [slowest - room, fastest + room];
    let highest =
        passed.iter().map(|shot| shot.residual).chain(fits().map(|found| found.residual(range[1]))).fold(0.0, f64::max);
    let mut plot = Plot::new(range, [0.0, highest], ["impact velocity [m/s]", "residual velocity [m/s]"]);
    for found in fits() {
        // The curve rises from the limit with an infinite slope: its points are dense there.
        let squared = evenly([0.0, 1.0]).map(|share| found.limit + (range[1] - found.limit) * share * share);
        let points = squared.filter(|impact| *impact >= range[0]).map(|impact| [impact, found.residual(impact)]);
        let class = if found.curve == ResidualModel::RechtIpson { "ink" } else { "ink dashed" };
        plot.line(class, found.curve.words(), &points.collect::<Vec<_>>());
    }
    for shot in passed {
        shots(&mut plot, PERFORATED, [shot.impact, shot.residual], shot.count);
    }
    Some(Figure::new("residual", "Residual velocity", "Of the shots that perforated.", Some(plot)))
}
