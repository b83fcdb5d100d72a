//! The built-in verification table: closed forms and measured facts against what this build computes.
//!
//! Three parts: the unit cell against tabulated values, every scene of `cases/verify` against its `expect` block,
//! and stability of hard scenes. The same scenes are run by the tests.

pub(crate) mod scenes;
mod stability;
pub mod stress;
pub(crate) mod unit_cell;

use std::sync::atomic::AtomicBool;

use serde::Serialize;

use crate::case::Case;
use crate::markdown::table;
use crate::run::{self, Options, Run};

/// One line of the table.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Check {
    /// Part of the table.
    pub group: &'static str,
    /// What is checked.
    pub name: String,
    /// Expected, as text.
    pub expected: String,
    /// Found, as text.
    pub got: String,
    /// Allowed difference, as text.
    pub tolerance: String,
    /// Where the expectation comes from.
    pub source: String,
    /// Whether it holds.
    pub pass: bool,
}

impl Check {
    /// A row without which nothing can be checked.
    fn failed(group: &'static str, name: &str, expected: &str, got: String) -> Self {
        Self { group, name: name.to_owned(), expected: expected.to_owned(), got, ..Self::default() }
    }
}

/// Runs the whole table, handing over each row as it is known. Rows after an interrupt are left out.
pub fn run(options: Options<'_>, interrupt: &AtomicBool, each: &mut dyn FnMut(&Check)) -> Vec<Check> {
    let mut rows = Vec::new();
    let mut keep = |row: Check| {
        each(&row);
        rows.push(row);
    };
    unit_cell::rows(&mut keep);
    scenes::rows(options, interrupt, &mut keep);
    stability::rows(options, interrupt, &mut keep);
    rows
}

/// The table in Markdown. Numbers found that are rounding and nothing else are not shown: they say no more than the row's bound.
pub fn markdown(rows: &[Check]) -> String {
    let cells = |row: &Check| {
        let verdict = if row.pass { "pass" } else { "FAIL" };
        let is_rounding = row.got.parse().is_ok_and(|got: f64| got != 0.0 && got.abs() < ROUNDING);
        let got = if is_rounding { "rounding" } else { &row.got };
        [row.group, &row.name, &row.expected, got, &row.tolerance, verdict, &row.source].map(str::to_owned).to_vec()
    };
    table(&["of", "what", "expected", "got", "tolerance", "", "source"], rows.iter().map(cells))
}

/// A number that is not zero and smaller than this is rounding.
const ROUNDING: f64 = 1e-9;

/// A scene's run, or a failed row that says why there is none.
fn simulate(group: &'static str, case: &Case, options: Options<'_>, interrupt: &AtomicBool) -> Result<Run, Box<Check>> {
    let failed = |got: String| Box::new(Check::failed(group, &case.title, "a finished run", got));
    let run = run::run(case, options, interrupt, &mut ()).map_err(|error| failed(error.to_string()))?;
    match &run.divergence {
        Some(t) => Err(failed(format!("unstable at step {} in {}: {}", t.step, t.kernel, t.quantity))),
        None => Ok(run),
    }
}
