//! `ripstop run`, and what follows every run: its observer, its files, what is printed, the exit code.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::{Args, ValueEnum, builder::RangedU64ValueParser};
use ripstop::case::Case;
use ripstop::output::checks::case_warnings;
use ripstop::output::expect::{Judgement, judgement};
use ripstop::output::frames::Recorder;
use ripstop::output::report;
use ripstop::output::{self, Animation, CHECKPOINT, CheckpointWriter, Folder};
use ripstop::run::checkpoint::{Checkpointable, Header};
use ripstop::run::{self, Observer, Options, Progress, Run, RunError, Skips, View};
use serde_json::Value;
use tracing::{info, warn};

use super::arguments::{BackendArguments, BackendChoice};
use super::failure::CommandFailure;
use super::input::{self, interval};
use super::terminal::{self, Bar};
use super::{backend, result};

/// `ripstop run`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop run cases/s720-1ply-155.json
  ripstop run shot.json --set /projectile/velocity_m_s=200 -o out/shot-200
  ripstop run cases/s728-*.json
  jq '.pack.plies = 2' shot.json | ripstop run -
  ripstop run shot.json --frames 60
  ripstop run shot.json --checkpoint-every 10     # then, after a crash: ripstop resume out/shot
  ripstop run shot.json --set '/pack/edges={\"left\":\"free\"}' --json | jq .residual_velocity_m_s

DIR gets report.html (open it in a browser: verdict, trust, figures, playback), summary.json, \
history.csv, events.csv, case.json (the case as run), shot.svg (a picture), plies.csv of a pack, \
profiles.csv where the case asks for profiles, and frames.pvd where there are frames. \
The first Ctrl-C writes them up to that moment, the second ends at once.")]
pub(crate) struct RunArguments {
    /// Case files, run one after the other; - is standard input
    #[arg(value_name = "CASE.json", required = true)]
    pub(crate) cases: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Folder for the results; of several cases each gets a folder in it [default: out/<case name>, with what --set changed]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Worker threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Compute also what cannot change the result: what nothing has reached, what comes after the outcome, mirror images
    /// [default: all]
    #[arg(
        long,
        value_enum,
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
    /// Frames for ParaView, evenly from impact to the end of the run, in frames.pvd [default: /output/frames of the case]
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    /// Simulated µs between checkpoints in DIR, from which `ripstop resume DIR` goes on; Ctrl-C leaves one too, the end of the run none
    #[arg(long, value_name = "US", value_parser = interval)]
    pub(crate) checkpoint_every: Option<f64>,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print summary.json instead of the table
    #[arg(long)]
    pub(crate) json: bool,
}

impl RunArguments {
    /// Changes of the case.
    pub(crate) fn sets(&self) -> Vec<String> {
        let frames = self.frames.map(|count| format!("/output/frames={count}"));
        self.sets.iter().cloned().chain(frames).collect()
    }

    /// Skips that are on.
    pub(crate) fn skips(&self) -> Skips {
        let on = |kind: Skip| !self.no_skip.iter().any(|off| [kind, Skip::All].contains(off));
        Skips { wavefront: on(Skip::Wavefront), outcome: on(Skip::Outcome), symmetry: on(Skip::Symmetry) }
    }
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
            terminal::complain(note)
        }
    };
    case.notes.iter().for_each(|note| say(&format!("note: {note}")));
    chosen.note.iter().chain(&waiting(&folder)).for_each(|note| say(note));
    let bar = Bar::new(!arguments.quiet);
    let options = chosen.options(arguments.threads).skips(arguments.skips());
    let attempt = |options: Options<'_>| {
        let head = arguments
            .checkpoint_every
            .map(|every| Header { report: !arguments.no_report, ..Header::new(case, &options, every) });
        let recorder = (case.output.frames > 0).then(|| Recorder::new(&folder, case, head.is_some()));
        let animation = (!arguments.no_report).then(|| Animation::new(case));
        let checkpoint_writer = head.map(|head| CheckpointWriter::new(&folder, case, head, start));
        let mut observer = RunObserver { bar: &bar, animation, recorder, checkpoint_writer };
        (run::run(case, options, interrupted, &mut observer), observer)
    };
    let (mut run, mut observer) = attempt(options);
    if let (Err(RunError::Device(error)), BackendChoice::Auto) = (&run, arguments.backend.backend) {
        say(&backend::took_cpu(error));
        (run, observer) = attempt(options.device(None::<&ripstop::Device>));
    }
    bar.clear();
    match run {
        Ok(run) => {
            let wall = start.elapsed().as_secs_f64();
            conclude(case, run, &folder, observer, wall, [arguments.json, arguments.quiet])
        }
        Err(error) => {
            folder.abandon();
            Err(CommandFailure::start(&file(case), &error))
        }
    }
}

/// Writes and prints the results of a run. `wall_seconds`: time of all commands together [s].
pub(crate) fn conclude(
    case: &Case,
    mut run: Run,
    folder: &Folder,
    observer: RunObserver<'_>,
    wall_seconds: f64,
    [json, quiet]: [bool; 2],
) -> Result<(), CommandFailure> {
    let RunObserver { animation, recorder, checkpoint_writer, .. } = observer;
    let frames = recorder.map(Recorder::finish).transpose();
    run.checkpoint_error = checkpoint_writer.as_ref().and_then(|writer| writer.failed.clone());
    let summary = output::summary(case, &run, wall_seconds);
    let page = animation.map(|animation| report::report(case, &run, &summary, &animation));
    let (frames, refused) = frames.map_or_else(|error| (None, Some(error)), |frames| (frames, None));
    let written = folder.write(case, &run, &summary, page, &frames.unwrap_or_default());
    let files = written.as_ref().ok().map(|names| (folder.path(), names.as_slice()));
    terminal::show(json, quiet, || summary.clone(), || result::text(case, &run, &summary, files))?;
    info!(folder = %folder.path().display(), files = ?written.as_deref().unwrap_or_default(), "files written");
    written?;
    let goes_on = (run.interrupted || run.lost.is_some())
        && checkpoint_writer.as_ref().is_some_and(|writer| writer.kept.is_some());
    if !goes_on {
        folder.forget()?;
    }
    if let Some(error) = refused {
        return Err(error.into());
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

/// Exit code of a run, with its message. `goes_on`: the run can be resumed.
fn verdict(case: &Case, run: &Run, summary: &Value, folder: &Path, goes_on: bool) -> Result<(), CommandFailure> {
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

/// Observer of a run: progress bar, animation, frames, checkpoints.
pub(crate) struct RunObserver<'a> {
    /// Progress bar on standard error.
    pub(crate) bar: &'a Bar,
    /// Animation of the report, where there is one.
    pub(crate) animation: Option<Animation>,
    /// Writer of frames, where they are asked for.
    pub(crate) recorder: Option<Recorder<'a>>,
    /// Writer of checkpoints, where they are asked for.
    pub(crate) checkpoint_writer: Option<CheckpointWriter<'a>>,
}

impl Observer for RunObserver<'_> {
    fn on_progress(&mut self, at: &Progress) {
        self.bar.show(at);
    }

    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.animation.as_ref().is_some_and(|animation| animation.snapshot_due(time, dt))
            || self.recorder.as_ref().is_some_and(|recorder| recorder.snapshot_due(time, dt))
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let [time, dt] = view.clock();
        if let Some(animation) = self.animation.as_mut().filter(|animation| animation.snapshot_due(time, dt)) {
            animation.on_snapshot(view);
        }
        if let Some(recorder) = self.recorder.as_mut().filter(|recorder| recorder.snapshot_due(time, dt)) {
            recorder.on_snapshot(view);
        }
    }

    fn on_end(&mut self, view: &View<'_>) {
        if let Some(animation) = &mut self.animation {
            animation.on_end(view);
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.on_end(view);
        }
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

/// Note that a run, which this one replaces, could be resumed.
pub(crate) fn waiting(folder: &Folder) -> Option<String> {
    let path = folder.path();
    path.join(CHECKPOINT).exists().then(|| {
        format!(
            "note: {0} holds a checkpoint, which this run replaces; `ripstop resume {0}` would go on from it",
            path.display()
        )
    })
}
