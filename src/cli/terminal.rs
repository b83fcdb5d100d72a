//! The terminal: standard output and error, colour, tables, progress, Ctrl-C, exit codes.
//!
//! A reader that has gone away (`| head`) is no error. Colour and bar are for terminals; `NO_COLOR` and `CLICOLOR=0` turn colour off. Text
//! for people is broken between words to the width of the terminal; elsewhere a line is a line.

use std::fmt::{self, Display};
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

pub(crate) use console::Alignment as Align;
use console::{Style, Term, measure_text_width, pad_str, style};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ripstop::case::CaseError;
use ripstop::gpu::DeviceError;
use ripstop::output::number::short;
use ripstop::run::{Progress, RunError};
use ripstop::study::batch::StudyProgress;
use serde_json::Value;

use super::arguments::PrintArguments;

/// Exit code of what the user stopped.
const INTERRUPTED: u8 = 130;
/// Ticks of the bar.
const LENGTH: f64 = 1000.0;
/// Columns of a page.
pub(crate) const PAGE: usize = 80;
/// Columns that a hanging indent leaves at least.
const LEAST_COLUMNS: usize = 24;
/// Time between lines of progress where standard error is no terminal.
const HEARTBEAT: Duration = Duration::from_secs(30);
/// Time after a request to end in which further ones change nothing: batch systems signal a process and its group, and results are written.
const GRACE: Duration = Duration::from_secs(5);

/// The bar on standard error; hidden until it is wanted, and where that is no terminal.
static BAR: LazyLock<ProgressBar> = LazyLock::new(ProgressBar::hidden);
/// Progress since it is shown; `None` where it is not wanted.
static SEEN: Mutex<Option<Seen>> = Mutex::new(None);

/// Progress so far, from which the time left is estimated.
#[derive(Clone, Debug)]
struct Seen {
    /// Run or study that is under way.
    name: String,
    /// Its begin, and its first velocity [m/s] or count.
    start: (Instant, f64),
    /// Time of the last line, where there is no terminal.
    last_line: Instant,
}

/// Reason why a command ends with another code than 0.
#[derive(Clone, Debug)]
pub(crate) struct CommandFailure {
    code: u8,
    message: String,
}

impl CommandFailure {
    /// Exit code 1: a check failed or the run became unstable.
    pub(crate) fn check(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into() }
    }

    /// Exit code 2: bad input or usage, or results that cannot be written.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into() }
    }

    /// Exit code 2, with the place, what may stand there and what stands there.
    pub(crate) fn expected(place: impl Display, expected: impl Display, found: impl Display) -> Self {
        Self::input(format!("error: {place}\n  expected: {expected}\n  found: {found}"))
    }

    /// This failure, with advice.
    pub(crate) fn help(mut self, help: impl Display) -> Self {
        self.message += &format!("\n  help: {help}");
        self
    }

    /// Exit code 3: no device for what was asked, or one that was lost on the way.
    pub(crate) fn lost(message: impl Into<String>) -> Self {
        Self { code: 3, message: message.into() }
    }

    /// Exit code 130.
    pub(crate) fn interrupted(message: impl Into<String>) -> Self {
        Self { code: INTERRUPTED, message: message.into() }
    }

    /// Both, with the code of the first.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { message: format!("{}\n{}", self.message, other.message), ..self }
    }

    /// Prints the message and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        complain(&self.message);
        ExitCode::from(self.code)
    }

    /// Failure of a run that did not start.
    pub(crate) fn start(file: &str, error: RunError) -> Self {
        match error {
            RunError::Model(error) | RunError::Checkpoint(error) => error.in_file(file).into(),
            RunError::Device(error) => error.into(),
            other => Self::input(format!("error: {other}")),
        }
    }
}

impl From<CaseError> for CommandFailure {
    fn from(error: CaseError) -> Self {
        Self::input(error.to_string())
    }
}

impl From<DeviceError> for CommandFailure {
    /// Exit code 3: no device, or one that cannot hold the case or was lost.
    fn from(error: DeviceError) -> Self {
        Self { code: 3, ..error.refusal().into() }
    }
}

/// Writes text for people to standard output, its lines no longer than a terminal is wide.
pub(crate) fn print(text: &str) -> Result<(), CommandFailure> {
    print_within(usize::MAX, text)
}

/// Writes text for people, its lines no longer than a terminal, or so many columns.
pub(crate) fn print_within(most: usize, text: &str) -> Result<(), CommandFailure> {
    let columns = Term::stdout().size_checked().map_or(usize::MAX, |(_, columns)| columns.into());
    print_raw(&wrapped(text, columns.min(most)))
}

/// Text whose long lines go on below the begin of their last column, broken between words only.
fn wrapped(text: &str, columns: usize) -> String {
    let mut out = String::new();
    for line in text.split_inclusive('\n') {
        let first = line.find(|c: char| c != ' ').unwrap_or(0);
        let column = line.rfind("  ").filter(|at| *at > first).map_or(first, |at| measure_text_width(&line[..at + 2]));
        let indent = if column.saturating_add(LEAST_COLUMNS) > columns { first + 2 } else { column };
        let mut at = 0;
        for word in line.split_inclusive(' ') {
            if at > indent && word.trim() != "" && at + measure_text_width(word.trim_end()) > columns {
                out.truncate(out.trim_end().len());
                out += &format!("\n{:indent$}", "");
                at = indent;
            }
            out += word;
            at += measure_text_width(word);
        }
    }
    out
}

/// Writes to standard output what programs read.
pub(crate) fn print_raw(text: &str) -> Result<(), CommandFailure> {
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
        (true, _) => print_raw(&format!("{value:#}\n")),
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

/// Sentences to look at, each after a word.
pub(crate) fn notes(sentences: &[String]) -> String {
    sentences.iter().map(|text| format!("{}  {text}\n", caution("look"))).collect()
}

/// Folder and names of the files written.
pub(crate) fn files(folder: &Path, names: &[&str]) -> String {
    format!("\n{}  {}\n  {}\n", heading("files"), folder.display(), names.join(", "))
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

/// Shows progress from now on if it is wanted.
pub(crate) fn begin_bar(print_as: &PrintArguments) {
    if print_as.quiet {
        return;
    }
    if let Ok(style) = ProgressStyle::with_template("{prefix}{wide_bar:.cyan} {msg}") {
        BAR.set_style(style.progress_chars("━╸ "));
    }
    BAR.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
    BAR.set_length(LENGTH as u64);
    // Programs that read JSON read no lines of progress.
    if BAR.is_hidden() && print_as.json {
        return;
    }
    let now = Instant::now();
    let begin = Seen { name: String::new(), start: (now, f64::NAN), last_line: now };
    *SEEN.lock().unwrap_or_else(PoisonError::into_inner) = Some(begin);
}

/// Shows a message on the bar, or every half minute in a line. `rest`: of the seconds since the begin and the number `first` there, the end
/// of the message, the part that is done, and the seconds left.
fn show_progress(name: &str, message: &str, first: f64, rest: impl FnOnce(f64, f64) -> (String, f64, Option<f64>)) {
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(seen) = seen.as_mut() else { return };
    if seen.name != name || seen.start.1.is_nan() {
        (seen.name, seen.start) = (name.to_owned(), (Instant::now(), first));
    }
    let (end, done, left) = rest(seen.start.0.elapsed().as_secs_f64(), seen.start.1);
    let left = left.map_or_else(String::new, |left| format!("  {} left", duration(left)));
    let [prefix, message] = [if name.is_empty() { "" } else { "  " }.to_owned(), format!("{message}{end}{left}")];
    if !BAR.is_hidden() {
        BAR.set_position((LENGTH * done) as u64);
        BAR.set_prefix(format!("{name}{prefix}"));
        BAR.set_message(message);
    } else if seen.last_line.elapsed() >= HEARTBEAT {
        seen.last_line = Instant::now();
        complain(&format!("{name}{prefix}{message}"));
    }
}

/// Time in the largest unit that leaves a whole number above one [s].
pub(crate) fn duration(seconds: f64) -> String {
    match seconds {
        ..120.0 => format!("{seconds:.0} s"),
        120.0..7200.0 => format!("{:.0} min", seconds / 60.0),
        _ => format!("{:.0} h", seconds / 3600.0),
    }
}

/// Shows where a run is. `name`: which of several it is.
pub(crate) fn show_run(name: &str, at: &Progress) {
    let [time, end] = [at.time, at.end_time].map(|time| time * 1e6);
    let message = format!("{time:.0}/{end:.0} µs  {:.1} m/s  {} yarns failed", at.velocity, at.failed);
    show_progress(name, &message, at.velocity, |seconds, first| {
        // The first look measures nothing.
        let rate = (seconds > 0.05).then(|| at.steps as f64 * at.elements as f64 / seconds / 1e6);
        let rate = rate.map_or_else(String::new, |rate| format!("  {rate:.1} M/s"));
        // A run ends once the projectile has stopped, at the deceleration so far, or at its end time.
        let stop = at.time * at.velocity / (first - at.velocity);
        let left = if stop > 0.0 { stop.min(at.end_time - at.time) } else { at.end_time - at.time };
        let done = at.time / (at.time + left);
        (rate, done, Some(seconds * (1.0 - done) / done).filter(|left| left.is_finite()))
    });
}

/// Shows where a study is, counted in `unit`.
pub(crate) fn show_count(at: StudyProgress, unit: &str) {
    let count = (at.of > 1).then(|| format!("{}/{} {unit}", at.done, at.of));
    let shots = (at.shots > 0).then(|| format!("{} shots", at.shots));
    let limit = match at.limit.map(|end| end.map(|end| short(end, 4))) {
        [Some(low), Some(high)] => Some(format!("limit between {low} and {high} m/s")),
        [Some(low), None] => Some(format!("limit above {low} m/s")),
        [None, Some(high)] => Some(format!("limit below {high} m/s")),
        [None, None] => None,
    };
    let message = [count, shots, limit].into_iter().flatten().collect::<Vec<_>>().join("  ");
    let [done, of] = [at.done, at.of].map(f64::from);
    show_progress("", &message, done, |seconds, first| {
        // Thresholds do not take equally many shots.
        let left = (done > first && at.shots == 0).then(|| seconds * (of - done) / (done - first));
        (String::new(), done / of, left)
    });
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_go_on_below_their_last_column_and_no_word_is_cut() {
        assert_eq!(wrapped("short line\n", 20), "short line\n");
        let table = "a   a text of words\nbb  another one\n";
        assert_eq!(wrapped(table, 30), table);
        assert_eq!(
            wrapped("name  a text that is too long for it\n", 32),
            "name  a text that is too long\n      for it\n"
        );
        assert_eq!(
            wrapped("name  \u{1b}[1ma text\u{1b}[0m that is too long\n", 32),
            "name  \u{1b}[1ma text\u{1b}[0m that is too long\n"
        );
        // Where the last column is far to the right, the line goes on below its begin.
        assert_eq!(wrapped("  a first column  and a second\n", 24), "  a first column  and a\n    second\n");
        assert_eq!(wrapped("averylongword\n", 5), "averylongword\n");
    }
}
