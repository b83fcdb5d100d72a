//! Scenes that are mirror images of each other.

use ripstop::run::{Precision, Run};

use super::pack;
use crate::scene::run_as;

fn shot(layup: &str, offset: [f64; 2], azimuth: f64, sets: &[&str]) -> Run {
    let pack_text = format!(r#"{{"width_mm": 38, "height_mm": 38, "spacing_mm": 0.4, {layup}}}"#);
    let projectile = format!(
        r#""projectile": {{"shape": "cylinder", "diameter_mm": 5, "length_mm": 7, "mass_g": 0.8, "velocity_m_s": 120,
        "offset_mm": {offset:?}, "obliquity_deg": 25, "azimuth_deg": {azimuth}, "friction": 0.2}},"#
    );
    run_as(&pack(&pack_text, &projectile, sets), Precision::F64, 2)
}

/// Histories that agree to round-off, over a shot in which nothing breaks. Contact amplifies it: nodes of alike plies stand on
/// corners, and walk on only a millionth of a cell beyond.
fn agree(a: &Run, b: &Run) {
    assert_eq!(a.history.len(), b.history.len());
    assert_eq!(a.history.last().unwrap().failed, [0, 0]);
    for (x, y) in a.history.iter().zip(&b.history) {
        let close = |p: f64, q: f64, scale: f64| (p - q).abs() <= 1e-4 * scale;
        assert!(close(x.projectile_velocity, y.projectile_velocity, 120.0), "{x:?}\n{y:?}");
        assert!(close(x.deflection, y.deflection, 5e-3), "{x:?}\n{y:?}");
        assert!(close(x.balance.stored, y.balance.stored, 1.0), "{x:?}\n{y:?}");
        assert!(close(x.balance.contact, y.balance.contact, 1.0), "{x:?}\n{y:?}");
    }
}

#[test]
fn a_mirrored_hit_gives_the_mirrored_shot() {
    let layup = r#""layup": [{"plies": 2}, {"orientation_deg": 90}]"#;
    let right = shot(layup, [2.1, 1.3], 0.0, &[]);
    let left = shot(layup, [-2.1, 1.3], 180.0, &[]);
    agree(&right, &left);
}

#[test]
fn a_pack_and_its_reflection_about_the_diagonal_agree() {
    // Warp and weft change places in every ply, the hit and its direction with them.
    let fabric = [
        "/fabric/warp/crimp=0.0139",
        "/fabric/weft/crimp=0.0218",
        "/fabric/weft/linear_density_denier=1000",
        "/fabric/warp/linear_density_denier=1420",
    ];
    let swapped = [
        "/fabric/warp/crimp=0.0218",
        "/fabric/weft/crimp=0.0139",
        "/fabric/weft/linear_density_denier=1420",
        "/fabric/warp/linear_density_denier=1000",
    ];
    let plain = shot(r#""plies": 3"#, [2.1, 1.3], 10.0, &fabric);
    let turned = shot(r#""plies": 3"#, [1.3, 2.1], 80.0, &swapped);
    agree(&plain, &turned);
}

#[test]
fn a_ply_laid_at_ninety_degrees_is_the_ply_with_warp_and_weft_exchanged() {
    let crimped = ["/fabric/weft/linear_density_denier=1000"];
    let turned = r#""layup": [{}, {"orientation_deg": 90}]"#;
    let turned = shot(turned, [2.1, 1.3], 10.0, &crimped);
    let exchanged = shot(
        r#""layup": [{}, {}]"#,
        [2.1, 1.3],
        10.0,
        &[
            "/fabric/weft/linear_density_denier=1000",
            "/pack/layup/1/fabric/warp/linear_density_denier=1000",
            "/pack/layup/1/fabric/weft/linear_density_denier=1420",
            "/pack/layup/1/fabric/warp/crimp=0.0139",
            "/pack/layup/1/fabric/weft/crimp=0.0218",
        ],
    );
    agree(&turned, &exchanged);
}
