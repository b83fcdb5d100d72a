//! The terminal: standard output and error, colour, tables, the progress bar, the log, Ctrl-C.
//!
//! A reader that has gone away (`| head`) is no error. Colour and bar are for terminals; `NO_COLOR` and `CLICOLOR=0` turn colour off.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

pub(crate) use console::Alignment as Align;
use console::{Style, Term, colors_enabled_stderr, measure_text_width, pad_str, style};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ripstop::output::number::duration;
use ripstop::run::Progress;
use serde_json::Value;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::{layer, time};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use super::failure::{CommandFailure, INTERRUPTED};

/// Width of text at most, however wide the screen [columns].
const WIDEST: usize = 80;
/// Width below which a bar has shorter words [columns].
const NARROW: u16 = 110;
/// Ticks of a bar.
const LENGTH: f64 = 1000.0;
/// Variable with the filter of the log, used where no `-v` is given.
const LOG: &str = "RIPSTOP_LOG";

/// The bar that is on the screen, if one is.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

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

/// Writes lines to standard error. A failure has no place left to be reported.
pub(crate) fn complain(message: &str) {
    let lines: Vec<String> = message.lines().map(label).collect();
    aside(|| drop(writeln!(io::stderr().lock(), "{}", lines.join("\n"))));
}

/// Prints a result as JSON or as text for people, or with `quiet` alone not at all.
pub(crate) fn show(
    json: bool,
    quiet: bool,
    value: impl FnOnce() -> Value,
    text: impl FnOnce() -> String,
) -> Result<(), CommandFailure> {
    match (json, quiet) {
        (true, _) => print(&format!("{:#}\n", value())),
        (false, false) => print(&text()),
        (false, true) => Ok(()),
    }
}

/// Writes while the bar, if there is one, is out of the way.
fn aside<T>(write: impl FnOnce() -> T) -> T {
    let shown = SHOWN.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match shown {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// A line with its label in colour.
fn label(line: &str) -> String {
    let bold = Style::new().for_stderr().bold();
    let text = line.trim_start();
    for (label, style) in [("error:", bold.clone().red()), ("note:", bold.clone().cyan()), ("help:", bold.green())] {
        if let Some(rest) = text.strip_prefix(label) {
            return format!("{}{}{rest}", &line[..line.len() - text.len()], style.apply_to(label));
        }
    }
    line.to_owned()
}

/// Lines of a text, broken between words, that fit on the screen (20 columns at least) behind an indent [columns].
pub(crate) fn wrapped(text: &str, indent: usize) -> Vec<String> {
    let screen = Term::stdout().size_checked().filter(|(_, columns)| *columns > 0);
    let width = screen.map_or(WIDEST, |(_, columns)| columns.into()).min(WIDEST).saturating_sub(indent).max(20);
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Every line two blanks further to the right.
pub(crate) fn indent(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
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

    /// A table with a heading.
    pub(crate) fn new(columns: &[(&str, Align)]) -> Self {
        let mut table = Self::plain(&columns.iter().map(|(_, align)| *align).collect::<Vec<_>>());
        table.row(columns.iter().map(|(name, _)| *name));
        table
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

/// A progress bar on standard error, or nothing.
pub(crate) struct Bar {
    bar: ProgressBar,
}

impl Bar {
    /// A bar that is shown if `wanted` and standard error is a terminal.
    pub(crate) fn new(wanted: bool) -> Self {
        let shown = wanted && io::stderr().is_terminal();
        let target = if shown { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(LENGTH as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{prefix}{wide_bar:.cyan} {msg}") {
            bar.set_style(style.progress_chars("━╸ "));
        }
        if shown {
            *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
        }
        Self { bar }
    }

    /// Shows where a run is.
    pub(crate) fn show(&self, at: &Progress) {
        if !self.bar.is_hidden() {
            self.bar.set_position((LENGTH * at.time / at.end_time) as u64);
            self.bar.set_message(message(at, self.bar.elapsed().as_secs_f64(), Term::stderr().size().1 < NARROW));
        }
    }

    /// Shows which run it is and where it is.
    pub(crate) fn show_named(&self, name: &str, at: &Progress) {
        let prefix = format!("{name}  ");
        if !self.bar.is_hidden() && self.bar.prefix() != prefix {
            self.bar.set_prefix(prefix);
            self.bar.reset_elapsed();
        }
        self.show(at);
    }

    /// Shows how much is done, counted in `unit`.
    pub(crate) fn show_count(&self, name: &str, done: usize, of: usize, unit: &str) {
        self.bar.set_prefix(format!("{name}  "));
        self.bar.set_position((LENGTH * done as f64 / of.max(1) as f64) as u64);
        self.bar.set_message(format!("{done}/{of} {unit}"));
    }

    /// Takes the bar away.
    pub(crate) fn clear(&self) {
        *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.bar.finish_and_clear();
    }
}

/// Progress of a run after a time [s]: simulated time, velocity, failed yarns, rate, and the time it may still take.
fn message(at: &Progress, elapsed: f64, narrow: bool) -> String {
    let rate = at.steps as f64 * at.elements as f64 / elapsed.max(1e-9) / 1e6;
    let left = duration(elapsed * (at.end_time - at.time).max(0.0) / at.time.max(1e-12));
    let [yarns, steps] = if narrow { ["failed", "M/s"] } else { ["yarns failed", "M element-steps/s"] };
    let [time, end] = [at.time, at.end_time].map(|time| time * 1e6);
    let (velocity, failed) = (at.velocity, at.failed);
    format!("{time:.0}/{end:.0} µs  {velocity:.1} m/s  {failed} {yarns}  {rate:.1} {steps}  ≤ {left} left")
}

/// Starts the log on standard error. Without `-v` and variable there is none, and its messages cost nothing.
pub(crate) fn start_log(verbose: u8) -> Result<(), CommandFailure> {
    let filter = match verbose {
        0 => std::env::var(LOG).unwrap_or_default(),
        1 => "ripstop=info".to_owned(),
        2 => "ripstop=debug".to_owned(),
        _ => "ripstop=trace".to_owned(),
    };
    if filter.is_empty() {
        return Ok(());
    }
    let wrong = |found: String| {
        let expected = "a level (info, debug, trace), or parts and levels as in ripstop::run::record=debug";
        let help = "-v and -vv are the same as ripstop=info and ripstop=debug";
        CommandFailure::expected(LOG, expected, found).help(help)
    };
    let targets = filter.parse::<Targets>().map_err(|error| wrong(format!("{filter:?}: {error}")))?;
    let log = layer().with_writer(|| LogWriter).with_timer(time::uptime()).with_ansi(colors_enabled_stderr());
    let log = tracing_subscriber::registry().with(targets).with(log.with_target(false));
    log.try_init().map_err(|error| wrong(error.to_string()))
}

/// Standard error, with the bar out of the way.
struct LogWriter;

impl Write for LogWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        aside(|| io::stderr().lock().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().lock().flush()
    }
}

/// A flag that the first Ctrl-C (or a polite request to terminate) raises. The second ends the program.
pub(crate) fn watch_interrupts() -> Result<Arc<AtomicBool>, CommandFailure> {
    let raised = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&raised);
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    };
    match ctrlc::set_handler(handler) {
        Ok(()) => Ok(raised),
        Err(error) => Err(CommandFailure::input(format!("error: cannot listen for Ctrl-C: {error}"))),
    }
}
