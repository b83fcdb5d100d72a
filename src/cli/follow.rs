//! What follows a run: the progress bar, and checkpoints.

use ripstop::checkpoint::{Keeper, Kept};
use ripstop::output::{CHECKPOINT, Folder};
use ripstop::simulation::{Progress, Watch};

use super::progress::Bar;

/// Shows progress and keeps checkpoints.
pub(crate) struct Follower<'a> {
    /// On standard error.
    pub(crate) bar: &'a Bar,
    /// Where checkpoints are asked for.
    pub(crate) keeper: Option<Keeper<'a>>,
}

impl Watch for Follower<'_> {
    fn progress(&mut self, at: &Progress) {
        self.bar.show(at);
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
