#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use super::*;
use crate::case::{Motion, Projectile, Rotation, Shape};

/// A projectile of that shape, with nothing else about it.
pub(crate) fn projectile(shape: Shape, edge_radius: f64) -> Projectile {
    Projectile {
        shape,
        edge_radius,
        mass: 3e-3,
        density: None,
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

/// Radius 3, an arc of radius 4.5.
const OGIVE: Shape = Shape::Ogive { diameter: 6.0, length: 7.0, nose_length: 3.0 * std::f64::consts::SQRT_2 };
/// The shortest ogive there is.
const HALF_BALL: Shape = Shape::Ogive { diameter: 6.0, length: 7.0, nose_length: 3.0 };

/// Numbers between −8 and 8.
pub(crate) struct Numbers(pub(crate) u32);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 24) * 16.0 - 8.0
    }

    /// Between −1 and 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.next() / 8.0
    }

    pub(crate) fn point(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
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
    assert!((body.support([0.0, 0.0, 1.0]) - 5.0).abs() < 1e-12);
    let (sine, cosine) = 0.3_f64.sin_cos();
    assert!((body.support([0.6 * sine, -0.8 * sine, cosine]) - (5.0 * cosine + 2.0 * sine)).abs() < 1e-12);
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
    assert!((body.inertia[2] - 3e-3 * 2.7).abs() < 1e-15);
    assert!((body.inertia[0] - 3e-3 * (0.15 * 9.0 + 0.0375 * 16.0)).abs() < 1e-15);
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
    let at = |point: [f64; 3]| contact_distance(&body.profile, point, 1.0);
    let held = at([1.9, 0.0, 4.5]);
    assert_eq!(held.normal, [0.0, 0.0, 1.0]);
    assert!((held.distance + 0.1).abs() < 1e-12, "the true sideways depth: {held:?}");
    assert!(at([2.1, 0.0, 4.5]).distance > 1e29, "outside the shadow nothing holds");
    assert!((at([1.9, 0.0, 3.5]).normal[0] - 1.0).abs() < 1e-15);
    assert_eq!(at([1.0, 0.0, 5.1]).normal, [0.0, 0.0, 1.0]);
    let sphere = Body::new(&projectile(Shape::Sphere { diameter: 2.0 }, 0.0)).unwrap();
    assert_eq!(
        contact_distance(&sphere.profile, [0.9, 0.0, -0.1], 1.0).distance,
        gap(&sphere.profile, [0.9, 0.0, -0.1]).distance
    );
}

/// The outline of the ogives, densely, (ρ, s) from the tail.
fn outline(shape: Shape, at: usize, of: usize) -> [[f64; 2]; 3] {
    let Shape::Ogive { diameter, length, nose_length } = shape else { panic!("{shape:?}") };
    let (r, part) = (0.5 * diameter, at as f64 / of as f64);
    let arc = (r * r + nose_length * nose_length) / (2.0 * r);
    let angle = part * (nose_length / arc).min(1.0).asin();
    let shank = length - nose_length;
    [[r - arc + arc * angle.cos(), shank + arc * angle.sin()], [r, part * shank], [part * r, 0.0]]
}

#[test]
fn the_gap_of_an_ogive_is_the_distance_of_its_nearest_point() {
    const PARTS: usize = 20_000;
    for shape in [OGIVE, HALF_BALL, Shape::Ogive { diameter: 6.0, length: 9.0, nose_length: 9.0 }] {
        let body = Body::new(&projectile(shape, 0.0)).unwrap();
        let tail = body.profile.corner[body.profile.count - 1][1];
        let mut numbers = Numbers(7);
        for _ in 0..60 {
            let point = numbers.point().map(|x| 0.8 * x);
            let (rho, s) = (point[0].hypot(point[1]), point[2] - tail);
            let near = |p: &[f64; 2]| (p[0] - rho).hypot(p[1] - s);
            let nearest = (0..=PARTS).flat_map(|at| outline(shape, at, PARTS)).map(|p| near(&p)).fold(1e9, f64::min);
            let g = gap(&body.profile, point);
            assert!((g.distance.abs() - nearest).abs() < 1e-6 / nearest, "{shape:?} {point:?}: {g:?}, {nearest}");
            assert!((g.normal.map(|n| n * n).iter().sum::<f64>() - 1.0).abs() < 1e-12, "{point:?}: {g:?}");
        }
    }
}

#[test]
fn an_ogive_has_its_tip_its_arc_and_its_wall() {
    let body = Body::new(&projectile(OGIVE, 0.0)).unwrap();
    let [tip, shoulder] = [body.profile.corner[0][1], body.profile.corner[1][1]];
    assert!((body.profile.arc - 4.5).abs() < 1e-12);
    check(&body, [0.0, 0.0, tip + 0.5], 0.5, [0.0, 0.0, 1.0]);
    check(&body, [0.0, 0.0, tip], 0.0, [0.0, 0.0, 1.0]);
    // From the arc's centre, which lies beyond the axis, at 45°.
    let h = 0.5_f64.sqrt();
    check(&body, [0.0, -1.5 + 5.0 * h, shoulder + 5.0 * h], 0.5, [0.0, h, h]);
    check(&body, [0.0, -1.5 + 4.4 * h, shoulder + 4.4 * h], -0.1, [0.0, h, h]);
    check(&body, [-3.25, 0.0, shoulder], 0.25, [-1.0, 0.0, 0.0]);
    check(&body, [-2.75, 0.0, shoulder - 1.0], -0.25, [-1.0, 0.0, 0.0]);
    assert!((body.support([0.0, 0.0, 1.0]) - tip).abs() < 1e-12);
    assert!((body.support([h, 0.0, h]) - (-1.5 * h + shoulder * h + 4.5)).abs() < 1e-12);
    assert!(!body.profile.is_flat() && !Body::new(&projectile(HALF_BALL, 0.0)).unwrap().profile.is_flat());
}

#[test]
fn beside_a_side_the_normal_is_that_side_s_however_near() {
    // In single precision the direction to the surface is noise there.
    let single = |body: &Body| {
        let p = body.profile;
        let pairs = |list: [[f64; 2]; CORNERS]| list.map(|pair| pair.map(|x| x as f32));
        let (corner, normal) = (pairs(p.corner), pairs(p.normal));
        Outline { corner, normal, count: p.count, radius: 0.0, arc: p.arc as f32, bar: false, chisel: None }
    };
    let cylinder = single(&cylinder(0.0));
    for distance in [1e-6_f32, 1e-5, 1e-4] {
        assert_eq!(gap(&cylinder, [1.3, 0.4, 5.0 + distance]).normal, [0.0, 0.0, 1.0]);
    }
    let body = Body::new(&projectile(OGIVE, 0.0)).unwrap();
    let h = 0.5_f64.sqrt();
    let point = [-1.5 + 4.5 * h, 0.0, body.profile.corner[1][1] + 4.5 * h].map(|x| x as f32);
    let g = gap(&single(&body), [point[0] + 1e-6, point[1], point[2]]);
    assert!((g.normal[0] - h as f32).abs() < 1e-6 && (g.normal[2] - h as f32).abs() < 1e-6, "{g:?}");
}

const ANGLES: [f64; 4] = [0.1, 0.611, 1.0, 1.3];

fn fragment(nose_angle: f64, edge: f64) -> Body {
    let shape = Shape::Fragment { diameter: 6.0, length: 12.0, nose_flat: 2.8, nose_angle, roll: 0.0 };
    Body::new(&projectile(shape, edge)).unwrap()
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
            let distance = chisel_gap(&body.profile, &body.profile.chisel.unwrap(), point).distance;
            // No point of the surface is nearer, and one of the sample, up to 0.04 apart, is hardly farther.
            assert!(nearest >= distance.abs() - 1e-12, "{angle} {point:?}: {distance}, {nearest}");
            assert!(nearest - distance.abs() < 0.02, "{angle} {point:?}: {distance}, {nearest}");
        }
    }
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
fn a_rounding_that_leaves_no_strip_does_not_fit() {
    let with = |edge: f64| {
        let shape = Shape::Fragment { diameter: 6.0, length: 12.0, nose_flat: 0.4, nose_angle: 1.0, roll: 0.0 };
        Body::new(&projectile(shape, edge))
    };
    let largest = 0.2 / 0.5_f64.tan();
    assert!(with(0.999 * largest).is_ok());
    assert_eq!(with(1.001 * largest), Err(EdgeRadiusTooLarge));
}
