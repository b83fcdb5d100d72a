//! Projectile: its keys, and the same in SI units.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::error::{millimetres, short_number_text};
use super::keys::choices;
use super::provenance::Provenance;
use super::{CaseError, Shape};

/// Rounding of a point that says nothing [m]. Under a sharp one a node stands on the tip or slips off it, which is a matter of the last bit:
/// the limit of a cone is 93 or 76 m/s. From 0.15 to 0.5 mm it is 95 to 99 m/s.
const TIP_RADIUS: f64 = 0.5e-3;
/// Largest such rounding over the diameter [-].
const TIP_PART: f64 = 0.1;

/// A rigid projectile. Flight is along +Z at normal incidence; the pack lies in Z = 0 around the origin.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Projectile {
    /// Geometry.
    #[serde(flatten)]
    pub shape: Shape,
    /// Radius of the rounding of every edge [m].
    #[serde(default)]
    pub edge_radius: f64,
    /// [kg]
    #[serde(default)]
    pub mass: f64,
    /// Density of a solid body, where the case gives it [kg/m³].
    pub density: Option<f64>,
    /// Moments of inertia about the body axis and across it through the centre of mass [kg·m²]; `None`: uniform solid.
    #[serde(flatten, deserialize_with = "inertia")]
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
    #[serde(default)]
    pub yaw: f64,
    /// Initial angular velocity, fixed axes X, Y, Z [rad/s].
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Coulomb coefficient against fabric [-].
    pub friction: f64,
    /// Free flight or velocity held.
    pub motion: Motion,
    /// Whether the body may rotate.
    #[serde(default = "locked")]
    pub rotation: Rotation,
}

fn inertia<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    #[derive(Deserialize)]
    struct Inertia {
        axial_inertia: Option<f64>,
        transverse_inertia: Option<f64>,
    }
    let Inertia { axial_inertia, transverse_inertia } = Inertia::deserialize(deserializer)?;
    Ok(axial_inertia.zip(transverse_inertia).map(Into::into))
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
    pub(super) enum ShapeWord {
        Cylinder = "cylinder" or "rcc",
        Sphere = "sphere" or "ball",
        Cone = "cone",
        Ogive = "ogive",
        Fragment = "fragment" or "fsp",
        Bar = "bar",
    }
}

/// Shapes that have a length and edges.
const LONG: [&str; 4] = ["cylinder", "cone", "ogive", "fragment"];
/// Shapes that can turn.
const TURNING: [&str; 5] = ["cylinder", "sphere", "cone", "ogive", "fragment"];

/// Keys of a projectile; those of its shape are one value of [`Projectile`].
#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
pub(super) struct ProjectileKeys {
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
    #[schemars(range(min = 1e-3, max = 10_000.0), extend("only" = {"shape": ["cone", "ogive"]}))]
    nose_length_mm: Option<f64>,
    /// Width of the flat strip across the front, at most diameter_mm, between the slanted flats.
    ///
    /// Otherwise: assumed: 0.46 × diameter_mm, about as chisel-nosed fragment simulators have it.
    #[schemars(range(min = 1e-3, max = 1000.0), extend("only" = {"shape": ["fragment"]}))]
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
    /// Radius of the rounding of every edge.
    ///
    /// Otherwise: 0, sharp edges; a point (cone, ogive): assumed, 0.5 mm, at most a tenth of diameter_mm and what the shape has room
    /// for.
    #[schemars(range(min = 0, max = 500), extend("only" = {"shape": LONG}))]
    edge_radius_mm: Option<f64>,
    /// The yarn direction a bar lies along.
    ///
    /// Default: across the warp.
    #[schemars(extend("default" = "weft", "only" = {"shape": ["bar"]}))]
    along: Option<Along>,
    /// Mass.
    ///
    /// Default: not used: the velocity is prescribed.
    #[schemars(range(min = 1e-9, max = 1e6), extend("default" = 1000.0, "where" = {"motion": "prescribed"}, "or" = "/density_kg_m3"))]
    mass_g: Option<f64>,
    /// Density of a solid body (steel 7850): gives the mass where mass_g is left out; where both are given, they are compared.
    #[schemars(range(min = 1.0, max = 1e5), extend("without" = "", "only" = {"shape": TURNING}))]
    density_kg_m3: Option<f64>,
    /// Moment of inertia about the body's axis.
    ///
    /// Otherwise: a uniform solid of this shape and mass.
    #[schemars(range(min = 1e-9, max = 1e12), extend("with" = "transverse_inertia_g_mm2", "only" = {"shape": TURNING}))]
    axial_inertia_g_mm2: Option<f64>,
    /// Moment of inertia across the axis, about the centre.
    ///
    /// Otherwise: a uniform solid of this shape and mass.
    #[schemars(range(min = 1e-9, max = 1e12), extend("with" = "axial_inertia_g_mm2", "only" = {"shape": TURNING}))]
    transverse_inertia_g_mm2: Option<f64>,
    /// Speed along the line of flight.
    #[schemars(range(max = 5000.0), extend("exclusiveMinimum" = 0.0))]
    velocity_m_s: f64,
    /// Point of aim from the pack's centre.
    ///
    /// Default: centred.
    #[schemars(inner(range(min = -1e5, max = 1e5)), extend("default" = [0, 0]))]
    offset_mm: [f64; 2],
    /// Gap between nose and first ply at the start.
    ///
    /// Default: flight through air is not computed.
    #[schemars(range(min = 0, max = 1000), extend("default" = 0.0))]
    standoff_mm: f64,
    /// Angle of the line of flight to the pack's normal.
    ///
    /// Default: normal incidence.
    #[schemars(range(min = 0, max = 85), extend("default" = 0.0))]
    obliquity_deg: f64,
    /// Direction of the obliquity, from warp towards weft.
    ///
    /// Default: towards warp.
    #[schemars(range(min = -360, max = 360), extend("default" = 0.0))]
    azimuth_deg: f64,
    /// Angle of the body's axis to the line of flight.
    ///
    /// Default: axis along the line of flight.
    #[schemars(range(min = -180, max = 180), extend("default" = 0.0, "only" = {"shape": TURNING}))]
    yaw_deg: Option<f64>,
    /// Initial rotation about X, Y, Z.
    ///
    /// Default: no rotation.
    #[schemars(inner(range(min = -1e6, max = 1e6)), extend("default" = [0, 0, 0], "only" = {"shape": TURNING}))]
    angular_velocity_rad_s: Option<[f64; 3]>,
    /// Coulomb coefficient against fabric.
    ///
    /// Default: assumed: not published for this projectile and fabric.
    #[schemars(range(min = 0, max = 2), extend("default" = 0.2))]
    friction: f64,
    /// Free flight, or the velocity held.
    ///
    /// Default: a body in flight.
    #[schemars(extend("default" = "free"))]
    motion: Motion,
    /// Whether the body may turn; a bar never does.
    ///
    /// Default: a body in flight.
    #[schemars(extend("default" = "free", "where" = {"shape": TURNING}))]
    rotation: Option<Rotation>,
}

/// Pointer of a key of the projectile.
pub(super) fn at(key: &str) -> String {
    format!("/projectile/{key}")
}

impl Projectile {
    /// Completes and checks the projectile.
    pub(super) fn complete(&mut self, record: &Provenance) -> Result<(), CaseError> {
        self.shape.complete(record)?;
        self.complete_edge_radius(record)?;
        if let Some(density) = self.density {
            let (how, assumed) =
                ("density_kg_m3 times the volume of the body", record.is_assumed(&at("density_kg_m3")));
            record.fill(&at("mass_g"), &mut self.mass, density * self.shape.volume(), how, assumed);
        }
        let g_mm2 = |inertia: f64| format!("{} g·mm²", short_number_text(inertia * 1e9));
        match self.inertia {
            Some([axial, transverse]) if axial > 2.0 * transverse => {
                let expected = format!("at most twice transverse_inertia_g_mm2, which is {}", g_mm2(2.0 * transverse));
                let error = CaseError::at(at("axial_inertia_g_mm2"), expected, g_mm2(axial));
                return Err(error.help("no body has a moment of inertia above the sum of the other two"));
            }
            None if !self.shape.is_bar() => {
                for key in ["axial_inertia_g_mm2", "transverse_inertia_g_mm2"] {
                    record.derive_text(&at(key), "of the body", "", false);
                }
            }
            _ => {}
        }
        if self.shape.is_bar() && self.rotation == Rotation::Free {
            let error = CaseError::at(at("rotation"), "\"locked\" for a bar", "\"free\"");
            return Err(error.help("a bar never turns; leave \"rotation\" out"));
        }
        if !record.has(&at("rotation")) {
            record.derive_text(&at("rotation"), "locked", "a bar never turns", false);
        }
        Ok(())
    }

    fn complete_edge_radius(&mut self, record: &Provenance) -> Result<(), CaseError> {
        if self.shape.sizes()[1] == 0.0 {
            return Ok(());
        }
        let largest = self.shape.largest_edge();
        let (radius, how) = match self.shape.is_pointed() {
            true => (
                TIP_RADIUS.min(TIP_PART * self.shape.diameter()).min(largest),
                "assumed: 0.5 mm, at most a tenth of diameter_mm and what the shape has room for",
            ),
            false => (0.0, "sharp edges"),
        };
        record.fill(&at("edge_radius_mm"), &mut self.edge_radius, radius, how, self.shape.is_pointed());
        if self.edge_radius > largest {
            let expected = format!("at most {}, the largest that this shape has room for", millimetres(largest));
            return Err(CaseError::at(at("edge_radius_mm"), expected, millimetres(self.edge_radius)));
        }
        Ok(())
    }
}
