use super::*;

#[test]
fn places_lie_in_cells_and_mirror_images_where_the_cells_do() {
    // Cells of 1, 1 and 2 m of the far half of a ply of 8 m.
    let span = Span { lines: vec![0.0, 1.0, 2.0, 4.0], start: 4.0, whole: 8.0 };
    assert_eq!([4.5, 5.5, 6.25, 7.9, 8.0].map(|place| span.cell(place)), [0, 1, 2, 2, 2]);
    assert_eq!([3.5, 2.5, 1.75, 0.1, 0.0].map(|place| span.cell(place)), [0, 1, 2, 2, 2]);
}
