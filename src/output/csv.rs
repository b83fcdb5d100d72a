//! Tables of a run as comma-separated text: history, yarn failures, plies, deflection profiles.

use crate::case::{Case, Layer};
use crate::run::profile::DeflectionProfile;
use crate::run::{PlySample, Sample};
use crate::solver::FailureEvent;

/// The first line.
pub(crate) fn header<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut line = names.into_iter().collect::<Vec<_>>().join(",");
    line.push('\n');
    line
}

/// Adds a line.
pub(crate) fn row(text: &mut String, cells: impl IntoIterator<Item = String>) {
    text.push_str(&cells.into_iter().collect::<Vec<_>>().join(","));
    text.push('\n');
}

/// A cell of free text: in quotes where it must be (RFC 4180).
pub(crate) fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// A number as the shortest text that reads back the same; whole numbers without a fraction, no negative zero.
pub(crate) fn number(value: f64) -> String {
    let value = value + 0.0;
    if value.fract() == 0.0 && value.abs() < 1e15 { format!("{value:.0}") } else { format!("{value:?}") }
}

/// A column of `history.csv`.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct HistoryColumn {
    /// Heading, unit last.
    pub name: &'static str,
    /// The number, in the heading's unit.
    pub read: fn(&Sample) -> f64,
}

const fn column(name: &'static str, read: fn(&Sample) -> f64) -> HistoryColumn {
    HistoryColumn { name, read }
}

/// Columns of `history.csv`, in order.
pub const COLUMNS: [HistoryColumn; 26] = [
    column("time_us", |s| s.time * 1e6),
    column("projectile_velocity_m_s", |s| s.projectile_velocity),
    column("projectile_displacement_mm", |s| s.projectile_displacement * 1e3),
    column("contact_force_n", |s| s.contact_force),
    column("kinetic_energy_j", |s| s.balance.kinetic),
    column("internal_energy_j", |s| s.balance.internal),
    column("hourglass_energy_j", |s| s.balance.hourglass),
    column("contact_dissipation_j", |s| s.balance.contact),
    column("friction_j", |s| s.balance.friction),
    column("failure_energy_j", |s| s.balance.failure),
    column("projectile_energy_j", |s| s.balance.projectile),
    column("energy_error", |s| s.balance.error),
    column("failed_warp", |s| s.failed[0] as f64),
    column("failed_weft", |s| s.failed[1] as f64),
    column("stored_energy_j", |s| s.balance.stored),
    column("external_work_j", |s| s.balance.external),
    column("eroded_elements", |s| s.eroded as f64),
    column("max_deflection_mm", |s| s.deflection * 1e3),
    column("max_yarn_tension_n", |s| s.balance.max_tension),
    column("momentum_error", |s| s.balance.momentum_error),
    column("perforated_plies", |s| f64::from(s.perforated_plies)),
    column("viscous_dissipation_j", |s| s.balance.viscous),
    column("energy_gained", |s| s.balance.gained),
    column("law_energy_j", |s| s.balance.law),
    column("last_ply_deflection_mm", |s| s.last_deflection * 1e3),
    column("ply_separation_j", |s| s.balance.separation),
];

/// The column of a name.
pub fn find(name: &str) -> Option<&'static HistoryColumn> {
    COLUMNS.iter().find(|column| column.name == name)
}

/// A column at a time [s], linear between rows; `None` outside the history.
pub fn at(history: &[Sample], column: &HistoryColumn, time: f64) -> Option<f64> {
    between(history, time, |row| row.time, column.read)
}

/// A value at a time, linear between rows of ascending time; `None` outside them.
pub(crate) fn between<T>(
    rows: &[T],
    time: f64,
    time_of: impl Fn(&T) -> f64,
    value_of: impl Fn(&T) -> f64,
) -> Option<f64> {
    let after = rows.partition_point(|row| time_of(row) < time);
    let next = rows.get(after)?;
    let value = value_of(next);
    if time_of(next) <= time {
        return Some(value);
    }
    let last = after.checked_sub(1).and_then(|before| rows.get(before))?;
    let share = (time - time_of(last)) / (time_of(next) - time_of(last));
    let start = value_of(last);
    Some(start + share * (value - start))
}

/// `history.csv`: a row per sample.
pub(super) fn history(history: &[Sample]) -> String {
    let mut text = header(COLUMNS.iter().map(|column| column.name));
    for sample in history {
        row(&mut text, COLUMNS.iter().map(|column| number((column.read)(sample))));
    }
    text
}

/// `events.csv`: every yarn failure. `ply`, `i` (column, along warp) and `j` (row, along weft) count from 0; `x_mm` and `y_mm` are the
/// reference place of the element from the middle of its ply, in the ply's axes. `time_step` [s].
pub(super) fn events(case: &Case, events: &[FailureEvent], time_step: f64) -> String {
    let mut text = header(["time_us", "ply", "i", "j", "yarn", "strain", "x_mm", "y_mm"]);
    let of_layer = |layer: &Layer| vec![layer.middles(); layer.plies as usize];
    let middles: Vec<[Vec<f64>; 2]> = case.layers().iter().flat_map(of_layer).collect();
    for event in events {
        let time = event.step as f64 * time_step * 1e6;
        let yarn = if event.yarn == 0 { "warp" } else { "weft" };
        let place = [event.ply, event.i, event.j].map(|n| n.to_string());
        let [ply, i, j] = place;
        let [along, across] = &middles[event.ply as usize];
        let [x, y] = [along[event.i as usize], across[event.j as usize]].map(|place| number(place * 1e3));
        row(&mut text, [number(time), ply, i, j, yarn.to_owned(), number(event.strain), x, y]);
    }
    text
}

/// `plies.csv`: every ply of a pack at the times of the history, counted from 0 at the struck side.
pub(super) fn plies(history: &[PlySample]) -> String {
    let names =
        ["time_us", "ply", "kinetic_energy_j", "stored_energy_j", "max_deflection_mm", "failed_warp", "failed_weft"];
    let mut text = header(names);
    for sample in history {
        let PlySample { time, ply, moment, failed } = sample;
        let numbers = [moment.kinetic, moment.stored, moment.deflection * 1e3].map(number);
        let [kinetic, stored, deflection] = numbers;
        let [warp, weft] = failed.map(|count| count.to_string());
        row(&mut text, [number(time * 1e6), ply.to_string(), kinetic, stored, deflection, warp, weft]);
    }
    text
}

/// `profiles.csv`: every node of every deflection profile.
pub(super) fn profiles(profiles: &[DeflectionProfile]) -> String {
    let mut text = header(["time_us", "reference_mm", "position_mm", "deflection_mm", "strain", "force_n_per_m"]);
    for profile in profiles {
        for p in &profile.points {
            let numbers =
                [profile.time * 1e6, p.reference * 1e3, p.position * 1e3, p.deflection * 1e3, p.strain, p.force];
            row(&mut text, numbers.map(number));
        }
    }
    text
}

#[cfg(test)]
#[path = "csv_tests.rs"]
mod tests;
