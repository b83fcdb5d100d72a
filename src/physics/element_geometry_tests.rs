#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::case;
use crate::model::Model;

#[test]
fn a_larger_element_has_the_constants_of_its_own_lengths() {
    let case = case::shipped(&[]);
    // Every constant another number, so that no two can be mistaken for each other.
    let c = ElementConstants::<f64> {
        gradient: [2.0, 3.0],
        membrane: [5.0, 7.0],
        half_length: [11.0, 13.0],
        hourglass: [17.0, 19.0],
        viscosity: [23.0, 29.0],
        viscous_length: [8.0, 6.0],
        mode_share: 41.0,
        cells: 31.0,
        area: 37.0,
        ..Model::<f64>::new(&case).unwrap().ply_types[0].element
    };
    // Four times as high, eight times as long: powers of two round nothing.
    let size = ElementGeometry::of_row(&c, 4.0).of_columns(8.0, 0.125);
    assert_eq!(size.gradient, [2.0 / 8.0, 3.0 / 4.0]);
    assert_eq!(size.membrane, [5.0 * 4.0, 7.0 * 8.0]);
    assert_eq!(size.half_length, [11.0 * 4.0, 13.0 * 8.0]);
    assert_eq!(size.hourglass, [17.0 / 64.0, 19.0 / 16.0]);
    assert_eq!(size.viscosity, [23.0 * 8.0, 29.0 * 4.0]);
    let larger = ElementGeometry::of_row(&c, 16.0).of_columns(32.0, 0.03125);
    assert_eq!(larger.viscosity, [23.0 * 8.0, 29.0 * 6.0]);
    assert_eq!(larger.steep_viscosity, [23.0 * 32.0, 29.0 * 16.0]);
    assert_eq!(size.mode_share, 41.0);
    assert_eq!([size.cells, size.area], [31.0 * 32.0, 37.0 * 32.0]);
}
