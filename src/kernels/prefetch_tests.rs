use super::lines;

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
