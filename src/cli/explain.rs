//! `ripstop explain`: meaning of an exit code or a warning, and what to do.

use clap::Args;
use ripstop::output::warnings;

use super::failure::{CHECK, CommandFailure, DEVICE, INPUT, INTERRUPTED};
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

/// Meaning of an exit code.
struct Exit {
    code: u8,
    /// Name in a few words.
    name: &'static str,
    means: &'static str,
    /// Advice.
    help: &'static str,
}

/// Every exit code.
static EXITS: [Exit; 5] = [
    Exit {
        code: 0,
        name: "done",
        means: "The command did what was asked; of a run, every expectation of the case holds. Warnings do not change the code.",
        help: "Nothing. `summary.json` lists the warnings.",
    },
    Exit {
        code: CHECK,
        name: "an expectation failed or the run became unstable",
        means: "An `expect` of the case does not hold, a row of `verify` fails, or a run made numbers that cannot be: not finite, or \
                energy that was never put in. The message says which, with step, kernel and place. Results up to there are written.",
        help: "Expectation: compare what was expected with what was got. Unstable: lower /solver/courant; if that does not \
               help, something in the case is extreme, and the place in the message shows where to look.",
    },
    Exit {
        code: INPUT,
        name: "bad input or usage",
        means: "The command line, the case or one of its files cannot be used, or results cannot be written. Nothing was computed, \
                or nothing could be kept.",
        help: "Do what the `help:` line of the message says. `ripstop check CASE` shows every field, `ripstop schema` every key.",
    },
    Exit {
        code: DEVICE,
        name: "no device for what was asked, or one that failed",
        means: "No graphics adapter suits, the case does not fit its memory, or the device was lost on the way; then results up \
                to there are written.",
        help: "Take --backend cpu. `ripstop info CASE` lists adapters and what the case needs.",
    },
    Exit {
        code: INTERRUPTED,
        name: "interrupted",
        means: "Ctrl-C, or a request to terminate, ended the command. After the first one results up to there are written.",
        help: "Run it again; an interrupted result is marked `interrupted` in `summary.json`.",
    },
];

/// Explains one code, or lists all.
pub(crate) fn explain(arguments: &ExplainArguments) -> Result<(), CommandFailure> {
    let Some(code) = &arguments.code else { return terminal::print(&list()) };
    if let Some(exit) = EXITS.iter().find(|exit| exit.code.to_string() == *code) {
        let title = terminal::heading(&format!("exit code {}: {}", exit.code, exit.name));
        return terminal::print(&entries(title, &[("means", exit.means), ("to do", exit.help)]));
    }
    let is_it = |word: &str| word.eq_ignore_ascii_case(code);
    if let Some(kind) = warnings::KINDS.iter().find(|kind| is_it(kind.code) || is_it(kind.name)) {
        let title = format!("{} {}", terminal::caution(kind.code), terminal::heading(kind.name));
        let parts = [("measured", kind.measured), ("given", kind.given), ("means", kind.means), ("to do", kind.help)];
        return terminal::print(&entries(title, &parts));
    }
    let exits = EXITS.iter().map(|exit| exit.code.to_string());
    let codes: Vec<String> = exits.chain(warnings::KINDS.iter().map(|kind| kind.code.to_owned())).collect();
    let failure = CommandFailure::expected("no such code", codes.join(", "), code);
    Err(failure.help("`ripstop explain` lists what they mean"))
}

fn list() -> String {
    let mut exits = TextTable::plain(&[Align::Right, Align::Left]);
    EXITS.iter().for_each(|exit| exits.row([exit.code.to_string(), exit.name.to_owned()]));
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
