//! `ripstop verify`: the shipped cases on this machine.

use std::sync::atomic::Ordering;

use clap::{Args, builder::RangedU64ValueParser};
use ripstop::output::expect::{expected, got, quantity};
use ripstop::run::Progress;
use ripstop::study::verify::{self, CASES};
use serde_json::{Value, json};

use super::arguments::BackendArguments;
use super::backend;
use super::failure::CommandFailure;
use super::terminal::{self, Align, Bar, TextTable};

/// `ripstop verify`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop verify
  ripstop verify --backend gpu --json | jq '.rows[] | select(.pass | not)'

The cases are those of cases/verify (closed forms, an independent prototype) and cases/stress (hard scenes), built in. \
The exit code is 1 if an expectation fails.")]
pub(crate) struct VerifyArguments {
    #[command(flatten)]
    backend: BackendArguments,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    threads: Option<usize>,
    /// Print JSON instead of the table
    #[arg(long)]
    json: bool,
}

/// Runs every case and prints a line for each expectation; exit code 1 if one fails.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), CommandFailure> {
    let interrupted = terminal::watch_interrupts()?;
    let chosen = backend::choose(&arguments.backend)?;
    chosen.note.iter().for_each(|note| terminal::complain(note));
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
        true => terminal::print(&format!("{:#}\n", json!({ "pass": failed == 0, "rows": rows })))?,
        false => terminal::print(&format!("{}\n{counts}\n", table(&rows)))?,
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
        table.row([terminal::mark(row["pass"] == true), name, quantity(row), expected(row), got(row)]);
    }
    table
}
