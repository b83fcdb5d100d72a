//! Colour for people at a terminal: none where output goes elsewhere, or `NO_COLOR` or `CLICOLOR=0` asks for none.

use console::{Style, style};

/// Title of a part.
pub(crate) fn heading(text: &str) -> String {
    style(text).bold().to_string()
}

/// What is as it should be.
pub(crate) fn good(text: &str) -> String {
    style(text).green().to_string()
}

/// What a reader should look at.
pub(crate) fn caution(text: &str) -> String {
    style(text).yellow().bold().to_string()
}

/// What is not as it should be.
pub(crate) fn bad(text: &str) -> String {
    style(text).red().bold().to_string()
}

/// What a row of a table of checks is marked with.
pub(crate) fn mark(pass: bool) -> String {
    if pass { good("pass") } else { bad("FAIL") }
}

/// A message for standard error with the labels its lines begin with set off.
pub(crate) fn labels(message: &str) -> String {
    let bold = || Style::new().for_stderr().bold();
    let labels = [("error:", bold().red()), ("note:", bold().cyan()), ("help:", bold().green())];
    let paint = |line: &str| {
        let text = line.trim_start();
        let found = labels.iter().find_map(|(label, style)| Some((label, style, text.strip_prefix(label)?)));
        match found {
            Some((label, style, rest)) => {
                format!("{}{}{rest}", &line[..line.len() - text.len()], style.apply_to(label))
            }
            None => line.to_owned(),
        }
    };
    message.split('\n').map(paint).collect::<Vec<_>>().join("\n")
}
