//! What the program says about its own work on standard error: `-v`, `-vv`, or `RIPSTOP_LOG` in the words of tracing's targets.

use std::env;
use std::io::{self, Write};

use console::colors_enabled_stderr;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::{self, time};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use super::failure::CommandFailure;
use super::progress;

/// Where the filter is looked up when no `-v` is given.
const VARIABLE: &str = "RIPSTOP_LOG";

/// Starts the log. Without `-v` and variable there is none, and what the program would say costs nothing.
pub(crate) fn start(verbose: u8) -> Result<(), CommandFailure> {
    let filter = match verbose {
        0 => env::var(VARIABLE).unwrap_or_default(),
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
        CommandFailure::expected(VARIABLE, expected, found).help(help)
    };
    let targets = filter.parse::<Targets>().map_err(|error| wrong(format!("{filter:?}: {error}")))?;
    let log = fmt::layer().with_writer(|| BesideTheBar).with_timer(time::uptime());
    let log = log.with_ansi(colors_enabled_stderr()).with_target(false);
    tracing_subscriber::registry().with(targets).with(log).try_init().map_err(|error| wrong(error.to_string()))
}

/// Standard error, with the progress bar out of the way.
struct BesideTheBar;

impl Write for BesideTheBar {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        progress::aside(|| io::stderr().lock().write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().lock().flush()
    }
}
