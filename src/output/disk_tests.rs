#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use std::sync::Barrier;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::*;

#[test]
fn a_folder_is_held_by_one_until_it_lets_go() {
    let folder = tempfile::tempdir().unwrap();
    let first = Lock::take(folder.path()).unwrap().unwrap();
    assert!(Lock::take(folder.path()).unwrap().is_none());
    drop(first);
    assert!(!folder.path().join(LOCK).exists());
    // What a killed process leaves.
    fs::write(folder.path().join(LOCK), "").unwrap();
    assert!(Lock::take(folder.path()).unwrap().is_some());
}

#[test]
fn a_folder_of_the_same_name_is_another() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("out");
    fs::create_dir(&folder).unwrap();
    let lock = Lock::take(&folder).unwrap().unwrap();
    assert!(lock.has_folder(&folder));
    fs::remove_dir_all(&folder).unwrap();
    assert!(!lock.has_folder(&folder));
    fs::create_dir(&folder).unwrap();
    assert!(!lock.has_folder(&folder));
    // The lock of who has come since is not removed.
    let next = Lock::take(&folder).unwrap().unwrap();
    drop(lock);
    assert!(next.has_file());
}

#[test]
fn of_many_at_once_never_two_hold_it() {
    let folder = tempfile::tempdir().unwrap();
    let (inside, start) = (AtomicUsize::new(0), Barrier::new(4));
    let contend = || {
        start.wait();
        let mut taken = 0;
        while taken < 200 {
            let Some(lock) = Lock::take(folder.path()).unwrap() else { continue };
            assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0, "two hold it");
            taken += 1;
            thread::yield_now();
            inside.fetch_sub(1, Ordering::SeqCst);
            drop(lock);
        }
        taken
    };
    let taken: usize = thread::scope(|scope| {
        let threads = [0; 4].map(|_| scope.spawn(contend));
        threads.into_iter().map(|thread| thread.join().unwrap()).sum()
    });
    assert_eq!(taken, 800);
}
