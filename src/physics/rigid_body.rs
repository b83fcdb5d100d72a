//! Rigid-body motion of the projectile, six degrees of freedom.
//!
//! Momentum and angular momentum are the state, so that contact impulses are exactly what the fabric receives;
//! between impulses both are constant. Free rotation is that of a symmetric top, exact however long the step, and what a third
//! moment of inertia adds is split off, second order in the step and without drift.

use nalgebra::{Matrix3, UnitQuaternion, Vector3, Vector4};
use serde::{Deserialize, Serialize};

use crate::case::{Motion, Projectile, Rotation, Shape};
use crate::physics::projectile_body::Body;
use crate::physics::projectile_shape::{self, SignedDistance};

/// A projectile in motion.
#[derive(Clone, Debug)]
pub struct RigidBody {
    /// Surface and inertia.
    pub body: Body,
    /// [kg]
    pub mass: f64,
    /// Velocity is held.
    pub prescribed: bool,
    /// Orientation is held.
    pub locked: bool,
    /// Depth of the rim zone of a flat nose: one element length [m].
    pub rim_depth: f64,
    /// Centre of mass [m].
    pub position: Vector3<f64>,
    /// Body frame to world; the body's z axis points to the nose, a chisel edge lies along its x axis.
    pub orientation: UnitQuaternion<f64>,
    /// Velocity of the centre of mass [m/s].
    pub velocity: Vector3<f64>,
    /// About the centre of mass, world frame [kg·m²/s].
    pub angular_momentum: Vector3<f64>,
    /// Unit vector of the line of flight at the start.
    pub flight: Vector3<f64>,
    /// Start of the centre of mass [m].
    pub start: Vector3<f64>,
    /// 1 for directions of velocity and of turning that are free, 0 for those that mirror planes hold.
    pub freedom: [Vector3<f64>; 2],
}

/// Velocities of a body's material at one time.
#[derive(Clone, Copy, Debug)]
pub struct Twist {
    /// Velocity of the centre of mass [m/s].
    pub velocity: Vector3<f64>,
    /// World frame [rad/s].
    pub spin: Vector3<f64>,
}

impl Twist {
    /// At a point given from the centre of mass [m/s].
    pub fn at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(arm)
    }
}

impl RigidBody {
    /// Places a projectile so that its surface is `standoff` away from the plane Z = 0 and its line of flight meets
    /// that plane at the point asked for.
    pub fn new(projectile: &Projectile, body: Body, rim_depth: f64) -> Self {
        let direction = |angle: f64| {
            let (s, c) = angle.sin_cos();
            Vector3::new(s * projectile.azimuth.cos(), s * projectile.azimuth.sin(), c)
        };
        let flight = direction(projectile.obliquity);
        let axis = direction(projectile.obliquity + projectile.yaw);
        let orientation = match projectile.shape {
            Shape::Bar { along: crate::case::Along::Warp, .. } => {
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2)
            }
            Shape::Bar { .. } => UnitQuaternion::identity(),
            shape => {
                let tilt = UnitQuaternion::rotation_between(&Vector3::z(), &axis)
                    .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
                let roll = if let Shape::Fragment { roll, .. } = shape { roll } else { 0.0 };
                tilt * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), roll)
            }
        };
        let support = body.support(orientation.inverse_transform_vector(&Vector3::z()).into());
        let height = -(projectile.standoff + support);
        let aim = Vector3::new(projectile.offset[0], projectile.offset[1], 0.0);
        let position = aim + flight * (height / flight.z);
        let locked = projectile.rotation == Rotation::Locked || matches!(projectile.shape, Shape::Bar { .. });
        let mut out = Self {
            body,
            mass: projectile.mass,
            prescribed: projectile.motion == Motion::Prescribed,
            locked,
            rim_depth,
            position,
            orientation,
            velocity: flight * projectile.velocity,
            angular_momentum: Vector3::zeros(),
            flight,
            start: position,
            freedom: MirrorPlanes::NONE.freedom(),
        };
        if !locked {
            out.angular_momentum = out.inertia() * Vector3::from(projectile.angular_velocity);
        }
        out
    }

    /// The part of the body between these mirror planes, on which it stays.
    #[must_use]
    pub fn part(mut self, planes: MirrorPlanes) -> Self {
        let share = 1.0 / planes.copies() as f64;
        self.mass *= share;
        self.body.inertia = self.body.inertia.map(|moment| moment * share);
        self.freedom = planes.freedom();
        let [moves, turns] = self.freedom;
        // To the last bit: what cosines of right angles left of places and velocities across the planes is no motion.
        self.velocity.component_mul_assign(&moves);
        self.position.component_mul_assign(&moves);
        self.start = self.position;
        self.angular_momentum = self.angular_momentum.component_mul(&turns) * share;
        self.locked |= turns == Vector3::zeros();
        self
    }

    /// Inertia tensor, world frame [kg·m²].
    pub fn inertia(&self) -> Matrix3<f64> {
        let r = self.orientation.to_rotation_matrix();
        r * Matrix3::from_diagonal(&Vector3::from(self.body.inertia)) * r.inverse()
    }

    /// Angular velocity, world frame [rad/s].
    pub fn angular_velocity(&self) -> Vector3<f64> {
        if self.locked {
            return Vector3::zeros();
        }
        let local = self.orientation.inverse_transform_vector(&self.angular_momentum);
        self.orientation.transform_vector(&local.component_div(&Vector3::from(self.body.inertia)))
    }

    /// Kinetic energy of translation and rotation [J].
    pub fn kinetic_energy(&self) -> f64 {
        self.translation() + self.rotational_energy()
    }

    /// Kinetic energy of rotation alone [J].
    pub(crate) fn rotational_energy(&self) -> f64 {
        if self.locked { 0.0 } else { 0.5 * self.angular_velocity().dot(&self.angular_momentum) }
    }

    /// Kinetic energy that fabric and body share [J]: the translation of a driven body is the drive's affair, its spin is not.
    pub(crate) fn own_energy(&self) -> f64 {
        if self.prescribed { self.rotational_energy() } else { self.kinetic_energy() }
    }

    /// Kinetic energy of translation alone [J].
    pub(crate) fn translation(&self) -> f64 {
        0.5 * self.mass * self.velocity.norm_squared()
    }

    /// Velocities of the body's material now.
    pub fn twist(&self) -> Twist {
        Twist { velocity: self.velocity, spin: self.angular_velocity() }
    }

    /// Gap and outward normal (world frame) at a point [m].
    pub fn gap(&self, point: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let local = self.to_body(point);
        let SignedDistance { distance, normal } = projectile_shape::gap(&self.body.profile, local.into());
        (distance, self.to_world(normal.into()))
    }

    /// Rotation of the body's frame against the world frame: at normal impact there is none.
    #[inline]
    fn is_turned(&self) -> bool {
        self.orientation.coords != Vector4::w()
    }

    /// A point in the body's frame [m].
    #[inline]
    pub(crate) fn to_body(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let arm = point - self.position;
        if self.is_turned() { self.orientation.inverse_transform_vector(&arm) } else { arm }
    }

    /// A vector of the body's frame in the world frame.
    #[inline]
    fn to_world(&self, vector: Vector3<f64>) -> Vector3<f64> {
        if self.is_turned() { self.orientation.transform_vector(&vector) } else { vector }
    }

    /// The gap and normal (world frame) that contact acts on at a point of the body's frame [m]; see
    /// [`projectile_shape::contact_distance`].
    pub(crate) fn contact_distance(&self, local: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let SignedDistance { distance, normal } =
            projectile_shape::contact_distance(&self.body.profile, (*local).into(), self.rim_depth);
        (distance, self.to_world(normal.into()))
    }

    /// Distance of a point of the body's frame from its surface [m], negative inside.
    pub(crate) fn clearance(&self, local: &Vector3<f64>) -> f64 {
        projectile_shape::gap(&self.body.profile, (*local).into()).distance
    }

    /// Upper bound of the speed of any point of the body [m/s].
    pub fn speed_bound(&self) -> f64 {
        self.velocity.norm() + self.angular_velocity().norm() * self.body.bounding_radius
    }

    /// An orientation turned about an axis of the body by the angular momentum about it times `rate` [s/(kg·m²)].
    fn spun(&self, orientation: UnitQuaternion<f64>, axis: Vector3<f64>, rate: f64) -> UnitQuaternion<f64> {
        let along = orientation.inverse_transform_vector(&self.angular_momentum).dot(&axis);
        orientation * UnitQuaternion::from_scaled_axis(axis * (along * rate))
    }

    /// Moves the body through `dt` [s] of free flight.
    pub fn advance(&mut self, dt: f64) {
        self.position += self.velocity * dt;
        if self.locked || self.angular_momentum == Vector3::zeros() {
            return;
        }
        let [x, y, z] = self.body.inertia.map(f64::recip);
        let uneven = self.spun(self.orientation, Vector3::x(), 0.5 * dt * (x - y));
        // A symmetric top turns about its axis and, at the same time, about its angular momentum, at constant rates.
        let spun = self.spun(uneven, Vector3::z(), dt * (z - y));
        let top = UnitQuaternion::from_scaled_axis(self.angular_momentum * (y * dt)) * spun;
        self.orientation = self.spun(top, Vector3::x(), 0.5 * dt * (x - y));
        self.orientation.renormalize();
    }
}

/// Mirror planes of a scene: whether x = 0 and whether y = 0 is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MirrorPlanes(pub [bool; 2]);

impl MirrorPlanes {
    /// No plane: the whole scene is computed.
    pub const NONE: Self = Self([false; 2]);

    /// Number of parts like the one computed that make the whole.
    pub fn copies(self) -> u64 {
        self.0.iter().map(|plane| if *plane { 2 } else { 1 }).product()
    }

    /// The planes, in words.
    pub fn names(self) -> Vec<&'static str> {
        ["x", "y"].into_iter().zip(self.0).filter(|(_, plane)| *plane).map(|(name, _)| name).collect()
    }

    /// Sum of a vector over the part and its images: what points across a plane cancels.
    pub fn whole(self, vector: Vector3<f64>) -> Vector3<f64> {
        let copies = self.copies() as f64;
        let [x, y] = self.0.map(|plane| if plane { 0.0 } else { copies });
        vector.component_mul(&Vector3::new(x, y, copies))
    }

    /// 1 for directions of velocity and of turning that a body on the planes has, 0 for the others.
    pub fn freedom(self) -> [Vector3<f64>; 2] {
        let [x, y] = self.0.map(|plane| if plane { 0.0 } else { 1.0 });
        // A turn is its own mirror image where its axis is across the plane.
        [Vector3::new(x, y, 1.0), Vector3::new(y, x, x * y)]
    }
}

/// Cut of a mirror plane through a mesh along one of its own axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cut {
    /// Nowhere: the mesh goes from edge to edge.
    #[default]
    Nowhere,
    /// At its first nodes: their images lie before them.
    First,
    /// At its last nodes: their images lie behind them.
    Last,
}

#[cfg(test)]
mod tests {
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
            middle.orientation =
                UnitQuaternion::from_scaled_axis(exact.angular_velocity() * 2.5e-9) * exact.orientation;
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
}
