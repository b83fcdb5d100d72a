//! Figures over time: velocity, force, energy, energy of the plies, failed yarns.

use std::collections::BTreeMap;

use super::super::breakage::Breakage;
use super::super::chart;
use super::super::number::short;
use super::animation;
use super::figure::{self, Figure, FigureNumbers};
use crate::case::Case;
use crate::run::{PlySample, Run, Sample};

/// Columns of an area at most.
const COLUMNS: usize = 240;
/// Energy below zero that is drawn, over the largest [-].
const LEAST: f64 = 1e-3;

/// A curve: what it is, and how to read it from a row of the history.
type HistoryCurve = (&'static str, fn(&Sample) -> f64);

/// Largest end of the time axis [µs].
fn end(run: &Run) -> f64 {
    run.history.last().map_or(1.0, |row| row.time * 1e6).max(1e-6)
}

/// A figure of lines over time, without its words. `rows`: those of the history that count; `least`: the upper end of the axis at least.
fn over_time(rows: &[Sample], end: f64, least: f64, unit: &str, curves: &[HistoryCurve]) -> Figure {
    let values = || rows.iter().flat_map(|row| curves.iter().map(move |(_, of)| of(row))).filter(|v| v.is_finite());
    let range = [values().fold(0.0, f64::min), values().fold(least, f64::max)];
    let axes = figure::axes([0.0, end], range);
    let points = |of: fn(&Sample) -> f64| rows.iter().map(|row| [row.time * 1e6, of(row)]).collect();
    let lines = curves.iter().map(|(name, of)| ((*name).to_owned(), points(*of)));
    let (drawing, legend) = figure::lines(axes, ["time [µs]", unit], lines);
    let legend = if curves.len() > 1 { legend } else { Vec::new() };
    Figure {
        drawing,
        legend,
        axes: Some(axes),
        over_time: true,
        numbers: numbers(rows, unit, curves),
        ..Figure::default()
    }
}

fn numbers(rows: &[Sample], unit: &str, curves: &[HistoryCurve]) -> FigureNumbers {
    let unit = unit.rsplit_once('[').map_or(String::new(), |(_, unit)| format!(" [{unit}"));
    let heads = curves.iter().map(|(name, _)| format!("{name}{unit}"));
    let row = |row: &Sample| {
        let values = curves.iter().map(|(_, of)| short(of(row), 4));
        std::iter::once(short(row.time * 1e6, 4)).chain(values).collect()
    };
    FigureNumbers::over_time(heads, rows.iter().map(row).collect(), "history.csv")
}

/// Projectile velocity.
pub(super) fn velocity(run: &Run) -> Figure {
    let of = |row: &Sample| row.projectile_velocity;
    let [first, last] = [run.history.first(), run.history.last()].map(|row| row.map_or(0.0, of));
    let caption = format!("From {} to {} m/s along the line of flight.", short(first, 4), short(last, 3));
    Figure {
        id: "velocity",
        title: "Projectile velocity".to_owned(),
        caption: caption.replace('-', "−"),
        ..over_time(&run.history, end(run), 0.0, "velocity [m/s]", &[("velocity", of)])
    }
}

/// Contact force.
pub(super) fn force(run: &Run) -> Figure {
    // The first row's force is an impulse over one step, not a mean.
    let rows = run.history.get(1..).unwrap_or_default();
    let of = |row: &Sample| row.contact_force;
    if rows.iter().all(|row| row.contact_force == 0.0) {
        return nothing("force", "Contact force", "none after the first step.");
    }
    let peak = rows.iter().max_by(|a, b| a.contact_force.total_cmp(&b.contact_force));
    let caption = peak.map_or(String::new(), |row| {
        let (force, time) = (short(row.contact_force, 3), short(row.time * 1e6, 3));
        format!("Of the fabric on the projectile, mean between rows of the history; at most {force} N, at {time} µs.")
    });
    Figure {
        id: "force",
        title: "Contact force".to_owned(),
        caption,
        ..over_time(rows, end(run), 0.0, "force [N]", &[("force", of)])
    }
}

/// A figure that has nothing to show.
fn nothing(id: &'static str, title: &str, caption: &str) -> Figure {
    Figure { id, title: title.to_owned(), caption: caption.to_owned(), ..Figure::default() }
}

/// Failed yarns.
pub(super) fn failures(case: &Case, run: &Run) -> Figure {
    let Some(first) = run.events.first() else { return nothing("failures", "Failed yarns", "none.") };
    let curves: [HistoryCurve; 2] = [("warp", |row| row.failed[0] as f64), ("weft", |row| row.failed[1] as f64)];
    let broken = Breakage::of(case, run);
    let [warp, weft] = broken.yarns;
    let time = short(first.step as f64 * run.time_step * 1e6, 3);
    Figure {
        id: "failures",
        title: "Failed yarns".to_owned(),
        caption: format!(
            "{warp} yarns of the warp and {weft} of the weft broke, in {} places, which are counted here; the first at {time} µs.",
            broken.pieces()
        ),
        ..over_time(&run.history, end(run), 5.0, "failures [-]", &curves)
    }
}

/// Kinetic and elastic energy of the plies of a pack, of a thick one those that the playback shows.
pub(super) fn plies(run: &Run) -> Option<Figure> {
    let shown = animation::shown(run.plies);
    if shown.len() < 2 || run.ply_history.is_empty() {
        return None;
    }
    let energy = |row: &PlySample| row.moment.kinetic + row.moment.stored;
    let finite = || run.ply_history.iter().filter(|row| energy(row).is_finite());
    let top = finite().map(energy).fold(0.0, f64::max);
    let (factor, unit) = unit(top);
    let lowest = finite().map(energy).fold(0.0, f64::min);
    let axes = figure::axes([0.0, end(run)], [factor * lowest, factor * top]);
    let points = |ply: usize| {
        let rows = finite().filter(move |row| row.ply == ply);
        rows.map(|row| [row.time * 1e6, factor * energy(row)]).collect()
    };
    let lines = shown.iter().map(|ply| (format!("ply {}", ply + 1), points(*ply)));
    let (drawing, legend) = figure::lines(axes, ["time [µs]", &format!("energy [{unit}]")], lines);
    let mut rows: BTreeMap<u64, Vec<String>> = BTreeMap::new();
    for row in run.ply_history.iter().filter(|row| shown.contains(&row.ply)) {
        // Times are not below zero: their bits are in their order.
        let numbers = rows.entry(row.time.to_bits()).or_insert_with(|| vec![short(row.time * 1e6, 4)]);
        numbers.push(short(energy(row), 4));
    }
    let heads = shown.iter().map(|ply| format!("ply {} [J]", ply + 1));
    Some(Figure {
        id: "plies",
        title: "Energy of the plies".to_owned(),
        caption: "Kinetic and elastic energy of a ply; ply 1 is struck.".to_owned(),
        drawing,
        legend,
        axes: Some(axes),
        over_time: true,
        numbers: FigureNumbers::over_time(heads, rows.into_values().collect(), "plies.csv"),
    })
}

/// Factor and unit in which energies up to this [J] are shown.
fn unit(top: f64) -> (f64, &'static str) {
    if top < 0.1 { (1e3, "mJ") } else { (1.0, "J") }
}

/// Every energy, one on the other: together they are what was there.
pub(super) fn energy(run: &Run) -> Figure {
    let mut curves: Vec<HistoryCurve> = vec![
        ("projectile", |row| row.balance.projectile),
        ("fabric, kinetic", |row| row.balance.kinetic),
        ("fabric, internal", |row| row.balance.internal),
        ("yarn failure", |row| row.balance.failure),
        ("friction", |row| row.balance.friction),
        ("contact", |row| row.balance.contact),
        ("hourglass", |row| row.balance.hourglass),
        ("shock viscosity", |row| row.balance.viscous),
    ];
    if run.history.iter().any(|row| row.balance.separation != 0.0) {
        curves.push(("ply separation", |row| -row.balance.separation));
    }
    let step = run.history.len().div_ceil(COLUMNS).max(1);
    let last = run.history.len().saturating_sub(1);
    let kept = run.history.iter().enumerate().filter(|(n, _)| n.is_multiple_of(step) || *n == last);
    let rows: Vec<&Sample> =
        kept.map(|(_, row)| row).filter(|row| curves.iter().all(|c| c.1(row).is_finite())).collect();
    // What is above zero stands on zero, what is below hangs from it.
    let part = |value: f64, below: bool| if below { value.min(0.0) } else { value.max(0.0) };
    let level = |row: &Sample, count: usize, below: bool| -> f64 {
        curves[..count].iter().map(|(_, of)| part(of(row), below)).sum()
    };
    let top = rows.iter().map(|row| level(row, curves.len(), false)).fold(0.0, f64::max);
    let bottom = rows.iter().map(|row| level(row, curves.len(), true)).fold(0.0, f64::min);
    // Rounding is not drawn.
    let bottom = if bottom < -LEAST * top { bottom } else { 0.0 };
    let (factor, unit) = unit(top);
    let [x, y] = figure::axes([0.0, end(run)], [factor * bottom, factor * top]);
    let mut drawing = String::new();
    for (n, (_, of)) in curves.iter().enumerate() {
        for below in [false, true] {
            let is_there = |row: &&Sample| part(of(row), below).abs() > if below { LEAST * top } else { 0.0 };
            if !rows.iter().any(is_there) {
                continue;
            }
            let edge = |count: usize| move |row: &&Sample| [row.time * 1e6, factor * level(row, count, below)];
            let places = chart::places(&x, &y, rows.iter().map(edge(n + 1)).chain(rows.iter().rev().map(edge(n))));
            drawing += &format!("<polygon class=\"area k{n}\" points=\"{places}\"/>\n");
        }
    }
    let unit = format!("energy [{unit}]");
    drawing += &chart::axes(&x, &y, ["time [µs]", &unit]);
    let level = if bottom < 0.0 {
        "What is below zero was given, not taken. That the height of all of it stays the same, what is below zero taken off, means \
         that no energy is made or lost."
    } else {
        "That the upper edge stays level means that no energy is made or lost."
    };
    Figure {
        id: "energy",
        title: "Where the energy is".to_owned(),
        caption: format!("One on the other. {level}"),
        drawing,
        legend: curves.iter().enumerate().map(|(n, (name, _))| (format!("block k{n}"), (*name).to_owned())).collect(),
        axes: Some([x, y]),
        over_time: true,
        numbers: numbers(&run.history, "energy [J]", &curves),
    }
}
