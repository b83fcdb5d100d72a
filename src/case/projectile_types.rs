//! What strikes the pack, in SI units.

use crate::num::solid::Solid;

/// A rigid projectile. Flight is along +Z at normal incidence; the pack lies in Z = 0 around the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Projectile {
    /// Geometry.
    pub shape: Shape,
    /// Radius of the rounding of every edge [m].
    pub edge_radius: f64,
    /// [kg]
    pub mass: f64,
    /// Density of a solid body, where the case gives it [kg/m³].
    pub density: Option<f64>,
    /// Moments of inertia about the body axis and across it through the centre of mass [kg·m²]; `None`: uniform solid.
    pub inertia: Option<[f64; 2]>,
    /// Speed along the line of flight [m/s].
    pub velocity: f64,
    /// Where the line of flight meets the pack's plane, from the pack's centre [m].
    pub offset: [f64; 2],
    /// Gap between nose and first ply at the start, along Z [m].
    pub standoff: f64,
    /// Angle between the line of flight and the pack's normal [rad].
    pub obliquity: f64,
    /// In-plane direction of the obliquity, from warp towards weft [rad].
    pub azimuth: f64,
    /// Angle between the body axis and the line of flight, in the plane of `azimuth` [rad].
    pub yaw: f64,
    /// Initial angular velocity, fixed axes X, Y, Z [rad/s].
    pub angular_velocity: [f64; 3],
    /// Coulomb coefficient against fabric [-].
    pub friction: f64,
    /// Free flight or velocity held.
    pub motion: Motion,
    /// Whether the body may rotate.
    pub rotation: Rotation,
}

/// Geometry of a projectile, lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// Flat-ended right circular cylinder.
    Cylinder {
        /// [m]
        diameter: f64,
        /// [m]
        length: f64,
    },
    /// Sphere.
    Sphere {
        /// [m]
        diameter: f64,
    },
    /// Cone (nose) on a cylinder; `nose_length == length` is a plain cone.
    Cone {
        /// [m]
        diameter: f64,
        /// Whole length [m].
        length: f64,
        /// Length of the conical nose [m].
        nose_length: f64,
    },
    /// Tangent ogive (nose, an arc that is tangent to the wall) on a cylinder.
    Ogive {
        /// [m]
        diameter: f64,
        /// Whole length [m].
        length: f64,
        /// Length of the nose, at least half the diameter (a hemisphere) [m].
        nose_length: f64,
    },
    /// Fragment simulator: a cylinder whose front two slanted flats cut to a chisel.
    Fragment {
        /// [m]
        diameter: f64,
        /// Whole length [m].
        length: f64,
        /// Width of the flat strip that is left of the front [m].
        nose_flat: f64,
        /// Angle between the strip's plane and the slanted flats [rad].
        nose_angle: f64,
        /// Turn of the strip about the body's axis; at 0 it lies along X at normal incidence [rad].
        roll: f64,
    },
    /// Round bar lying in the pack's plane, as long as the pack: the striker of strip tests.
    Bar {
        /// [m]
        diameter: f64,
        /// The yarn direction the bar lies along.
        along: Along,
    },
}

impl Shape {
    /// The uniform solid of a shape, edges sharp; of a bar, a ball of its diameter.
    pub(crate) fn solid(&self) -> Solid {
        match *self {
            Shape::Sphere { diameter } | Shape::Bar { diameter, .. } => Solid::sphere(0.5 * diameter),
            Shape::Cylinder { diameter, length } => Solid::cylinder(0.5 * diameter, length),
            Shape::Cone { diameter, length, nose_length } => {
                let (r, shank) = (0.5 * diameter, length - nose_length);
                Solid::cylinder(r, shank).with(Solid::cone(r, nose_length).raised(shank))
            }
            Shape::Ogive { diameter, length, nose_length } => {
                let (r, shank) = (0.5 * diameter, length - nose_length);
                Solid::cylinder(r, shank).with(Solid::ogive(r, nose_length).raised(shank))
            }
            Shape::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                Solid::chisel(0.5 * diameter, length, 0.5 * nose_flat, nose_angle)
            }
        }
    }

    /// Volume, edges sharp [m³]; a bar has none of its own.
    pub fn volume(&self) -> f64 {
        self.solid().volume
    }
}

impl Shape {
    /// Whether the nose ends in a tip, as that of an ogive does unless it is half a ball.
    pub(crate) fn is_pointed(&self) -> bool {
        match *self {
            Self::Cone { .. } => true,
            Self::Ogive { diameter, nose_length, .. } => nose_length > 0.5 * diameter * (1.0 + 1e-9),
            _ => false,
        }
    }

    /// Largest diameter [m].
    pub fn diameter(&self) -> f64 {
        match *self {
            Self::Cylinder { diameter, .. }
            | Self::Sphere { diameter }
            | Self::Cone { diameter, .. }
            | Self::Ogive { diameter, .. }
            | Self::Fragment { diameter, .. }
            | Self::Bar { diameter, .. } => diameter,
        }
    }
}

/// A yarn direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Along {
    /// X
    Warp,
    /// Y
    Weft,
}

/// Whether contact changes the projectile's velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Rigid body of the given mass.
    Free,
    /// Velocity held whatever the contact force (the work this takes is in the ledger).
    Prescribed,
}

/// Whether the projectile may rotate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rotation {
    /// Six degrees of freedom.
    Free,
    /// Translation only.
    Locked,
}
