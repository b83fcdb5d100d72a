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
mod tests {
    use super::*;

    #[test]
    fn work_side_by_side_comes_back_in_order() {
        for threads in [1, 2, 7] {
            assert_eq!(side_by_side(threads, 0..20, |at| at * at), (0..20).map(|at| at * at).collect::<Vec<_>>());
        }
    }

    #[test]
    #[should_panic(expected = "of the work")]
    fn a_panic_of_one_piece_of_work_takes_no_results_away_unnoticed() {
        side_by_side(2, 0..9, |at| assert!(at != 4, "of the work"));
    }

    #[test]
    fn results_are_in_order_and_an_error_ends_the_work() {
        let squares = in_threads(3, 2..9, |n, _| Ok::<_, ()>(n * n));
        assert_eq!(squares, Ok(vec![4, 9, 16, 25, 36, 49, 64]));
        let done = AtomicUsize::new(0);
        let failed = in_threads(1, 0..100, |n, _| {
            done.fetch_add(1, Ordering::Relaxed);
            if n == 4 { Err(n) } else { Ok(n) }
        });
        assert_eq!((failed, done.into_inner()), (Err(4), 5));
        assert_eq!(in_threads(2, 0..0, |_, _| Ok::<_, ()>(())), Ok(Vec::new()));
    }
}
