//! Tables of a run as comma-separated text: history, yarn failures, plies, deflection profiles.

use crate::case::{Case, Layer};
use crate::run::{DeflectionProfile, PlySample, ProfilePoint, Sample};
use crate::solver::FailureEvent;

/// A table: names of the columns, then its rows.
pub(crate) fn table<'a>(names: impl IntoIterator<Item = &'a str>, rows: impl Iterator<Item = Vec<String>>) -> String {
    let names = names.into_iter().map(str::to_owned).collect();
    let line = |cells: Vec<String>| cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",") + "\n";
    std::iter::once(names).chain(rows).map(line).collect()
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

/// A column of `history.csv`: heading, unit last, and the number in that unit.
pub type HistoryColumn = (&'static str, fn(&Sample) -> f64);

/// Columns of `history.csv`, in order.
pub const COLUMNS: [HistoryColumn; 28] = [
    ("time_us", |s| s.time * 1e6),
    ("projectile_velocity_m_s", |s| s.projectile_velocity),
    ("projectile_displacement_mm", |s| s.projectile_displacement * 1e3),
    ("contact_force_n", |s| s.contact_force),
    ("kinetic_energy_j", |s| s.balance.kinetic),
    ("internal_energy_j", |s| s.balance.internal),
    ("hourglass_energy_j", |s| s.balance.hourglass),
    ("contact_dissipation_j", |s| s.balance.contact),
    ("friction_j", |s| s.balance.friction),
    ("failure_energy_j", |s| s.balance.failure),
    ("projectile_energy_j", |s| s.balance.projectile),
    ("energy_error", |s| s.balance.error),
    ("failed_warp", |s| s.failed[0] as f64),
    ("failed_weft", |s| s.failed[1] as f64),
    ("stored_energy_j", |s| s.balance.stored),
    ("external_work_j", |s| s.balance.external),
    ("eroded_elements", |s| s.eroded as f64),
    ("max_deflection_mm", |s| s.deflection * 1e3),
    ("max_yarn_tension_n", |s| s.balance.max_tension),
    ("momentum_error", |s| s.balance.momentum_error),
    ("perforated_plies", |s| f64::from(s.perforated_plies)),
    ("viscous_dissipation_j", |s| s.balance.viscous),
    ("energy_gained", |s| s.balance.gained),
    ("law_energy_j", |s| s.balance.law),
    ("last_ply_deflection_mm", |s| s.last_deflection * 1e3),
    ("ply_separation_j", |s| s.balance.separation),
    ("backing_energy_j", |s| s.balance.backing),
    ("crater_depth_mm", |s| s.balance.crater * 1e3),
];

/// The column of a name.
pub fn find(name: &str) -> Option<&'static HistoryColumn> {
    COLUMNS.iter().find(|(heading, _)| *heading == name)
}

/// A value at a time, linear between rows of a history; `None` outside them.
pub(crate) fn between(history: &[Sample], time: f64, value_of: impl Fn(&Sample) -> f64) -> Option<f64> {
    let after = history.partition_point(|row| row.time < time);
    let next = history.get(after)?;
    let value = value_of(next);
    if next.time <= time {
        return Some(value);
    }
    let last = after.checked_sub(1).and_then(|before| history.get(before))?;
    let share = (time - last.time) / (next.time - last.time);
    let start = value_of(last);
    Some(start + share * (value - start))
}

/// `history.csv`: a row per sample.
pub(super) fn history(history: &[Sample]) -> String {
    let row = |sample: &Sample| COLUMNS.iter().map(|(_, read)| number(read(sample))).collect();
    table(COLUMNS.iter().map(|(heading, _)| *heading), history.iter().map(row))
}

/// `events.csv`: every yarn failure. `ply`, `i` (column, along warp) and `j` (row, along weft) count from 0; `x_mm` and `y_mm` are the
/// reference place of the element from the middle of its ply, in the ply's axes. `time_step` [s].
pub fn events(case: &Case, events: &[FailureEvent], time_step: f64) -> String {
    let of_layer = |layer: &Layer| vec![layer.middles(); layer.plies as usize];
    let middles: Vec<[Vec<f64>; 2]> = case.layers().iter().flat_map(of_layer).collect();
    let row = |event: &FailureEvent| {
        let FailureEvent { step, ply, i, j, yarn, strain } = *event;
        let [along, across] = &middles[ply as usize];
        let [x, y] = [along[i as usize], across[j as usize]].map(|place| number(place * 1e3));
        let [ply, i, j] = [ply, i, j].map(|n| n.to_string());
        let yarn = ["warp", "weft"][usize::from(yarn)].to_owned();
        vec![number(step as f64 * time_step * 1e6), ply, i, j, yarn, number(strain), x, y]
    };
    table(["time_us", "ply", "i", "j", "yarn", "strain", "x_mm", "y_mm"], events.iter().map(row))
}

/// `plies.csv`: every ply of a pack at the times of the history, counted from 0 at the struck side.
pub fn plies(history: &[PlySample]) -> String {
    let names =
        ["time_us", "ply", "kinetic_energy_j", "stored_energy_j", "max_deflection_mm", "failed_warp", "failed_weft"];
    let row = |PlySample { time, ply, moment, failed: [warp, weft] }: &PlySample| {
        let counts = [*ply as f64, *warp as f64, *weft as f64];
        let (kinetic, stored, deflection) = (moment.kinetic, moment.stored, moment.deflection * 1e3);
        [time * 1e6, counts[0], kinetic, stored, deflection, counts[1], counts[2]].map(number).into()
    };
    table(names, history.iter().map(row))
}

/// `profiles.csv`: every node of every deflection profile.
pub fn profiles(profiles: &[DeflectionProfile]) -> String {
    let names = ["time_us", "reference_mm", "position_mm", "deflection_mm", "strain", "force_n_per_m"];
    let points = profiles.iter().flat_map(|profile| profile.points.iter().map(|point| (profile.time, point)));
    let row = |(time, p): (f64, &ProfilePoint)| {
        [time * 1e6, p.reference * 1e3, p.position * 1e3, p.deflection * 1e3, p.strain, p.force].map(number).into()
    };
    table(names, points.map(row))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_and_stay_short() {
        for value in [0.1, -3.25e-20, 1.0 / 3.0, 6.02e23, 42.0, f64::MIN_POSITIVE] {
            assert_eq!(number(value).parse(), Ok(value));
        }
        assert_eq!(number(-0.0), "0");
        assert_eq!(number(400.0), "400");
        assert_eq!(number(f64::NAN), "NaN");
    }

    #[test]
    fn reads_between_rows_and_never_outside() {
        let row = |time: f64, velocity: f64| Sample { time, projectile_velocity: velocity, ..Sample::default() };
        let history = [row(0.0, 100.0), row(1e-6, 90.0), row(3e-6, 80.0)];
        let velocity = find("projectile_velocity_m_s");
        let read = |time: f64| velocity.and_then(|(_, read)| between(&history, time, read));
        assert_eq!(read(0.0), Some(100.0));
        assert_eq!(read(3e-6), Some(80.0));
        assert!(read(2e-6).is_some_and(|v| (v - 85.0).abs() < 1e-9));
        assert_eq!(read(3.1e-6), None);
        assert_eq!(read(-1e-9), None);
    }
}
