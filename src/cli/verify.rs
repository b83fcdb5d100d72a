//! `ripstop verify`: the built-in verification table.

use ripstop::simulation::Options;
use ripstop::verify::{self, Row};
use serde_json::{Value, json};

use super::arguments::VerifyArguments;
use super::failure::Failure;
use super::table::{Align, Table};
use super::{backend, interrupt, screen};

/// Runs the table and prints it; exit code 1 if a row fails.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), Failure> {
    let interrupted = interrupt::watch()?;
    let chosen = backend::choose(&arguments.backend)?;
    chosen.note.iter().for_each(|note| screen::complain(note));
    let options = Options {
        threads: arguments.threads,
        precision: chosen.precision,
        device: chosen.device.as_ref(),
        ..Options::default()
    };
    let rows = verify::run(options, &interrupted, &mut |_| {});
    let failed = rows.iter().filter(|row| !row.pass).count();
    let counts = format!("{} of {} rows pass", rows.len() - failed, rows.len());
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(to_json).collect();
        screen::print(&format!("{:#}\n", json!({ "pass": failed == 0, "rows": rows })))?;
    } else {
        screen::print(&format!("{}\n{counts}\n", table(&rows)))?;
    }
    if interrupted.load(std::sync::atomic::Ordering::Relaxed) {
        return Err(Failure::interrupted("interrupted; rows after this are missing"));
    }
    if failed > 0 {
        return Err(Failure::check(format!("error: verification: {counts}")));
    }
    Ok(())
}

fn table(rows: &[Row]) -> Table {
    use Align::{Left, Right};
    let heads = [("", Left), ("what", Left), ("expected", Right), ("got", Right), ("tolerance", Right)];
    let mut table = Table::new(&heads);
    let mut group = "";
    for row in rows {
        if row.group != group {
            group = row.group;
            table.row(["", ""]);
            table.row(["", group]);
        }
        let mark = if row.pass { "pass" } else { "FAIL" };
        table.row([mark, &row.name, &row.expected, &row.got, &row.tolerance]);
    }
    table
}

fn to_json(row: &Row) -> Value {
    json!({
        "group": row.group,
        "name": row.name,
        "expected": row.expected,
        "got": row.got,
        "tolerance": row.tolerance,
        "source": row.source,
        "pass": row.pass,
    })
}
