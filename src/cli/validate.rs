//! `ripstop validate`: predictions, expected and got.

use std::path::Path;
use std::sync::atomic::Ordering;

use ripstop::case::{self, Case};
use ripstop::output::Folder;
use ripstop::run::Progress;
use ripstop::study::validate::{self, Prediction};
use serde_json::{Value, json};

use super::failure::CommandFailure;
use super::progress::Bar;
use super::study_arguments::ValidateArguments;
use super::table::{Align, TextTable};
use super::{backend, input, interrupt, paint, screen};

/// Computes the table and prints it; exit code 1 if a row fails.
pub(crate) fn validate(arguments: &ValidateArguments) -> Result<(), CommandFailure> {
    let interrupted = interrupt::watch()?;
    let page = arguments.html.as_deref().map(page).transpose()?;
    let cases = arguments.cases.iter().map(|path| stated(path)).collect::<Result<Vec<_>, _>>()?;
    let chosen = backend::choose(&arguments.backend)?;
    chosen.note.iter().for_each(|note| screen::complain(note));
    let bar = Bar::new(!arguments.json && !arguments.markdown);
    let options = chosen.options(arguments.threads);
    let mut progress = |name: &str, at: &Progress| bar.show_named(name, at);
    let rows = match cases.is_empty() {
        true => validate::run(arguments.limits, options, &interrupted, &mut progress),
        false => validate::run_cases(&cases, options, &interrupted, &mut progress),
    };
    bar.clear();
    if interrupted.load(Ordering::Relaxed) {
        return Err(CommandFailure::interrupted("interrupted; a table with rows missing is not shown"));
    }
    let [pass, fail, open] = validate::counts(&rows);
    let unexplained = validate::unexplained(&rows);
    let known = match fail - unexplained {
        0 => String::new(),
        known => format!(", {known} differ for a known reason"),
    };
    let counts = format!("{pass} of {} judged rows pass{known}, {open} are not judged", pass + fail);
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(Prediction::to_json).collect();
        screen::print(&format!("{:#}\n", json!({ "pass": unexplained == 0, "paper": validate::PAPER, "rows": rows })))?;
    } else if arguments.markdown {
        screen::print(&validate::markdown(&rows))?;
    } else {
        screen::print(&format!("{}\n{counts}\n", table(&rows)))?;
    }
    if let Some((folder, name)) = &page {
        let machine =
            chosen.device.as_ref().map_or_else(|| "on the CPU".to_owned(), |device| format!("on {}", device.name()));
        folder.put(&[(name, validate::html(&rows, &machine))], &[])?;
    }
    if unexplained > 0 { Err(CommandFailure::check(format!("error: validation: {counts}"))) } else { Ok(()) }
}

/// A case that states something published.
fn stated(path: &Path) -> Result<Case, CommandFailure> {
    let case = case::read(path, &[])?;
    if validate::has_published(&case) {
        return Ok(case);
    }
    let place = format!("{}: /expect", path.display());
    let expected = "a statement whose source begins with \"paper\", \"published\" or \"closed form\"";
    Err(CommandFailure::expected(place, expected, "none").help("`ripstop run` checks all statements of a case"))
}

/// The folder and the name of the page; tried before anything is computed.
fn page(path: &Path) -> Result<(Folder, &str), CommandFailure> {
    let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(|| {
        let failure = CommandFailure::expected("--html", "a file", path.display());
        failure.help("for example --html out/validation.html")
    })?;
    Ok((Folder::share(input::folder(path), &[name], &[])?, name))
}

fn table(rows: &[Prediction]) -> String {
    use Align::{Left, Right};
    let heads =
        [("", Left), ("quantity", Left), ("expected", Right), ("got", Right), ("difference", Right), ("source", Left)];
    let mut table = TextTable::new(&heads);
    let mut group = "";
    for row in rows {
        if row.group != group {
            group = &row.group;
            table.group(group);
        }
        let mark = row.pass.map_or_else(String::new, paint::mark);
        table.row([
            &mark,
            &row.name,
            &row.expected_text(),
            &row.got_text(),
            &row.difference_text(),
            &row.source_text(),
        ]);
    }
    table.to_string()
}
