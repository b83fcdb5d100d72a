//! `ripstop run` and `ripstop resume`, and what follows every run: its observer, its files, what is printed, the exit code.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::{Args, ValueEnum};
use ripstop::case::{self, Case};
use ripstop::output::checks::{self, Check, Level};
use ripstop::output::expect::{Judgement, expected, got, judgement, note, quantity};
use ripstop::output::frames::Recorder;
use ripstop::output::number::us;
use ripstop::output::report;
use ripstop::output::warnings::Warning;
use ripstop::output::{self, Animation, CHECKPOINT, CheckpointWriter, Energies, Folder, StagedFrames};
use ripstop::run::checkpoint::{Checkpoint, Checkpointable, Header};
use ripstop::run::outcome::Outcome;
use ripstop::run::{self, Observer, Options, Precision, Progress, Run, RunError, Skips, View};
use serde_json::Value;

use super::arguments::{Backend, BackendArguments, BackendChoice, PrintArguments, interval, read, took_cpu};
use super::terminal::{self, Align, CommandFailure, TextTable, files, part, say};

/// Least share of the largest energy that has a line [-].
const LEAST_SHARE: f64 = 0.005;

/// `ripstop run`
#[derive(Args, Debug, Default)]
#[command(after_help = "Examples:
  ripstop run shot.json --set /projectile/velocity_m_s=200 -o out/shot-200
  ripstop run cases/s728-*.json
  ripstop run shot.json --checkpoint-every 10     # then, after a crash: ripstop resume out/shot
  ripstop run shot.json --set '/pack/edges={\"left\":\"free\"}' --json | jq .residual_velocity_m_s

DIR gets report.html (open it in a browser), summary.json, history.csv, events.csv, case.json (the case as run), shot.svg and more. \
Ctrl-C writes them up to that moment; once more, from 5 s later on, ends at once.")]
pub(crate) struct RunArguments {
    /// Case files, run one after the other
    #[arg(value_name = "CASE.json", required = true)]
    pub(crate) cases: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Number type of the state [default: f64 on the CPU, f32 on a GPU, which has no other]
    #[arg(long, value_enum)]
    pub(crate) precision: Option<Precision>,
    /// Folder for the results; of several cases each gets a folder in it [default: out/<case name>, with what --set changed]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Compute also what cannot change the result: what nothing has reached, what comes after the outcome, mirror images
    /// [default: all]
    #[arg(
        long,
        value_name = "KIND,…",
        num_args = 0..,
        require_equals = true,
        value_delimiter = ',',
        default_missing_value = "all"
    )]
    pub(crate) no_skip: Vec<Skip>,
    /// Write no report.html
    #[arg(long)]
    pub(crate) no_report: bool,
    /// Frames for ParaView, evenly from impact to the end of the run, in frames.pvd; up to twice as many where that comes before
    /// /solver/end_time_us [default: /output/frames of the case]
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    /// Simulated µs between checkpoints in DIR, from which `ripstop resume DIR` goes on; Ctrl-C leaves one too, the end of the run none
    #[arg(long, value_name = "US", value_parser = interval)]
    pub(crate) checkpoint_every: Option<f64>,
    #[command(flatten)]
    pub(crate) print: PrintArguments,
}

/// Kind of skip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Skip {
    /// Fabric that nothing has reached
    Wavefront,
    /// Time after the outcome
    Outcome,
    /// Mirror images
    Symmetry,
    /// Every one
    All,
}

/// Runs cases one after the other; one that fails does not keep the others from being run.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), CommandFailure> {
    let interrupted = terminal::watch_interrupts()?;
    let frames = arguments.frames.map(|count| format!("/output/frames={count}"));
    let sets: Vec<String> = arguments.sets.iter().cloned().chain(frames).collect();
    let mut folders: Vec<PathBuf> = Vec::new();
    let mut failures = Vec::new();
    for path in &arguments.cases {
        let done = read(path, &sets).map_err(Into::into).and_then(|case| {
            let folder = match &arguments.out {
                Some(folder) if arguments.cases.len() == 1 => folder.clone(),
                several => several.as_deref().unwrap_or(Path::new("out")).join(&case.name),
            };
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
    let chosen = Backend::choose(&arguments.backend, BackendChoice::Auto, arguments.precision, &arguments.print)?;
    let folder = Folder::prepare(out, case)?;
    case.notes.iter().for_each(|note| say(&arguments.print, &format!("note: {note}")));
    if out.join(CHECKPOINT).exists() {
        let words = "holds a checkpoint, which this run replaces; `ripstop resume";
        say(&arguments.print, &format!("note: {0} {words} {0}` would go on from it", out.display()));
    }
    terminal::begin_bar(&arguments.print);
    let on = |kind: Skip| !arguments.no_skip.iter().any(|off| [kind, Skip::All].contains(off));
    let skips = Skips { wavefront: on(Skip::Wavefront), outcome: on(Skip::Outcome), symmetry: on(Skip::Symmetry) };
    let options = chosen.options(arguments.backend.threads).skips(skips);
    let attempt = |options: Options<'_>| {
        let head = arguments
            .checkpoint_every
            .map(|every| Header { report: !arguments.no_report, ..Header::new(case, &options, every) });
        let recorder = (case.output.frames > 0).then(|| Recorder::new(&folder, case, head.is_some()));
        let animation = (!arguments.no_report).then(|| Animation::new(case));
        let checkpoint_writer = head.map(|head| CheckpointWriter::new(&folder, case, head, start));
        let mut observer = RunObserver { animation, recorder, checkpoint_writer };
        (run::run(case, options, interrupted, &mut observer), observer)
    };
    let (mut run, mut observer) = attempt(options);
    if let (Err(RunError::Device(error)), None | Some(BackendChoice::Auto)) = (&run, arguments.backend.backend) {
        took_cpu(&arguments.print, &error.to_string());
        (run, observer) = attempt(options.device(None::<&ripstop::Device>));
    }
    terminal::end_bar();
    match run {
        Ok(run) => conclude(case, run, &folder, observer, start.elapsed().as_secs_f64(), &arguments.print),
        Err(error) => {
            folder.abandon();
            Err(CommandFailure::start(&file(case), error))
        }
    }
}

/// Goes on with a run from its last checkpoint.
pub(crate) fn resume(path: &Path, print: &PrintArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let interrupted = terminal::watch_interrupts()?;
    let checkpoint = path.join(CHECKPOINT);
    if !checkpoint.exists() {
        return nothing_to_resume(path, print);
    }
    // First: until the folder is held, another run may write a later checkpoint, or end.
    let folder = Folder::reopen(path)?;
    let checkpoint = Checkpoint::open(&checkpoint)?;
    let head = &checkpoint.header;
    let mut case = case::read(&path.join("case.json"), &[])?;
    case.name.clone_from(&head.case);
    checkpoint.check_case(&case)?;
    let chosen = Backend::again(&head.backend)?;
    say(print, &format!("note: goes on from {}", us(head.time)));
    terminal::begin_bar(print);
    let options = chosen.options(head.threads).skips(head.skips).resume(&checkpoint);
    let recorder = (case.output.frames > 0).then(|| Recorder::resume(&folder, &case, head)).transpose()?;
    let kept = if head.report { Animation::from_bytes(&checkpoint.observer) } else { None };
    let animation = head.report.then(|| kept.unwrap_or_else(|| Animation::new(&case)));
    let checkpoint_writer = Some(CheckpointWriter::new(&folder, &case, head.clone(), start));
    let mut observer = RunObserver { animation, recorder, checkpoint_writer };
    let run = run::run(&case, options, &interrupted, &mut observer);
    terminal::end_bar();
    let run = run.map_err(|error| CommandFailure::start(&file(&case), error))?;
    let wall = observer.checkpoint_writer.as_ref().map_or(0.0, CheckpointWriter::wall_seconds);
    conclude(&case, run, &folder, observer, wall, print)
}

/// A run that has ended is no mistake; a folder without a run is.
fn nothing_to_resume(folder: &Path, print: &PrintArguments) -> Result<(), CommandFailure> {
    let summary = fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let summary: Value = serde_json::from_str(&summary).unwrap_or_default();
    if summary["interrupted"] == false && summary["device_lost"].is_null() {
        say(print, &format!("note: {}: the run has ended; there is nothing to resume", folder.display()));
        return Ok(());
    }
    let expected = format!("a folder with a checkpoint, {CHECKPOINT}");
    let help = "`ripstop run CASE.json --checkpoint-every US` leaves them";
    Err(CommandFailure::expected(folder.display(), expected, "none").help(help))
}

/// Writes and prints the results of a run. `wall_seconds`: time of all commands together [s].
fn conclude(
    case: &Case,
    mut run: Run,
    folder: &Folder,
    observer: RunObserver<'_>,
    wall_seconds: f64,
    print: &PrintArguments,
) -> Result<(), CommandFailure> {
    let RunObserver { animation, recorder, checkpoint_writer, .. } = observer;
    let (frames, refused) = match recorder.map(Recorder::finish).transpose() {
        Ok(frames) => (frames.unwrap_or_default(), None),
        Err(error) => (StagedFrames::default(), Some(error)),
    };
    run.checkpoint_error = checkpoint_writer.as_ref().and_then(|writer| writer.failed.clone());
    let summary = output::summary(case, &run, wall_seconds);
    let page = animation.map(|animation| report::report(case, &run, &summary, &animation));
    let written = folder.write(case, &run, &summary, page, &frames);
    let written_to = written.as_ref().ok().map(|names| (folder.path(), names.as_slice()));
    terminal::show(print, &summary, || text(case, &run, &summary, written_to))?;
    written?;
    let goes_on = (run.interrupted || run.lost.is_some())
        && checkpoint_writer.as_ref().is_some_and(|writer| writer.kept.is_some());
    if !goes_on {
        folder.forget()?;
    }
    if let Some(error) = refused {
        return Err(error.into());
    }
    exit(case, &run, &summary, folder.path(), goes_on)
}

fn file(case: &Case) -> String {
    case.path.display().to_string()
}

/// Exit code of a run, with its message. `goes_on`: the run can be resumed.
fn exit(case: &Case, run: &Run, summary: &Value, folder: &Path, goes_on: bool) -> Result<(), CommandFailure> {
    let folder = folder.display();
    let resume = if goes_on { format!("\n  help: `ripstop resume {folder}` goes on") } else { String::new() };
    if let Some(divergence) = &run.divergence {
        return Err(CommandFailure::check(format!(
            "error: {}: the run became unstable\n  where: {}\n  found: {}\n  help: lower /solver/courant",
            file(case),
            output::place(divergence),
            divergence.quantity
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
    let expect = || summary["expect"].as_array().into_iter().flatten();
    let fails = expect().filter(|check| judgement(check) == Judgement::Fails);
    let failed: Vec<String> = fails.map(|check| format!("\n  {}", broken(check))).collect();
    if failed.is_empty() {
        return Ok(());
    }
    let counts = format!("{} of {} expectations failed", failed.len(), expect().count());
    Err(CommandFailure::check(format!("error: {}: {counts}{}", file(case), failed.concat())))
}

/// Result of a run as people read it. `written`: folder and names of the files, where there are some.
fn text(case: &Case, run: &Run, summary: &Value, written: Option<(&Path, &[&str])>) -> String {
    let checks = checks::checks(case, run);
    let mut weighed = TextTable::plain(&[Align::Left; 3]);
    output::margins(case, run)
        .into_iter()
        .for_each(|(name, number, more)| weighed.row([name.to_owned(), number, more]));
    let parts = [
        format!("{}\n\n{}\n{}\n", case.title, headline(case, run), advice(&checks)),
        warnings(&checks::warnings(case, &checks)),
        format!("\n{weighed}"),
        energy(run),
        part("cost", &TextTable::pairs(output::costs(case, run, summary)).to_string()),
        expectations(summary),
        written.map_or_else(String::new, |(folder, names)| files(folder, names)),
    ];
    parts.concat()
}

/// Verdict in its colour, and what belongs to it.
fn headline(case: &Case, run: &Run) -> String {
    let verdict = output::verdict(case, run);
    let paint = match (verdict.complete, run.outcome) {
        (false, _) | (_, Outcome::Perforated) => terminal::bad,
        (_, Outcome::Stopped | Outcome::Rebounded) => terminal::good,
        _ => terminal::caution,
    };
    let word = terminal::heading(&paint(&verdict.word.to_uppercase()));
    format!("{word}{} {}", terminal::heading(verdict.mark()), terminal::heading(&verdict.detail))
}

/// One line each, with its code.
pub(crate) fn warnings(warnings: &[Warning]) -> String {
    let Some(first) = warnings.first() else { return String::new() };
    let rows = warnings.iter().map(|warning| (terminal::caution(warning.kind.code), warning.message.clone()));
    format!("{}`ripstop explain {}` says what it means and what to do\n", TextTable::pairs(rows), first.kind.code)
}

/// Advice on the use of the result, with its reasons, a line each.
fn advice(checks: &[Check]) -> String {
    let (level, why) = checks::advice(checks);
    let why: Vec<String> = why.iter().map(|check| format!("{}: {}", check.name, check.reason)).collect();
    let (word, why) = (level.advice(), why.join("\n      "));
    match level {
        Level::Fine => format!("{}: all {} checks are fine", terminal::good(word), checks.len()),
        Level::Look => format!("{}: {why}", terminal::caution(word)),
        Level::Bad => format!("{}: {why}", terminal::bad(word)),
    }
}

/// Energy given to the fabric, and its shares at the end.
fn energy(run: &Run) -> String {
    let Some(energies) = Energies::of(run) else { return String::new() };
    let mut table = TextTable::plain(&[Align::Left, Align::Right, Align::Right]);
    for (name, energy) in &energies.sources {
        let of = if name.ends_with("projectile") {
            format!("of {}", energies.text(run.impact_energy))
        } else {
            String::new()
        };
        table.row([(*name).to_owned(), energies.text(*energy), of]);
    }
    // Small ones are left to the report.
    let is_shown =
        |(name, energy): &&(&str, f64)| energy.abs() >= LEAST_SHARE * energies.scale || *name == "unaccounted";
    for (name, energy) in energies.shares.iter().filter(is_shown) {
        table.row([format!("  {name}"), energies.text(*energy), energies.percent(*energy)]);
    }
    part("energy", &table.to_string())
}

fn expectations(summary: &Value) -> String {
    let mut text = String::new();
    for check in summary["expect"].as_array().into_iter().flatten() {
        let pass = match judgement(check) {
            Judgement::Known => terminal::caution("known"),
            other => terminal::mark(other == Judgement::Holds),
        };
        text += &format!("{pass}  {} {}, got {}", quantity(check), expected(check), got(check));
        text.extend(check["source"].as_str().map(|source| format!(" ({source})")));
        text += format!(" {}", note(check)).trim_end();
        text.push('\n');
    }
    part("expected", &text)
}

/// One line about an expectation that does not hold.
fn broken(check: &Value) -> String {
    let line = format!("{}: expected {}, got {} {}", quantity(check), expected(check), got(check), note(check));
    line.trim_end().to_owned()
}

/// Observer of a run: progress bar, animation, frames, checkpoints.
struct RunObserver<'a> {
    /// Animation of the report, where there is one.
    animation: Option<Animation>,
    /// Writer of frames, where they are asked for.
    recorder: Option<Recorder<'a>>,
    /// Writer of checkpoints, where they are asked for.
    checkpoint_writer: Option<CheckpointWriter<'a>>,
}

impl RunObserver<'_> {
    /// Observers that take snapshots.
    fn takers(&mut self) -> impl Iterator<Item = &mut dyn Observer> {
        let animation = self.animation.as_mut().map(|animation| animation as &mut dyn Observer);
        animation.into_iter().chain(self.recorder.as_mut().map(|recorder| recorder as &mut dyn Observer))
    }
}

impl Observer for RunObserver<'_> {
    fn on_progress(&mut self, at: &Progress) {
        terminal::show_run("", at);
    }

    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.animation.as_ref().is_some_and(|animation| animation.snapshot_due(time, dt))
            || self.recorder.as_ref().is_some_and(|recorder| recorder.snapshot_due(time, dt))
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let [time, dt] = view.clock();
        self.takers().filter(|taker| taker.snapshot_due(time, dt)).for_each(|taker| taker.on_snapshot(view));
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.takers().for_each(|taker| taker.on_end(view));
    }

    fn checkpoint_due(&self, time: f64, dt: f64) -> bool {
        self.checkpoint_writer.as_ref().is_some_and(|checkpoint_writer| checkpoint_writer.is_due(time, dt))
    }

    fn on_checkpoint(&mut self, run: &dyn Checkpointable, loop_seconds: f64) {
        let Some(checkpoint_writer) = &mut self.checkpoint_writer else { return };
        // A checkpoint without the frames before it would be worth less. Where the folder refuses, so does the checkpoint.
        if let (Ok(()), Some(recorder)) = (checkpoint_writer.begin(), &mut self.recorder) {
            recorder.settle();
        }
        let animation = self.animation.as_ref().map_or_else(Vec::new, Animation::to_bytes);
        // A disk that is full for long is reported once.
        let is_first = checkpoint_writer.failed.is_none();
        match (checkpoint_writer.write(run, &animation, loop_seconds), &mut self.recorder) {
            (Err(error), _) if is_first => terminal::complain(&format!("warning: {error}")),
            (Ok(()), Some(recorder)) => recorder.discard(),
            _ => {}
        }
    }
}
