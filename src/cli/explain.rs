//! `ripstop explain`: what an exit code or a warning means and what to do.

use ripstop::markdown;
use ripstop::output::warnings::{self, WarningKind};

use super::arguments::ExplainArguments;
use super::failure::{CommandFailure, EXITS, Exit};
use super::table::{Align, TextTable};
use super::{paint, screen};

/// Explains one code, or lists all.
pub(crate) fn explain(arguments: &ExplainArguments) -> Result<(), CommandFailure> {
    if arguments.markdown {
        return screen::print(&tables());
    }
    let Some(code) = &arguments.code else { return screen::print(&list()) };
    let exit = EXITS.iter().find(|exit| exit.code.to_string() == *code);
    let same = |word: &str| word.eq_ignore_ascii_case(code);
    let warning = warnings::KINDS.iter().find(|kind| same(kind.code) || same(kind.name));
    match (exit, warning) {
        (Some(exit), _) => screen::print(&of_exit(exit)),
        (_, Some(kind)) => screen::print(&of_warning(kind)),
        (None, None) => Err(CommandFailure::expected("no such code", codes().join(", "), code)
            .help("`ripstop explain` lists what they mean")),
    }
}

/// Every code there is.
fn codes() -> Vec<String> {
    let exits = EXITS.iter().map(|exit| exit.code.to_string());
    exits.chain(warnings::KINDS.iter().map(|kind| kind.code.to_owned())).collect()
}

fn list() -> String {
    let mut exits = TextTable::plain(&[Align::Right, Align::Left]);
    for exit in &EXITS {
        exits.row([exit.code.to_string(), exit.name.to_owned()]);
    }
    let mut kinds = TextTable::plain(&[Align::Left, Align::Left, Align::Left]);
    let longest = warnings::KINDS.iter().map(|kind| kind.code.len() + kind.name.len()).max().unwrap_or(0);
    for kind in &warnings::KINDS {
        let (mut code, mut name) = (paint::caution(kind.code), kind.name);
        for line in screen::wrapped(kind.measured, longest + 6) {
            kinds.row([std::mem::take(&mut code), std::mem::take(&mut name).to_owned(), line]);
        }
    }
    let [exits, kinds] = [exits, kinds].map(|table| screen::indent(&table.to_string()));
    let [first, second] = ["exit codes", "warnings"].map(paint::heading);
    format!("{first}\n{exits}\n{second}\n{kinds}\n`ripstop explain CODE` says what one means and what to do.\n")
}

/// All there is to say about every code, in Markdown.
fn tables() -> String {
    let exits = EXITS.iter().map(|exit| [&exit.code.to_string(), exit.name, exit.means, exit.help].map(str::to_owned));
    let kinds =
        warnings::KINDS.iter().map(|kind| [kind.code, kind.name, kind.measured, kind.given, kind.means, kind.help]);
    format!(
        "## Exit codes\n\n{}\n## Warnings\n\n{}",
        markdown::table(&["code", "what", "means", "to do"], exits.map(Vec::from)),
        markdown::table(&["code", "name", "measured", "given", "means", "to do"], kinds.map(Vec::from))
    )
}

fn of_exit(exit: &Exit) -> String {
    let title = paint::heading(&format!("exit code {}: {}", exit.code, exit.name));
    entries(title, &[("means", exit.means), ("to do", exit.help)])
}

fn of_warning(kind: &WarningKind) -> String {
    let title = format!("{} {}", paint::caution(kind.code), paint::heading(kind.name));
    let parts = [("measured", kind.measured), ("given", kind.given), ("means", kind.means), ("to do", kind.help)];
    entries(title, &parts)
}

/// A title and what there is to say, in paragraphs as wide as the screen.
fn entries(title: String, parts: &[(&str, &str)]) -> String {
    let indent = "  ".len() + parts.iter().map(|(name, _)| name.len()).max().unwrap_or(0) + "  ".len();
    let mut lines = vec![title];
    for (name, text) in parts {
        for (number, line) in screen::wrapped(text, indent).iter().enumerate() {
            let name = if number == 0 { name } else { "" };
            lines.push(format!("  {name:0$}{line}", indent - 2));
        }
    }
    lines.join("\n") + "\n"
}
