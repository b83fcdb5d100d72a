//! The keys of `projectile`.

use super::fields::{CaseKey, KeyType, above, key, number, within, word};
use super::units::{DEG, G_MM2, GRAM, KG_M3, M_S, MM, NONE, RAD_S};
use super::words::{ShapeWord, Word};
use super::{Along, Motion, Rotation};

/// The shapes that have a length and edges, and those that can turn.
const LONG: &[&str] = &["cylinder", "cone", "ogive", "fragment"];
const TURNING: &[&str] = &["cylinder", "sphere", "cone", "ogive", "fragment"];

pub(super) static PROJECTILE: &[CaseKey] = &[
    word("shape", ShapeWord::WORDS, "Geometry of the rigid body."),
    number("diameter_mm", MM, within(1e-3, 1000.0), "Diameter."),
    number("length_mm", MM, within(1e-3, 10_000.0), "Whole length.").only("shape", LONG),
    number(
        "nose_length_mm",
        MM,
        within(1e-3, 10_000.0),
        "Length of the nose, at most length_mm; of an ogive at least half of diameter_mm.",
    )
    .derived("a plain cone: length_mm; an ogive: assumed, 1.5 × diameter_mm, at most length_mm")
    .only("shape", &["cone", "ogive"]),
    number(
        "nose_flat_mm",
        MM,
        within(1e-3, 1000.0),
        "Width of the flat strip across the front, at most diameter_mm, between the slanted flats.",
    )
    .derived("assumed: 0.46 × diameter_mm, about as chisel-nosed fragment simulators have it")
    .only("shape", &["fragment"]),
    number("nose_angle_deg", DEG, within(5.0, 75.0), "Angle between the strip's plane and the slanted flats.")
        .default(35.0, "assumed: about as chisel-nosed fragment simulators have it")
        .only("shape", &["fragment"]),
    number("roll_deg", DEG, within(-360.0, 360.0), "Turn of the strip about the body's axis, from warp towards weft.")
        .default(0.0, "strip along warp at normal incidence")
        .only("shape", &["fragment"]),
    number("edge_radius_mm", MM, within(0.0, 500.0), "Radius of the rounding of every edge.")
        .derived("0, sharp edges; a point (cone, ogive): assumed, 0.5 mm, at most a tenth of diameter_mm and what the shape has room for")
        .only("shape", LONG),
    word("along", Along::WORDS, "The yarn direction a bar lies along.")
        .default_word("weft", "across the warp")
        .only("shape", &["bar"]),
    number("mass_g", GRAM, within(1e-9, 1e6), "Mass.").required_unless(
        ("motion", "prescribed"),
        1000.0,
        "not used: the velocity is prescribed",
    )
    .or("density_kg_m3"),
    number(
        "density_kg_m3",
        KG_M3,
        within(1.0, 1e5),
        "Density of a solid body (steel 7850): gives the mass where mass_g is left out; where both are given, they are compared.",
    )
    .optional("")
    .only("shape", TURNING),
    number("axial_inertia_g_mm2", G_MM2, within(1e-9, 1e12), "Moment of inertia about the body's axis.")
        .derived("a uniform solid of this shape and mass")
        .with("transverse_inertia_g_mm2")
        .only("shape", TURNING),
    number(
        "transverse_inertia_g_mm2",
        G_MM2,
        within(1e-9, 1e12),
        "Moment of inertia across the axis, about the centre.",
    )
    .derived("a uniform solid of this shape and mass")
    .with("axial_inertia_g_mm2")
    .only("shape", TURNING),
    number("velocity_m_s", M_S, above(0.0, 5000.0), "Speed along the line of flight."),
    key("offset_mm", KeyType::Numbers(MM, within(-1e5, 1e5), [2, 2]), "Point of aim from the pack's centre.")
        .default_list(&[0.0; 2], "centred"),
    number("standoff_mm", MM, within(0.0, 1000.0), "Gap between nose and first ply at the start.")
        .default(0.0, "flight through air is not computed"),
    number("obliquity_deg", DEG, within(0.0, 85.0), "Angle of the line of flight to the pack's normal.")
        .default(0.0, "normal incidence"),
    number("azimuth_deg", DEG, within(-360.0, 360.0), "Direction of the obliquity, from warp towards weft.")
        .default(0.0, "towards warp"),
    number("yaw_deg", DEG, within(-180.0, 180.0), "Angle of the body's axis to the line of flight.")
        .default(0.0, "axis along the line of flight")
        .only("shape", TURNING),
    key("angular_velocity_rad_s", KeyType::Numbers(RAD_S, within(-1e6, 1e6), [3, 3]), "Initial rotation about X, Y, Z.")
        .default_list(&[0.0; 3], "no rotation")
        .only("shape", TURNING),
    number("friction", NONE, within(0.0, 2.0), "Coulomb coefficient against fabric.")
        .default(0.2, "assumed: not published for this projectile and fabric"),
    word("motion", Motion::WORDS, "Free flight, or the velocity held.").default_word("free", "a body in flight"),
    word("rotation", Rotation::WORDS, "Whether the body may turn; a bar never does.")
        .default_word("free", "a body in flight"),
];
