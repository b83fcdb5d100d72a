//! Independent work in parallel, results in order.

use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Does `work` for every number, on at most so many threads at a time.
pub(super) fn side_by_side<T: Send>(threads: usize, numbers: Range<usize>, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(numbers.start);
    let worker = || {
        let mut done = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if !numbers.contains(&number) {
                return done;
            }
            done.push((number, work(number)));
        }
    };
    let mut results: Vec<(usize, T)> = thread::scope(|scope| {
        let handles: Vec<_> = (0..threads.min(numbers.len())).map(|_| scope.spawn(worker)).collect();
        // What panics here is this program's fault: results must not go missing with it.
        handles.into_iter().flat_map(|handle| handle.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
    });
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The same for work that may fail. Its second argument is raised once one of them has failed: the others may give up then.
///
/// # Errors
/// The first in time: what was given up because of it does not hide it.
pub(super) fn in_threads<T: Send, E: Send>(
    threads: usize,
    numbers: Range<usize>,
    work: impl Fn(usize, &AtomicBool) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let (given_up, first) = (AtomicBool::new(false), Mutex::new(None));
    let fail = |error: E| {
        first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        given_up.store(true, Ordering::Relaxed);
    };
    let results = side_by_side(threads, numbers, |number| match given_up.load(Ordering::Relaxed) {
        true => None,
        false => work(number, &given_up).map_err(fail).ok(),
    });
    match first.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None => Ok(results.into_iter().flatten().collect()),
    }
}

#[cfg(test)]
#[path = "threads_tests.rs"]
mod tests;
