//! `ripstop compare`: CPU and GPU from the same state, kernel by kernel.

use ripstop::case;
use ripstop::study::compare::{self, BackendDifference, Comparison, TOLERANCES};
use serde_json::{Value, json};

use super::failure::CommandFailure;
use super::study_arguments::CompareArguments;
use super::table::{Align, TextTable};
use super::{backend, interrupt, screen};

/// Follows a case on both backends and prints what differs; exit code 1 if anything differs more than it may.
pub(crate) fn compare(arguments: &CompareArguments) -> Result<(), CommandFailure> {
    let interrupted = interrupt::watch()?;
    let case = case::read(&arguments.case, &arguments.sets)?;
    let device = backend::named(arguments.adapter.as_deref())?;
    let found = compare::compare(&case, &device, arguments.steps, arguments.every, &interrupted)
        .map_err(|e| CommandFailure::start(&case.path.display().to_string(), &e))?;
    if arguments.json {
        screen::print(&format!("{:#}\n", to_json(&found, device.name())))?;
    } else {
        screen::print(&text(&found, device.name()))?;
    }
    if interrupted.load(std::sync::atomic::Ordering::Relaxed) {
        return Err(CommandFailure::interrupted("interrupted; steps after this were not compared"));
    }
    match &found.first {
        Some(d) => Err(CommandFailure::check(format!("error: the backends differ\n  {}", first(d)))),
        None => Ok(()),
    }
}

fn first(d: &BackendDifference) -> String {
    let line = &TOLERANCES[d.what];
    let [ply, row, column] = d.place;
    format!(
        "first: step {}, {}, {}, ply {ply} row {row} column {column} component {}: cpu {:e}, gpu {:e}\n  \
         {:.1e} of the scale, allowed {:.1e}: {} roundings, each grown {:.0} times ({}); scale: {}",
        d.step,
        line.kernel,
        line.quantity,
        d.component,
        d.cpu,
        d.gpu,
        d.relative,
        d.limit,
        line.roundings,
        line.condition,
        line.reason,
        line.scale
    )
}

fn text(found: &Comparison, adapter: &str) -> String {
    use Align::{Left, Right};
    let mut table = TextTable::new(&[
        ("", Left),
        ("kernel", Left),
        ("quantity", Left),
        ("gpu - cpu f32", Right),
        ("allowed", Right),
        ("cpu f32 - f64", Right),
        ("largest at step, ply, row, column", Right),
    ]);
    for (i, line) in TOLERANCES.iter().enumerate() {
        let Some(worst) = &found.worst[i] else { continue };
        let [ply, row, column] = worst.place;
        let mark = if worst.is_over() { "FAIL" } else { "pass" };
        let number = |x: f64| if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") };
        let place =
            if worst.relative == 0.0 { String::new() } else { format!("{}, {ply}, {row}, {column}", worst.step) };
        table.row([
            mark,
            line.kernel,
            line.quantity,
            &number(worst.relative),
            &number(worst.limit),
            &number(found.rounding[i]),
            &place,
        ]);
    }
    format!(
        "{table}\ndifferences over the scale of each quantity; {} of {} steps compared, {} numbers, on {adapter}\n",
        found.compared, found.steps, found.numbers
    )
}

fn to_json(found: &Comparison, adapter: &str) -> Value {
    let one = |d: &BackendDifference| {
        let line = &TOLERANCES[d.what];
        json!({
            "step": d.step, "kernel": line.kernel, "buffer": line.quantity,
            "ply": d.place[0], "row": d.place[1], "column": d.place[2], "component": d.component,
            "cpu": d.cpu, "gpu": d.gpu, "cpu_f64": d.wide,
            "difference": d.relative, "tolerance": d.limit, "pass": !d.is_over(),
            "roundings": line.roundings, "condition": line.condition, "scale": line.scale, "reason": line.reason,
        })
    };
    json!({
        "pass": found.first.is_none(),
        "adapter": adapter,
        "steps": found.steps,
        "compared": found.compared,
        "numbers": found.numbers,
        "first": found.first.as_ref().map(one),
        "largest": found.worst.iter().flatten().map(one).collect::<Vec<_>>(),
        "single_precision": TOLERANCES.iter().zip(&found.rounding).map(|(line, x)| json!({
            "kernel": line.kernel, "buffer": line.quantity, "difference": x,
        })).collect::<Vec<_>>(),
    })
}
