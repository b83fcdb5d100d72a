//! `ripstop run`.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use ripstop::case::Case;
use ripstop::output::checks::case_warnings;
use ripstop::output::expectation::{Judgement, judgement};
use ripstop::output::frames::Recorder;
use ripstop::output::report::{self, Animation};
use ripstop::output::{self, CheckpointWriter, Folder, StagedFrames};
use ripstop::run::checkpoint::{Extras, Header};
use ripstop::run::{self, Options, Run, RunError};
use serde_json::Value;
use tracing::{info, warn};

use super::arguments::{BackendChoice, RunArguments};
use super::failure::CommandFailure;
use super::follow::{RunObserver, recorder, waiting};
use super::progress::Bar;
use super::{backend, input, interrupt, result, screen};

/// Runs cases one after the other; one that fails does not keep the others from being run.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), CommandFailure> {
    let interrupted = interrupt::watch()?;
    let sets = arguments.sets();
    let mut folders: Vec<PathBuf> = Vec::new();
    let mut failures = Vec::new();
    for path in &arguments.cases {
        let done = input::read(path, &sets).and_then(|case| {
            let folder = out(arguments, &case);
            if folders.contains(&folder) {
                let found = format!("two cases for {}", folder.display());
                return Err(CommandFailure::expected(path.display(), "a folder for each case", found));
            }
            folders.push(folder.clone());
            shoot(arguments, &case, &folder, &interrupted)
        });
        failures.extend(done.err());
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
    }
    failures.into_iter().reduce(CommandFailure::and).map_or(Ok(()), Err)
}

/// Runs a case, writes its results and says what happened.
pub(crate) fn shoot(
    arguments: &RunArguments,
    case: &Case,
    out: &Path,
    interrupted: &AtomicBool,
) -> Result<(), CommandFailure> {
    let start = Instant::now();
    info!(file = file(case), fields = case.fields.len(), changes = arguments.sets.len(), "case read");
    for warning in case_warnings(case) {
        warn!(code = warning.kind.code, "{}", warning.message);
    }
    let chosen = backend::choose(&arguments.backend)?;
    let folder = Folder::prepare(out, case)?;
    let say = |note: &str| {
        if !arguments.quiet {
            screen::complain(note)
        }
    };
    case.notes.iter().for_each(|note| say(&format!("note: {note}")));
    chosen.note.iter().chain(&waiting(&folder)).for_each(|note| say(note));
    let bar = Bar::new(!arguments.quiet);
    let options = chosen.options(arguments.threads).skips(arguments.skips());
    let attempt = |options: Options<'_>| -> Result<(Result<Run, RunError>, RunObserver<'_>), CommandFailure> {
        let head = arguments.checkpoint_every.map(|every| Header {
            extras: Extras { report: !arguments.no_report },
            ..Header::new(case, &options, every)
        });
        let recorder = recorder(case, &folder, &options, head.is_some());
        let animation = (!arguments.no_report).then(|| Animation::new(case));
        let checkpoint_writer = head.map(|head| CheckpointWriter::new(&folder, case, head, start));
        let mut follower = RunObserver { bar: &bar, animation, recorder, checkpoint_writer, told: false };
        Ok((run::run(case, options, interrupted, &mut follower), follower))
    };
    let mut shot = attempt(options);
    if let (Ok((Err(RunError::Device(error)), _)), BackendChoice::Auto) = (&shot, arguments.backend.backend) {
        say(&backend::took_cpu(error));
        shot = attempt(options.device(None::<&ripstop::Device>));
    }
    bar.clear();
    let refused = match shot {
        Ok((Ok(run), follower)) => {
            let wall = start.elapsed().as_secs_f64();
            return conclude(case, run, &folder, follower, wall, Print::of(arguments.json, arguments.quiet));
        }
        Ok((Err(error), _)) => CommandFailure::start(&file(case), &error),
        Err(failure) => failure,
    };
    folder.abandon();
    Err(refused)
}

/// What is printed of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Print {
    /// Nothing.
    Nothing,
    /// For people.
    Table,
    /// `summary.json`.
    Json,
}

impl Print {
    /// What two switches ask for.
    pub(crate) fn of(json: bool, quiet: bool) -> Self {
        match (json, quiet) {
            (true, _) => Self::Json,
            (false, true) => Self::Nothing,
            (false, false) => Self::Table,
        }
    }

    /// Prints a result in one form or the other, or not at all.
    pub(crate) fn show(
        self,
        json: impl FnOnce() -> Value,
        text: impl FnOnce() -> String,
    ) -> Result<(), CommandFailure> {
        match self {
            Self::Json => screen::print(&format!("{:#}\n", json())),
            Self::Table => screen::print(&text()),
            Self::Nothing => Ok(()),
        }
    }
}

/// Writes and prints the results of a run. `wall_seconds`: time that it took, all commands together.
pub(crate) fn conclude(
    case: &Case,
    mut run: Run,
    folder: &Folder,
    follower: RunObserver<'_>,
    wall_seconds: f64,
    print: Print,
) -> Result<(), CommandFailure> {
    let RunObserver { animation, recorder, checkpoint_writer, .. } = follower;
    let frames = recorder.map_or_else(|| Ok(StagedFrames::default()), Recorder::finish);
    run.checkpoint_error = checkpoint_writer.as_ref().and_then(CheckpointWriter::failed).map(str::to_owned);
    let summary = output::summary(case, &run, wall_seconds);
    let page = animation.map(|animation| report::report(case, &run, &summary, &animation));
    let (frames, refused) = match frames {
        Ok(frames) => (frames, None),
        Err(error) => (StagedFrames::default(), Some(error)),
    };
    let written = folder.write(case, &run, &summary, page, frames);
    let files = written.as_ref().ok().map(|names| (folder.path(), names.as_slice()));
    print.show(|| summary.clone(), || result::text(case, &run, &summary, files))?;
    info!(folder = %folder.path().display(), files = ?written.as_deref().unwrap_or_default(), "files written");
    written?;
    if let Some(error) = refused {
        return Err(error.into());
    }
    let goes_on =
        (run.interrupted || run.lost.is_some()) && checkpoint_writer.as_ref().is_some_and(CheckpointWriter::has_kept);
    if !goes_on {
        folder.forget()?;
    }
    verdict(case, &run, &summary, folder.path(), goes_on)
}

fn out(arguments: &RunArguments, case: &Case) -> PathBuf {
    match &arguments.out {
        Some(folder) if arguments.cases.len() == 1 => folder.clone(),
        several => several.as_deref().unwrap_or(Path::new("out")).join(&case.name),
    }
}

pub(crate) fn file(case: &Case) -> String {
    case.path.display().to_string()
}

/// What the exit code says. `goes_on`: the run can be resumed.
fn verdict(case: &Case, run: &Run, summary: &Value, folder: &Path, goes_on: bool) -> Result<(), CommandFailure> {
    let folder = folder.display();
    let resume = if goes_on { format!("\n  help: `ripstop resume {folder}` goes on") } else { String::new() };
    if let Some(trouble) = &run.divergence {
        return Err(CommandFailure::check(format!(
            "error: {}: the run became unstable\n  where: {}\n  found: {}\n  help: lower /solver/courant",
            file(case),
            output::place(trouble),
            trouble.quantity
        )));
    }
    if let Some(reason) = &run.lost {
        return Err(CommandFailure::lost(format!(
            "error: {}: the device gave up at {}\n  found: {reason}\n  help: take --backend cpu; results up to there: {folder}{resume}",
            file(case),
            output::reached(run),
        )));
    }
    if run.interrupted {
        let reached = output::reached(run);
        return Err(CommandFailure::interrupted(format!(
            "interrupted at {reached}; results up to there: {folder}{resume}"
        )));
    }
    let expect: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    let failed: Vec<String> = expect
        .iter()
        .filter(|check| judgement(check) == Judgement::Fails)
        .map(|check| format!("\n  {}", result::broken(check)))
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    let (failed_count, count) = (failed.len(), expect.len());
    Err(CommandFailure::check(format!(
        "error: {}: {failed_count} of {count} expectations failed{}",
        file(case),
        failed.concat()
    )))
}
