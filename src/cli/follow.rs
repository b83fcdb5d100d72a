//! What follows a run: the progress bar, the film for the report, frames and checkpoints.

use ripstop::case::Case;
use ripstop::checkpoint::{Keeper, Kept};
use ripstop::output::frames::Recorder;
use ripstop::output::report::Film;
use ripstop::output::{CHECKPOINT, Folder};
use ripstop::simulation::{Progress, View, Watch};

use super::failure::Failure;
use super::progress::Bar;

/// Shows progress, films, writes frames and keeps checkpoints.
pub(crate) struct Follower<'a> {
    /// On standard error.
    pub(crate) bar: &'a Bar,
    /// For the report.
    pub(crate) film: Option<Film>,
    /// Where frames are asked for.
    pub(crate) recorder: Option<Recorder>,
    /// Where checkpoints are asked for.
    pub(crate) keeper: Option<Keeper<'a>>,
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

    fn keeps(&self, time: f64, dt: f64) -> bool {
        self.keeper.as_ref().is_some_and(|keeper| keeper.is_due(time, dt))
    }

    fn keep(&mut self, run: &dyn Kept, loop_seconds: f64) {
        if let Some(keeper) = &mut self.keeper
            && let Err(complaint) = keeper.keep(run, loop_seconds)
        {
            self.bar.say(&format!("warning: {complaint}"));
        }
    }
}

/// Says that a run, which will replace it, could be resumed.
pub(crate) fn waiting(folder: &Folder) -> Option<String> {
    let path = folder.path();
    path.join(CHECKPOINT).exists().then(|| {
        format!(
            "note: {0} holds a checkpoint, which this run replaces; `ripstop resume {0}` would go on from it",
            path.display()
        )
    })
}

/// Writes frames where some are asked for.
pub(crate) fn recorder(case: &Case, folder: &Folder, vtu: bool) -> Result<Option<Recorder>, Failure> {
    if case.output.frames == 0 && !vtu {
        return Ok(None);
    }
    if case.output.frames == 0 {
        let message = "error: --vtu\n  expected: a number of frames\n  found: none\n  help: add --frames 60, or set /output/frames";
        return Err(Failure::input(message));
    }
    let failed = |error| Failure::input(format!("error: cannot start the thread that writes frames: {error}"));
    Recorder::start(folder.path(), case, vtu).map(Some).map_err(failed)
}
