use super::*;

#[test]
fn places_lie_between_the_middles_of_cells_and_mirror_images_where_the_cells_do() {
    // Cells of 1, 1 and 2 m of the far half of a ply of 8 m.
    let span = Span { lines: vec![0.0, 1.0, 2.0, 4.0], start: 4.0, whole: 8.0 };
    let at = |place: f64| span.around(place);
    assert_eq!(at(4.5), Around { cell: 0, next: 1, share: 0.0 });
    assert_eq!(at(5.0), Around { cell: 1, next: 0, share: 0.5 });
    assert_eq!(at(6.25), Around { cell: 2, next: 1, share: 0.5 });
    assert_eq!(at(7.5), Around { cell: 2, next: 2, share: 0.0 });
    assert_eq!(at(1.75), at(6.25));
}
