use super::*;
#[test]
fn graded_lines_at_even_places_answer_like_even_ones() {
    let (even, graded) = (Lines::even(6), Lines::graded((0..=6).map(f64::from).collect()));
    for line in 0..=6 {
        assert_eq!((even.at(line), even.share(line)), (graded.at(line), graded.share(line)));
    }
    for step in -10..80 {
        let place = 0.1 * f64::from(step) + 0.01;
        assert_eq!(even.element_at(place), graded.element_at(place), "{place}");
        assert_eq!(even.nearest(place), graded.nearest(place), "{place}");
    }
    for element in 0..6 {
        for reach in [0.0, 1.0, 2.0, 9.0] {
            assert_eq!(even.within(element, reach), graded.within(element, reach), "{element} {reach}");
        }
    }
    assert!(even.is_mirrored() && graded.is_mirrored() && !Lines::even(5).is_mirrored());
    assert_eq!(graded.half(true), Lines::graded(vec![0.0, 1.0, 2.0, 3.0]));
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
