//! Threads that wait for a short serial part of a step without going to sleep.
//!
//! A thread of the pool that finds nothing to do sleeps after some 10 µs, and to wake it takes longer than that: with a few thousand elements it
//! then comes too late for every sweep (benches/NOTES.md).

use std::sync::atomic::{AtomicBool, Ordering};

use super::sweep::BANDS;

/// Does the work on this thread, while others that are awake stay so: one for each further band of a ply.
pub(super) fn beside_others<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let others = (rayon::current_num_threads() - 1).min(BANDS - 1);
    if others == 0 {
        return work();
    }
    let done = AtomicBool::new(false);
    rayon::scope(|scope| {
        for _ in 0..others {
            scope.spawn(|_| {
                while !done.load(Ordering::Acquire) {
                    std::thread::yield_now();
                }
            });
        }
        let _end = Raised(&done);
        work()
    })
}

/// Raises a flag at its end, whatever happens before.
struct Raised<'a>(&'a AtomicBool);

impl Drop for Raised<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}
