//! The case: what the user asked for, read from JSON, checked, in SI units.
//!
//! This is the only module that knows JSON keys and textile or ballistic units. Everything downstream
//! (`model`, `state`, `step`, …) sees the types below: SI numbers that are finite, in range and
//! consistent with each other.

use std::borrow::Cow;
use std::path::PathBuf;

mod build;
mod check;
mod error;
mod expect;
mod fabric_file;
mod fields;
mod grading;
mod hash;
mod json;
mod layup;
mod limits;
mod places;
mod pointer;
mod projectile;
mod read;
mod record;
mod reference;
mod report;
mod schema;
mod scope;
mod set;
mod sources;
mod table;
mod value;
mod variability;
mod variability_keys;
mod words;

use crate::math::solid::Solid;
pub use error::CaseError;
pub(crate) use error::nearest;
pub use fabric_file::builtin_fabric;
pub use grading::Grading;
pub(crate) use hash::CASE_WORDS;
pub use hash::case_hash;
pub(crate) use pointer::escape as escape_pointer;
pub(crate) use read::realisation;
pub use read::{from_str, from_text, read};
pub use reference::reference;
pub(crate) use report::mesh;
pub use report::report;
pub use schema::schema;
pub(crate) use variability::RANGE_STREAM;
pub use variability::{Distribution, Drawn, HitPlace, Scattered, Variability, YarnStrength};
pub(crate) use words::Word;

/// A complete, validated case in SI units.
#[derive(Clone, Debug)]
pub struct Case {
    /// File stem of the case; names the default output folder.
    pub name: String,
    /// Free text for people.
    pub title: String,
    /// The fabric of every ply.
    pub fabric: Fabric,
    /// Plies, size, edges and initial state of the pack.
    pub pack: Pack,
    /// What strikes the pack, if anything does.
    pub projectile: Option<Projectile>,
    /// What varies from shot to shot; `None`: nothing does.
    pub variability: Option<Variability>,
    /// What was drawn for the shot that this case is; empty for the nominal case.
    pub drawn: Vec<Drawn>,
    /// Time integration.
    pub solver: Solver,
    /// What is written and how often.
    pub output: Output,
    /// Statements about the result that the run checks.
    pub expect: Vec<Expect>,
    /// Every field of the case with where its value came from, in schema order.
    pub fields: Vec<Field>,
    /// The case as run: file with its fabric inlined and every `--set` applied. Written to the output folder.
    pub as_run: serde_json::Value,
    /// What of the file was left out, and why, a line each.
    pub notes: Vec<String>,
    /// The file the case was read from (empty for a built-in case).
    pub path: PathBuf,
}

impl Case {
    /// The plies in groups of alike ones, from the struck side: the layup, or the whole pack where it has none.
    pub fn layers(&self) -> Cow<'_, [Layer]> {
        let pack = &self.pack;
        if !pack.layup.is_empty() {
            return Cow::Borrowed(&pack.layup);
        }
        Cow::Owned(vec![Layer {
            plies: pack.plies,
            fabric: self.fabric.clone(),
            orientation: 0.0,
            edges: pack.edges,
            initial_velocity: pack.initial_velocity,
            columns: pack.columns,
            rows: pack.rows,
            element_length_x: pack.element_length_x,
            element_length_y: pack.element_length_y,
            grading: pack.grading,
        }])
    }

    /// Memory set aside for frames that wait to be written [bytes].
    pub(crate) fn waiting_frame_bytes(&self) -> usize {
        limits::waiting_frame_bytes(self)
    }

    /// Frames that the memory set aside for making them holds, at least one.
    pub(crate) fn frames_at_once(&self) -> usize {
        limits::frames_at_once(self)
    }

    /// Elements over all plies.
    pub fn elements(&self) -> usize {
        self.layers().iter().map(|layer| layer.plies as usize * layer.columns * layer.rows).sum()
    }
}

/// One woven fabric (Table I of the paper plus what it leaves open).
#[derive(Clone, Debug, PartialEq)]
pub struct Fabric {
    /// Designation, e.g. "S-720".
    pub name: String,
    /// Fibre density [kg/m³]; enters through the yarn's cross-section only.
    pub fibre_density: f64,
    /// Mass per area [kg/m²], given or derived from linear density, count and crimp.
    pub areal_density: f64,
    /// Yarns along X.
    pub warp: Yarn,
    /// Yarns along Y.
    pub weft: Yarn,
    /// Warp–weft interaction.
    pub crossover: Crossover,
    /// Trellis shear (25); `None` when the case has no shear.
    pub shear: Option<Shear>,
    /// Fabric thickness [m]: shear resultant and default ply spacing.
    pub thickness: f64,
}

/// One yarn system.
#[derive(Clone, Debug, PartialEq)]
pub struct Yarn {
    /// False when this yarn direction is absent (`"absent": true`): no tension, no crimp, only its count.
    pub present: bool,
    /// Mass per length of the straight yarn [kg/m].
    pub linear_density: f64,
    /// Fibre elastic modulus [Pa].
    pub modulus: f64,
    /// Axial strain at which the yarn breaks [-].
    pub failure_strain: f64,
    /// Crossovers per metre along this yarn, m in (12): undeformed cell length 2·w0 = 1/count [1/m].
    pub count: f64,
    /// Crimp (14): yarn length over fabric length minus one [-].
    pub crimp: f64,
}

/// The warp–weft interaction law.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossover {
    /// Which unit-cell law.
    pub law: Law,
    /// In-plane force of the published law.
    pub membrane_force: MembraneForce,
    /// Initial gap g between the yarns (22) [m].
    pub gap: f64,
    /// Transverse compression (21); `None` is a rigid crossover.
    pub compression: Option<Compression>,
}

/// Unit-cell law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Law {
    /// The paper's (13)–(24): sinusoidal yarns, F = 2 T sin α.
    Published,
    /// Sinusoidal yarns, forces conjugate to the arc length: conserves energy to round-off.
    Variational,
    /// Saw-tooth cell of Kawabata (1973).
    Kawabata,
}

/// In-plane force of the published law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MembraneForce {
    /// The yarn tension T.
    Tension,
    /// Its projection T cos α.
    Projected,
}

/// Constants of the transverse compression law (21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compression {
    /// Largest transverse compression a [m].
    pub a: f64,
    /// b [m·N^(1/3)].
    pub b: f64,
}

/// Trellis shear (25).
#[derive(Clone, Debug, PartialEq)]
pub struct Shear {
    /// Modulus before locking [Pa].
    pub g1: f64,
    /// Modulus after locking [Pa].
    pub g2: f64,
    /// Shear angle where locking begins [rad].
    pub gamma1: f64,
    /// Shear angle where locking is complete [rad].
    pub gamma2: f64,
    /// How G enters the stress.
    pub modulus: ShearModulus,
}

/// How the modulus of (25) is understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShearModulus {
    /// dτ/dγ = G(γ).
    Tangent,
    /// τ = G(γ)·γ.
    Secant,
}

/// The pack: plies and the frame that holds them.
#[derive(Clone, Debug, PartialEq)]
pub struct Pack {
    /// Number of plies.
    pub plies: u32,
    /// Distance between mid-planes of neighbouring plies [m]; `None`: the mean of their two thicknesses.
    pub spacing: Option<f64>,
    /// Coulomb coefficient between plies [-].
    pub friction: f64,
    /// The plies in groups from the struck side, where they are not all of the case's fabric, laid alike; else empty.
    pub layup: Vec<Layer>,
    /// Elements of the finest size along warp (X); the asked width rounded to whole elements.
    pub columns: usize,
    /// Elements of the finest size along weft (Y).
    pub rows: usize,
    /// Undeformed length along warp of the finest elements [m].
    pub element_length_x: f64,
    /// Undeformed length along weft of the finest elements [m].
    pub element_length_y: f64,
    /// Crossovers along each side of an element of the finest size.
    pub crossovers_per_element: u32,
    /// How elements grow away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
    /// Elements along each side of one crossover.
    pub elements_per_crossover: u32,
    /// Boundary conditions.
    pub edges: Edges,
    /// Initial membrane force per reference length [N/m] along warp and weft; `None` holds that stretch at 1.
    pub pretension: Option<[Option<f64>; 2]>,
    /// Uniform initial velocity of every free node [m/s].
    pub initial_velocity: [f64; 3],
    /// Initial sine deflection, if any.
    pub initial_deflection: Option<InitialDeflection>,
}

impl Pack {
    /// Crossovers along a side of the finest elements.
    pub fn crossovers_along_element(&self) -> f64 {
        f64::from(self.crossovers_per_element) / f64::from(self.elements_per_crossover)
    }
}

/// Consecutive plies that are alike.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Number of plies.
    pub plies: u32,
    /// Their fabric.
    pub fabric: Fabric,
    /// Angle of the warp to the pack's X axis, towards Y [rad]. The ply's own axes turn with it, its edges too.
    pub orientation: f64,
    /// Boundary conditions, in the ply's own axes.
    pub edges: Edges,
    /// Initial velocity of every free node, in the pack's axes [m/s].
    pub initial_velocity: [f64; 3],
    /// Elements of the finest size along warp.
    pub columns: usize,
    /// Elements of the finest size along weft.
    pub rows: usize,
    /// Undeformed length along warp of the finest elements [m].
    pub element_length_x: f64,
    /// Undeformed length along weft of the finest elements [m].
    pub element_length_y: f64,
    /// How elements grow away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
}

/// w = amplitude · sin(m π X/width) · sin(n π Y/height); 0 half waves along a direction: constant there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialDeflection {
    /// [m]
    pub amplitude: f64,
    /// m
    pub warp_half_waves: u32,
    /// n
    pub weft_half_waves: u32,
}

/// Boundary condition of each side; X runs left to right along warp, Y bottom to top along weft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edges {
    /// X = 0
    pub left: Edge,
    /// X = width
    pub right: Edge,
    /// Y = 0
    pub bottom: Edge,
    /// Y = height
    pub top: Edge,
}

/// Boundary condition of one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// All displacements held.
    Clamped,
    /// Nothing held.
    Free,
    /// Displacement normal to the side held (symmetry plane).
    Roller,
}

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

/// The scheme that keys left out of a case take their values from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numerics {
    /// Shock viscosity, contact at the rim, a mesh that is fine around the hit.
    Default,
    /// The paper's own: one even element per crossover, contact at nodes, no viscosity.
    Paper,
}

/// How far the mesh around the hit is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accuracy {
    /// The cheapest mesh whose ballistic limit is near the converged one.
    Default,
    /// The mesh from which on the limit stays.
    Converged,
}

/// Time integration.
#[derive(Clone, Debug, PartialEq)]
pub struct Solver {
    /// The scheme behind the defaults of the others.
    pub numerics: Numerics,
    /// How far the mesh around the hit is refined.
    pub accuracy: Accuracy,
    /// [s]
    pub end_time: f64,
    /// Time step over the critical one, in (0, 1].
    pub courant: f64,
    /// Hourglass stiffness over the full-integration stiffness [-].
    pub hourglass: f64,
    /// Coefficient of the shock viscosity along the yarns [-].
    pub shock_viscosity: f64,
    /// Length along a yarn over which its failure is judged [m]; 0: that of an element.
    pub failure_length: f64,
    /// Whether mirror symmetry may be used.
    pub symmetry: Symmetry,
    /// Where contact with the projectile is sampled.
    pub contact_sampling: ContactSampling,
    /// How the unit cell is solved.
    pub unit_cell: UnitCell,
    /// When the run ends.
    pub run_until: RunUntil,
}

/// Where the lines of nodes of a graded mesh are counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinesFrom {
    /// Two lines cross where the projectile hits, so that the mesh around a hit does not depend on its place in the weave.
    Hit,
    /// Lines lie whole finest elements from the edges of the ply.
    Edges,
}

/// Whether mirror symmetry may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Where the scene has it.
    Auto,
    /// Never.
    None,
}

/// Where contact with the projectile is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactSampling {
    /// At nodes.
    Nodes,
    /// At nodes, and where the rim of a flat face crosses the edges of elements.
    Edges,
}

/// How the unit cell is solved; to rounding the result is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitCell {
    /// Newton on both heights and the compression together; bracketed where that fails.
    Newton,
    /// Bracketed Newton on one height: slower.
    Safeguarded,
}

/// When the run ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunUntil {
    /// As soon as the outcome is known (or at `end_time`).
    Outcome,
    /// As soon as the projectile is through, or flies back free of the fabric (or at `end_time`).
    Separation,
    /// At `end_time`, whatever happened before.
    EndTime,
}

/// What is written and how often.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Interval of `history.csv` [s].
    pub history_interval: f64,
    /// Frames for ParaView, evenly from the start to the end time.
    pub frames: u32,
    /// Times at which a deflection profile is sampled [s], ascending.
    pub profile_times: Vec<f64>,
    /// Direction of the profile through the point of impact (pack centre without projectile).
    pub profile_along: Along,
}

/// A statement about the result, checked after the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Expect {
    /// Name of the quantity: any number or word of `summary.json`, any column of `history.csv` (with `at_us`),
    /// or a measured wave quantity.
    pub quantity: String,
    /// What is expected.
    pub bound: Bound,
    /// Time at which a history or profile quantity is read [s].
    pub at: Option<f64>,
    /// Interval over which a speed or frequency is measured [s].
    pub between: Option<[f64; 2]>,
    /// Where the statement comes from.
    pub source: String,
    /// Why it is known not to hold; empty: it must.
    pub known_difference: String,
}

/// The expectation itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// A word, e.g. an outcome.
    Word(String),
    /// |got − value| ≤ tolerance (already absolute, in the quantity's own unit).
    Value {
        /// Expected.
        value: f64,
        /// Allowed absolute difference.
        tolerance: f64,
    },
    /// min ≤ got ≤ max.
    Range {
        /// −∞ when absent.
        min: f64,
        /// +∞ when absent.
        max: f64,
    },
}

/// One field of the case and where its value came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// JSON pointer, e.g. `/fabric/warp/modulus_gpa`.
    pub pointer: String,
    /// Value in the key's unit, as text.
    pub value: String,
    /// Unit, empty when dimensionless.
    pub unit: &'static str,
    /// Read, defaulted or derived.
    pub origin: Origin,
    /// Where the value comes from: the case's `sources`, the default's source, or the formula.
    pub source: String,
    /// True when the value is assumed rather than published.
    pub assumed: bool,
}

/// Where a field's value came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// From the case file or `--set`.
    Read,
    /// Not given: the documented default.
    Default,
    /// Computed from other fields.
    Derived,
}

impl Origin {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Default => "default",
            Self::Derived => "derived",
        }
    }
}

impl Yarn {
    /// Fibre cross-section A = linear density / fibre density [m²].
    pub fn area(&self, fibre_density: f64) -> f64 {
        self.linear_density / fibre_density
    }

    /// Undeformed half-span w0 = 1/(2·count) (12) [m].
    pub fn half_span(&self) -> f64 {
        0.5 / self.count
    }
}
