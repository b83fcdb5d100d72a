//! `ripstop verify`: the shipped cases on this machine.

use std::sync::atomic::Ordering;

use ripstop::output::expectation::{expected, got, quantity};
use ripstop::run::Progress;
use ripstop::study::verify::{self, CASES};
use serde_json::{Value, json};

use super::failure::CommandFailure;
use super::progress::Bar;
use super::study_arguments::VerifyArguments;
use super::table::{Align, TextTable};
use super::{backend, interrupt, paint, screen};

/// Runs every case and prints a line for each expectation; exit code 1 if one fails.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), CommandFailure> {
    let interrupted = interrupt::watch()?;
    let chosen = backend::choose(&arguments.backend)?;
    chosen.note.iter().for_each(|note| screen::complain(note));
    let bar = Bar::new(!arguments.json);
    let mut rows: Vec<Value> = Vec::new();
    for case in CASES {
        let mut show = |at: &Progress| bar.show_named(case.0, at);
        let checks = verify::check(*case, chosen.options(arguments.threads), &interrupted, &mut show);
        let checks = checks.unwrap_or_else(|why| {
            vec![json!({"quantity": "outcome", "expected": "a result", "got": why, "pass": false})]
        });
        rows.extend(checks.into_iter().map(|mut check| {
            check["name"] = case.0.into();
            check
        }));
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
    }
    bar.clear();
    let failed = rows.iter().filter(|row| row["pass"] != true).count();
    let counts = format!("{} of {} rows pass", rows.len() - failed, rows.len());
    match arguments.json {
        true => screen::print(&format!("{:#}\n", json!({ "pass": failed == 0, "rows": rows })))?,
        false => screen::print(&format!("{}\n{counts}\n", table(&rows)))?,
    }
    if interrupted.load(Ordering::Relaxed) {
        return Err(CommandFailure::interrupted("interrupted; rows after this are missing"));
    }
    if failed > 0 { Err(CommandFailure::check(format!("error: verification: {counts}"))) } else { Ok(()) }
}

fn table(rows: &[Value]) -> TextTable {
    use Align::{Left, Right};
    let mut table =
        TextTable::new(&[("", Left), ("case", Left), ("quantity", Left), ("expected", Right), ("got", Right)]);
    for row in rows {
        let name = row["name"].as_str().unwrap_or_default().to_owned();
        table.row([paint::mark(row["pass"] == true), name, quantity(row), expected(row), got(row)]);
    }
    table
}
