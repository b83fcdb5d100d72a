//! The quantities of `summary.json`, side by side.

use serde::Serialize;
use serde_json::Value;

use super::curve::share;
use super::input::Input;
use super::quantity::is_share;

/// Where a quantity stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ColumnOf {
    /// A key of `summary.json`; of an object in it, with a dot between.
    Summary,
    /// The last row of `history.csv`.
    End,
}

/// A quantity.
struct SummaryQuantity {
    name: &'static str,
    source: ColumnOf,
    /// Whether it is a result that two runs are judged by.
    judged: bool,
}

const fn row(name: &'static str) -> SummaryQuantity {
    SummaryQuantity { name, source: ColumnOf::Summary, judged: false }
}

const fn judged(name: &'static str) -> SummaryQuantity {
    SummaryQuantity { judged: true, ..row(name) }
}

const fn end(name: &'static str) -> SummaryQuantity {
    SummaryQuantity { source: ColumnOf::End, ..row(name) }
}

/// What is shown, in order.
const ROWS: [SummaryQuantity; 40] = [
    judged("outcome"),
    judged("residual_velocity_m_s"),
    row("residual_velocity_scatter_m_s"),
    judged("rebound_velocity_m_s"),
    judged("carried_velocity_m_s"),
    judged("stop_time_us"),
    judged("absorbed_energy_j"),
    end("kinetic_energy_j"),
    end("internal_energy_j"),
    end("failure_energy_j"),
    end("friction_j"),
    end("contact_dissipation_j"),
    end("hourglass_energy_j"),
    end("viscous_dissipation_j"),
    end("ply_separation_j"),
    end("law_energy_j"),
    judged("max_deflection_mm"),
    row("last_ply_deflection_mm"),
    row("max_penetration_mm"),
    row("peak_contact_force_n"),
    row("peak_yarn_tension_n"),
    row("breaking_load_ratio"),
    row("failed_yarns.warp"),
    row("failed_yarns.weft"),
    row("broken_yarns.warp"),
    row("broken_yarns.weft"),
    row("eroded_elements"),
    row("perforated_plies"),
    row("trust.advice"),
    row("energy_gained"),
    row("energy_error"),
    row("momentum_error"),
    row("hourglass_fraction"),
    row("time_us"),
    row("steps"),
    row("time_step_us"),
    row("elements"),
    row("element_steps"),
    row("element_steps_computed"),
    row("wall_s"),
];

/// A quantity of two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SummaryRow {
    /// Key, with a dot before one of an object.
    pub name: &'static str,
    /// Number or word of the first; null where it has none.
    pub a: Value,
    /// The same of the other.
    pub b: Value,
    /// Other less first, of numbers.
    pub difference: Option<f64>,
    /// That over the magnitude of the first, but of what is a share already; `None` where the first is zero and the other is not.
    pub relative: Option<f64>,
    /// Within what was asked for; `None` where it is not judged.
    pub pass: Option<bool>,
}

/// Every quantity that at least one of two runs has; none where one is no run. `within`: what is judged by, if anything is.
pub(super) fn rows(first: &Input, other: &Input, within: Option<f64>) -> Vec<SummaryRow> {
    if first.summary.is_none() || other.summary.is_none() {
        return Vec::new();
    }
    ROWS.iter().filter_map(|row| of(row, first, other, within)).collect()
}

fn of(row: &SummaryQuantity, first: &Input, other: &Input, within: Option<f64>) -> Option<SummaryRow> {
    let [a, b] = [first, other].map(|input| value(row, input));
    let none = |value: &Value| value.is_null() || row.source == ColumnOf::End && value.as_f64() == Some(0.0);
    if none(&a) && none(&b) {
        return None;
    }
    let numbers = a.as_f64().zip(b.as_f64());
    let difference = numbers.map(|(a, b)| b - a);
    let relative = numbers.and_then(|(a, b)| share(b - a, if is_share(row.name) { 1.0 } else { a }));
    let good = |within: f64| match difference {
        Some(_) => relative.is_some_and(|relative| relative.abs() <= within),
        None => a == b,
    };
    let pass = within.filter(|_| row.judged).map(good);
    Some(SummaryRow { name: row.name, a, b, difference, relative, pass })
}

fn value(row: &SummaryQuantity, input: &Input) -> Value {
    match row.source {
        ColumnOf::Summary => {
            let pointer = format!("/{}", row.name.replace('.', "/"));
            input.summary.as_ref().and_then(|summary| summary.pointer(&pointer)).cloned().unwrap_or_default()
        }
        ColumnOf::End => {
            let last = input.table.column(row.name).and_then(|column| column.values.last());
            last.map_or(Value::Null, |value| Value::from(*value))
        }
    }
}
