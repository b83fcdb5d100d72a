use super::*;

#[test]
fn even_lines_lie_at_whole_numbers() {
    let even = Lines::even(6);
    assert_eq!([0, 3, 6].map(|line| (even.at(line), even.share(line))), [(0.0, 0.5), (3.0, 1.0), (6.0, 0.5)]);
    assert_eq!(
        [-1.0, 0.99, 4.01, 8.0].map(|place| (even.element_at(place), even.nearest(place))),
        [(0, 0), (0, 1), (4, 4), (5, 6)]
    );
    assert_eq!((even.within(2, 0.0), even.within(2, 1.0), even.within(5, 9.0)), (2..3, 1..4, 0..6));
    assert_eq!((even.between(1.5, 3.2), even.between(-2.0, 9.0)), (1..5, 0..7));
    assert!(even.is_mirrored() && !Lines::even(5).is_mirrored() && even.half(true) == Lines::even(3));
}

#[test]
fn lines_of_different_elements_know_their_sizes() {
    let lines = Lines::graded(vec![0.0, 2.0, 3.0, 4.0, 6.0]);
    assert!(lines.is_mirrored() && !Lines::graded(vec![0.0, 2.0, 3.0]).is_mirrored());
    assert_eq!([0, 1, 2, 3, 4].map(|line| lines.share(line)), [1.0, 1.5, 1.0, 1.5, 1.0]);
    assert_eq!([-1.0, 1.9, 2.0, 3.5, 7.0].map(|place| lines.element_at(place)), [0, 0, 1, 2, 3]);
    assert_eq!([0.9, 1.1, 2.4, 5.1].map(|place| lines.nearest(place)), [0, 1, 1, 4]);
    assert_eq!((lines.within(1, 0.0), lines.within(1, 1.0), lines.within(2, 2.5)), (1..2, 0..3, 0..4));
    assert_eq!(lines.half(false), Lines::graded(vec![0.0, 2.0, 3.0]));
    assert!([true, false].into_iter().all(|behind| lines.half(behind).doubled(behind) == lines));
    assert_eq!((lines.widest(), lines.elements()), (2.0, 4));
}

#[test]
fn what_lies_around_an_element_is_that_of_the_whole_in_its_half() {
    assert_eq!(Lines::even(9).overlaps(4, 1.5, [false; 2]), (3, vec![1.0, 1.0, 1.0]));
    assert_eq!(Lines::even(9).overlaps(4, 3.0, [false; 2]), (1, vec![0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.5]));
    assert_eq!(Lines::even(9).overlaps(0, 1.5, [false; 2]), (0, vec![1.0, 1.0]));
    // The image of the first element lies beside it, that of the second half a length within reach.
    assert_eq!(Lines::even(9).overlaps(0, 2.0, [true, false]), (0, vec![2.0, 1.5, 0.5]));
    assert_eq!(Lines::even(9).overlaps(8, 2.0, [false, true]), (6, vec![0.5, 1.5, 2.0]));
    let lines = Lines::graded(vec![0.0, 2.0, 3.0, 4.0, 6.0]);
    assert_eq!(lines.overlaps(1, 1.5, [false; 2]), (0, vec![1.0, 1.0, 1.0]));
    assert_eq!(lines.overlaps(3, 1.5, [false; 2]), (2, vec![0.5, 2.0]));
}
