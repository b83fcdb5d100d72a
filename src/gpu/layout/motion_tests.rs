use super::*;

#[test]
fn positions_survive_the_fixed_point() {
    for x in [0.0, -1e-12, 1e-3, -0.02, 0.314_159, -3.0, 1e3] {
        let [coarse, fine] = fixed(x);
        assert!((0..1 << 24).contains(&fine), "{x}: {fine}");
        assert!((metres(coarse as u32, fine as u32) - x).abs() <= 0.5 / FIXED_POINT_SCALE, "{x}");
    }
}
