#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
use super::*;
use crate::case::{Motion, Rotation};

fn projectile(shape: Shape, edge_radius: f64) -> Projectile {
    Projectile {
        shape,
        edge_radius,
        mass: 3e-3,
        inertia: None,
        velocity: 155.0,
        offset: [0.0; 2],
        standoff: 0.0,
        obliquity: 0.0,
        azimuth: 0.0,
        yaw: 0.0,
        angular_velocity: [0.0; 3],
        friction: 0.0,
        motion: Motion::Free,
        rotation: Rotation::Free,
    }
}

fn cylinder(edge: f64) -> Body {
    Body::new(&projectile(Shape::Cylinder { diameter: 4.0, length: 10.0 }, edge)).unwrap()
}

fn check(body: &Body, point: [f64; 3], distance: f64, normal: [f64; 3]) {
    let g = gap(&body.profile, point);
    assert!((g.distance - distance).abs() < 1e-12, "{point:?}: {g:?}");
    for a in 0..3 {
        assert!((g.normal[a] - normal[a]).abs() < 1e-12, "{point:?}: {g:?}");
    }
}

#[test]
fn flat_cylinder() {
    let body = cylinder(0.0);
    let h = 0.5_f64.sqrt();
    check(&body, [0.0, 0.0, 5.0], 0.0, [0.0, 0.0, 1.0]);
    check(&body, [1.0, 0.5, 5.0], 0.0, [0.0, 0.0, 1.0]);
    check(&body, [0.0, 0.0, 7.0], 2.0, [0.0, 0.0, 1.0]);
    check(&body, [0.0, 3.0, 1.0], 1.0, [0.0, 1.0, 0.0]);
    check(&body, [-3.0, 0.0, 6.0], 2.0_f64.sqrt(), [-h, 0.0, h]);
    check(&body, [0.0, 1.0, 4.75], -0.25, [0.0, 0.0, 1.0]);
    check(&body, [1.75, 0.0, 0.0], -0.25, [1.0, 0.0, 0.0]);
    check(&body, [0.0, 0.0, -6.0], 1.0, [0.0, 0.0, -1.0]);
    assert!((body.support(0.0) - 5.0).abs() < 1e-12);
    assert!((body.support(0.3) - (5.0 * 0.3_f64.cos() + 2.0 * 0.3_f64.sin())).abs() < 1e-12);
}

#[test]
fn rounded_cylinder_keeps_its_size_and_rounds_its_edge() {
    let body = cylinder(0.5);
    let h = 0.5_f64.sqrt();
    check(&body, [0.0, 1.0, 5.5], 0.5, [0.0, 0.0, 1.0]);
    check(&body, [2.5, 0.0, 0.0], 0.5, [1.0, 0.0, 0.0]);
    check(&body, [1.5 + 2.0 * h, 0.0, 4.5 + 2.0 * h], 1.5, [h, 0.0, h]);
    assert_eq!(cylinder_error(3.0), Err(EdgeRadiusTooLarge));
}

fn cylinder_error(edge: f64) -> Result<Body, EdgeRadiusTooLarge> {
    Body::new(&projectile(Shape::Cylinder { diameter: 4.0, length: 10.0 }, edge))
}

#[test]
fn sphere_and_bar() {
    let sphere = Body::new(&projectile(Shape::Sphere { diameter: 2.0 }, 0.0)).unwrap();
    check(&sphere, [0.0, 3.0, 4.0], 4.0, [0.0, 0.6, 0.8]);
    check(&sphere, [0.0, 0.0, 1.0], 0.0, [0.0, 0.0, 1.0]);
    assert!((sphere.inertia[0] - 0.4 * 3e-3).abs() < 1e-15);
    let bar = Shape::Bar { diameter: 2.0, along: crate::case::Along::Weft };
    let bar = Body::new(&projectile(bar, 0.0)).unwrap();
    check(&bar, [3.0, 100.0, 4.0], 4.0, [0.6, 0.0, 0.8]);
}

#[test]
fn cone_has_its_centre_of_mass_a_quarter_up_and_its_flank_normal() {
    let shape = Shape::Cone { diameter: 6.0, length: 4.0, nose_length: 4.0 };
    let body = Body::new(&projectile(shape, 0.0)).unwrap();
    // Flank from (0, 3) to (3, −1): normal (4, 3)/5.
    check(&body, [1.5 + 0.8, 0.0, 1.0 + 0.6], 1.0, [0.8, 0.0, 0.6]);
    check(&body, [0.0, 0.0, -1.5], 0.5, [0.0, 0.0, -1.0]);
    check(&body, [0.0, 0.0, 3.5], 0.5, [0.0, 0.0, 1.0]);
    // Solid cone about its centre: 3/10 m r² and 3/20 m r² + 3/80 m h².
    assert!((body.inertia[0] - 3e-3 * 2.7).abs() < 1e-15);
    assert!((body.inertia[1] - 3e-3 * (0.15 * 9.0 + 0.0375 * 16.0)).abs() < 1e-15);
    // With a shank the whole is heavier at the tail: centre by volumes 4/3 at 3.0 … and 2 at 1.
    let shape = Shape::Cone { diameter: 6.0, length: 6.0, nose_length: 4.0 };
    let body = Body::new(&projectile(shape, 0.0)).unwrap();
    let centre = (4.0 / 3.0 * 3.0 + 2.0 * 1.0) / (4.0 / 3.0 + 2.0);
    check(&body, [0.0, 0.0, 6.0 - centre + 1.0], 1.0, [0.0, 0.0, 1.0]);
    check(&body, [4.0, 0.0, 0.5 - centre], 1.0, [1.0, 0.0, 0.0]);
}

#[test]
fn the_rim_of_a_flat_nose_holds_what_hangs_behind_it() {
    let body = cylinder(0.0);
    let at = |point: [f64; 3]| holding_gap(&body.profile, point, 1.0);
    let held = at([1.9, 0.0, 4.5]);
    assert_eq!(held.normal, [0.0, 0.0, 1.0]);
    assert!((held.distance + 0.1).abs() < 1e-12, "the true sideways depth: {held:?}");
    assert!(at([2.1, 0.0, 4.5]).distance > 1e29, "outside the shadow nothing holds");
    assert!((at([1.9, 0.0, 3.5]).normal[0] - 1.0).abs() < 1e-15);
    assert_eq!(at([1.0, 0.0, 5.1]).normal, [0.0, 0.0, 1.0]);
    let sphere = Body::new(&projectile(Shape::Sphere { diameter: 2.0 }, 0.0)).unwrap();
    assert_eq!(
        holding_gap(&sphere.profile, [0.9, 0.0, -0.1], 1.0).distance,
        gap(&sphere.profile, [0.9, 0.0, -0.1]).distance
    );
}

#[test]
fn the_normal_is_the_gradient_of_the_gap() {
    let shapes = [
        (Shape::Cylinder { diameter: 4.0, length: 10.0 }, 0.4),
        (Shape::Cone { diameter: 6.0, length: 6.0, nose_length: 4.0 }, 0.3),
        (Shape::Sphere { diameter: 3.0 }, 0.0),
    ];
    for (shape, edge) in shapes {
        let body = Body::new(&projectile(shape, edge)).unwrap();
        let mut seed = 1_u32;
        for _ in 0..500 {
            let mut next = || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed >> 8) / f64::from(1 << 24) * 16.0 - 8.0
            };
            let point = [next(), next(), next()];
            let g = gap(&body.profile, point);
            if g.distance < 0.05 {
                continue;
            }
            for a in 0..3 {
                let (mut plus, mut minus) = (point, point);
                plus[a] += 1e-6;
                minus[a] -= 1e-6;
                let slope = (gap(&body.profile, plus).distance - gap(&body.profile, minus).distance) / 2e-6;
                assert!((slope - g.normal[a]).abs() < 1e-4, "{shape:?} {point:?} {slope} {:?}", g.normal);
            }
        }
    }
}
