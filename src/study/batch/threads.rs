//! Independent work in parallel, results in order.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Does `work` for every number, on at most so many threads at a time. Its second argument is raised once one of them has failed: the others
/// may give up then.
///
/// # Errors
/// The first in time: what was given up because of it does not hide it.
pub(in crate::study) fn in_threads<T: Send, E: Send>(
    threads: usize,
    numbers: Range<usize>,
    work: impl Fn(usize, &AtomicBool) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let (next, given_up) = (AtomicUsize::new(numbers.start), AtomicBool::new(false));
    let (results, failed) = (Mutex::new(Vec::new()), Mutex::new(None));
    let worker = || {
        while !given_up.load(Ordering::Relaxed) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if !numbers.contains(&number) {
                return;
            }
            match work(number, &given_up) {
                Ok(result) => results.lock().unwrap_or_else(PoisonError::into_inner).push((number, result)),
                Err(error) => {
                    failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                    given_up.store(true, Ordering::Relaxed);
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads.min(numbers.len()) {
            scope.spawn(worker);
        }
    });
    if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(number, _)| *number);
    Ok(results.into_iter().map(|(_, result)| result).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

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
