//! Rigid-body motion of the projectile, six degrees of freedom.
//!
//! Momentum and angular momentum are the state, so that contact impulses are exactly what the fabric receives;
//! between impulses both are constant. Free rotation is that of a symmetric top, exact however long the step, and what a third
//! moment of inertia adds is split off, second order in the step and without drift.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::case::{Motion, Projectile, Rotation, Shape};
use crate::physics::mirror_planes::MirrorPlanes;
use crate::physics::projectile_body::Body;
use crate::physics::projectile_shape;
use crate::physics::projectile_shape::SignedDistance;

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

    fn principal(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(self.body.inertia))
    }

    /// Inertia tensor, world frame [kg·m²].
    pub fn inertia(&self) -> Matrix3<f64> {
        let r = self.orientation.to_rotation_matrix();
        r * self.principal() * r.inverse()
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
        (distance, self.orientation.transform_vector(&Vector3::from(normal)))
    }

    /// A point in the body's frame [m].
    pub(crate) fn to_body(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.orientation.inverse_transform_vector(&(point - self.position))
    }

    /// The gap and normal (world frame) that contact acts on at a point of the body's frame [m]; see
    /// [`projectile_shape::contact_distance`].
    pub(crate) fn contact_distance(&self, local: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let SignedDistance { distance, normal } =
            projectile_shape::contact_distance(&self.body.profile, (*local).into(), self.rim_depth);
        (distance, self.orientation.transform_vector(&Vector3::from(normal)))
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

#[cfg(test)]
#[path = "rigid_body_tests.rs"]
mod tests;
