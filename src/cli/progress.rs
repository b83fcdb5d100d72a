//! The progress bar, for people at a terminal.

use std::io::{self, IsTerminal};
use std::sync::{Mutex, PoisonError};

use console::Term;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ripstop::run::Progress;

use super::screen;
use ripstop::output::number::duration;

/// Ticks of the bar.
const LENGTH: f64 = 1000.0;
/// Screens narrower than this [columns] get the numbers with fewer words.
const NARROW: u16 = 110;

/// The bar that is on the screen, if one is.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Writes to the terminal while the bar, if there is one, is out of the way.
pub(crate) fn aside<T>(write: impl FnOnce() -> T) -> T {
    let shown = SHOWN.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match shown {
        Some(bar) => bar.suspend(write),
        None => write(),
    }
}

/// A bar on standard error, or nothing.
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

    /// Shows where the run is.
    pub(crate) fn show(&self, at: &Progress) {
        if self.bar.is_hidden() {
            return;
        }
        self.bar.set_position((LENGTH * at.time / at.end_time) as u64);
        let narrow = Term::stderr().size().1 < NARROW;
        self.bar.set_message(message(at, self.bar.elapsed().as_secs_f64(), narrow));
    }

    /// Shows what runs and where it is.
    pub(crate) fn show_named(&self, name: &str, at: &Progress) {
        let prefix = format!("{name}  ");
        if !self.bar.is_hidden() && self.bar.prefix() != prefix {
            self.bar.set_prefix(prefix);
            self.bar.reset_elapsed();
        }
        self.show(at);
    }

    /// Shows what runs and how much of it is done, counted in `what`.
    pub(crate) fn show_count(&self, name: &str, done: usize, of: usize, what: &str) {
        if !self.bar.is_hidden() {
            self.bar.set_prefix(format!("{name}  "));
            self.bar.set_position((LENGTH * done as f64 / of.max(1) as f64) as u64);
            self.bar.set_message(format!("{done}/{of} {what}"));
        }
    }

    /// Says something while the bar is there.
    pub(crate) fn say(&self, text: &str) {
        self.bar.suspend(|| screen::complain(text));
    }

    /// Takes the bar away.
    pub(crate) fn clear(&self) {
        *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.bar.finish_and_clear();
    }
}

/// Where a run is after so many seconds: time, velocity, failed yarns, rate, and how long it may still take.
fn message(at: &Progress, elapsed: f64, narrow: bool) -> String {
    let rate = at.steps as f64 * at.elements as f64 / elapsed.max(1e-9) / 1e6;
    let left = duration(elapsed * (at.end_time - at.time).max(0.0) / at.time.max(1e-12));
    let [yarns, steps] = if narrow { ["failed", "M/s"] } else { ["yarns failed", "M element-steps/s"] };
    let [time, end] = [at.time, at.end_time].map(|time| time * 1e6);
    let (velocity, failed) = (at.velocity, at.failed);
    format!("{time:.0}/{end:.0} µs  {velocity:.1} m/s  {failed} {yarns}  {rate:.1} {steps}  ≤ {left} left")
}
