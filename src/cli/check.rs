//! `ripstop check`: everything about a case that can be known without running it.

use std::fmt::Write;
use std::path::Path;

use ripstop::case::{self, Case};
use ripstop::output::checks;
use ripstop::output::number::{bytes, grouped, us};
use ripstop::output::symmetry;
use ripstop::run::{Sample, Simulation, Skips};

use super::arguments::CheckArguments;
use super::failure::CommandFailure;
use super::table::{Align, TextTable};
use super::{input, paint, result, screen};

/// Reports every case; fails if any of them is refused.
pub(crate) fn check(arguments: &CheckArguments) -> Result<(), CommandFailure> {
    let mut failures = Vec::new();
    for (index, path) in arguments.cases.iter().enumerate() {
        match report(path, &arguments.sets) {
            Ok(report) => {
                let gap = if index > 0 { "\n" } else { "" };
                screen::print(&format!("{gap}{}\n{report}", path.display()))?;
            }
            Err(failure) => failures.push(failure),
        }
    }
    failures.into_iter().reduce(CommandFailure::and).map_or(Ok(()), Err)
}

fn report(path: &Path, sets: &[String]) -> Result<String, CommandFailure> {
    let case = input::read(path, sets)?;
    let simulation = Simulation::<f64>::with_skips(&case, Skips::default())
        .map_err(|error| CommandFailure::model(&path.display().to_string(), &error))?;
    let mut report = case::report(&case);
    // Writing to a string cannot fail.
    write!(report, "\n{}\n{}", paint::heading("the run"), the_run(&case, &simulation))
        .map_err(|error| CommandFailure::input(error.to_string()))?;
    report += &result::part("notes", &case.notes.join("\n"));
    report += &result::part("warnings", &result::warnings(&checks::case_warnings(&case)));
    Ok(report)
}

/// What follows for the run.
fn the_run(case: &Case, simulation: &Simulation<f64>) -> TextTable {
    let (model, state) = (&simulation.model, &simulation.state);
    let steps = (case.solver.end_time / model.dt).ceil() as u64 + 1;
    let rows = (case.solver.end_time / case.output.history_interval).ceil() + 1.0;
    let numbers = (state.nodes.data.len() + state.elements.data.len()) * size_of::<f64>();
    let memory = numbers as f64 + rows * size_of::<Sample>() as f64;
    let elements = model.whole_elements() as u64;
    let mut table = TextTable::plain(&[Align::Left, Align::Left]);
    let critical = format!("{}, set by: {}", us(model.bound.critical_step), model.bound.set_by);
    table.row(["  critical time step", critical.as_str()]);
    table.row(["  time step", us(model.dt).as_str()]);
    table.row(["  steps", format!("{} at most", grouped(steps)).as_str()]);
    table.row(["  elements", grouped(elements).as_str()]);
    table.row(["  element-steps", format!("{} at most", grouped(elements.saturating_mul(steps))).as_str()]);
    table.row(["  symmetry", symmetry(model.planes).as_str()]);
    table.row(["  memory", format!("{} of state and history", bytes(memory)).as_str()]);
    table
}
