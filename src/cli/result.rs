//! The result of a run as people read it: verdict first, then where the energy went, how far the numbers can be
//! trusted, what they cost, what was expected, and where the files are.

use std::path::Path;

use ripstop::case::Case;
use ripstop::model::MirrorPlanes;
use ripstop::outcome::Outcome;
use ripstop::output;
use ripstop::simulation::Run;
use ripstop::step::Trouble;
use ripstop::warnings::{self, Warning};
use serde_json::Value;

use super::number::{fixed, fraction, grouped, short, us};
use super::table::{Align, Table};
use super::{paint, screen};

/// The whole text. `files`: folder and names, where they were written.
pub(crate) fn text(case: &Case, run: &Run, summary: &Value, files: Option<(&Path, &[&str])>) -> String {
    let verdict = paint::heading(&verdict(case, run));
    let mut parts = vec![case.title.clone(), format!("\n{verdict}"), energy(run), trust(run, summary)];
    parts.push(cost(case, run, summary));
    parts.push(part("warnings", &warnings(&warnings::of_run(case, run))));
    parts.push(expectations(summary));
    if let Some((folder, names)) = files {
        let names = screen::wrapped(&names.join(", "), 2);
        parts.push(format!(
            "\n{}  {}\n{}",
            paint::heading("files"),
            folder.display(),
            screen::indent(&names.join("\n"))
        ));
    }
    parts.retain(|part| !part.is_empty());
    parts.iter().map(|part| format!("{}\n", part.trim_end())).collect()
}

/// Time reached.
pub(crate) fn reached(run: &Run) -> String {
    us(run.history.last().map_or(0.0, |row| row.time))
}

/// Where a run went wrong.
pub(crate) fn place(trouble: &Trouble) -> String {
    let [ply, row, column] = trouble.place;
    format!("step {}, kernel {}, ply {ply}, row {row}, column {column}", trouble.step, trouble.kernel)
}

/// A part of the text under its title; nothing where there is nothing to say.
pub(crate) fn part(title: &str, text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("\n{}\n{}", paint::heading(title), screen::indent(text)) }
}

/// One line each, with its code.
pub(crate) fn warnings(warnings: &[Warning]) -> String {
    let mut table = Table::plain(&[Align::Left, Align::Left]);
    for warning in warnings {
        table.row([paint::caution(warning.kind.code), warning.message.clone()]);
    }
    match warnings.first() {
        Some(first) => format!("{table}`ripstop explain {}` says what it means and what to do\n", first.kind.code),
        None => String::new(),
    }
}

fn verdict(case: &Case, run: &Run) -> String {
    if let Some(trouble) = &run.trouble {
        return format!("UNSTABLE at {}: {}", place(trouble), trouble.quantity);
    }
    let velocity = output::residual_velocity(case, run).unwrap_or(0.0);
    let stop = run.stop_time.map_or(String::new(), |time| format!(" at {}", us_rounded(time)));
    let deflection = run.history.iter().map(|row| row.deflection).fold(0.0, f64::max) * 1e3;
    let deflected = format!("deflected {} mm at most", short(deflection, 4));
    if run.interrupted {
        return format!("INTERRUPTED at {}, {deflected}", reached(run));
    }
    if !output::flies_freely(case) {
        return format!("DONE: {} computed, {deflected}", reached(run));
    }
    let struck = case.projectile.as_ref().map_or(0.0, |p| p.velocity);
    let through = run.history.last().map_or(0, |row| row.perforated_plies);
    let torn = if run.plies > 1 { format!("{through} of {} plies perforated, ", run.plies) } else { String::new() };
    let struck = format!("{torn}struck at {} m/s", short(struck, 4));
    match run.outcome {
        Outcome::Perforated => format!("PERFORATED: leaves at {} m/s, {struck}", short(velocity, 4)),
        Outcome::Stopped => format!("STOPPED{stop}, {struck}, {deflected}"),
        Outcome::Rebounded => {
            format!("REBOUNDED: turned{stop}, flies at {} m/s, {struck}, {deflected}", short(velocity, 4))
        }
        Outcome::Running => format!(
            "STILL RUNNING at {}: {} m/s left, {struck}, {deflected}; raise /solver/end_time_us for a verdict",
            reached(run),
            short(velocity, 4)
        ),
    }
}

fn us_rounded(time: f64) -> String {
    format!("{:.1} µs", time * 1e6)
}

/// What the fabric was given and where it is at the end.
fn energy(run: &Run) -> String {
    let (Some(first), Some(last)) = (run.history.first(), run.history.last()) else { return String::new() };
    let (start, end) = (&first.balance, &last.balance);
    let absorbed = output::absorbed_energy(run);
    let given = absorbed + end.external;
    // The first row stands after the first contact: what the fabric moved with before is what balances it.
    let kinetic =
        start.kinetic + start.contact + start.friction + start.projectile - start.external - run.impact_energy;
    let mut rows = vec![
        ("fabric, kinetic", end.kinetic - kinetic),
        ("fabric, internal", end.internal - start.internal),
        ("hourglass", end.hourglass - start.hourglass),
        ("contact", end.contact),
        ("friction", end.friction),
        ("yarn failure", end.failure),
    ];
    let found: f64 = rows.iter().map(|row| row.1).sum();
    rows.push(("unaccounted", given - found));
    let scale = rows.iter().map(|row| row.1.abs()).fold(given.abs(), f64::max);
    if scale <= 0.0 || !scale.is_finite() {
        return String::new();
    }
    let (factor, unit) = match scale {
        0.1.. => (1.0, "J"),
        1e-4.. => (1e3, "mJ"),
        _ => (1e6, "µJ"),
    };
    let decimals = (4.0 - (factor * scale).log10().floor()).clamp(0.0, 4.0) as usize;
    let joule = |energy: f64| format!("{} {unit}", fixed(factor * energy, decimals));
    let mut table = Table::plain(&[Align::Left, Align::Right, Align::Right]);
    if run.impact_energy > 0.0 && end.external == 0.0 {
        table.row(["lost by the projectile".to_owned(), joule(absorbed), format!("of {}", joule(run.impact_energy))]);
    } else if given != 0.0 {
        table.row(["given to the fabric".to_owned(), joule(given)]);
    } else {
        table.row(["change"]);
    }
    for (name, energy) in rows {
        let share = 100.0 * energy / given;
        let share = if given > 1e-9 * scale { format!("{} %", fixed(share, 1)) } else { String::new() };
        table.row([format!("  {name}"), joule(energy), share]);
    }
    part("energy", &table.to_string())
}

fn trust(run: &Run, summary: &Value) -> String {
    let mut table = Table::plain(&[Align::Left, Align::Left]);
    table.row(["energy error".to_owned(), fraction(run.energy_error)]);
    table.row(["momentum error".to_owned(), fraction(run.momentum_error)]);
    table.row(["hourglass / internal".to_owned(), fraction(run.hourglass_fraction)]);
    table.row(["penetration".to_owned(), format!("{} mm", short(run.max_penetration * 1e3, 2))]);
    if run.plies > 1 {
        table.row(["  between plies".to_owned(), format!("{} mm", short(run.max_ply_penetration * 1e3, 2))]);
    }
    table.row(["Newton unconverged".to_owned(), grouped(run.newton.unconverged)]);
    let assumed: Vec<&str> = summary["assumed"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    table.row(["assumed parameters".to_owned(), assumed.len().to_string()]);
    let pointers: String = screen::wrapped(&assumed.join(", "), 4).iter().map(|line| format!("  {line}\n")).collect();
    part("trust", &format!("{table}{pointers}"))
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
    part("cost", &table.to_string())
}

/// What mirror planes a scene is cut at, if it is.
pub(crate) fn symmetry(planes: MirrorPlanes) -> String {
    let names = planes.names();
    let part = match names.len() {
        0 => return "none: the whole scene is computed".to_owned(),
        1 => "a half",
        _ => "a quarter",
    };
    format!("{part}, mirrored at {} = 0", names.join(" = 0 and "))
}

fn expectations(summary: &Value) -> String {
    let checks: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    if checks.is_empty() {
        return String::new();
    }
    let mut table = Table::plain(&[Align::Left; 6]);
    for check in checks {
        let pass = paint::mark(check["pass"] == true);
        let got = format!("got {}", got(check));
        let source = check["source"].as_str().unwrap_or_default().to_owned();
        table.row([pass, quantity(check), expected(check), got, source, note(check)]);
    }
    part("expected", &table.to_string())
}

/// One line about an expectation that does not hold.
pub(crate) fn broken(check: &Value) -> String {
    let line = format!("{}: expected {}, got {} {}", quantity(check), expected(check), got(check), note(check));
    line.trim_end().to_owned()
}

fn quantity(check: &Value) -> String {
    let name = check["quantity"].as_str().unwrap_or_default();
    if let Some(at) = check["at_us"].as_f64() {
        return format!("{name} at {} µs", short(at, 7));
    }
    match (check["between_us"][0].as_f64(), check["between_us"][1].as_f64()) {
        (Some(from), Some(to)) => format!("{name} between {} and {} µs", short(from, 7), short(to, 7)),
        _ => name.to_owned(),
    }
}

fn expected(check: &Value) -> String {
    let expected = &check["expected"];
    let number = |key: &str| expected[key].as_f64();
    if let Some(word) = expected.as_str() {
        return word.to_owned();
    }
    match (number("value"), number("tolerance"), number("min"), number("max")) {
        (Some(value), Some(tolerance), ..) => format!("{value} ± {}", short(tolerance, 6)),
        (.., Some(min), Some(max)) => format!("{min} to {max}"),
        (.., Some(min), None) => format!("≥ {min}"),
        (.., None, Some(max)) => format!("≤ {max}"),
        _ => "-".to_owned(),
    }
}

fn got(check: &Value) -> String {
    match &check["got"] {
        Value::Number(number) => number.as_f64().map_or_else(String::new, |number| short(number, 6)),
        Value::String(word) => word.clone(),
        Value::Null => "nothing".to_owned(),
        other => other.to_string(),
    }
}

fn note(check: &Value) -> String {
    check["note"].as_str().map_or_else(String::new, |note| format!("({note})"))
}
