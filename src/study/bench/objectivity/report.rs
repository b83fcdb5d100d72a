//! `objectivity.json`, and the table of what is asked and what was got.

use serde_json::{Value, json};

use super::{ABOVE, FACTORS, ObjectivityPlan, ObjectivityResult, ObjectivityRow, VariedAxis};
use crate::case::{Accuracy, Word, case_hash};
use crate::markdown;

/// A figure that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct AskedFigure {
    /// What is compared.
    pub quantity: &'static str,
    /// What is varied.
    pub varied: &'static str,
    /// Spread allowed [-].
    pub allowed: f64,
    /// Spread got [-]; none where a part of it could not be measured.
    pub got: Option<f64>,
}

impl AskedFigure {
    /// Whether the figure is what is asked.
    pub fn met(&self) -> bool {
        self.got.is_some_and(|got| got <= self.allowed)
    }
}

/// The figures that are asked for.
pub fn figures(measured: &ObjectivityResult) -> Vec<AskedFigure> {
    let figure = |quantity, varied, allowed, got| AskedFigure { quantity, varied, allowed, got };
    let limit = |row: &ObjectivityRow| row.limit.map(|limit| limit.middle());
    let mean = |row: &ObjectivityRow| row.scatter.map(|scatter| scatter.mean);
    let (before, ballistic) = ("velocity before failure", "ballistic limit");
    let means = "mean residual velocity at 1.5 × the limit";
    let energy = if measured.case.solver.accuracy == Accuracy::Converged { 0.05 } else { 0.08 };
    let half = largest(measured, |row| row.setting.half_cell);
    let finer = largest(measured, |row| row.setting.axis == VariedAxis::Finer);
    let of = |axis: VariedAxis, read: &dyn Fn(&ObjectivityRow) -> Option<f64>| spread(measured, axis, read);
    let mut figures = vec![
        figure(before, "half-cell shifts", 0.005, half),
        figure(before, "half as long elements", 0.01, finer),
        figure(ballistic, "position of the hit in a cell", 0.03, of(VariedAxis::Position, &limit)),
        figure(ballistic, "half as long elements", 0.03, of(VariedAxis::Finer, &limit)),
        figure(ballistic, "Courant number", 0.01, of(VariedAxis::Courant, &limit)),
        figure(means, "position of the hit in a cell", 0.02, of(VariedAxis::Position, &mean)),
        figure(means, "half as long elements", 0.02, of(VariedAxis::Finer, &mean)),
        figure(means, "Courant number", 0.02, of(VariedAxis::Courant, &mean)),
    ];
    figures.extend(
        ABSORBED.into_iter().enumerate().map(|(at, name)| {
            figure(name, "position, elements, Courant number", energy, absorbed_spread(measured, at))
        }),
    );
    // An even mesh has no other lines than those counted from the edges.
    if measured.rows.iter().any(|row| row.setting.axis == VariedAxis::Lines) {
        figures.push(figure(ballistic, "lines of nodes under the hit", 0.05, of(VariedAxis::Lines, &limit)));
    }
    figures
}

/// Absorbed energy at each of [`FACTORS`].
const ABSORBED: [&str; FACTORS.len()] = [
    "absorbed energy at 1.05 × the limit",
    "absorbed energy at 1.2 × the limit",
    "absorbed energy at 1.5 × the limit",
    "absorbed energy at 2 × the limit",
    "absorbed energy at 3 × the limit",
];

/// Largest less smallest absorbed energy at one of [`FACTORS`] over places, half as long elements and Courant numbers, over the impact energy at
/// the limit of the reference [-].
fn absorbed_spread(measured: &ObjectivityResult, at: usize) -> Option<f64> {
    let limit = measured.rows.first()?.limit?.middle();
    let impact = 0.5 * measured.case.projectile.as_ref()?.mass * limit * limit;
    let asked = [VariedAxis::Reference, VariedAxis::Position, VariedAxis::Finer, VariedAxis::Courant];
    let rows = measured.rows.iter().filter(|row| asked.contains(&row.setting.axis));
    let energies = rows.map(|row| row.absorbed.get(at).copied().flatten()).collect::<Option<Vec<f64>>>()?;
    let largest = energies.iter().copied().reduce(f64::max)?;
    Some((largest - energies.iter().copied().reduce(f64::min)?) / impact)
}

/// Largest difference of velocity before failure among rows.
fn largest(measured: &ObjectivityResult, among: impl Fn(&ObjectivityRow) -> bool) -> Option<f64> {
    let rows = measured.rows.iter().filter(|row| among(row)).map(|row| row.before_failure);
    let values = rows.collect::<Option<Vec<f64>>>()?;
    values.into_iter().reduce(f64::max)
}

/// Largest less smallest value over an axis with the reference, over the reference's [-].
pub fn spread(
    measured: &ObjectivityResult,
    axis: VariedAxis,
    read: &dyn Fn(&ObjectivityRow) -> Option<f64>,
) -> Option<f64> {
    let reference = read(measured.rows.first()?)?;
    let rows: Vec<&ObjectivityRow> = measured.rows.iter().filter(|row| row.setting.axis == axis).collect();
    let values = rows.iter().map(|row| read(row)).collect::<Option<Vec<f64>>>()?;
    if values.is_empty() || reference <= 0.0 {
        return None;
    }
    let all = || values.iter().copied().chain([reference]);
    Some((all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)) / reference)
}

/// The whole file. `wall_seconds`: time since the command began [s].
pub fn json(measured: &ObjectivityResult, plan: ObjectivityPlan, wall_seconds: f64) -> Value {
    let case = &measured.case;
    let figure = |figure: AskedFigure| {
        json!({
            "quantity": figure.quantity,
            "varied": figure.varied,
            "allowed_percent": figure.allowed * 100.0,
            "got_percent": figure.got.map(|got| got * 100.0),
            "met": figure.met(),
        })
    };
    let axis = |axis: &VariedAxis| {
        let percent =
            |read: &dyn Fn(&ObjectivityRow) -> Option<f64>| spread(measured, *axis, read).map(|part| part * 100.0);
        json!({
            "axis": axis.name(),
            "limit_spread_percent": percent(&|row| row.limit.map(|limit| limit.middle())),
            "residual_velocity_spread_percent": percent(&|row| row.residual),
            "mean_residual_velocity_spread_percent": percent(&|row| row.scatter.map(|scatter| scatter.mean)),
        })
    };
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "case": case.name,
        "title": case.title,
        "case_hash": case_hash(&case.as_run),
        "numerics": case.solver.numerics.word(),
        "contact_sampling": case.solver.contact_sampling.word(),
        "threads": plan.threads,
        "quick": plan.quick,
        "bracket_percent": plan.width * 100.0,
        "wall_s": wall_seconds,
        "interrupted": measured.interrupted,
        "above_limit": ABOVE,
        "absorbed_at": FACTORS,
        "accuracy": case.solver.accuracy.word(),
        "spread_is": "largest less smallest value over the axis with the reference, over the reference's; before failure: largest \
                      difference to the reference's velocity before either's first broken yarn, over the velocity it lost until then; absorbed energy: over \
                      position, half as long elements and Courant numbers, over the impact energy at the limit",
        "figures": figures(measured).into_iter().map(figure).collect::<Vec<_>>(),
        "axes": VariedAxis::ALL.iter().map(axis).collect::<Vec<_>>(),
        "settings": measured.rows.iter().map(of_row).collect::<Vec<_>>(),
    })
}

fn of_row(row: &ObjectivityRow) -> Value {
    json!({
        "axis": row.setting.axis.name(),
        "name": row.setting.name,
        "sets": row.setting.sets,
        "limit_m_s": row.limit.map(|limit| limit.middle()),
        "stopped_m_s": row.limit.map(|limit| limit.stopped),
        "perforated_m_s": row.limit.map(|limit| limit.perforated),
        "residual_velocity_m_s": row.residual,
        "absorbed_energy_j": row.absorbed,
        "mean_residual_velocity_m_s": row.scatter.map(|scatter| scatter.mean),
        "standard_error_m_s": row.scatter.map(|scatter| scatter.error()),
        "standard_deviation_m_s": row.scatter.map(|scatter| scatter.deviation),
        "smallest_m_s": row.scatter.map(|scatter| scatter.range[0]),
        "largest_m_s": row.scatter.map(|scatter| scatter.range[1]),
        "shots_of_the_mean": row.scatter.map(|scatter| scatter.shots),
        "first_failure_us": row.first_failure.map(|time| time * 1e6),
        "before_failure_percent": row.before_failure.map(|part| part * 100.0),
        "shots": row.shots.all,
        "undecided": row.shots.undecided,
        "unstable": row.shots.unstable,
    })
}

/// The figures as a table in Markdown, from the file.
pub fn markdown(report: &Value) -> String {
    let text = |value: &Value| value.as_str().unwrap_or("-").to_owned();
    let quick = if report["quick"] == true { " (--quick)" } else { "" };
    let limit =
        report["settings"][0]["limit_m_s"].as_f64().map_or_else(|| "-".to_owned(), |limit| format!("{limit:.1}"));
    let accuracy = if report["accuracy"] == "converged" { ", accuracy `converged`" } else { "" };
    let percent = |value: &Value| value.as_f64().map_or_else(|| "-".to_owned(), |value| format!("{value:.1} %"));
    let figure = |figure: &Value| {
        let verdict = if figure["met"] == true { "met" } else { "**missed**" };
        let [quantity, varied] = ["quantity", "varied"].map(|key| text(&figure[key]));
        let [allowed, got] = ["allowed_percent", "got_percent"].map(|key| percent(&figure[key]));
        vec![quantity, varied, allowed, got, verdict.to_owned()]
    };
    let figures = report["figures"].as_array().into_iter().flatten().map(figure);
    format!(
        "{}, numerics `{}`{accuracy}, contact sampling `{}`{quick}: ballistic limit {limit} m/s\n\n{}",
        text(&report["case"]),
        text(&report["numerics"]),
        text(&report["contact_sampling"]),
        markdown::table(&["quantity", "varied", "allowed", "got", ""], figures)
    )
}
