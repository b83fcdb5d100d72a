//! The terminal: standard output and error, colour, tables, the progress bar, Ctrl-C.
//!
//! A reader that has gone away (`| head`) is no error. Colour and bar are for terminals; `NO_COLOR` and `CLICOLOR=0` turn colour off.

use std::fmt;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

pub(crate) use console::Alignment as Align;
use console::{Style, measure_text_width, pad_str, style};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ripstop::run::Progress;
use serde_json::Value;

use super::arguments::PrintArguments;
use super::failure::{CommandFailure, INTERRUPTED};

/// Ticks of the bar of a run.
const LENGTH: f64 = 1000.0;
/// Time after a request to end in which further ones change nothing: batch systems signal a process and its group, and results are written.
const GRACE: Duration = Duration::from_secs(5);

/// The bar on standard error; hidden until it is wanted, and where that is no terminal.
static BAR: LazyLock<ProgressBar> = LazyLock::new(ProgressBar::hidden);

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

/// Writes lines to standard error, their labels in colour. A failure has no place left to be reported.
pub(crate) fn complain(message: &str) {
    let bold = Style::new().for_stderr().bold();
    let labels = [("error:", bold.clone().red()), ("note:", bold.clone().cyan()), ("help:", bold.green())];
    let paint = |line: &str| {
        let label = labels.iter().find(|(label, _)| line.trim_start().starts_with(label));
        label.map_or(line.to_owned(), |(label, style)| line.replacen(label, &style.apply_to(label).to_string(), 1))
    };
    let lines: Vec<String> = message.lines().map(paint).collect();
    BAR.suspend(|| drop(writeln!(io::stderr().lock(), "{}", lines.join("\n"))));
}

/// Says something beside the result, unless nothing is wanted.
pub(crate) fn say(print_as: &PrintArguments, note: &str) {
    if !print_as.quiet {
        complain(note);
    }
}

/// Prints a result as JSON or as text for people, or with `quiet` alone not at all.
pub(crate) fn show(
    print_as: &PrintArguments,
    value: &Value,
    text: impl FnOnce() -> String,
) -> Result<(), CommandFailure> {
    match (print_as.json, print_as.quiet) {
        (true, _) => print(&format!("{value:#}\n")),
        (false, false) => print(&text()),
        (false, true) => Ok(()),
    }
}

/// Every line two blanks further to the right.
pub(crate) fn indent(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

/// A part of a text under its title; nothing where there is nothing to say.
pub(crate) fn part(title: &str, text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("\n{}\n{}", heading(title), indent(text)) }
}

/// Title of a part.
pub(crate) fn heading(text: &str) -> String {
    style(text).bold().to_string()
}

/// Text in the colour of a good result.
pub(crate) fn good(text: &str) -> String {
    style(text).green().to_string()
}

/// Text in the colour of something to look at.
pub(crate) fn caution(text: &str) -> String {
    style(text).yellow().bold().to_string()
}

/// Text in the colour of a bad result.
pub(crate) fn bad(text: &str) -> String {
    style(text).red().bold().to_string()
}

/// Mark of a check.
pub(crate) fn mark(pass: bool) -> String {
    if pass { good("pass") } else { bad("FAIL") }
}

/// A table: columns padded to their widest cell, whatever its colour, two blanks between them.
#[derive(Clone, Debug)]
pub(crate) struct TextTable {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table without a heading, with one alignment per column.
    pub(crate) fn plain(align: &[Align]) -> Self {
        Self { align: align.to_vec(), rows: Vec::new() }
    }

    /// A table of names and values.
    pub(crate) fn pairs<T: Into<String>>(pairs: impl IntoIterator<Item = (T, String)>) -> Self {
        let mut table = Self::plain(&[Align::Left, Align::Left]);
        pairs.into_iter().for_each(|(name, value)| table.row([name.into(), value]));
        table
    }

    /// Adds a row; cells beyond the last column are left out.
    pub(crate) fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

impl fmt::Display for TextTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cells = |column: usize| self.rows.iter().filter_map(move |row| row.get(column));
        let width = |column: usize| cells(column).map(|cell| measure_text_width(cell)).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.align.len()).map(width).collect();
        for row in &self.rows {
            let columns = row.iter().zip(&widths).zip(&self.align);
            let padded = columns.map(|((cell, width), align)| pad_str(cell, *width, *align, None));
            writeln!(f, "{}", padded.collect::<Vec<_>>().join("  ").trim_end())?;
        }
        Ok(())
    }
}

/// Shows the bar from now on if it is wanted.
pub(crate) fn begin_bar(print_as: &PrintArguments) {
    if print_as.quiet {
        return;
    }
    if let Ok(style) = ProgressStyle::with_template("{prefix}{wide_bar:.cyan} {msg}  ≤ {eta} left") {
        BAR.set_style(style.progress_chars("━╸ "));
    }
    BAR.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
}

/// Shows where a run is. `name`: which of several it is.
pub(crate) fn show_run(name: &str, at: &Progress) {
    if BAR.is_hidden() {
        return;
    }
    let prefix = if name.is_empty() { String::new() } else { format!("{name}  ") };
    if BAR.prefix() != prefix || BAR.length() != Some(LENGTH as u64) {
        BAR.set_prefix(prefix);
        BAR.set_length(LENGTH as u64);
        BAR.reset();
    }
    let rate = at.steps as f64 * at.elements as f64 / BAR.elapsed().as_secs_f64().max(1e-9) / 1e6;
    let [time, end] = [at.time, at.end_time].map(|time| time * 1e6);
    BAR.set_position((LENGTH * at.time / at.end_time) as u64);
    BAR.set_message(format!(
        "{time:.0}/{end:.0} µs  {:.1} m/s  {} yarns failed  {rate:.1} M/s",
        at.velocity, at.failed
    ));
}

/// Shows how much is done, counted in `unit`.
pub(crate) fn show_count(done: u32, of: u32, unit: &str) {
    BAR.set_length(u64::from(of));
    BAR.set_position(u64::from(done));
    BAR.set_message(format!("{done}/{of} {unit}"));
}

/// Takes the bar away.
pub(crate) fn end_bar() {
    BAR.finish_and_clear();
    BAR.set_draw_target(ProgressDrawTarget::hidden());
}

/// A flag that the first Ctrl-C (or a polite request to terminate) raises. One that comes much later ends the program.
pub(crate) fn watch_interrupts() -> Result<Arc<AtomicBool>, CommandFailure> {
    let raised = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&raised);
    let mut first = None;
    let handler = move || {
        flag.store(true, Ordering::Relaxed);
        if first.get_or_insert_with(Instant::now).elapsed() > GRACE {
            std::process::exit(i32::from(INTERRUPTED));
        }
    };
    match ctrlc::set_handler(handler) {
        Ok(()) => Ok(raised),
        Err(error) => Err(CommandFailure::input(format!("error: cannot listen for Ctrl-C: {error}"))),
    }
}
