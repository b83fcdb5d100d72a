//! What follows a run: the progress bar, the animation for the report, frames and checkpoints.

use ripstop::case::Case;
use ripstop::output::frames::Recorder;
use ripstop::output::number::us;
use ripstop::output::report::Animation;
use ripstop::output::{CHECKPOINT, CheckpointWriter, Folder};
use ripstop::run::checkpoint::{Checkpoint, Checkpointable, Header};
use ripstop::run::{Observer, Options, Progress, View};

use super::failure::CommandFailure;
use super::progress::Bar;

/// Shows progress, films, writes frames and keeps checkpoints.
pub(crate) struct RunObserver<'a> {
    /// On standard error.
    pub(crate) bar: &'a Bar,
    /// For the report.
    pub(crate) animation: Option<Animation>,
    /// Where frames are asked for.
    pub(crate) recorder: Option<Recorder<'a>>,
    /// Where checkpoints are asked for.
    pub(crate) checkpoint_writer: Option<CheckpointWriter<'a>>,
    /// The user knows that checkpoints cannot be written.
    pub(crate) told: bool,
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
        let begun = checkpoint_writer.begin().is_ok();
        let unspooled = self.recorder.as_mut().filter(|_| begun).and_then(Recorder::settle);
        let animation = self.animation.as_ref().map_or_else(Vec::new, Animation::to_bytes);
        let unkept = checkpoint_writer.write(run, &animation, loop_seconds).err().map(|error| error.to_string());
        if let Some(recorder) = self.recorder.as_mut().filter(|_| unkept.is_none()) {
            recorder.discard();
        }
        // A disk that is full for long is told once.
        let news = unkept.iter().filter(|_| !self.told);
        unspooled.iter().chain(news).for_each(|complaint| self.bar.say(&format!("warning: {complaint}")));
        self.told = unkept.is_some();
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

/// Recorder of frames where some are asked for. `checkpoints`: the run leaves some.
pub(crate) fn recorder<'a>(
    case: &'a Case,
    folder: &'a Folder,
    options: &Options<'_>,
    checkpoints: bool,
) -> Option<Recorder<'a>> {
    (case.output.frames > 0).then(|| Recorder::new(folder, case, options, checkpoints))
}

/// Recorder of a run that goes on; `say` hears of frames that are lost.
pub(crate) fn recorder_again<'a>(
    case: &'a Case,
    folder: &'a Folder,
    options: &Options<'_>,
    head: &Header,
    say: impl Fn(&str),
) -> Option<Recorder<'a>> {
    (case.output.frames > 0).then(|| {
        let (recorder, lost) = Recorder::resume(folder, case, options, head);
        lost.iter().for_each(|lost| say(&format!("warning: {lost}; the files of frames begin after that")));
        recorder
    })
}

/// The animation of a run that goes on; `say` hears of one that is lost.
pub(crate) fn film_again(
    case: &Case,
    checkpoint: &Checkpoint,
    say: impl Fn(&str),
) -> Result<Animation, CommandFailure> {
    let head = checkpoint.head();
    Ok(Animation::resume(case, &checkpoint.observer_state()?, head.step, head.time_step).unwrap_or_else(|| {
        let from = us(head.time);
        say(&format!("warning: the pictures before {from} are lost; the report's playback begins there"));
        Animation::new(case)
    }))
}
