//! `bench.json`: everything measured, units at the end of the keys.

use serde_json::{Value, json};

use super::{BenchPlan, BenchResult, BenchRow, Errors, REFERENCE};
use crate::case::{Case, case_hash};
use crate::num::simd::Vectors;
use crate::output;
use crate::run::Run;

/// The whole file. `wall_seconds`: time since the command began [s].
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
        "cases": measured.iter().map(|m| of_case(m, plan.tolerance)).collect::<Vec<_>>(),
    })
}

fn of_case(measured: &BenchResult, tolerance: f64) -> Value {
    let mut reference = of_run(&measured.case, &measured.reference);
    reference["what"] = json!(REFERENCE);
    reference["loop_s"] = json!(measured.reference.loop_seconds);
    reference["scatter_percent"] = json!(measured.scatter().map(|error| error * 100.0));
    let mut front: Vec<&BenchRow> = measured.rows.iter().filter(|row| row.on_front).collect();
    front.sort_by(|a, b| a.time().total_cmp(&b.time()));
    let skipped = measured.skipped.iter().map(|skipped| json!({ "name": skipped.name, "reason": skipped.reason }));
    json!({
        "case": measured.case.name,
        "title": measured.case.title,
        "interrupted": measured.interrupted,
        "reference": reference,
        "choices": measured.rows.iter().map(|row| of_row(row, tolerance)).collect::<Vec<_>>(),
        "skipped": skipped.collect::<Vec<_>>(),
        "pareto": front.iter().map(|row| &row.choice.name).collect::<Vec<_>>(),
        "cheapest_within_tolerance": measured.cheapest.map(|at| &measured.rows[at].choice.name),
    })
}

/// How a case was run and what came out.
fn of_run(case: &Case, run: &Run) -> Value {
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
        "unstable": run.divergence.as_ref().map(|trouble| trouble.quantity.clone()),
        "device_lost": run.lost,
    })
}

fn of_row(row: &BenchRow, tolerance: f64) -> Value {
    let mut out = of_run(&row.case, &row.run);
    let errors = row.errors;
    let percent = |error: fn(&Errors) -> Option<f64>| errors.as_ref().and_then(error).map(|error| error * 100.0);
    out["name"] = json!(row.choice.name);
    out["sets"] = json!(row.choice.sets);
    out["loop_s"] = json!(row.time());
    out["loop_s_of_each_run"] = json!(row.loop_seconds);
    out["element_steps_per_s"] = json!(row.rate());
    out["compared_until_us"] = json!(errors.map(|errors| errors.span * 1e6));
    out["velocity_error_percent"] = json!(percent(|errors| errors.velocity));
    out["residual_velocity_error_m_s"] = json!(errors.map(|errors| errors.residual_velocity));
    out["stop_time_error_us"] = json!(errors.and_then(|errors| errors.stop_time).map(|time| time * 1e6));
    out["end_error_percent"] = json!(percent(|errors| errors.end));
    out["deflection_error_percent"] = json!(percent(|errors| errors.deflection));
    out["tension_error_percent"] = json!(percent(|errors| errors.tension));
    out["same_outcome"] = json!(row.same_outcome);
    out["on_front"] = json!(row.on_front);
    out["within_tolerance"] = json!(row.is_within(tolerance));
    out
}
