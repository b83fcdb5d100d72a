#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
use super::*;
use crate::kernels::projectile_shape::gap;
use crate::kernels::projectile_shape::tests::{Numbers, projectile};
use crate::kernels::rigid_body::RigidBody;

const SHAPES: [Shape; 5] = [
    Shape::Cylinder { diameter: 6.0, length: 4.0 },
    Shape::Cone { diameter: 6.0, length: 8.0, nose_length: 5.0 },
    Shape::Ogive { diameter: 6.0, length: 8.0, nose_length: 6.0 },
    Shape::Fragment { diameter: 6.0, length: 7.0, nose_flat: 2.8, nose_angle: 0.611, roll: 0.4 },
    Shape::Fragment { diameter: 6.0, length: 7.0, nose_flat: 1.0, nose_angle: 1.0, roll: -2.0 },
];

/// Height of the centre, and second moments of what lies inside, by counting cells in a quarter of the body.
fn count(body: &Body) -> (f64, [f64; 3]) {
    const CELL: [f64; 3] = [0.08, 0.08, 0.02];
    let (mut cells, mut first, mut second) = (0.0, 0.0, [0.0; 3]);
    for i in 0..38 {
        for j in 0..38 {
            for k in -300..300 {
                let point = [0, 1, 2].map(|a| (f64::from([i, j, k][a]) + 0.5) * CELL[a]);
                if gap(&body.profile, point).distance < 0.0 {
                    cells += 1.0;
                    first += point[2];
                    for a in 0..3 {
                        second[a] += point[a] * point[a];
                    }
                }
            }
        }
    }
    (first / cells, second.map(|x| x / cells))
}

#[test]
fn inertia_is_that_of_the_solid_and_the_origin_its_centre_of_mass() {
    for shape in SHAPES {
        let body = Body::new(&projectile(shape, 0.0)).unwrap();
        let (centre, [x, y, z]) = count(&body);
        assert!(centre.abs() < 1e-2, "{shape:?}: {centre:?}");
        let mass = projectile(shape, 0.0).mass;
        for (got, expected) in body.inertia.into_iter().zip([y + z, x + z, x + y]) {
            assert!((got / (mass * expected) - 1.0).abs() < 4e-3, "{shape:?}: {got} for {}", mass * expected);
        }
    }
}

#[test]
fn reach_and_radius_hold_the_whole_body() {
    for shape in SHAPES {
        for edge in [0.0, 0.3] {
            let body = Body::new(&projectile(shape, edge)).unwrap();
            let mut numbers = Numbers(2);
            let mut furthest = 0.0_f64;
            for _ in 0..5000 {
                let d = numbers.point();
                let size = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                let support = body.support(d.map(|x| x / size));
                assert!(support <= body.bounding_radius + 1e-12, "{shape:?}");
                furthest = furthest.max(support);
            }
            assert!(furthest > 0.99 * body.bounding_radius, "{shape:?}: {furthest} of {}", body.bounding_radius);
            let sideways = body.support([0.6, 0.8, 0.0]);
            assert!((sideways - body.radius).abs() < 1e-12 && (body.radius - 3.0).abs() < 1e-12, "{shape:?}");
        }
    }
}

/// Least value of a convex function of a number.
fn least(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-40.0, 40.0);
    for _ in 0..90 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if f(a) < f(b) { high = b } else { low = a }
    }
    f(0.5 * (low + high))
}

#[test]
fn every_shape_starts_at_its_standoff() {
    let mut numbers = Numbers(4);
    for shape in SHAPES {
        for edge in [0.0, 0.3] {
            let mut p = projectile(shape, edge);
            let turn = numbers.next();
            if let Shape::Fragment { roll, .. } = &mut p.shape {
                *roll = turn;
            }
            p.standoff = 0.7;
            p.obliquity = 0.1 * numbers.next().abs();
            (p.azimuth, p.yaw) = (numbers.next(), 0.3 * numbers.next());
            let body = RigidBody::new(&p, Body::new(&p).unwrap(), 1.0);
            // The gap is convex in the plane of the fabric, and so is its least value along a line of it.
            let over =
                |x: f64, y: f64| body.gap(&nalgebra::Vector3::new(x + body.position.x, y + body.position.y, 0.0)).0;
            let nearest = least(|x| least(|y| over(x, y)));
            assert!((nearest - 0.7).abs() < 1e-9, "{p:?}: {nearest}");
        }
    }
}

#[test]
fn roll_turns_the_edge_of_a_chisel_from_warp_towards_weft() {
    let shape = Shape::Fragment { diameter: 6.0, length: 7.0, nose_flat: 2.8, nose_angle: 0.611, roll: 0.5 };
    let p = projectile(shape, 0.0);
    let body = RigidBody::new(&p, Body::new(&p).unwrap(), 1.0);
    let top = body.position.z + body.body.profile.corner[1][1];
    let gap = |x: f64, y: f64| body.gap(&nalgebra::Vector3::new(x, y, top)).0;
    let (sine, cosine) = 0.5_f64.sin_cos();
    assert!(gap(2.5 * cosine, 2.5 * sine).abs() < 1e-12, "along the strip the plane touches");
    assert!(gap(-2.5 * sine, 2.5 * cosine) > 0.5, "across it the flats fall off");
}

#[test]
fn only_a_flat_face_has_a_round_rim() {
    let rim = |shape| Body::new(&projectile(shape, 0.0)).unwrap().profile.has_round_rim();
    assert_eq!(SHAPES.map(rim), [true, false, false, false, false]);
    assert!(!rim(Shape::Sphere { diameter: 6.0 }));
    assert!(!rim(Shape::Bar { diameter: 6.0, along: crate::case::Along::Weft }));
}

#[test]
fn no_point_of_a_body_is_faster_than_its_bound() {
    let mut projectile = projectile(Shape::Cylinder { diameter: 6.0e-3, length: 4.0e-3 }, 0.0);
    projectile.angular_velocity = [0.0, 2e4, 0.0];
    let body = RigidBody::new(&projectile, Body::new(&projectile).unwrap(), 0.0);
    let furthest = nalgebra::Vector3::new(0.0, 0.0, body.body.bounding_radius);
    let turning = body.velocity_at(&furthest).norm_squared() - body.velocity.norm_squared();
    assert!((turning.sqrt() + body.velocity.norm() - body.speed_bound()).abs() < 1e-9, "{}", body.speed_bound());
}

#[test]
fn nothing_of_a_body_lies_beyond_its_supporting_planes() {
    // In metres, as in a case.
    let shapes = [
        Shape::Ogive { diameter: 6e-3, length: 8e-3, nose_length: 6e-3 },
        Shape::Cone { diameter: 6e-3, length: 8e-3, nose_length: 5e-3 },
    ];
    for shape in shapes {
        let body = Body::new(&projectile(shape, 0.0)).unwrap();
        let inside: Vec<[f64; 3]> = (0..=30)
            .flat_map(|i| (-80..=80).map(move |k| [1e-4 * f64::from(i), 0.0, 1e-4 * f64::from(k)]))
            .filter(|point| gap(&body.profile, *point).distance < 0.0)
            .collect();
        for i in 0..=60 {
            let (along, across) = (std::f64::consts::PI * f64::from(i) / 60.0).sin_cos();
            let direction = [along, 0.0, across];
            let furthest = inside.iter().map(|p| p[0] * along + p[2] * across).fold(f64::MIN, f64::max);
            let support = body.support(direction);
            // The points are a tenth of a millimetre apart.
            assert!((-1e-9..1.5e-4).contains(&(support - furthest)), "{shape:?} {direction:?}: {support} {furthest}");
        }
    }
}
