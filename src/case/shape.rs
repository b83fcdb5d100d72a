//! Shape of a projectile.

use serde::Deserialize;

use super::Along;
use super::error::{CaseError, millimetres};
use super::projectile::at;
use super::provenance::Provenance;
use crate::num::solid::Solid;

/// Geometry of a projectile, lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "shape", rename_all = "snake_case")]
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
        #[serde(default)]
        nose_length: f64,
    },
    /// Tangent ogive (nose, an arc that is tangent to the wall) on a cylinder.
    Ogive {
        /// [m]
        diameter: f64,
        /// Whole length [m].
        length: f64,
        /// Length of the nose, at least half the diameter (a hemisphere) [m].
        #[serde(default)]
        nose_length: f64,
    },
    /// Fragment simulator: a cylinder whose front two slanted flats cut to a chisel.
    Fragment {
        /// [m]
        diameter: f64,
        /// Whole length [m].
        length: f64,
        /// Width of the flat strip that is left of the front [m].
        #[serde(default)]
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

    /// Whether the nose ends in a tip, as that of an ogive does unless it is half a ball.
    pub(crate) fn is_pointed(&self) -> bool {
        match *self {
            Self::Cone { .. } => true,
            Self::Ogive { diameter, nose_length, .. } => nose_length > 0.5 * diameter * (1.0 + 1e-9),
            _ => false,
        }
    }

    /// Whether it is a bar.
    pub(super) fn is_bar(&self) -> bool {
        matches!(self, Self::Bar { .. })
    }

    /// Largest diameter [m].
    pub fn diameter(&self) -> f64 {
        self.sizes()[0]
    }

    /// Largest diameter and whole length, 0 of a ball and a bar [m].
    pub(super) fn sizes(&self) -> [f64; 2] {
        match *self {
            Self::Sphere { diameter } | Self::Bar { diameter, .. } => [diameter, 0.0],
            Self::Cylinder { diameter, length }
            | Self::Cone { diameter, length, .. }
            | Self::Ogive { diameter, length, .. }
            | Self::Fragment { diameter, length, .. } => [diameter, length],
        }
    }

    /// The largest edge radius that leaves room for itself: a ball of its radius fits into the body, and each face is left in part [m].
    pub(super) fn largest_edge(&self) -> f64 {
        match *self {
            Shape::Cylinder { diameter, length } => (0.5 * diameter).min(0.5 * length),
            Shape::Cone { diameter, length, nose_length } => {
                let sine = 0.5 * diameter / nose_length.hypot(0.5 * diameter);
                (0.5 * diameter).min(length * sine / (1.0 + sine))
            }
            Shape::Ogive { diameter, length, nose_length } => {
                let (r, shank) = (0.5 * diameter, length - nose_length);
                // Of the ball that touches arc and tail, where it is no wider than the wall.
                let arc = (r * r + nose_length * nose_length) / (2.0 * r);
                if shank < r { (nose_length * nose_length - shank * shank) / (2.0 * (arc - shank)) } else { r }
            }
            Shape::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                let turn = (0.5 * nose_angle).tan();
                let nose = 0.5 * (diameter - nose_flat) * nose_angle.tan();
                let room = 0.5 * (length - nose) * (1.0 + turn);
                (0.5 * diameter).min(0.5 * length).min(0.5 * nose_flat / turn).min(room)
            }
            Shape::Sphere { .. } | Shape::Bar { .. } => 0.0,
        }
    }
}

impl Shape {
    pub(super) fn complete(&mut self, record: &Provenance) -> Result<(), CaseError> {
        let at_most = |key: &str, given: f64, limit_key: &str, limit: f64| match given > limit {
            true => {
                let expected = format!("at most {limit_key}, which is {}", millimetres(limit));
                Err(CaseError::at(at(key), expected, millimetres(given)))
            }
            false => Ok(()),
        };
        match self {
            Self::Cone { length, nose_length, .. } => {
                record.fill(&at("nose_length_mm"), nose_length, *length, "length_mm: a plain cone", false);
                at_most("nose_length_mm", *nose_length, "length_mm", *length)
            }
            Self::Ogive { diameter, length, nose_length } => {
                let (radius, own) = (0.5 * *diameter, length.min(1.5 * *diameter));
                let how = "assumed: 1.5 × diameter_mm, at most length_mm";
                // A tangent arc is at least as long as the radius that it closes.
                for (key, found) in [("length_mm", *length), ("nose_length_mm", *nose_length)] {
                    if found < radius && record.has(&at(key)) {
                        let expected = format!("at least half of diameter_mm, which is {}", millimetres(radius));
                        let error = CaseError::at(at(key), expected, millimetres(found));
                        return Err(
                            error.help("a tangent ogive of that length is a hemisphere, a shorter one there is not")
                        );
                    }
                }
                record.fill(&at("nose_length_mm"), nose_length, own, how, true);
                at_most("nose_length_mm", *nose_length, "length_mm", *length)
            }
            Self::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                record.fill(&at("nose_flat_mm"), nose_flat, 0.46 * *diameter, "", true);
                at_most("nose_flat_mm", *nose_flat, "diameter_mm", *diameter)?;
                // The slanted flats must meet the wall before the tail.
                let nose = 0.5 * (*diameter - *nose_flat) * nose_angle.tan();
                if nose > *length {
                    let expected = format!("flats that end within length_mm, which is {}", millimetres(*length));
                    return Err(CaseError::at(
                        at("nose_angle_deg"),
                        expected,
                        format!("a nose of {}", millimetres(nose)),
                    ));
                }
                Ok(())
            }
            Self::Cylinder { .. } | Self::Sphere { .. } | Self::Bar { .. } => Ok(()),
        }
    }
}
