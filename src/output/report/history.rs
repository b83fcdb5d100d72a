//! Figures over time: velocity, force, energy, failed yarns.

use super::super::chart::{self, Axis};
use super::super::number::short;
use super::figure::{self, Figure, Numbers};
use crate::simulation::{Run, Sample};

/// Points of a line, and columns of an area, at most.
const POINTS: usize = 600;
const COLUMNS: usize = 240;

/// A curve: what it is, and how to read it from a row of the history.
type Curve = (&'static str, fn(&Sample) -> f64);

/// Largest end of the time axis [µs].
fn end(run: &Run) -> f64 {
    run.history.last().map_or(1.0, |row| row.time * 1e6).max(1e-6)
}

/// Lines over time. `rows`: those of the history that count; `least`: the upper end of the axis at least.
fn over_time(rows: &[Sample], end: f64, least: f64, unit: &str, curves: &[Curve]) -> (Axis, String, Numbers) {
    let values = || rows.iter().flat_map(|row| curves.iter().map(move |(_, of)| of(row))).filter(|v| v.is_finite());
    let range = [values().fold(0.0, f64::min), values().fold(least, f64::max)];
    let [x, y] = figure::axes([0.0, end], range);
    let mut drawing = chart::axes(&x, &y, ["time [µs]", unit]);
    for (n, (_, of)) in curves.iter().enumerate() {
        let points: Vec<[f64; 2]> = rows.iter().map(|row| [row.time * 1e6, of(row)]).collect();
        let class = format!("class=\"curve k{n}\"");
        drawing += &chart::line(&x, &y, chart::thinned(&points, POINTS).into_iter(), &class);
    }
    (x, drawing, numbers(rows, unit, curves))
}

fn numbers(rows: &[Sample], unit: &str, curves: &[Curve]) -> Numbers {
    let unit = unit.rsplit_once('[').map_or(String::new(), |(_, unit)| format!(" [{unit}"));
    let heads = curves.iter().map(|(name, _)| format!("{name}{unit}"));
    let row = |row: &Sample| {
        let values = curves.iter().map(|(_, of)| short(of(row), 4));
        std::iter::once(short(row.time * 1e6, 4)).chain(values).collect()
    };
    Numbers {
        heads: std::iter::once("time [µs]".to_owned()).chain(heads).collect(),
        rows: rows.iter().map(row).collect(),
        file: "history.csv",
    }
}

/// Projectile velocity.
pub(super) fn velocity(run: &Run) -> Figure {
    let of = |row: &Sample| row.projectile_velocity;
    let (x, drawing, numbers) = over_time(&run.history, end(run), 0.0, "velocity [m/s]", &[("velocity", of)]);
    let [first, last] = [run.history.first(), run.history.last()].map(|row| row.map_or(0.0, of));
    Figure {
        id: "velocity",
        title: "Projectile velocity".to_owned(),
        caption: format!("From {} to {} m/s along the line of flight.", short(first, 4), short(last, 3))
            .replace('-', "−"),
        drawing,
        time: Some(x),
        numbers,
        ..Figure::default()
    }
}

/// Contact force.
pub(super) fn force(run: &Run) -> Figure {
    // The first row's force is an impulse over one step, not a mean.
    let rows = run.history.get(1..).unwrap_or_default();
    let of = |row: &Sample| row.contact_force;
    let (x, drawing, numbers) = over_time(rows, end(run), 0.0, "force [N]", &[("force", of)]);
    let peak = rows.iter().max_by(|a, b| a.contact_force.total_cmp(&b.contact_force));
    let caption = peak.map_or(String::new(), |row| {
        let (force, time) = (short(row.contact_force, 3), short(row.time * 1e6, 3));
        format!("Of the fabric on the projectile, mean between rows of the history; at most {force} N, at {time} µs.")
    });
    Figure {
        id: "force",
        title: "Contact force".to_owned(),
        caption,
        drawing,
        time: Some(x),
        numbers,
        ..Figure::default()
    }
}

/// Failed yarns.
pub(super) fn failures(run: &Run) -> Figure {
    let curves: [Curve; 2] = [("warp", |row| row.failed[0] as f64), ("weft", |row| row.failed[1] as f64)];
    let (x, drawing, numbers) = over_time(&run.history, end(run), 5.0, "failures [-]", &curves);
    let [warp, weft] = run.history.last().map_or([0, 0], |row| row.failed);
    let first = run.events.first().map(|event| short(event.step as f64 * run.time_step * 1e6, 3));
    let first = first.map_or("No yarn failed.".to_owned(), |time| {
        format!("Elements in which the yarn broke: {warp} of the warp, {weft} of the weft; the first at {time} µs.")
    });
    Figure {
        id: "failures",
        title: "Failed yarns".to_owned(),
        caption: first,
        drawing,
        legend: legend(&curves, "line"),
        time: Some(x),
        numbers,
    }
}

fn legend(curves: &[Curve], kind: &str) -> Vec<(String, String)> {
    curves.iter().enumerate().map(|(n, (name, _))| (format!("{kind} k{n}"), (*name).to_owned())).collect()
}

/// Every energy, one on the other: together they are what was there.
pub(super) fn energy(run: &Run) -> Figure {
    let curves: [Curve; 8] = [
        ("projectile", |row| row.balance.projectile),
        ("fabric, kinetic", |row| row.balance.kinetic),
        ("fabric, internal", |row| row.balance.internal),
        ("yarn failure", |row| row.balance.failure),
        ("friction", |row| row.balance.friction),
        ("contact", |row| row.balance.contact),
        ("hourglass", |row| row.balance.hourglass),
        ("shock viscosity", |row| row.balance.viscous),
    ];
    let step = run.history.len().div_ceil(COLUMNS).max(1);
    let last = run.history.len().saturating_sub(1);
    let kept = run.history.iter().enumerate().filter(|(n, _)| n.is_multiple_of(step) || *n == last);
    let rows: Vec<&Sample> =
        kept.map(|(_, row)| row).filter(|row| curves.iter().all(|c| c.1(row).is_finite())).collect();
    // Below zero lies rounding, or what a law that is not conservative owes.
    let level = |row: &Sample, count: usize| curves[..count].iter().map(|(_, of)| of(row).max(0.0)).sum::<f64>();
    let top = rows.iter().map(|row| level(row, curves.len())).fold(0.0, f64::max);
    let (factor, unit) = if top < 0.1 { (1e3, "mJ") } else { (1.0, "J") };
    let [x, y] = figure::axes([0.0, end(run)], [0.0, factor * top]);
    let mut drawing = String::new();
    for n in 0..curves.len() {
        let over = rows.iter().map(|row| [row.time * 1e6, factor * level(row, n + 1)]);
        let under = rows.iter().rev().map(|row| [row.time * 1e6, factor * level(row, n)]);
        let places = chart::places(&x, &y, over.chain(under));
        drawing += &format!("<polygon class=\"area k{n}\" points=\"{places}\"/>\n");
    }
    let unit = format!("energy [{unit}]");
    drawing += &chart::axes(&x, &y, ["time [µs]", &unit]);
    Figure {
        id: "energy",
        title: "Where the energy is".to_owned(),
        caption: "One on the other; that the upper edge stays level means that no energy is made or lost.".to_owned(),
        drawing,
        legend: legend(&curves, "block"),
        time: Some(x),
        numbers: numbers(&run.history, "energy [J]", &curves),
    }
}
