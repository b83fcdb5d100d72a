//! `history.csv`: one row per sample. The columns are one table, for the file and for expectations.

use crate::run::Sample;

use super::csv;

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

/// The file's text.
pub(super) fn text(history: &[Sample]) -> String {
    let mut text = csv::header(COLUMNS.iter().map(|column| column.name));
    for sample in history {
        csv::row(&mut text, COLUMNS.iter().map(|column| csv::number((column.read)(sample))));
    }
    text
}

#[cfg(test)]
#[path = "history_tests.rs"]
mod tests;
