//! `ripstop resume`.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, builder::RangedU64ValueParser};
use ripstop::case;
use ripstop::output::Animation;
use ripstop::output::frames::Recorder;
use ripstop::output::number::us;
use ripstop::output::{CHECKPOINT, CheckpointWriter, Folder};
use ripstop::run;
use ripstop::run::checkpoint::{Checkpoint, Header};
use serde_json::Value;

use super::backend;
use super::failure::CommandFailure;
use super::input::interval;
use super::run::{RunObserver, conclude, file};
use super::terminal::{self, Bar};

/// `ripstop resume`
#[derive(Args, Debug)]
#[command(after_help = "Example:
  ripstop run shot.json --checkpoint-every 10
  ripstop resume out/shot

The case, the backend, its number type and the skips are those of the run; so are all files, to the last bit, but
for the time it took. Frames of the run so far lie in DIR/checkpoint.frames until it ends. The case in DIR must be the one that the run began with. A run that has ended is left as it is.")]
pub(crate) struct ResumeArguments {
    /// Folder of the run
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Simulated µs between further checkpoints [default: as the run began]
    #[arg(long, value_name = "US", value_parser = interval)]
    checkpoint_every: Option<f64>,
    /// Worker threads [default: as the run began]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    threads: Option<usize>,
    /// Write no report.html
    #[arg(long)]
    no_report: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Print summary.json instead of the table
    #[arg(long)]
    json: bool,
}

/// Goes on with a run from its last checkpoint.
pub(crate) fn resume(arguments: &ResumeArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let interrupted = terminal::watch_interrupts()?;
    let path = arguments.folder.join(CHECKPOINT);
    if !path.exists() {
        return nothing_to_resume(&arguments.folder, arguments.quiet);
    }
    // First: until the folder is held, another run may write a later checkpoint, or end.
    let folder = Folder::reopen(&arguments.folder)?;
    let checkpoint = Checkpoint::open(&path)?;
    let head = &checkpoint.header;
    let mut case = case::read(&arguments.folder.join("case.json"), &[])?;
    case.name.clone_from(&head.case);
    checkpoint.check_case(&case)?;
    let chosen = backend::again(&head.backend)?;
    let say = |note: &str| {
        if !arguments.quiet {
            terminal::complain(note);
        }
    };
    say(&format!("note: goes on from {}", us(head.time)));
    let bar = Bar::new(!arguments.quiet);
    let options = chosen.options(arguments.threads.or(head.threads)).skips(head.skips).resume(&checkpoint);
    let report = head.report && !arguments.no_report;
    let head = Header { every: arguments.checkpoint_every.unwrap_or(head.every), report, ..head.clone() };
    let recorder = (case.output.frames > 0).then(|| {
        let (recorder, lost) = Recorder::resume(&folder, &case, &head);
        lost.iter().for_each(|lost| say(&format!("warning: {lost}; the files of frames begin after that")));
        recorder
    });
    let kept = if report { Animation::from_bytes(&checkpoint.observer) } else { None };
    let animation = report.then(|| kept.unwrap_or_else(|| Animation::new(&case)));
    let checkpoint_writer = Some(CheckpointWriter::new(&folder, &case, head, start));
    let mut observer = RunObserver { bar: &bar, animation, recorder, checkpoint_writer };
    let run = run::run(&case, options, &interrupted, &mut observer);
    bar.clear();
    let run = run.map_err(|error| CommandFailure::start(&file(&case), &error))?;
    let wall = observer.checkpoint_writer.as_ref().map_or(0.0, |writer| writer.spent(run.loop_seconds).wall);
    conclude(&case, run, &folder, observer, wall, [arguments.json, arguments.quiet])
}

/// A run that has ended is no mistake; a folder without a run is.
fn nothing_to_resume(folder: &Path, quiet: bool) -> Result<(), CommandFailure> {
    let summary = fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let summary: Value = serde_json::from_str(&summary).unwrap_or_default();
    if summary["interrupted"] == false && summary["device_lost"].is_null() {
        if !quiet {
            terminal::complain(&format!("note: {}: the run has ended; there is nothing to resume", folder.display()));
        }
        return Ok(());
    }
    let expected = format!("a folder with a checkpoint, {CHECKPOINT}");
    let help = "`ripstop run CASE.json --checkpoint-every US` leaves them";
    Err(CommandFailure::expected(folder.display(), expected, "none").help(help))
}
