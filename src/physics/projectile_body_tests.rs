#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use super::*;
use crate::physics::projectile_shape::gap;
use crate::physics::projectile_shape::tests::{Numbers, projectile};
use crate::physics::rigid_body::RigidBody;

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

/// A body of revolution or a bar, with every corner rounded by `edge`.
fn body(shape: Shape, edge: f64) -> Body {
    Body::new(&projectile(shape, edge)).unwrap()
}

#[test]
fn a_plane_through_the_nearest_point_parts_point_and_body() {
    // To rounding: the body lies behind its supporting plane along the normal, and the point that far in front of it.
    let more = [
        (Shape::Sphere { diameter: 6.0 }, 0.0),
        (Shape::Bar { diameter: 6.0, along: crate::case::Along::Warp }, 0.0),
        (Shape::Cone { diameter: 6.0, length: 5.0, nose_length: 5.0 }, 0.0),
        (Shape::Cone { diameter: 6.0, length: 5.0, nose_length: 5.0 }, 0.4),
        (Shape::Ogive { diameter: 6.0, length: 9.0, nose_length: 9.0 }, 0.0),
        (Shape::Ogive { diameter: 6.0, length: 9.0, nose_length: 9.0 }, 0.4),
        (Shape::Ogive { diameter: 6.0, length: 7.0, nose_length: 3.0 }, 0.0),
    ];
    let mut numbers = Numbers(31);
    for (shape, edge) in SHAPES.into_iter().flat_map(|shape| [(shape, 0.0), (shape, 0.3)]).chain(more) {
        let body = body(shape, edge);
        let points = (0..2000).map(|_| numbers.point()).chain([[0.0, 0.0, 7.3], [0.0, 0.0, -7.3]]);
        for point in points.collect::<Vec<_>>() {
            let g = gap(&body.profile, point);
            let along = |d: [f64; 3]| g.normal[0] * d[0] + g.normal[1] * d[1] + g.normal[2] * d[2];
            assert!((along(g.normal) - 1.0).abs() < 1e-12, "{shape:?} {point:?}: {g:?}");
            let apart = along(point) - body.support(g.normal);
            assert!((apart - g.distance).abs() < 1e-11, "{shape:?} {edge} {point:?}: {g:?} for {apart}");
        }
    }
}

#[test]
fn the_largest_rounding_is_that_of_the_first_side_that_vanishes() {
    let cone = |length: f64, nose: f64| Shape::Cone { diameter: 6.0, length, nose_length: nose };
    let flank = 3.0_f64.hypot(4.0);
    // Half the turn of a flank of 3 to 4 into its wall: its tangent is a third.
    let largest = [
        (Shape::Cylinder { diameter: 6.0, length: 9.0 }, 3.0),
        (Shape::Cylinder { diameter: 6.0, length: 4.0 }, 2.0),
        // A wall of one loses the radius at its tail and a third of it at the nose.
        (cone(5.0, 4.0), 1.0 / (1.0 + 1.0 / 3.0)),
        // The flank loses the radius over the tangent of half its tip.
        (cone(14.0, 4.0), flank / (4.0 / 3.0 + 1.0 / 3.0)),
        // The circle in a triangle.
        (cone(4.0, 4.0), 3.0 * 4.0 / (3.0 + flank)),
    ];
    for (shape, largest) in largest {
        let with = |edge: f64| Body::new(&projectile(shape, edge)).is_ok();
        assert!(with(largest * (1.0 - 1e-9)) && !with(largest * (1.0 + 1e-9)), "{shape:?}: {largest}");
    }
}

#[test]
fn a_body_rounded_to_the_full_is_a_ball_or_a_rod_with_round_ends() {
    let ogive = |length: f64| Shape::Ogive { diameter: 6.0, length, nose_length: 3.0 };
    let mut numbers = Numbers(32);
    for (shape, rod) in [
        (Shape::Cylinder { diameter: 6.0, length: 6.0 }, 0.0),
        (Shape::Cylinder { diameter: 6.0, length: 8.0 }, 2.0),
        (ogive(6.0), 0.0),
        (ogive(8.0), 2.0),
    ] {
        let profile = body(shape, 3.0).profile;
        let (nose, tail) = (profile.corner[0][1], profile.corner[profile.count - 1][1]);
        assert!((nose - tail - rod).abs() < 1e-14, "{shape:?}: {profile:?}");
        for _ in 0..500 {
            let point = numbers.point();
            let on = point[2].clamp(tail, nose);
            let away = [point[0], point[1], point[2] - on];
            let far = away[0].hypot(away[1]).hypot(away[2]);
            let g = gap(&profile, point);
            assert!((g.distance - (far - 3.0)).abs() < 1e-12, "{shape:?} {point:?}: {g:?}");
            assert!((0..3).all(|a| (g.normal[a] - away[a] / far).abs() < 1e-12), "{shape:?} {point:?}: {g:?}");
        }
    }
}

#[test]
fn a_line_crosses_the_cylinder_through_the_rim_where_it_is_as_far_from_the_axis() {
    let profile = body(Shape::Cylinder { diameter: 6.0, length: 9.0 }, 0.0).profile;
    let mut numbers = Numbers(33);
    let mut seen = [0; 3];
    for _ in 0..2000 {
        let (from, to) = (numbers.point(), numbers.point());
        let far = |part: f64| {
            let [x, y] = [0, 1].map(|a: usize| from[a] + part * (to[a] - from[a]));
            x.hypot(y) - 3.0
        };
        let found = profile.rim_crossings(from, to);
        let crossings: Vec<f64> = found.into_iter().filter(|at| !at.is_nan()).collect();
        assert!(crossings.iter().all(|at| (0.0..1.0).contains(at) && far(*at).abs() < 1e-9), "{from:?} {to:?}");
        // Inside between two of them, and nowhere else.
        let ends = [[0.0].as_slice(), crossings.as_slice(), &[1.0]].concat();
        for (i, pair) in ends.windows(2).enumerate() {
            assert!(pair[0] <= pair[1], "{found:?}");
            let inside = far(0.5 * (pair[0] + pair[1])) < 0.0;
            let begins_inside = far(0.0) < 0.0;
            assert_eq!(inside, begins_inside == (i % 2 == 0), "{from:?} {to:?}: {found:?}");
        }
        seen[crossings.len()] += 1;
    }
    assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
    for edge in [0.0, 0.3] {
        let body = body(Shape::Cylinder { diameter: 6.0, length: 9.0 }, edge);
        assert!((body.profile.height_over_face([1.0, 2.0, 5.0]) - 0.5).abs() < 1e-14, "4.5 from the centre of mass");
    }
}
