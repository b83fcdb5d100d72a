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
