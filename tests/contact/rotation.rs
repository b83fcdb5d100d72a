//! A body in free flight turns as it must, whatever its moments of inertia and the step.

use nalgebra::{UnitQuaternion, Vector3};
use ripstop::physics::rigid_body::RigidBody;

use super::cylinder;

#[test]
fn a_free_body_keeps_angular_momentum_and_energy() {
    let mut body = cylinder(&[]);
    body.orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
    body.angular_momentum = body.inertia() * Vector3::new(3e3, -2e3, 8e3);
    let (energy, axis_spin) = (body.kinetic_energy(), body.angular_velocity().dot(&nose(&body)));
    let start = nose(&body);
    for _ in 0..20_000 {
        body.advance(1e-7);
    }
    // A symmetric top keeps its spin about its axis, to the rounding of 20 000 steps.
    assert!((body.kinetic_energy() / energy - 1.0).abs() < 1e-12);
    assert!((body.angular_velocity().dot(&nose(&body)) / axis_spin - 1.0).abs() < 1e-12);
    assert!(start.angle(&nose(&body)) > 0.01, "it does precess");
}

#[test]
fn free_rotation_of_a_top_does_not_depend_on_the_step() {
    let spinning = || {
        let mut body = cylinder(&[]);
        body.orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
        body.angular_momentum = body.inertia() * Vector3::new(3e4, -2e4, 2e5);
        body
    };
    let (mut coarse, mut fine) = (spinning(), spinning());
    let energy = coarse.kinetic_energy();
    for _ in 0..100 {
        coarse.advance(2e-7);
        (0..50).for_each(|_| fine.advance(4e-9));
    }
    // 0.04 rad a step, where a midpoint rule loses 1e-6 of the energy in twenty.
    assert!((coarse.kinetic_energy() / energy - 1.0).abs() < 1e-13);
    assert!(
        coarse.orientation.angle_to(&fine.orientation) < 1e-10,
        "{}",
        coarse.orientation.angle_to(&fine.orientation)
    );
}

#[test]
fn a_body_of_three_moments_keeps_angular_momentum_and_energy() {
    let mut body = cylinder(&[]);
    body.body.inertia = [3e-7, 2e-7, 1e-7];
    // Spin about the middle axis is unstable: the body tumbles, and still no energy is made.
    body.angular_momentum = body.inertia() * Vector3::new(20.0, 8e3, -10.0);
    let (energy, start) = (body.kinetic_energy(), nose(&body));
    let mut turned = 0.0_f64;
    for _ in 0..40_000 {
        body.advance(1e-7);
        assert!((body.kinetic_energy() / energy - 1.0).abs() < 1e-5);
        turned = turned.max(start.angle(&nose(&body)));
    }
    assert!(turned > 1.0, "it does tumble: {turned}");
}

fn nose(body: &RigidBody) -> Vector3<f64> {
    body.orientation.transform_vector(&Vector3::z())
}
