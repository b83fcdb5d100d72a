#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use super::*;
use crate::case::Along;
use crate::physics::projectile_shape::tests::projectile;

const FRAGMENT: Shape =
    Shape::Fragment { diameter: 6e-3, length: 7e-3, nose_flat: 2.8e-3, nose_angle: 0.611, roll: 0.4 };

fn body(change: impl FnOnce(&mut Projectile)) -> RigidBody {
    let mut p = projectile(FRAGMENT, 0.0);
    change(&mut p);
    RigidBody::new(&p, Body::new(&p).unwrap(), 1e-3)
}

#[test]
fn a_body_of_three_moments_turns_as_euler_s_equations_say() {
    let spinning = || {
        let mut body = body(|p| p.angular_velocity = [3e4, -2e4, 5e4]);
        body.body.inertia = [3e-8, 2e-8, 1.2e-8];
        body.orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
        body
    };
    // dR/dt = ω × R, with ω from the angular momentum that stays, in small steps of the midpoint rule.
    let start = spinning();
    let mut exact = start.clone();
    for _ in 0..4000 {
        let mut middle = exact.clone();
        middle.orientation = UnitQuaternion::from_scaled_axis(exact.angular_velocity() * 2.5e-9) * exact.orientation;
        exact.orientation = UnitQuaternion::from_scaled_axis(middle.angular_velocity() * 5e-9) * exact.orientation;
    }
    let off = |steps: u32| {
        let mut body = start.clone();
        (0..steps).for_each(|_| body.advance(2e-5 / f64::from(steps)));
        assert!((body.position - start.position - start.velocity * 2e-5).norm() < 1e-12);
        body.orientation.angle_to(&exact.orientation)
    };
    let turned = start.orientation.angle_to(&exact.orientation);
    let [coarse, fine] = [off(50), off(100)];
    assert!(turned > 0.5 && coarse < 1e-3 && fine < 0.3 * coarse, "{turned}: {coarse} {fine}");
}

#[test]
fn velocities_energies_and_bounds_are_those_of_every_point() {
    let body = body(|p| {
        p.angular_velocity = [3e3, -2e3, 5e3];
        (p.obliquity, p.azimuth, p.yaw) = (0.2, 0.5, 0.1);
    });
    assert!((body.angular_velocity() - Vector3::new(3e3, -2e3, 5e3)).norm() < 1e-9);
    assert!((body.inertia() * body.angular_velocity() - body.angular_momentum).norm() < 1e-18);
    let arm = Vector3::new(1e-3, -2e-3, 3e-3);
    let moved = |time: f64| {
        let mut later = body.clone();
        later.advance(time);
        later.position + later.orientation * body.orientation.inverse_transform_vector(&arm)
    };
    let velocity = (moved(1e-9) - moved(-1e-9)) / 2e-9;
    assert!((body.twist().at(&arm) - velocity).norm() < 1e-3, "{velocity}");
    assert!((body.speed_bound() - (155.0 + 38e6_f64.sqrt() * body.body.bounding_radius)).abs() < 1e-9);
    let translation = 0.5 * 3e-3 * 155.0_f64.powi(2);
    let turning = 0.5 * body.angular_velocity().dot(&(body.inertia() * body.angular_velocity()));
    assert!((body.translation() / translation - 1.0).abs() < 1e-12);
    assert!((body.rotational_energy() / turning - 1.0).abs() < 1e-12 && turning > 1e-3);
    assert!((body.kinetic_energy() / (translation + turning) - 1.0).abs() < 1e-12);
    assert_eq!(body.own_energy(), body.kinetic_energy());
    assert_eq!(RigidBody { prescribed: true, ..body.clone() }.own_energy(), body.rotational_energy());
    let locked = RigidBody { locked: true, ..body };
    assert_eq!((locked.angular_velocity(), locked.rotational_energy()), (Vector3::zeros(), 0.0));
}

#[test]
fn a_body_flies_along_its_line_to_where_it_is_aimed_at() {
    for (obliquity, azimuth, yaw) in [(0.0, 0.0, 0.0), (0.3, 0.7, 0.2), (0.5, -2.0, -0.4)] {
        let body = body(|p| {
            (p.obliquity, p.azimuth, p.yaw, p.standoff, p.offset) = (obliquity, azimuth, yaw, 2e-3, [1e-3, -3e-3]);
        });
        let across = obliquity.sin();
        let flight = Vector3::new(across * azimuth.cos(), across * azimuth.sin(), obliquity.cos());
        assert!((body.flight - flight).norm() < 1e-15 && (body.velocity - flight * 155.0).norm() < 1e-12);
        // Down its line of flight it meets the plane of the fabric there.
        let there = body.position - flight * (body.position.z / flight.z);
        assert!((there - Vector3::new(1e-3, -3e-3, 0.0)).norm() < 1e-15, "{there}");
        let nose = body.orientation * Vector3::z();
        let tilt = obliquity + yaw;
        let axis = Vector3::new(tilt.sin() * azimuth.cos(), tilt.sin() * azimuth.sin(), tilt.cos());
        assert!((nose - axis).norm() < 1e-12 && body.start == body.position, "{nose}");
    }
    // A bar lies along its yarns and never turns.
    for (along, expected) in [(Along::Warp, Vector3::x()), (Along::Weft, Vector3::y())] {
        let bar = body(|p| p.shape = Shape::Bar { diameter: 6e-3, along });
        assert!((bar.orientation * Vector3::y()).dot(&expected).abs() > 1.0 - 1e-12 && bar.locked, "{along:?}");
        assert!((bar.position.z + 3e-3).abs() < 1e-15);
    }
    assert!(body(|p| p.rotation = Rotation::Locked).locked && !body(|_| ()).locked);
    assert!(body(|p| p.motion = Motion::Prescribed).prescribed && !body(|_| ()).prescribed);
}

#[test]
fn parts_of_a_body_make_the_whole() {
    let whole = body(|p| p.angular_velocity = [10.0, 20.0, 30.0]);
    for (planes, share, moves, turns) in [
        ([true, false], 0.5, [0.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
        ([false, true], 0.5, [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        ([true, true], 0.25, [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]),
    ] {
        let mut aside = whole.clone();
        (aside.position, aside.velocity) = (Vector3::new(1e-20, 2e-20, -3e-3), Vector3::new(3.0, 4.0, 5.0));
        let part = aside.part(MirrorPlanes(planes));
        let [moves, turns] = [moves, turns].map(Vector3::from);
        assert!((part.mass - share * whole.mass).abs() < 1e-18 && part.freedom == [moves, turns], "{planes:?}");
        assert!((0..3).all(|a| (part.body.inertia[a] - share * whole.body.inertia[a]).abs() < 1e-20));
        assert_eq!(part.velocity, Vector3::new(3.0, 4.0, 5.0).component_mul(&moves));
        assert_eq!(part.position, Vector3::new(1e-20, 2e-20, -3e-3).component_mul(&moves));
        assert_eq!(part.start, part.position);
        assert!((part.angular_momentum - whole.angular_momentum.component_mul(&turns) * share).norm() < 1e-20);
        assert_eq!(part.locked, turns == Vector3::zeros());
    }
}
