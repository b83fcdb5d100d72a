//! Follows a run: the bar shows where it is, a thread of its own makes pictures of the frames.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use ripstop::case::Case;
use ripstop::frame::Snapshot;
use ripstop::output::report::Film;
use ripstop::simulation::{Progress, Watch};

use super::progress::Bar;

/// Snapshots that may wait; a run that is ahead of them by more waits, so that memory stays bounded.
const WAITING: usize = 4;

struct Follower<'a> {
    bar: &'a Bar,
    frames: SyncSender<Snapshot>,
}

impl Watch for Follower<'_> {
    fn progress(&mut self, at: &Progress) {
        self.bar.show(at);
    }

    fn frame(&mut self, snapshot: Snapshot) {
        // The other end is there as long as this one; if it were not, there would be no film.
        drop(self.frames.send(snapshot));
    }
}

/// Runs something that is followed; gives its result and the film, if there were frames.
pub(crate) fn followed<T>(case: &Case, bar: &Bar, run: impl FnOnce(&mut dyn Watch) -> T) -> (T, Option<Film>) {
    let (frames, received) = sync_channel(WAITING);
    thread::scope(|scope| {
        let film = scope.spawn(move || film(case, &received));
        let done = run(&mut Follower { bar, frames });
        (done, film.join().ok().flatten())
    })
}

fn film(case: &Case, frames: &Receiver<Snapshot>) -> Option<Film> {
    let first = frames.recv().ok()?;
    let mut film = Film::new(case, first.scene());
    for snapshot in std::iter::once(first).chain(frames) {
        if film.wants(snapshot.index()) {
            film.take(&snapshot.frame());
        }
    }
    Some(film)
}
