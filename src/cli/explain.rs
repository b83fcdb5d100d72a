//! `ripstop explain`: meaning of an exit code or a warning, and what to do.

use clap::Args;
use ripstop::output::warnings;

use super::failure::CommandFailure;
use super::terminal::{self, Align, TextTable};

/// `ripstop explain`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop explain
  ripstop explain W3
  ripstop explain 130")]
pub(crate) struct ExplainArguments {
    /// Exit code (0, 1, 2, 3, 130), or code or name of a warning (W1, energy) [default: all, in a list]
    #[arg(value_name = "EXIT|WARNING")]
    code: Option<String>,
}

/// Every exit code: number, name in a few words, meaning, advice.
const EXITS: [[&str; 4]; 5] = [
    [
        "0",
        "done",
        "The command did what was asked; of a run, every expectation of the case holds. Warnings do not change the code.",
        "Nothing. `summary.json` lists the warnings.",
    ],
    [
        "1",
        "an expectation failed or the run became unstable",
        "An `expect` of the case does not hold, a row of `verify` fails, or a run made numbers that cannot be: not finite, or energy \
         that was never put in. The message says which, with step, kernel and place. Results up to there are written.",
        "Expectation: compare what was expected with what was got. Unstable: lower /solver/courant; if that does not \
         help, something in the case is extreme, and the place in the message shows where to look.",
    ],
    [
        "2",
        "bad input or usage",
        "The command line, the case or one of its files cannot be used, or results cannot be written. Nothing was computed, \
         or nothing could be kept.",
        "Do what the `help:` line of the message says. `ripstop check CASE` shows every field, `ripstop schema` every key.",
    ],
    [
        "3",
        "no device for what was asked, or one that failed",
        "No graphics adapter suits, the case does not fit its memory, or the device was lost on the way; then results up \
         to there are written.",
        "Take --backend cpu. `ripstop info CASE` lists adapters and what the case needs.",
    ],
    [
        "130",
        "interrupted",
        "Ctrl-C, or a request to terminate, ended the command. After the first one results up to there are written.",
        "Run it again; an interrupted result is marked `interrupted` in `summary.json`.",
    ],
];

/// Explains one code, or lists all.
pub(crate) fn explain(arguments: &ExplainArguments) -> Result<(), CommandFailure> {
    let Some(code) = &arguments.code else { return terminal::print(&list()) };
    if let Some([_, name, means, help]) = EXITS.iter().find(|exit| exit[0] == code) {
        let title = terminal::heading(&format!("exit code {code}: {name}"));
        return terminal::print(&entries(title, &[("means", means), ("to do", help)]));
    }
    let is_it = |word: &str| word.eq_ignore_ascii_case(code);
    if let Some(kind) = warnings::KINDS.iter().find(|kind| is_it(kind.code) || is_it(kind.name)) {
        let title = format!("{} {}", terminal::caution(kind.code), terminal::heading(kind.name));
        let parts = [("measured", kind.measured), ("given", kind.given), ("means", kind.means), ("to do", kind.help)];
        return terminal::print(&entries(title, &parts));
    }
    let codes = EXITS.iter().map(|exit| exit[0]).chain(warnings::KINDS.iter().map(|kind| kind.code));
    let codes: Vec<&str> = codes.collect();
    let failure = CommandFailure::expected("no such code", codes.join(", "), code);
    Err(failure.help("`ripstop explain` lists what they mean"))
}

fn list() -> String {
    let mut exits = TextTable::plain(&[Align::Right, Align::Left]);
    EXITS.iter().for_each(|exit| exits.row([exit[0], exit[1]]));
    let mut kinds = TextTable::plain(&[Align::Left, Align::Left, Align::Left]);
    let longest = warnings::KINDS.iter().map(|kind| kind.code.len() + kind.name.len()).max().unwrap_or(0);
    for kind in &warnings::KINDS {
        let (mut code, mut name) = (terminal::caution(kind.code), kind.name);
        for line in terminal::wrapped(kind.measured, longest + 6) {
            kinds.row([std::mem::take(&mut code), std::mem::take(&mut name).to_owned(), line]);
        }
    }
    let [exits, kinds] = [exits, kinds].map(|table| terminal::indent(&table.to_string()));
    let [first, second] = ["exit codes", "warnings"].map(terminal::heading);
    format!("{first}\n{exits}\n{second}\n{kinds}\n`ripstop explain CODE` says what one means and what to do.\n")
}

/// A title and entries below it, in paragraphs as wide as the screen.
fn entries(title: String, parts: &[(&str, &str)]) -> String {
    let indent = "  ".len() + parts.iter().map(|(name, _)| name.len()).max().unwrap_or(0) + "  ".len();
    let mut lines = vec![title];
    for (name, text) in parts {
        let mut name = *name;
        for line in terminal::wrapped(text, indent) {
            lines.push(format!("  {:1$}{line}", std::mem::take(&mut name), indent - 2));
        }
    }
    lines.join("\n") + "\n"
}
