//! `bench.json` with everything measured, and `bench.svg`: run time against error, both logarithmic, one panel per case.

use serde_json::{Value, json};

use super::{BenchPlan, BenchResult, BenchRow, Errors, REFERENCE};
use crate::case::{Case, case_hash};
use crate::num::simd::Vectors;
use crate::output;
use crate::output::plot::{self, Axis};
use crate::run::Run;

/// Everything measured. `wall_seconds`: time since the command began [s].
pub fn json(measured: &[BenchResult], plan: BenchPlan<'_>, wall_seconds: f64) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "threads": measured.first().map(|m| m.reference.threads),
        "vectors": Vectors::widest().name(),
        "adapter": plan.device.map(|device| device.name()),
        "repeat": plan.repeat,
        "tolerance_percent": plan.tolerance * 100.0,
        "wall_s": wall_seconds,
        "interrupted": measured.iter().any(|m| m.interrupted),
        "error_is": "root mean square of the difference to the reference's velocity history over the time both cover, \
                     over the velocity the reference lost in that time; deflection and tension are compared over the same \
                     time, residual velocity and stop time at the end of each",
        "scatter_is": "the error of a second reference, with a time step a fifth longer: smaller errors rank nothing",
        "cases": measured.iter().map(|m| case_json(m, plan.tolerance)).collect::<Vec<_>>(),
    })
}

fn case_json(measured: &BenchResult, tolerance: f64) -> Value {
    let mut reference = run_json(&measured.case, &measured.reference);
    reference["what"] = json!(REFERENCE);
    reference["loop_s"] = json!(measured.reference.loop_seconds);
    reference["scatter_percent"] = json!(measured.scatter.map(|error| error * 100.0));
    let mut front: Vec<&BenchRow> = measured.rows.iter().filter(|row| row.on_front).collect();
    front.sort_by(|a, b| a.time().total_cmp(&b.time()));
    let skipped = measured.skipped.iter().map(|(name, reason)| json!({ "name": name, "reason": reason }));
    json!({
        "case": measured.case.name,
        "title": measured.case.title,
        "interrupted": measured.interrupted,
        "reference": reference,
        "choices": measured.rows.iter().map(|row| row_json(row, tolerance)).collect::<Vec<_>>(),
        "skipped": skipped.collect::<Vec<_>>(),
        "pareto": front.iter().map(|row| &row.configuration.name).collect::<Vec<_>>(),
        "cheapest_within_tolerance": measured.cheapest.map(|at| &measured.rows[at].configuration.name),
    })
}

/// Settings of a run and its results.
fn run_json(case: &Case, run: &Run) -> Value {
    let peak = |read: fn(&crate::run::Sample) -> f64| run.history.iter().map(read).fold(0.0, f64::max);
    json!({
        "case_hash": case_hash(&case.as_run),
        "backend": run.backend,
        "adapter": run.adapter,
        "precision": run.precision,
        "courant": case.solver.courant,
        "crossovers_per_element": case.pack.crossovers_per_element,
        "history_interval_us": case.output.history_interval * 1e6,
        "switched_off": run.skips.switched_off(),
        "elements": run.elements,
        "steps": run.steps,
        "time_us": run.history.last().map(|row| row.time * 1e6),
        "time_step_us": run.time_step * 1e6,
        "element_steps": run.elements as u64 * run.steps,
        "element_steps_computed": run.element_steps_computed,
        "outcome": run.outcome.word(),
        "residual_velocity_m_s": output::residual_velocity(case, run),
        "stop_time_us": run.stop_time.map(|time| time * 1e6),
        "max_deflection_mm": peak(|row| row.deflection) * 1e3,
        "peak_yarn_tension_n": peak(|row| row.balance.max_tension),
        "energy_error": run.energy_error,
        "unstable": run.divergence.as_ref().map(|divergence| divergence.quantity.clone()),
        "device_lost": run.lost,
    })
}

fn row_json(row: &BenchRow, tolerance: f64) -> Value {
    let mut out = run_json(&row.case, &row.run);
    let errors = row.errors;
    let percent = |error: fn(&Errors) -> Option<f64>| errors.as_ref().and_then(error).map(|error| error * 100.0);
    let more = json!({
        "name": row.configuration.name,
        "sets": row.configuration.sets,
        "loop_s": row.time(),
        "loop_s_of_each_run": row.loop_seconds,
        "element_steps_per_s": row.rate(),
        "compared_until_us": errors.map(|errors| errors.span * 1e6),
        "velocity_error_percent": percent(|errors| errors.velocity),
        "residual_velocity_error_m_s": errors.map(|errors| errors.residual_velocity),
        "stop_time_error_us": errors.and_then(|errors| errors.stop_time).map(|time| time * 1e6),
        "end_error_percent": percent(|errors| errors.end),
        "deflection_error_percent": percent(|errors| errors.deflection),
        "tension_error_percent": percent(|errors| errors.tension),
        "same_outcome": row.same_outcome,
        "on_front": row.on_front,
        "within_tolerance": row.is_within(tolerance),
    });
    for (key, value) in more.as_object().into_iter().flatten() {
        out[key] = value.clone();
    }
    out
}

/// Size of a panel.
const SIZE: [f64; 2] = [960.0, 520.0];
/// Ends of the plot area across, and up from the bottom.
const ACROSS: [f64; 2] = [90.0, 700.0];
const UP: [f64; 2] = [458.0, 72.0];
const STYLE: &str = ".limit { stroke: #444; stroke-dasharray: 5 4 } .scatter { fill-opacity: 0.07 } .best { fill: #0b62b0 } \
                     .front { stroke: #0b62b0; stroke-width: 1.8 } .other { fill: #8a5a00 }";

/// The drawing of everything measured. `tolerance`: error that is good enough [-].
pub fn plot(measured: &[BenchResult], tolerance: f64) -> String {
    let panels = measured.iter().enumerate().map(|(at, one)| {
        format!("<g transform=\"translate(0 {})\">\n{}</g>\n", SIZE[1] * at as f64, panel(one, tolerance * 100.0))
    });
    let size = [SIZE[0], SIZE[1] * measured.len().max(1) as f64];
    plot::svg(size, &format!("{}{STYLE}", plot::STYLE), &panels.collect::<String>())
}

/// Points are numbered, their names stand beside the plot. `limit`: error that is good enough [%].
fn panel(measured: &BenchResult, limit: f64) -> String {
    let mut rows: Vec<(&BenchRow, [f64; 2])> =
        measured.rows.iter().filter_map(|row| Some((row, [row.time(), row.velocity_error()? * 100.0]))).collect();
    rows.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let x = Axis::logarithmic(&rows.iter().map(|row| row.1[0]).collect::<Vec<_>>(), ACROSS);
    let y = Axis::logarithmic(&rows.iter().map(|row| row.1[1]).chain([limit]).collect::<Vec<_>>(), UP);
    let title = format!("{}: run time against error", measured.case.title);
    let caption = match measured.cheapest.map(|at| &measured.rows[at]) {
        Some(row) => format!("cheapest that is good enough: {}", row.configuration.name),
        None => "no choice is good enough".to_owned(),
    };
    let mut out = plot::text(24.0, 28.0, "font-size=\"16\" font-weight=\"bold\"", &title);
    out += &plot::text(24.0, 48.0, "", &format!("{caption}; line: what no other choice beats"));
    out += &plot::axes(&x, &y, ["time in the loop [s]", "error of the velocity history [%]"]);
    let ends = [x.range()[0], x.range()[1]];
    out += &plot::line(&x, &y, ends.map(|end| [end, limit]).into_iter(), "class=\"limit\"");
    let asked = format!("asked for: {} %", plot::label(limit));
    out += &plot::text(ACROSS[1] - 4.0, y.at(limit) - 4.0, "text-anchor=\"end\"", &asked);
    if let Some(top) = measured.scatter.map(|error| y.at(error * 100.0)).filter(|top| *top < UP[0]) {
        out += &plot::area(ACROSS, [top, UP[0]], "class=\"scatter\"", "");
        out += &plot::text(ACROSS[0] + 6.0, UP[0] - 6.0, "", "scatter of the reference");
    }
    let front = rows.iter().filter(|(row, _)| row.on_front).map(|(_, point)| *point);
    out += &plot::line(&x, &y, front, "class=\"front\"");
    for (number, (row, point)) in rows.iter().enumerate() {
        let [across, up] = [x.at(point[0]), y.at(point[1])];
        let class = if row.on_front { "best" } else { "other" };
        out += &format!("<circle class=\"{class}\" cx=\"{across:.1}\" cy=\"{up:.1}\" r=\"4.5\"/>\n");
        out += &plot::text(across + 7.0, up - 5.0, "", &format!("{}", number + 1));
        let name = row.configuration.name.split(':').next().unwrap_or_default();
        let outcome = if row.same_outcome { String::new() } else { format!(" ({})", row.run.outcome.word()) };
        let words = format!("{} {name}{outcome}", number + 1);
        out += &plot::text(ACROSS[1] + 24.0, UP[1] + 12.0 + 18.0 * number as f64, "", &words);
    }
    out
}
