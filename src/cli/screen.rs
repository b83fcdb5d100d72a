//! Standard output and error. A reader that has gone away (`| head`) is no error.

use std::io::{self, Write};

use console::Term;

use super::failure::CommandFailure;
use super::paint;

/// Lines of text are no wider than this, however wide the screen.
const WIDEST: usize = 80;

/// Writes to standard output.
pub(crate) fn print(text: &str) -> Result<(), CommandFailure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CommandFailure::input(format!("error: cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes lines to standard error, fitted to the screen if it is one; where that fails there is no one left to tell.
pub(crate) fn complain(message: &str) {
    let term = Term::stderr();
    let fitted = if term.is_term() { fitted(message, width(&term)) } else { message.to_owned() };
    let mut err = io::stderr().lock();
    let told = writeln!(err, "{}", paint::labels(&fitted));
    drop(told);
}

/// Lines that are too long go on under themselves, four blanks further to the right.
fn fitted(message: &str, width: usize) -> String {
    let mut lines = Vec::new();
    for line in message.lines() {
        let text = line.trim_start();
        let blanks = " ".repeat(line.len() - text.len());
        if line.chars().count() <= width {
            lines.push(line.to_owned());
            continue;
        }
        for (number, part) in broken(text, width.saturating_sub(blanks.len() + 4)).iter().enumerate() {
            let further = if number == 0 { "" } else { "    " };
            lines.push(format!("{blanks}{further}{part}"));
        }
    }
    lines.join("\n")
}

/// Columns of text on a screen.
fn width(term: &Term) -> usize {
    term.size_checked().filter(|(_, columns)| *columns > 0).map_or(WIDEST, |(_, columns)| columns.into()).min(WIDEST)
}

/// Every line two blanks further to the right.
pub(crate) fn indent(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

/// Lines of a text that fit on the screen after so many blanks.
pub(crate) fn wrapped(text: &str, indent: usize) -> Vec<String> {
    broken(text, width(&Term::stdout()).saturating_sub(indent))
}

/// A text in lines of at most so many columns (20 at least), broken between words.
fn broken(text: &str, width: usize) -> Vec<String> {
    let width = width.max(20);
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
