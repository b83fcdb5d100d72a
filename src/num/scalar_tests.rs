use super::*;
#[test]
fn the_inverse_cube_root_is_exact_to_rounding() {
    let mut x = 1e-12_f64;
    while x < 1e12 {
        let estimate = x.inverse_cube_root_estimate() * x.cbrt();
        assert!((estimate - 1.0).abs() < 0.06, "{x}: {estimate}");
        let y = x.inverse_cube_root() * x.cbrt();
        assert!((y - 1.0).abs() < 4.0 * f64::EPSILON, "f64 {x}: {y}");
        let x_32 = x as f32;
        let z = f64::from(x_32.inverse_cube_root()) * f64::from(x_32).cbrt();
        assert!((z - 1.0).abs() < 3.0 * f64::from(f32::EPSILON), "f32 {x}: {z}");
        x *= 1.37;
    }
}

#[test]
fn min_and_max_follow_the_order() {
    assert_eq!(Real::max(1.0_f64, 2.0), 2.0);
    assert_eq!(Real::min(1.0_f32, 2.0), 1.0);
}
