//! What moves of the projectile.

use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

use crate::physics::rigid_body::RigidBody;

/// The numbers of a [`RigidBody`] that vary; the rest follows from the case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct BodyMotion {
    position: [f64; 3],
    /// i, j, k, w.
    orientation: [f64; 4],
    velocity: [f64; 3],
    angular_momentum: [f64; 3],
}

impl BodyMotion {
    pub(super) fn of(body: &RigidBody) -> Self {
        Self {
            position: body.position.into(),
            orientation: body.orientation.coords.into(),
            velocity: body.velocity.into(),
            angular_momentum: body.angular_momentum.into(),
        }
    }

    pub(super) fn give(self, body: &mut RigidBody) {
        body.position = self.position.into();
        // As it was, to the last bit: it is not brought to unit length again.
        body.orientation = UnitQuaternion::new_unchecked(Quaternion::from(self.orientation));
        body.velocity = self.velocity.into();
        body.angular_momentum = self.angular_momentum.into();
    }
}
