//! Projectile: its shape, mass and flight.

use schemars::JsonSchema;
use serde::Deserialize;

use super::CaseError;
use super::error::{millimetres, short_number_text};
use super::keys::choices;
use super::provenance::Provenance;
use crate::num::solid::Solid;

/// Rounding of a point that says nothing [m]. Under a sharp one a node stands on the tip or slips off it, which is a matter of the last bit:
/// the limit of a cone is 93 or 76 m/s. From 0.15 to 0.5 mm it is 95 to 99 m/s.
const TIP_RADIUS: f64 = 0.5e-3;
/// Mean densities of bullets with a core of lead [kg/m³].
const LEAD: std::ops::RangeInclusive<f64> = 9300.0..=12_000.0;
/// Largest such rounding over the diameter [-].
const TIP_PART: f64 = 0.1;
/// Source of a rounding of a point that is left out.
const ROUNDED: &str = "assumed: 0.5 mm, at most a tenth of diameter_mm and what the shape has room for";
/// Shapes that have a length and edges.
const LONG: [&str; 4] = ["cylinder", "cone", "ogive", "fragment"];
/// Shapes that can turn.
const TURNING: [&str; 5] = ["cylinder", "sphere", "cone", "ogive", "fragment"];

/// A rigid projectile. Flight is along +Z at normal incidence; the pack lies in Z = 0 around the origin.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Projectile {
    /// Geometry.
    #[serde(flatten)]
    #[schemars(with = "ShapeKeys")]
    pub shape: Shape,
    /// Radius of the rounding of every edge [m].
    ///
    /// Otherwise: 0, sharp edges; a point (cone, ogive): assumed, 0.5 mm, at most a tenth of diameter_mm and what the shape has room
    /// for.
    #[serde(default)]
    #[schemars(rename = "edge_radius_mm", range(min = 0, max = 500), extend("only" = {"shape": LONG}))]
    pub edge_radius: f64,
    /// Mass [kg].
    ///
    /// Default: not used: the velocity is prescribed.
    #[serde(default)]
    #[schemars(rename = "mass_g", range(min = 1e-9, max = 1e6))]
    #[schemars(extend("default" = 1000.0, "where" = {"motion": "prescribed"}, "or" = "/density_kg_m3"))]
    pub mass: f64,
    /// Density of a solid body (steel 7850): gives the mass where mass_g is left out; where both are given, they are compared [kg/m³].
    #[schemars(rename = "density_kg_m3", range(min = 1.0, max = 1e5), extend("without" = "", "only" = {"shape": TURNING}))]
    pub density: Option<f64>,
    /// Moment of inertia about the body's axis [kg·m²].
    ///
    /// Otherwise: a uniform solid of this shape and mass.
    #[schemars(rename = "axial_inertia_g_mm2", range(min = 1e-9, max = 1e12))]
    #[schemars(extend("with" = "transverse_inertia_g_mm2", "only" = {"shape": TURNING}))]
    pub axial_inertia: Option<f64>,
    /// Moment of inertia across the axis, about the centre [kg·m²].
    ///
    /// Otherwise: a uniform solid of this shape and mass.
    #[schemars(rename = "transverse_inertia_g_mm2", range(min = 1e-9, max = 1e12))]
    #[schemars(extend("with" = "axial_inertia_g_mm2", "only" = {"shape": TURNING}))]
    pub transverse_inertia: Option<f64>,
    /// Speed along the line of flight [m/s].
    #[schemars(rename = "velocity_m_s", range(max = 5000.0), extend("exclusiveMinimum" = 0.0))]
    pub velocity: f64,
    /// Point of aim from the pack's centre, where the line of flight meets its plane [m].
    ///
    /// Default: centred.
    #[schemars(rename = "offset_mm", inner(range(min = -1e5, max = 1e5)), extend("default" = [0, 0]))]
    pub offset: [f64; 2],
    /// Gap between nose and first ply at the start [m].
    ///
    /// Default: flight through air is not computed.
    #[schemars(rename = "standoff_mm", range(min = 0, max = 1000), extend("default" = 0.0))]
    pub standoff: f64,
    /// Angle of the line of flight to the pack's normal [rad].
    ///
    /// Default: normal incidence.
    #[schemars(rename = "obliquity_deg", range(min = 0, max = 85), extend("default" = 0.0))]
    pub obliquity: f64,
    /// Direction of the obliquity, from warp towards weft [rad].
    ///
    /// Default: towards warp.
    #[schemars(rename = "azimuth_deg", range(min = -360, max = 360), extend("default" = 0.0))]
    pub azimuth: f64,
    /// Angle of the body's axis to the line of flight, in the plane of the azimuth [rad].
    ///
    /// Default: axis along the line of flight.
    #[serde(default)]
    #[schemars(rename = "yaw_deg", range(min = -180, max = 180), extend("default" = 0.0, "only" = {"shape": TURNING}))]
    pub yaw: f64,
    /// Initial rotation about X, Y, Z [rad/s].
    ///
    /// Default: no rotation.
    #[serde(default)]
    #[schemars(rename = "angular_velocity_rad_s", inner(range(min = -1e6, max = 1e6)))]
    #[schemars(extend("default" = [0, 0, 0], "only" = {"shape": TURNING}))]
    pub angular_velocity: [f64; 3],
    /// Coulomb coefficient against fabric.
    ///
    /// Default: assumed: not published for this projectile and fabric.
    #[schemars(range(min = 0, max = 2), extend("default" = 0.2))]
    pub friction: f64,
    /// Free flight, or the velocity held.
    ///
    /// Default: a body in flight.
    #[schemars(extend("default" = "free"))]
    pub motion: Motion,
    /// Whether the body may turn; a bar never does.
    ///
    /// Default: a body in flight.
    #[serde(default = "locked")]
    #[schemars(extend("default" = "free", "where" = {"shape": TURNING}))]
    pub rotation: Rotation,
}

fn locked() -> Rotation {
    Rotation::Locked
}

choices! {
    /// A yarn direction.
    pub enum Along {
        /// X
        Warp = "warp",
        /// Y
        Weft = "weft",
    }
    /// Whether contact changes the projectile's velocity.
    pub enum Motion {
        /// Rigid body of the given mass.
        Free = "free",
        /// Velocity held whatever the contact force (the work this takes is in the energy balance).
        Prescribed = "prescribed",
    }
    /// Whether the projectile may rotate.
    pub enum Rotation {
        /// Six degrees of freedom.
        Free = "free",
        /// Translation only.
        Locked = "locked",
    }
    /// Shape without its lengths.
    enum ShapeWord {
        Cylinder = "cylinder" or "rcc",
        Sphere = "sphere" or "ball",
        Cone = "cone",
        Ogive = "ogive",
        Fragment = "fragment" or "fsp",
        Bar = "bar",
    }
}

/// Geometry of a projectile, lengths in metres; its keys are `ShapeKeys`.
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

/// Keys of a [`Shape`].
#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
struct ShapeKeys {
    /// Geometry of the rigid body.
    shape: ShapeWord,
    /// Diameter.
    #[schemars(range(min = 1e-3, max = 1000.0))]
    diameter_mm: f64,
    /// Whole length.
    #[schemars(range(min = 1e-3, max = 10_000.0), extend("only" = {"shape": LONG}))]
    length_mm: Option<f64>,
    /// Length of the nose, at most length_mm; of an ogive at least half of diameter_mm.
    ///
    /// Otherwise: a plain cone: length_mm; an ogive: assumed, 1.5 × diameter_mm, at most length_mm.
    #[schemars(range(min = 1e-3, max = 10_000.0), extend("only" = {"shape": ["cone", "ogive"]}, "at_most" = "length_mm"))]
    nose_length_mm: Option<f64>,
    /// Width of the flat strip across the front, at most diameter_mm, between the slanted flats.
    ///
    /// Otherwise: assumed: 0.46 × diameter_mm, about as chisel-nosed fragment simulators have it.
    #[schemars(range(min = 1e-3, max = 1000.0), extend("only" = {"shape": ["fragment"]}, "at_most" = "diameter_mm"))]
    nose_flat_mm: Option<f64>,
    /// Angle between the strip's plane and the slanted flats.
    ///
    /// Default: assumed: about as chisel-nosed fragment simulators have it.
    #[schemars(range(min = 5, max = 75), extend("default" = 35.0, "only" = {"shape": ["fragment"]}))]
    nose_angle_deg: Option<f64>,
    /// Turn of the strip about the body's axis, from warp towards weft.
    ///
    /// Default: strip along warp at normal incidence.
    #[schemars(range(min = -360, max = 360), extend("default" = 0.0, "only" = {"shape": ["fragment"]}))]
    roll_deg: Option<f64>,
    /// The yarn direction a bar lies along.
    ///
    /// Default: across the warp.
    #[schemars(extend("default" = "weft", "only" = {"shape": ["bar"]}))]
    along: Option<Along>,
}

impl Shape {
    /// The uniform solid of a shape, edges sharp; of a bar, a ball of its diameter.
    pub(crate) fn solid(&self) -> Solid {
        let r = 0.5 * self.diameter();
        match *self {
            Self::Sphere { .. } | Self::Bar { .. } => Solid::sphere(r),
            Self::Cylinder { length, .. } => Solid::cylinder(r, length),
            Self::Cone { length, nose_length, .. } => {
                let shank = length - nose_length;
                Solid::cylinder(r, shank).with(Solid::cone(r, nose_length).raised(shank))
            }
            Self::Ogive { length, nose_length, .. } => {
                let shank = length - nose_length;
                Solid::cylinder(r, shank).with(Solid::ogive(r, nose_length).raised(shank))
            }
            Self::Fragment { length, nose_flat, nose_angle, .. } => {
                Solid::chisel(r, length, 0.5 * nose_flat, nose_angle)
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

    pub(crate) fn is_bar(&self) -> bool {
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
    fn largest_edge(&self) -> f64 {
        let r = 0.5 * self.diameter();
        match *self {
            Self::Cylinder { length, .. } => r.min(0.5 * length),
            Self::Cone { length, nose_length, .. } => {
                let sine = r / nose_length.hypot(r);
                r.min(length * sine / (1.0 + sine))
            }
            Self::Ogive { length, nose_length, .. } => {
                let shank = length - nose_length;
                // Of the ball that touches arc and tail, where it is no wider than the wall.
                let arc = (r * r + nose_length * nose_length) / (2.0 * r);
                if shank < r { (nose_length * nose_length - shank * shank) / (2.0 * (arc - shank)) } else { r }
            }
            Self::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                let turn = (0.5 * nose_angle).tan();
                let nose = 0.5 * (diameter - nose_flat) * nose_angle.tan();
                let room = 0.5 * (length - nose) * (1.0 + turn);
                r.min(0.5 * length).min(0.5 * nose_flat / turn).min(room)
            }
            Self::Sphere { .. } | Self::Bar { .. } => 0.0,
        }
    }

    /// Completes and checks the nose.
    fn complete(&mut self, record: &Provenance) -> Result<(), CaseError> {
        match self {
            Self::Cone { length, nose_length, .. } => {
                record.fill(&at("nose_length_mm"), nose_length, *length, "length_mm: a plain cone", false);
            }
            Self::Ogive { diameter, length, nose_length } => {
                let (radius, own) = (0.5 * *diameter, length.min(1.5 * *diameter));
                let how = "assumed: 1.5 × diameter_mm, at most length_mm";
                record.fill(&at("nose_length_mm"), nose_length, own, how, true);
                // A tangent arc is at least as long as the radius that it closes.
                let lengths = [("length_mm", *length), ("nose_length_mm", *nose_length)];
                if let Some((key, found)) = lengths.into_iter().find(|(_, length)| *length < radius) {
                    let expected = format!("at least half of diameter_mm, which is {}", millimetres(radius));
                    let error = CaseError::at(at(key), expected, millimetres(found));
                    return Err(
                        error.help("a tangent ogive of that length is a hemisphere, a shorter one there is not")
                    );
                }
            }
            Self::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                record.fill(&at("nose_flat_mm"), nose_flat, 0.46 * *diameter, "", true);
                // The slanted flats must meet the wall before the tail.
                let nose = 0.5 * (*diameter - *nose_flat) * nose_angle.tan();
                if nose > *length {
                    let expected = format!("flats that end within length_mm, which is {}", millimetres(*length));
                    let found = format!("a nose of {}", millimetres(nose));
                    return Err(CaseError::at(at("nose_angle_deg"), expected, found));
                }
            }
            Self::Cylinder { .. } | Self::Sphere { .. } | Self::Bar { .. } => {}
        }
        Ok(())
    }
}

/// Pointer of a key of the projectile.
fn at(key: &str) -> String {
    format!("/projectile/{key}")
}

impl Projectile {
    /// Whether the body has the nose and the density of a bullet of lead, which flattens where this one is rigid.
    pub(crate) fn is_bullet_of_lead(&self) -> bool {
        let has_nose = matches!(self.shape, Shape::Cone { .. } | Shape::Ogive { .. });
        has_nose && LEAD.contains(&(self.mass / self.shape.volume()))
    }

    /// Completes and checks the projectile.
    pub(super) fn complete(&mut self, record: &Provenance) -> Result<(), CaseError> {
        self.shape.complete(record)?;
        if self.shape.sizes()[1] > 0.0 {
            self.complete_edge_radius(record)?;
        }
        if let Some(density) = self.density {
            let how = "density_kg_m3 times the volume of the body";
            let assumed = record.is_assumed(&at("density_kg_m3"));
            record.fill(&at("mass_g"), &mut self.mass, density * self.shape.volume(), how, assumed);
        }
        if let Some((axial, transverse)) = self.axial_inertia.zip(self.transverse_inertia)
            && axial > 2.0 * transverse
        {
            let g_mm2 = |inertia: f64| format!("{} g·mm²", short_number_text(inertia * 1e9));
            let expected = format!("at most twice transverse_inertia_g_mm2, which is {}", g_mm2(2.0 * transverse));
            let error = CaseError::at(at("axial_inertia_g_mm2"), expected, g_mm2(axial));
            return Err(error.help("no body has a moment of inertia above the sum of the other two"));
        }
        if self.shape.is_bar() {
            if self.rotation == Rotation::Free {
                let error = CaseError::at(at("rotation"), "\"locked\" for a bar", "\"free\"");
                return Err(error.help("a bar never turns; leave \"rotation\" out"));
            }
            if !record.has(&at("rotation")) {
                record.derive_text(&at("rotation"), "locked", "a bar never turns", false);
            }
        } else if self.axial_inertia.is_none() {
            for key in ["axial_inertia_g_mm2", "transverse_inertia_g_mm2"] {
                record.derive_text(&at(key), "of the body", "", false);
            }
        }
        Ok(())
    }

    fn complete_edge_radius(&mut self, record: &Provenance) -> Result<(), CaseError> {
        let (largest, pointed) = (self.shape.largest_edge(), self.shape.is_pointed());
        let (radius, how) = match pointed {
            true => (TIP_RADIUS.min(TIP_PART * self.shape.diameter()).min(largest), ROUNDED),
            false => (0.0, "sharp edges"),
        };
        record.fill(&at("edge_radius_mm"), &mut self.edge_radius, radius, how, pointed);
        if self.edge_radius > largest {
            let expected = format!("at most {}, the largest that this shape has room for", millimetres(largest));
            return Err(CaseError::at(at("edge_radius_mm"), expected, millimetres(self.edge_radius)));
        }
        Ok(())
    }
}
