//! `ripstop run`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use ripstop::case::{self, Case};
use ripstop::output::frames::{Recorder, Staged};
use ripstop::output::report::{self, Film};
use ripstop::output::{self, Folder};
use ripstop::simulation::{self, Options, Progress, Run, RunError, View, Watch};
use ripstop::warnings;
use serde_json::Value;
use tracing::{info, warn};

use super::arguments::{Backend, RunArguments};
use super::failure::Failure;
use super::progress::Bar;
use super::{backend, interrupt, result, screen};

/// Runs a case, writes its results and says what happened.
pub(crate) fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let start = Instant::now();
    let interrupted = interrupt::watch()?;
    let case = case::read(&arguments.case, &arguments.sets())?;
    info!(file = file(&case), fields = case.fields.len(), changes = arguments.sets().len(), "case read");
    for warning in warnings::of_case(&case) {
        warn!(code = warning.kind.code, "{}", warning.message);
    }
    let chosen = backend::choose(&arguments.backend)?;
    let folder = Folder::prepare(&out(arguments, &case), &case)?;
    let say = |note: &str| {
        if !arguments.quiet {
            screen::complain(note)
        }
    };
    chosen.note.iter().for_each(|note| say(note));
    let bar = Bar::new(!arguments.quiet);
    let options = Options {
        threads: arguments.threads,
        precision: chosen.precision,
        device: chosen.device.as_ref(),
        skips: arguments.skips(),
    };
    let recorder = match recorder(arguments, &case, &folder) {
        Ok(recorder) => recorder,
        Err(failure) => {
            folder.abandon();
            return Err(failure);
        }
    };
    let film = (!arguments.no_report).then(|| Film::new(&case));
    let mut watch = Follower { bar: &bar, film, recorder };
    let mut run = simulation::run(&case, options, &interrupted, &mut watch);
    if let (Err(RunError::Device(error)), Backend::Auto) = (&run, arguments.backend.backend) {
        say(&backend::took_cpu(error));
        run = simulation::run(&case, Options { device: None, ..options }, &interrupted, &mut watch);
    }
    bar.clear();
    let frames = watch.recorder.map_or_else(|| Ok(Staged::default()), Recorder::finish);
    let run = match run {
        Ok(run) => run,
        Err(error) => {
            drop(frames);
            folder.abandon();
            return Err(Failure::start(&file(&case), &error));
        }
    };
    let summary = output::summary(&case, &run, start.elapsed().as_secs_f64());
    let page = watch.film.map(|film| report::report(&case, &run, &summary, &film));
    let (frames, refused) = match frames {
        Ok(frames) => (frames, None),
        Err(error) => (Staged::default(), Some(error)),
    };
    let written = folder.write(&case, &run, &summary, page, frames);
    if arguments.json {
        screen::print(&format!("{summary:#}\n"))?;
    } else if !arguments.quiet {
        let files = written.as_ref().ok().map(|names| (folder.path(), names.as_slice()));
        screen::print(&result::text(&case, &run, &summary, files))?;
    }
    info!(folder = %folder.path().display(), files = ?written.as_deref().unwrap_or_default(), "files written");
    written?;
    if let Some(error) = refused {
        return Err(error.into());
    }
    verdict(&case, &run, &summary, folder.path())
}

/// Follows a run: shows where it is, films it for the report, writes frames.
struct Follower<'a> {
    bar: &'a Bar,
    film: Option<Film>,
    recorder: Option<Recorder>,
}

impl Watch for Follower<'_> {
    fn progress(&mut self, at: &Progress) {
        self.bar.show(at);
    }

    fn is_due(&self, time: f64, dt: f64) -> bool {
        self.film.as_ref().is_some_and(|film| film.is_due(time, dt))
            || self.recorder.as_ref().is_some_and(|recorder| recorder.is_due(time, dt))
    }

    fn look(&mut self, view: &View<'_>) {
        let [time, dt] = view.clock();
        if let Some(film) = self.film.as_mut().filter(|film| film.is_due(time, dt)) {
            film.look(view);
        }
        if let Some(recorder) = self.recorder.as_mut().filter(|recorder| recorder.is_due(time, dt)) {
            recorder.look(view);
        }
    }

    fn end(&mut self, view: &View<'_>) {
        if let Some(film) = &mut self.film {
            film.end(view);
        }
    }
}

/// Writes frames where some are asked for.
fn recorder(arguments: &RunArguments, case: &Case, folder: &Folder) -> Result<Option<Recorder>, Failure> {
    if case.output.frames == 0 && !arguments.vtu {
        return Ok(None);
    }
    if case.output.frames == 0 {
        let message = "error: --vtu\n  expected: a number of frames\n  found: none\n  help: add --frames 60, or set /output/frames";
        return Err(Failure::input(message));
    }
    let failed = |error| Failure::input(format!("error: cannot start the thread that writes frames: {error}"));
    Recorder::start(folder.path(), case, arguments.vtu).map(Some).map_err(failed)
}

fn out(arguments: &RunArguments, case: &Case) -> PathBuf {
    arguments.out.clone().unwrap_or_else(|| Path::new("out").join(&case.name))
}

fn file(case: &Case) -> String {
    case.path.display().to_string()
}

/// What the exit code says.
fn verdict(case: &Case, run: &Run, summary: &Value, folder: &Path) -> Result<(), Failure> {
    if let Some(trouble) = &run.trouble {
        return Err(Failure::check(format!(
            "error: {}: the run became unstable\n  where: {}\n  found: {}\n  help: lower /solver/courant",
            file(case),
            output::place(trouble),
            trouble.quantity
        )));
    }
    if let Some(reason) = &run.lost {
        return Err(Failure::lost(format!(
            "error: {}: the device gave up at {}\n  found: {reason}\n  help: take --backend cpu; results up to there: {}",
            file(case),
            output::reached(run),
            folder.display()
        )));
    }
    if run.interrupted {
        let reached = output::reached(run);
        return Err(Failure::interrupted(format!(
            "interrupted at {reached}; results up to there: {}",
            folder.display()
        )));
    }
    let expect: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    let failed: Vec<String> = expect
        .iter()
        .filter(|check| check["pass"] == false)
        .map(|check| format!("\n  {}", result::broken(check)))
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    let (failed_count, count) = (failed.len(), expect.len());
    Err(Failure::check(format!(
        "error: {}: {failed_count} of {count} expectations failed{}",
        file(case),
        failed.concat()
    )))
}
