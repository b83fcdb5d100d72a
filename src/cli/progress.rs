//! The progress bar, for people at a terminal.

use std::io::{self, IsTerminal};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use ripstop::simulation::Progress;

/// Ticks of the bar.
const LENGTH: f64 = 1000.0;

/// A bar on standard error, or nothing.
pub(crate) struct Bar {
    bar: ProgressBar,
    start: Instant,
}

impl Bar {
    /// A bar that is shown if `wanted` and standard error is a terminal.
    pub(crate) fn new(wanted: bool) -> Self {
        let shown = wanted && io::stderr().is_terminal();
        let target = if shown { ProgressDrawTarget::stderr_with_hz(10) } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(LENGTH as u64), target);
        if let Ok(style) = ProgressStyle::with_template("{prefix}{wide_bar} {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, start: Instant::now() }
    }

    /// Shows where the run is.
    pub(crate) fn show(&self, at: &Progress) {
        if self.bar.is_hidden() {
            return;
        }
        let rate = at.steps as f64 * at.elements as f64 / self.start.elapsed().as_secs_f64();
        self.bar.set_position((LENGTH * at.time / at.end_time) as u64);
        self.bar.set_message(format!(
            "{:.1}/{:.0} µs  {:.1} m/s  {} yarns failed  {:.1} M element-steps/s",
            at.time * 1e6,
            at.end_time * 1e6,
            at.velocity,
            at.failed,
            rate / 1e6,
        ));
    }

    /// Shows what runs and where it is.
    pub(crate) fn show_named(&self, name: &str, at: &Progress) {
        if !self.bar.is_hidden() {
            self.bar.set_prefix(format!("{name}  "));
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

    /// Takes the bar away.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
