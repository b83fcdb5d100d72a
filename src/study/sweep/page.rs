//! `sweep.html`: lines over the first factor, a heat map of two, the table.

use super::places::{Place, places};
use super::{PointResult, SweepRequest, SweepResult};
use crate::output::chart;
use crate::output::number::short;
use crate::study::fit::draw::{CURVE, PANEL, below, plane};
use crate::study::page::{document, figures, row, table};

/// Colours of Okabe and Ito for lines.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#222"];
/// Rows of the table on the page at most.
const MAX_ROWS: usize = 400;

/// The page. `title`: of the case.
pub fn html(request: &SweepRequest, results: &SweepResult, title: &str) -> String {
    let columns = request.columns();
    let response = columns.first().copied().unwrap_or_default();
    let places = places(request, &results.points);
    let names: Vec<&str> = request.factors.iter().map(super::factor::Factor::name).collect();
    let mut panels = Vec::new();
    if !places.is_empty() {
        panels.push((format!("{response} over {}", names[0]), lines(&names, &places, response)));
        if names.len() == 2 {
            panels
                .push((format!("{response} over {} and {}", names[0], names[1]), heat_map(&names, &places, response)));
        }
    }
    let mut body = figures(panels.iter().map(|(name, drawing)| (name.as_str(), drawing.clone())));
    body += &all(request, &results.points, columns);
    document(&format!("Sweep: {title}"), &body, "sweep.json")
}

fn span(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max));
    let room = (0.05 * (high - low)).max(1e-3 * high.abs()).max(1e-9);
    [low - room, high + room]
}

/// Room for the labels of the upright axis.
const LEFT: f64 = 84.0;

/// The response over the first factor, a line for each combination of the others.
fn lines(names: &[&str], places: &[Place], response: &str) -> String {
    let ends = places.iter().flat_map(|place| place.bounds.unwrap_or([place.response; 2]));
    let ranges = [span(places.iter().map(|place| place.values[0])), span(ends)];
    let (x, y, mut out) = plane(LEFT, ranges, [names[0], response]);
    let mut groups: Vec<(&[f64], Vec<&Place>)> = Vec::new();
    for place in places {
        let others = &place.values[1..];
        match groups.iter_mut().find(|(known, _)| *known == others) {
            Some((_, group)) => group.push(place),
            None => groups.push((others, vec![place])),
        }
    }
    let joined = groups.len() <= COLOURS.len();
    let mut legend = Vec::new();
    for (n, (others, group)) in groups.iter_mut().enumerate() {
        group.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
        let colour = if joined { COLOURS[n] } else { CURVE };
        if joined {
            let points = group.iter().map(|place| [place.values[0], place.response]);
            out += &chart::line(&x, &y, points, &format!("stroke=\"{colour}\" stroke-width=\"2\""));
        }
        for place in group.iter() {
            let at = x.at(place.values[0]);
            if let Some([low, high]) = place.bounds {
                let [low, high] = [low, high].map(|end| y.at(end));
                out += &format!(
                    "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{low:.1}\" y2=\"{high:.1}\" stroke=\"{colour}\"/>\n"
                );
            }
            out += &format!("<circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"/>\n", y.at(place.response));
        }
        if joined && !others.is_empty() {
            let values: Vec<String> = others.iter().map(|value| short(*value, 4)).collect();
            legend.push((colour, values.join(", ")));
        }
    }
    let others = names[1..].join(", ");
    out += &chart::text(4.0, PANEL[1] - 8.0, "font-size=\"11\"", &others);
    let begin = 16.0 + 7.0 * others.chars().count() as f64;
    let step = (PANEL[0] - begin) / legend.len().max(1) as f64;
    for (n, (colour, words)) in legend.iter().enumerate() {
        let at = begin + step.min(62.0) * n as f64;
        out += &chart::text(at, PANEL[1] - 8.0, &format!("font-size=\"11\" style=\"fill:{colour}\""), words);
    }
    out
}

/// The response over two factors in shades.
fn heat_map(names: &[&str], places: &[Place], response: &str) -> String {
    let values = |n: usize| {
        let mut values: Vec<f64> = places.iter().map(|place| place.values[n]).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (xs, ys) = (values(0), values(1));
    let whole = xs.len() * ys.len() <= 2 * places.len();
    let (x, y, mut out) = plane(LEFT, [cells(&xs), cells(&ys)], [names[0], names[1]]);
    let low = places.iter().map(|place| place.response).fold(f64::INFINITY, f64::min);
    let high = places.iter().map(|place| place.response).fold(f64::NEG_INFINITY, f64::max);
    for place in places {
        let part = if high > low { (place.response - low) / (high - low) } else { 0.5 };
        let colour = colorous::VIRIDIS.eval_continuous(part);
        let fill = format!("fill=\"#{colour:x}\"");
        let title = format!("<title>{}: {}</title>", chart::escape(response), short(place.response, 4));
        if whole {
            let sides = edges(&xs, place.values[0]).map(|at| x.at(at));
            let [bottom, top] = edges(&ys, place.values[1]).map(|at| y.at(at));
            out += &chart::area(sides, [top, bottom], &fill, &title);
        } else {
            let (at, height) = (x.at(place.values[0]), y.at(place.values[1]));
            out += &format!("<circle cx=\"{at:.1}\" cy=\"{height:.1}\" r=\"6\" {fill}>{title}</circle>\n");
        }
    }
    let words = format!("{response}: dark {}, light {}", short(low, 4), short(high, 4));
    out + &below(&x, &words)
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

fn all(request: &SweepRequest, results: &[PointResult], columns: &[&str]) -> String {
    let mut rows = String::new();
    for (n, (values, result)) in request.points.iter().zip(results).enumerate().take(MAX_ROWS) {
        let numbers = result.numbers.iter().map(|number| number.map_or_else(String::new, |number| short(number, 4)));
        let cells: Vec<String> = std::iter::once(n.to_string()).chain(values.iter().cloned()).chain(numbers).collect();
        rows += &row(&[cells, vec![result.reason.clone()]].concat());
    }
    let heads: Vec<&str> = std::iter::once("point")
        .chain(request.factors.iter().map(super::factor::Factor::name))
        .chain(columns.iter().copied())
        .chain(["reason"])
        .collect();
    let title = if results.len() > MAX_ROWS { "The first points; all are in sweep.csv" } else { "Points" };
    table(title, &heads, &rows)
}
