//! Standard output and error. A reader that has gone away (`| head`) is no error.

use std::io::{self, Write};

use console::Term;

use super::failure::Failure;
use super::paint;

/// Lines of text are no wider than this, however wide the screen.
const WIDEST: usize = 80;

/// Writes to standard output.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::input(format!("error: cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error; where that fails there is no one left to tell.
pub(crate) fn complain(line: &str) {
    let mut err = io::stderr().lock();
    let told = writeln!(err, "{}", paint::labels(line));
    drop(told);
}

/// Every line two blanks further to the right.
pub(crate) fn indent(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

/// Lines of a text that fit on the screen after so many blanks.
pub(crate) fn wrapped(text: &str, indent: usize) -> Vec<String> {
    let screen = Term::stdout().size_checked().map_or(WIDEST, |(_, columns)| columns.into());
    let width = screen.min(WIDEST).saturating_sub(indent).max(20);
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}
