use super::some;

#[test]
fn some_of_many_hold_the_last() {
    assert_eq!(some(6, 6), [0, 1, 2, 3, 4, 5]);
    assert_eq!(some(51, 6).last(), Some(&50));
    assert_eq!(some(2, 6), [0, 1]);
    assert!(some(0, 6).is_empty());
}
