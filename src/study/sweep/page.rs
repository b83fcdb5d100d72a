//! `sweep.html`: lines over the first factor, a heat map of two, the table.

use maud::{Markup, html};

use super::places::{Place, places};
use super::{PointResult, SweepRequest, SweepResult};
use crate::output::number::short;
use crate::output::plot::{Figure, Plot};
use crate::study::page::{document, figures, table};

/// Lines at most; there is a colour for each.
const LINES: usize = 9;
/// Rows of the table on the page at most.
const MAX_ROWS: usize = 400;

/// The page. `title`: of the case.
pub fn html(request: &SweepRequest, results: &SweepResult, title: &str) -> String {
    let columns = request.columns();
    let response = columns.first().copied().unwrap_or_default();
    let places = places(request, &results.points);
    let names: Vec<&str> = request.factors.iter().map(super::factor::Factor::name).collect();
    let mut plots = Vec::new();
    if !places.is_empty() {
        plots.push(lines(&names, &places, response));
        plots.extend((names.len() == 2).then(|| heat_map(&names, &places, response)));
    }
    let body = html! {
        (figures(&plots))
        (all(request, &results.points, columns))
    };
    document(&format!("Sweep: {title}"), &body, "sweep.json")
}

fn span(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
    let room = (0.05 * (high - low)).max(1e-3 * high.abs()).max(1e-9);
    [low - room, high + room]
}

/// The response over the first factor, a line for each combination of the others.
fn lines(names: &[&str], places: &[Place], response: &str) -> Figure {
    let ends = places.iter().flat_map(|place| place.bounds.unwrap_or([place.response; 2]));
    let mut plot = Plot::new(span(places.iter().map(|place| place.values[0])), span(ends), [names[0], response]);
    let mut groups: Vec<(&[f64], Vec<&Place>)> = Vec::new();
    for place in places {
        let others = &place.values[1..];
        match groups.iter_mut().find(|(known, _)| *known == others) {
            Some((_, group)) => group.push(place),
            None => groups.push((others, vec![place])),
        }
    }
    let joined = groups.len() <= LINES;
    for (n, (others, group)) in groups.iter_mut().enumerate() {
        group.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
        let class = if joined { format!("k{n}") } else { "ink".to_owned() };
        let values = others.iter().map(|value| short(*value, 4)).collect::<Vec<_>>().join(", ");
        if joined {
            let points: Vec<[f64; 2]> = group.iter().map(|place| [place.values[0], place.response]).collect();
            plot.line(&class, &values, &points);
        }
        for place in group.iter() {
            if let Some(bounds) = place.bounds {
                plot.line(&format!("{class} interval"), "", &bounds.map(|end| [place.values[0], end]));
            }
            plot.dot(&class, [place.values[0], place.response], 3.0, &short(place.response, 4));
        }
    }
    let caption = if names.len() > 1 { format!("Lines: {}.", names[1..].join(", ")) } else { String::new() };
    Figure::new("lines", &format!("{response} over {}", names[0]), caption, Some(plot))
}

/// The response over two factors in shades.
fn heat_map(names: &[&str], places: &[Place], response: &str) -> Figure {
    let values = |n: usize| {
        let mut values: Vec<f64> = places.iter().map(|place| place.values[n]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (xs, ys) = (values(0), values(1));
    let mut plot = Plot::new(cells(&xs), cells(&ys), [names[0], names[1]]);
    let low = places.iter().map(|place| place.response).fold(f64::INFINITY, f64::min);
    let high = places.iter().map(|place| place.response).fold(f64::NEG_INFINITY, f64::max);
    for place in places {
        let part = if high > low { (place.response - low) / (high - low) } else { 0.5 };
        let fill = format!("fill=\"#{:x}\"", colorous::VIRIDIS.eval_continuous(part));
        let words = format!("{response}: {}", short(place.response, 4));
        plot.bar(&fill, edges(&xs, place.values[0]), edges(&ys, place.values[1]), &words);
    }
    let caption = format!("Dark {}, light {}.", short(low, 4), short(high, 4));
    Figure::new("map", &format!("{response} over {} and {}", names[0], names[1]), caption, Some(plot))
}

/// Half way to the neighbours on both sides.
fn edges(values: &[f64], value: f64) -> [f64; 2] {
    let at = values.iter().position(|other| *other == value).unwrap_or(0);
    let gap = |n: usize| 0.5 * (values[n + 1] - values[n]);
    let alone = 0.5 * value.abs().max(1.0);
    let below = if at > 0 {
        gap(at - 1)
    } else if values.len() > 1 {
        gap(0)
    } else {
        alone
    };
    let above = if at + 1 < values.len() { gap(at) } else { below };
    [value - below, value + above]
}

fn cells(values: &[f64]) -> [f64; 2] {
    match (values.first(), values.last()) {
        (Some(first), Some(last)) => [edges(values, *first)[0], edges(values, *last)[1]],
        _ => [0.0, 1.0],
    }
}

fn all(request: &SweepRequest, results: &[PointResult], columns: &[&str]) -> Markup {
    let row = |(n, (values, result)): (usize, (&Vec<String>, &PointResult))| {
        let numbers = result.numbers.iter().map(|number| number.map_or_else(String::new, |number| short(number, 4)));
        let cells = std::iter::once(n.to_string()).chain(values.iter().cloned()).chain(numbers);
        cells.chain([result.reason.clone()]).collect()
    };
    let names = request.factors.iter().map(super::factor::Factor::name);
    let heads: Vec<&str> =
        ["point"].into_iter().chain(names).chain(columns.iter().copied()).chain(["reason"]).collect();
    let title = if results.len() > MAX_ROWS { "The first points; all are in sweep.csv" } else { "Points" };
    table(title, &heads, request.points.iter().zip(results).enumerate().take(MAX_ROWS).map(row))
}
