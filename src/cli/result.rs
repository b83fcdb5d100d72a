//! The result of a run as people read it: verdict first, then where the energy went, how far the numbers can be
//! trusted, what they cost, what was expected, and where the files are.

use std::path::Path;

use ripstop::case::Case;
use ripstop::model::MirrorPlanes;
use ripstop::output::expectation::{expected, got, note, quantity};
use ripstop::output::number::{fixed, fraction, grouped, short, us};
use ripstop::output::{Energies, symmetry, verdict};
use ripstop::simulation::Run;
use serde_json::Value;

use super::table::{Align, Table};

/// What practitioners accept: energy balance and hourglass energy [-].
const ENERGY_LIMIT: f64 = 0.02;
const HOURGLASS_LIMIT: f64 = 0.05;

/// The whole text. `files`: folder and names, where they were written.
pub(crate) fn text(case: &Case, run: &Run, summary: &Value, files: Option<(&Path, &[&str])>) -> String {
    let verdict = verdict(case, run);
    let verdict = format!("\n{}{} {}", verdict.word.to_uppercase(), verdict.mark(), verdict.detail);
    let mut parts = vec![case.title.clone(), verdict, energy(run), trust(run, summary)];
    parts.push(cost(case, run, summary));
    parts.push(expectations(summary));
    if let Some((folder, names)) = files {
        parts.push(format!("\nfiles  {}: {}\n", folder.display(), names.join(", ")));
    }
    parts.retain(|part| !part.is_empty());
    parts.iter().map(|part| format!("{}\n", part.trim_end())).collect()
}

/// What the fabric was given and where it is at the end.
fn energy(run: &Run) -> String {
    let Some(energies) = Energies::of(run) else { return String::new() };
    let mut table = Table::plain(&[Align::Left, Align::Right, Align::Right]);
    let absorbed = energies.text(energies.absorbed);
    if run.impact_energy > 0.0 && energies.given == energies.absorbed {
        let impact = format!("of {}", energies.text(run.impact_energy));
        table.row(["lost by the projectile".to_owned(), absorbed, impact]);
    } else if energies.given != 0.0 {
        table.row(["given to the fabric".to_owned(), energies.text(energies.given)]);
    } else {
        table.row(["change"]);
    }
    for (name, energy) in &energies.shares {
        table.row([format!("  {name}"), energies.text(*energy), energies.percent(*energy)]);
    }
    format!("\nenergy\n{}", indent(&table.to_string()))
}

fn trust(run: &Run, summary: &Value) -> String {
    let above = |value: f64, limit: f64| {
        if value <= limit { String::new() } else { format!("above the {:.0} % practitioners accept", limit * 100.0) }
    };
    let mut table = Table::plain(&[Align::Left, Align::Left, Align::Left]);
    let energy = fraction(run.energy_error);
    table.row(["energy error".to_owned(), energy, above(run.energy_error, ENERGY_LIMIT)]);
    table.row(["momentum error".to_owned(), fraction(run.momentum_error)]);
    let hourglass = fraction(run.hourglass_fraction);
    table.row(["hourglass / internal".to_owned(), hourglass, above(run.hourglass_fraction, HOURGLASS_LIMIT)]);
    table.row(["penetration".to_owned(), format!("{} mm", short(run.max_penetration * 1e3, 2))]);
    if run.plies > 1 {
        table.row(["  between plies".to_owned(), format!("{} mm", short(run.max_ply_penetration * 1e3, 2))]);
    }
    table.row(["Newton unconverged".to_owned(), grouped(run.newton.unconverged)]);
    let assumed: Vec<&str> = summary["assumed"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    table.row(["assumed parameters".to_owned(), assumed.len().to_string()]);
    let pointers: String = assumed.iter().map(|pointer| format!("    {pointer}\n")).collect();
    format!("\ntrust\n{}{pointers}", indent(&table.to_string()))
}

fn cost(case: &Case, run: &Run, summary: &Value) -> String {
    let element_steps = run.elements as u64 * run.steps;
    let rate = element_steps as f64 / run.loop_seconds / 1e6;
    let mut table = Table::plain(&[Align::Left, Align::Left]);
    let courant = case.solver.courant;
    let step = format!("{}, {courant} of the critical step, set by: {}", us(run.time_step), run.step_set_by);
    table.row(["time step", step.as_str()]);
    let done = format!(
        "{} elements × {} steps = {} element-steps",
        grouped(run.elements as u64),
        grouped(run.steps),
        grouped(element_steps)
    );
    table.row(["work", done.as_str()]);
    let share = 100.0 * run.element_steps_computed as f64 / element_steps.max(1) as f64;
    let computed = match run.planes {
        MirrorPlanes::NONE => format!("{} % of them", fixed(share, 1)),
        planes => format!("{} % of them: {}", fixed(share, 1), symmetry(planes)),
    };
    table.row(["computed", computed.as_str()]);
    let off = run.skips.switched_off();
    if !off.is_empty() {
        table.row(["not skipped", off.join(", ").as_str()]);
    }
    let wall = summary["wall_s"].as_f64().unwrap_or(0.0);
    let time = format!("{wall:.2} s, of which the loop {:.2} s: {rate:.1} M element-steps/s", run.loop_seconds);
    table.row(["wall time", time.as_str()]);
    let threads = if run.threads == 1 { "1 thread".to_owned() } else { format!("{} threads", run.threads) };
    let what = run.adapter.clone().unwrap_or(threads);
    table.row(["on", format!("{}, {what}, {}", run.backend, run.precision).as_str()]);
    format!("\ncost\n{}", indent(&table.to_string()))
}

fn expectations(summary: &Value) -> String {
    let checks: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    if checks.is_empty() {
        return String::new();
    }
    let mut table = Table::plain(&[Align::Left; 6]);
    for check in checks {
        let pass = if check["pass"] == true { "pass" } else { "FAIL" };
        let got = format!("got {}", got(check));
        let source = check["source"].as_str().unwrap_or_default().to_owned();
        table.row([pass.to_owned(), quantity(check), expected(check), got, source, note(check)]);
    }
    format!("\nexpected\n{}", indent(&table.to_string()))
}

/// One line about an expectation that does not hold.
pub(crate) fn broken(check: &Value) -> String {
    let line = format!("{}: expected {}, got {} {}", quantity(check), expected(check), got(check), note(check));
    line.trim_end().to_owned()
}

fn indent(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}
