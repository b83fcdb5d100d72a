//! `ripstop resume`.

use std::fs;
use std::path::Path;
use std::time::Instant;

use ripstop::case;
use ripstop::output::number::us;
use ripstop::output::{CHECKPOINT, CheckpointWriter, Folder};
use ripstop::run;
use ripstop::run::checkpoint::{Checkpoint, Extras, Header};
use serde_json::Value;

use super::arguments::ResumeArguments;
use super::failure::CommandFailure;
use super::follow::{RunObserver, film_again, recorder_again};
use super::progress::Bar;
use super::run::{Print, conclude, file};
use super::{backend, interrupt, screen};

/// Goes on with a run from its last checkpoint.
pub(crate) fn resume(arguments: &ResumeArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let interrupted = interrupt::watch()?;
    let path = arguments.folder.join(CHECKPOINT);
    if !path.exists() {
        return nothing_to_resume(&arguments.folder, arguments.quiet);
    }
    // First: until the folder is held, another run may write a later checkpoint, or end.
    let folder = Folder::reopen(&arguments.folder)?;
    let checkpoint = Checkpoint::open(&path)?;
    let head = checkpoint.head();
    let mut case = case::read(&arguments.folder.join("case.json"), &[])?;
    case.name.clone_from(&head.case);
    checkpoint.check_case(&case)?;
    let chosen = backend::again(&head.backend)?;
    let say = |note: &str| {
        if !arguments.quiet {
            screen::complain(note);
        }
    };
    say(&format!("note: goes on from {}", us(head.time)));
    let bar = Bar::new(!arguments.quiet);
    let options = chosen.options(arguments.threads.or(head.threads)).skips(head.skips).resume(&checkpoint);
    let extras = Extras { report: head.extras.report && !arguments.no_report };
    let head = Header { every: arguments.checkpoint_every.unwrap_or(head.every), extras, ..head.clone() };
    let recorder = recorder_again(&case, &folder, &options, &head, say);
    let animation = if extras.report { Some(film_again(&case, &checkpoint, say)?) } else { None };
    let checkpoint_writer = Some(CheckpointWriter::new(&folder, &case, head, start));
    let mut follower = RunObserver { bar: &bar, animation, recorder, checkpoint_writer, told: false };
    let run = run::run(&case, options, &interrupted, &mut follower);
    bar.clear();
    let run = run.map_err(|error| CommandFailure::start(&file(&case), &error))?;
    let wall = follower.checkpoint_writer.as_ref().map_or(0.0, |writer| writer.spent(run.loop_seconds).wall);
    let print = Print::of(arguments.json, arguments.quiet);
    conclude(&case, run, &folder, follower, wall, print)
}

/// A run that has ended is no mistake; a folder without a run is.
fn nothing_to_resume(folder: &Path, quiet: bool) -> Result<(), CommandFailure> {
    let summary = fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let summary: Value = serde_json::from_str(&summary).unwrap_or_default();
    if summary["interrupted"] == false && summary["device_lost"].is_null() {
        if !quiet {
            screen::complain(&format!("note: {}: the run has ended; there is nothing to resume", folder.display()));
        }
        return Ok(());
    }
    let expected = format!("a folder with a checkpoint, {CHECKPOINT}");
    let help = "`ripstop run CASE.json --checkpoint-every US` leaves them";
    Err(CommandFailure::expected(folder.display(), expected, "none").help(help))
}
