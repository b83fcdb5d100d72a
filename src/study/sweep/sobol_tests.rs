use super::*;

#[test]
fn the_first_points_are_the_published_ones() {
    let points = sobol(3, 7);
    let of = |dimension: usize| points.iter().map(|point| point[dimension]).collect::<Vec<_>>();
    assert_eq!(of(0), [0.5, 0.75, 0.25, 0.375, 0.875, 0.625, 0.125]);
    assert_eq!(of(1), [0.5, 0.25, 0.75, 0.375, 0.875, 0.125, 0.625]);
    assert_eq!(of(2), [0.5, 0.25, 0.75, 0.625, 0.125, 0.875, 0.375]);
}

#[test]
fn every_dimension_and_every_pair_of_the_first_two_is_filled_evenly() {
    let points = sobol(MAX_DIMENSIONS, 255);
    for dimension in 0..MAX_DIMENSIONS {
        let mut cells: Vec<usize> = points.iter().map(|point| (point[dimension] * 256.0) as usize).collect();
        cells.sort_unstable();
        assert_eq!(cells, (1..256).collect::<Vec<_>>(), "{dimension}");
    }
    let mut cells = [0; 256];
    points.iter().for_each(|point| cells[16 * (point[0] * 16.0) as usize + (point[1] * 16.0) as usize] += 1);
    // The origin's cell lacks it.
    assert!(cells[0] == 0 && cells[1..].iter().all(|count| *count == 1));
}
