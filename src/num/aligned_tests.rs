use super::*;
fn begins_a_line<S>(number: &S) -> bool {
    std::ptr::from_ref(number).addr().is_multiple_of(CACHE_LINE)
}

#[test]
fn the_number_asked_for_begins_a_line_in_copies_too() {
    for first in [0, 1, 7, 8, 17] {
        let mut numbers = Aligned::new(0.0_f64, 100, first);
        assert!(begins_a_line(&numbers[first]), "{first}");
        numbers[99] = 3.0;
        let copies: Vec<_> = (0..5).map(|_| numbers.clone()).collect();
        for copy in &copies {
            assert!(begins_a_line(&copy[first]) && *copy == numbers && copy.len() == 100, "{first}");
        }
        let singles = Aligned::new(1.0_f32, 3, first);
        assert!(singles.iter().all(|x| *x == 1.0) && singles.len() == 3);
    }
    assert!(begins_a_line(&Aligned::new(0_f32, 40, 17)[17]));
}

#[test]
fn every_line_is_asked_for_once_however_many_columns_go_at_once() {
    for lanes in [1, 2, 4, 8, 16, 32] {
        let of = |columns: usize| (0..columns).step_by(lanes).map(move |column| column..column + lanes);
        let double: Vec<usize> = of(64).flat_map(lines::<f64>).collect();
        let single: Vec<usize> = of(64).flat_map(lines::<f32>).collect();
        assert_eq!(double, [0, 8, 16, 24, 32, 40, 48, 56], "{lanes}");
        assert_eq!(single, [0, 16, 32, 48], "{lanes}");
    }
}
