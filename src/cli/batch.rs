//! What commands that compute many shots share.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Instant;

use ripstop::case::Case;
use ripstop::output::number::{bytes, duration, short};
use ripstop::run::batch::DeviceUse;
use ripstop::study::batch::{BatchError, BatchOptions};
use ripstop::study::interval::Bounds;

use super::backend::{self, Chosen};
use super::campaign_arguments::BatchArguments;
use super::failure::CommandFailure;
use super::input::Source;
use super::terminal::{self, Bar};

/// Reads the case of a batch: the nominal one, whatever shot it names.
pub(crate) fn case(source: &Source<'_>, arguments: &BatchArguments) -> Result<Case, CommandFailure> {
    let case = source.case(&arguments.sets)?;
    if case.projectile.is_none() {
        return Err(CommandFailure::expected(source.name(), "a projectile, to be shot", "none in the case"));
    }
    Ok(case)
}

/// What all draws come from.
pub(crate) fn seed(arguments: &BatchArguments, case: &Case) -> u32 {
    let of_case = case.variability.as_ref().map_or(1, |variability| variability.seed);
    arguments.seed.unwrap_or(of_case)
}

/// Opens what computes, and says what `auto` took.
pub(crate) fn choose(arguments: &BatchArguments) -> Result<Chosen, CommandFailure> {
    let chosen = backend::choose(&arguments.backend())?;
    chosen.note.iter().filter(|_| !arguments.quiet).for_each(|note| terminal::complain(note));
    Ok(chosen)
}

/// How shots are computed.
pub(crate) fn options<'a>(
    arguments: &BatchArguments,
    case: &Case,
    chosen: &'a Chosen,
    interrupt: &'a AtomicBool,
) -> BatchOptions<'a> {
    BatchOptions {
        seed: seed(arguments, case),
        threads: self::threads(arguments.threads),
        threads_per_shot: 1,
        precision: chosen.precision,
        device: chosen.device.as_ref(),
        interrupt,
    }
}

/// What shots took of a device; nothing where there was none.
pub(crate) fn device_text(used: DeviceUse) -> String {
    if used.shots == 0 {
        return String::new();
    }
    let each = |count: u64, of: u64| count as f64 / of as f64;
    format!(
        "GPU: {} shots, up to {} at a time; {} dispatches and {} a shot\n",
        used.shots,
        used.room,
        short(each(used.dispatches, used.shots), 4),
        bytes(each(used.bytes, used.room.max(1)))
    )
}

/// As many threads as asked for, one for each core otherwise.
pub(crate) fn threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get))
}

/// The folder of a batch.
pub(crate) fn out(given: Option<&Path>, case: &Case, command: &str) -> PathBuf {
    given.map_or_else(|| Path::new("out").join(format!("{}-{command}", case.name)), Path::to_owned)
}

/// What a batch that did not end says; `folder`: where its rows are.
pub(crate) fn failure(error: BatchError, folder: &Path) -> CommandFailure {
    match error {
        BatchError::Output(error) => error.into(),
        BatchError::Study(error) => error.into(),
        BatchError::Device(error) => CommandFailure::device(&error),
        BatchError::Interrupted => CommandFailure::interrupted(format!(
            "interrupted; rows so far: {}\n  help: the same command with --resume goes on",
            folder.display()
        )),
    }
}

/// A progress bar that knows how long each shot takes.
pub(crate) struct ShotBar {
    bar: Bar,
    start: Instant,
    /// Shots that were there when it began.
    before: Option<u32>,
}

impl ShotBar {
    pub(crate) fn new(wanted: bool) -> Self {
        Self { bar: Bar::new(wanted), start: Instant::now(), before: None }
    }

    /// Shows how many shots are done, what is known of V50, and the time left.
    pub(crate) fn show(&mut self, name: &str, done: u32, of: u32, v50: Option<(f64, Bounds)>) {
        let before = *self.before.get_or_insert(done.saturating_sub(1));
        let own = f64::from(done - before.min(done)).max(1.0);
        let left = self.start.elapsed().as_secs_f64() / own * f64::from(of.saturating_sub(done));
        let known = v50.map_or_else(String::new, |(value, bounds)| format!("  {}", interval(value, bounds)));
        let what = format!("shots{known}  ≤ {} left", duration(left));
        self.bar.show_count(name, done as usize, of as usize, &what);
    }

    pub(crate) fn clear(&self) {
        self.bar.clear();
    }
}

/// V50 with its interval.
pub(crate) fn interval(value: f64, bounds: Bounds) -> String {
    let [low, high] = bounds.words();
    format!("V50 {} m/s ({low} to {high})", short(value, 4))
}
