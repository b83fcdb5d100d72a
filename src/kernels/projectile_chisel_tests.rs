#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
use super::*;
use crate::case::Shape;
use crate::kernels::projectile_shape::tests::{Numbers, projectile};
use crate::kernels::projectile_shape::{self, Body, EdgeRadiusTooLarge, contact_distance, recess};

const ANGLES: [f64; 4] = [0.1, 0.611, 1.0, 1.3];

fn fragment(nose_angle: f64, edge: f64) -> Body {
    let shape = Shape::Fragment { diameter: 6.0, length: 12.0, nose_flat: 2.8, nose_angle, roll: 0.0 };
    Body::new(&projectile(shape, edge)).unwrap()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Points of the sharp surface: nose, wall and tail.
fn surface(body: &Body, parts: usize) -> Vec<[f64; 3]> {
    let p = &body.profile;
    let ([radius, front], back) = (p.corner[1], p.corner[2][1]);
    let mut out = Vec::new();
    for i in 0..=parts {
        let (sine, cosine) = (std::f64::consts::TAU * i as f64 / parts as f64).sin_cos();
        let top = front - recess(p, [0.0, radius * sine, 0.0]);
        for j in 0..=parts {
            let part = j as f64 / parts as f64;
            let [x, y] = [radius * part * cosine, radius * part * sine];
            out.push([x, y, front - recess(p, [x, y, 0.0])]);
            out.push([x, y, back]);
            out.push([radius * cosine, radius * sine, back + part * (top - back)]);
        }
    }
    out
}

#[test]
fn the_gap_is_the_distance_of_the_nearest_point() {
    for angle in ANGLES {
        let body = fragment(angle, 0.0);
        let surface = surface(&body, 300);
        let mut numbers = Numbers(3);
        for _ in 0..40 {
            let point = numbers.point();
            let far = |q: &[f64; 3]| (q[0] - point[0]).hypot(q[1] - point[1]).hypot(q[2] - point[2]);
            let nearest = surface.iter().map(far).fold(1e9, f64::min);
            let distance = gap(&body.profile, &body.profile.chisel.unwrap(), point).distance;
            // No point of the surface is nearer, and one of the sample, up to 0.04 apart, is hardly farther.
            assert!(nearest >= distance.abs() - 1e-12, "{angle} {point:?}: {distance}, {nearest}");
            assert!(nearest - distance.abs() < 0.02, "{angle} {point:?}: {distance}, {nearest}");
        }
    }
}

#[test]
fn a_plane_through_the_nearest_point_parts_body_and_point() {
    // To rounding: the body lies behind its supporting plane along the normal, and the point that far in front of it.
    for angle in ANGLES {
        for edge in [0.0, 0.4] {
            let body = fragment(angle, edge);
            let mut numbers = Numbers(5);
            for _ in 0..20_000 {
                let point = numbers.point();
                let g = projectile_shape::gap(&body.profile, point);
                assert!((dot(g.normal, g.normal) - 1.0).abs() < 1e-12, "{point:?}: {g:?}");
                let apart = dot(g.normal, point) - body.support(g.normal);
                assert!((apart - g.distance).abs() < 1e-11, "{angle}, {edge}, {point:?}: {g:?} for {apart}");
            }
        }
    }
}

#[test]
fn no_point_of_the_surface_lies_beyond_the_support() {
    for angle in ANGLES {
        let body = fragment(angle, 0.0);
        let surface = surface(&body, 200);
        let mut numbers = Numbers(9);
        for _ in 0..50 {
            let d = numbers.point();
            let size = dot(d, d).sqrt();
            let d = d.map(|x| x / size);
            let furthest = surface.iter().map(|q| dot(*q, d)).fold(-1e9, f64::max);
            let support = body.support(d);
            assert!(support > furthest - 1e-12 && support - furthest < 0.04, "{angle} {d:?}: {support}, {furthest}");
        }
    }
}

#[test]
fn faces_edges_and_corners_of_a_chisel() {
    let body = fragment(0.611, 0.0);
    let front = body.profile.corner[1][1];
    let (sine, cosine) = 0.611_f64.sin_cos();
    let near = |point: [f64; 3], distance: f64, normal: [f64; 3]| {
        let g = projectile_shape::gap(&body.profile, point);
        let off = (0..3).map(|a| (g.normal[a] - normal[a]).abs()).fold((g.distance - distance).abs(), f64::max);
        assert!(off < 1e-12, "{point:?}: {g:?}");
    };
    near([1.0, -0.5, front + 0.3], 0.3, [0.0, 0.0, 1.0]);
    near([2.9, 0.0, front - 0.05], -0.05, [0.0, 0.0, 1.0]);
    near(
        [-3.2, 0.1, front - 2.0],
        3.2_f64.hypot(0.1) - 3.0,
        [-3.2 / 3.2_f64.hypot(0.1), 0.1 / 3.2_f64.hypot(0.1), 0.0],
    );
    // 0.2 over a flat, half way down.
    let at = |up: f64| [0.4, -(2.2 + up * sine), front - 0.8 * sine / cosine + up * cosine];
    near(at(0.2), 0.2, [0.0, -sine, cosine]);
    near(at(0.0), 0.0, [0.0, -sine, cosine]);
    near(at(-0.1), -0.1, [0.0, -sine, cosine]);
    // Over the edge between strip and flat, in the middle of its fan.
    let (half_sine, half_cosine) = 0.3055_f64.sin_cos();
    near([0.3, 1.4 + half_sine, front + half_cosine], 1.0, [0.0, half_sine, half_cosine]);
}

#[test]
fn behind_a_chisel_nose_nodes_are_held_along_the_face_in_front_of_them() {
    let body = fragment(0.611, 0.0);
    let front = body.profile.corner[1][1];
    let (sine, cosine) = 0.611_f64.sin_cos();
    let held = |point: [f64; 3]| contact_distance(&body.profile, point, 1.0);
    assert_eq!(held([2.95, 0.2, front - 0.5]).normal, [0.0, 0.0, 1.0]);
    assert!((held([2.95, 0.0, front - 0.5]).distance + 0.05).abs() < 1e-12, "the true sideways depth");
    let low = front - 1.5 * sine / cosine;
    assert_eq!(held([0.0, -2.9, low - 0.5]).normal, [0.0, -sine, cosine]);
    assert!(held([0.0, -3.1, low - 0.5]).distance > 1e29, "outside the shadow nothing holds");
    assert!((held([0.0, -2.95, low - 1.2]).normal[1] + 1.0).abs() < 1e-12);
}

#[test]
fn a_strip_as_wide_as_the_body_makes_a_cylinder() {
    for edge in [0.0, 0.5] {
        let shape = Shape::Fragment { diameter: 6.0, length: 12.0, nose_flat: 6.0, nose_angle: 0.6, roll: 0.0 };
        let chisel = Body::new(&projectile(shape, edge)).unwrap();
        let cylinder = Body::new(&projectile(Shape::Cylinder { diameter: 6.0, length: 12.0 }, edge)).unwrap();
        let mut numbers = Numbers(11);
        for _ in 0..2000 {
            let point = numbers.point();
            let [a, b] = [&chisel, &cylinder].map(|body| projectile_shape::gap(&body.profile, point));
            assert!((a.distance - b.distance).abs() < 1e-12, "{point:?}: {a:?} {b:?}");
            assert!((0..3).all(|i| (a.normal[i] - b.normal[i]).abs() < 1e-12), "{point:?}: {a:?} {b:?}");
        }
        assert!((0..3).all(|a| (chisel.inertia[a] / cylinder.inertia[a] - 1.0).abs() < 1e-12));
    }
}

#[test]
fn a_rounding_that_leaves_no_strip_does_not_fit() {
    let with = |edge: f64| {
        let shape = Shape::Fragment { diameter: 6.0, length: 12.0, nose_flat: 0.4, nose_angle: 1.0, roll: 0.0 };
        Body::new(&projectile(shape, edge))
    };
    let largest = 0.2 / 0.5_f64.tan();
    assert!(with(0.999 * largest).is_ok());
    assert_eq!(with(1.001 * largest), Err(EdgeRadiusTooLarge));
}
