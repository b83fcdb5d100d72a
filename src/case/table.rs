//! Every key of the case file: name, unit, range, default with its source, and meaning.

use std::f64::consts::PI;

use super::fields::{CaseKey, KeyType, Unit, above, key, number, within, word};
use super::pointer::index;
use super::variability_keys::VARIABILITY;
use super::words::{ShapeWord, Word};
use super::{
    Accuracy, Along, ContactSampling, Edge, Law, LinesFrom, MembraneForce, Motion, Numerics, Rotation, RunUntil,
    ShearModulus, Symmetry, UnitCell,
};

pub(super) const NONE: Unit = Unit::new("", 1.0, 1.0);
const RAD: Unit = Unit::new("rad", 1.0, 1.0);
pub(super) const DEG: Unit = Unit::new("deg", PI, 180.0);
pub(super) const MM: Unit = Unit::new("mm", 1.0, 1e3);
const MM_N13: Unit = Unit::new("mm·N^(1/3)", 1.0, 1e3);
const US: Unit = Unit::new("µs", 1.0, 1e6);
pub(super) const M_S: Unit = Unit::new("m/s", 1.0, 1.0);
const RAD_S: Unit = Unit::new("rad/s", 1.0, 1.0);
const GRAM: Unit = Unit::new("g", 1.0, 1e3);
const G_MM2: Unit = Unit::new("g·mm²", 1.0, 1e9);
const KG_M3: Unit = Unit::new("kg/m³", 1.0, 1.0);
const G_M2: Unit = Unit::new("g/m²", 1.0, 1e3);
/// Grams per 9000 m.
const DENIER: Unit = Unit::new("denier", 1.0, 9e6);
/// Grams per 1000 m.
const TEX: Unit = Unit::new("tex", 1.0, 1e6);
const DTEX: Unit = Unit::new("dtex", 1.0, 1e7);
const PER_INCH: Unit = Unit::new("1/inch", 1e4, 254.0);
const PER_CM: Unit = Unit::new("1/cm", 100.0, 1.0);
const GPA: Unit = Unit::new("GPa", 1e9, 1.0);
const MPA: Unit = Unit::new("MPa", 1e6, 1.0);
const N_M: Unit = Unit::new("N/m", 1.0, 1.0);

/// Hourglass stiffness over the full-integration stiffness where the case gives none.
const HOURGLASS: f64 = 0.001;
/// Plies of a pack at most.
pub(super) const MAX_PLIES: u32 = 64;
const NOT_PUBLISHED: &str = "assumed: not published for this fabric";

pub(super) static CASE: &[CaseKey] = &[
    key(
        "$schema",
        KeyType::Text,
        "The JSON Schema of case files, for editors; ripstop writes one with `ripstop schema`.",
    )
    .optional(""),
    key("title", KeyType::Text, "What the case is, for people."),
    key(
        "fabric",
        KeyType::ObjectOrFile(FABRIC),
        "The fabric of every ply that pack.layup gives no other; a file is named relative to the case's folder.",
    ),
    key("pack", KeyType::Object(PACK), "Plies, size, edges and initial state."),
    key("projectile", KeyType::Object(PROJECTILE), "What strikes the pack; null or absent: nothing does.")
        .optional("nothing strikes the pack"),
    key(
        "variability",
        KeyType::Object(VARIABILITY),
        "What varies from shot to shot; nothing does in a case that names no shot.",
    )
    .optional(""),
    key("solver", KeyType::Object(SOLVER), "Time integration.").optional(""),
    key("output", KeyType::Object(OUTPUT), "What is written and how often.").optional(""),
    key("expect", KeyType::Items(EXPECT, [0, 1000]), "Statements about the result that the run checks.").optional(""),
    key(
        "sources",
        KeyType::Sources,
        "Where values come from: JSON pointer of a value or of an object around it, and text; \
        a text that begins with \"assumed\" marks its values as assumed.",
    )
    .optional(""),
    key("notes", KeyType::Text, "Remarks for people.").optional(""),
];

pub(super) static FABRIC: &[CaseKey] = &[
    key("name", KeyType::Text, "Designation."),
    number("fibre_density_kg_m3", KG_M3, within(100.0, 30_000.0), "Density of the fibre; gives the yarn's section."),
    number("areal_density_g_m2", G_M2, within(0.01, 1e5), "Mass per area of the fabric.")
        .derived("linear density × (1 + crimp) × count of both yarns"),
    key("warp", KeyType::Object(YARN), "Yarns along X."),
    key("weft", KeyType::Object(YARN), "Yarns along Y."),
    key("crossover", KeyType::Object(CROSSOVER), "Interaction of warp and weft.").optional(""),
    number("thickness_mm", MM, within(1e-3, 100.0), "Thickness of the fabric: shear resultant and ply spacing.")
        .default(0.30, NOT_PUBLISHED),
    key("shear", KeyType::WordOrObject(&["none"], SHEAR), "Resistance to trellis shear, (25) of the paper.")
        .optional(""),
];

static YARN: &[CaseKey] = &[
    key("absent", KeyType::Flag, "True: no yarn in this direction, its count still sets the element size.")
        .default_false("a woven fabric has both yarns"),
    number("linear_density_denier", DENIER, within(0.01, 1e6), "Mass of 9000 m of yarn.")
        .one_of("linear density")
        .only("absent", &["false"]),
    number("linear_density_tex", TEX, within(0.001, 1e5), "Mass of 1000 m of yarn.")
        .one_of("linear density")
        .only("absent", &["false"]),
    number("linear_density_dtex", DTEX, within(0.01, 1e6), "Mass of 10 000 m of yarn.")
        .one_of("linear density")
        .only("absent", &["false"]),
    number("modulus_gpa", GPA, within(1e-6, 1e4), "Axial modulus of the fibre.").only("absent", &["false"]),
    number("failure_strain", NONE, above(0.0, 1.0), "Axial strain at which the yarn breaks; 1: never.")
        .only("absent", &["false"]),
    number("count_per_inch", PER_INCH, within(0.1, 1000.0), "Crossovers along this yarn per inch.").one_of("count"),
    number("count_per_cm", PER_CM, within(0.04, 400.0), "Crossovers along this yarn per cm.").one_of("count"),
    number("crimp", NONE, within(0.0, 0.5), "Yarn length over fabric length, minus one.").only("absent", &["false"]),
];

static CROSSOVER: &[CaseKey] = &[
    word("law", Law::WORDS, "Unit-cell law.").default_word("published", "the paper's (11)-(24)"),
    word("membrane_force", MembraneForce::WORDS, "In-plane force of the published law: T, or T cos α.")
        .default_word("tension", "the paper's yarn tension"),
    number("gap_mm", MM, within(0.0, 1.0), "Initial gap between the yarns, (22).").default(0.0, NOT_PUBLISHED),
    key("compression", KeyType::WordOrObject(&["rigid"], COMPRESSION), "Transverse compression of the yarns, (21).")
        .optional(""),
];

static COMPRESSION: &[CaseKey] = &[
    number("a_mm", MM, within(0.0, 10.0), "Largest compression a of (21); a = b = 0 is rigid.")
        .default(0.10, NOT_PUBLISHED),
    number("b_mm_n13", MM_N13, within(0.0, 10.0), "b of (21).").default(0.10, NOT_PUBLISHED),
];

static SHEAR: &[CaseKey] = &[
    number("thickness_mm", MM, within(1e-3, 100.0), "Thickness that carries the shear stress.")
        .derived("the fabric's thickness_mm"),
    number("g1_mpa", MPA, within(0.0, 1e6), "Modulus before locking.").default(10.0, NOT_PUBLISHED),
    number("g2_mpa", MPA, within(0.0, 1e6), "Modulus after locking, at least g1_mpa.").default(1000.0, NOT_PUBLISHED),
    number("gamma1", RAD, within(0.0, 1.5), "Shear angle where locking begins.").default(0.35, NOT_PUBLISHED),
    number("gamma2", RAD, within(0.0, 1.5), "Shear angle where locking is complete, at least gamma1.")
        .default(0.60, NOT_PUBLISHED),
    word("modulus", ShearModulus::WORDS, "Tangent: dτ/dγ = G(γ); secant: τ = G(γ) γ.")
        .default_word("tangent", "model: G of (25) as the slope of the stress"),
];

/// Where the mesh comes from.
const MESH: &str = "numerics and accuracy: around a free projectile's hit two elements per crossover (converged: four), graded beyond; one \
    even element for the paper's numerics, a bar, no projectile, or several crossovers per element";

static PACK: &[CaseKey] = &[
    key(
        "plies",
        KeyType::Whole(1, MAX_PLIES),
        "Number of plies; with a layup the sum over it, which need not be given.",
    )
    .default(1.0, "a single ply"),
    number("width_mm", MM, within(1e-3, 1e5), "Size along warp, rounded to whole elements."),
    number("height_mm", MM, within(1e-3, 1e5), "Size along weft, rounded to whole elements."),
    key("edges", KeyType::WordOrObject(Edge::WORDS, EDGES), "How the sides are held.")
        .default_word("clamped", "a fixed frame, as in the paper"),
    key("crossovers_per_element", KeyType::Whole(1, 64), "Crossovers along each side of an element.")
        .default(1.0, "the paper: one element per crossover"),
    key(
        "elements_per_crossover",
        KeyType::Whole(1, 16),
        "Elements along each side of a crossover, to refine the mesh.",
    )
    .derived(MESH),
    key(
        "mesh_grading",
        KeyType::WordOrObject(&["none", "graded"], GRADING),
        "Elements that grow away from the hit; \"graded\" is an object without keys.",
    )
    .derived(MESH),
    number(
        "spacing_mm",
        MM,
        within(0.0, 100.0),
        "Distance of neighbouring plies' mid-planes; in a layup by default the mean of the two thicknesses.",
    )
    .derived("the fabric's thickness_mm"),
    number("friction", NONE, within(0.0, 2.0), "Coulomb coefficient between plies.")
        .default(0.2, "assumed: not published for this fabric"),
    key("pretension", KeyType::Object(PRETENSION), "Initial membrane force of every ply, along its own yarns.")
        .optional(""),
    key("initial_velocity_m_s", KeyType::Numbers(M_S, within(-5000.0, 5000.0), [3, 3]), "Velocity of every free node.")
        .default_list(&[0.0; 3], "at rest"),
    key(
        "initial_deflection",
        KeyType::Object(DEFLECTION),
        "Initial amplitude·sin(mπX/width)·sin(nπY/height) of every ply, in its own axes.",
    )
    .optional("flat"),
    key(
        "layup",
        KeyType::Items(LAYER, [1, MAX_PLIES as usize]),
        "The plies in groups of consecutive ones, from the struck side, where they are not all alike.",
    )
    .optional(""),
];

static GRADING: &[CaseKey] = &[
    number(
        "fine_radius_mm",
        MM,
        within(0.0, 1e5),
        "Up to this distance from the projectile's way through the pack, along warp and weft, elements have \
        crossovers_per_element.",
    )
    .derived("four radii of the projectile, and as far as a yawed tail swings out"),
    number("growth_ratio", NONE, within(1.0, 2.0), "Largest ratio of the lengths of neighbouring elements.")
        .default(1.15, "measured: smaller ones keep the outcome no better"),
    key("max_crossovers", KeyType::Whole(1, 64), "Crossovers along a side of the largest elements.")
        .default(2.0, "measured: larger ones tangle with what is torn"),
    word(
        "lines_from",
        LinesFrom::WORDS,
        "Where lines of nodes are counted from: the hit, at which two of them cross, or the edges of the ply.",
    )
    .default_word("hit", "measured: the result does not depend on where in a cell the projectile hits"),
];

static LAYER: &[CaseKey] = &[
    key("plies", KeyType::Whole(1, MAX_PLIES), "Number of plies of this group.").default(1.0, "a single ply"),
    key(
        "fabric",
        KeyType::ObjectOrFile(FABRIC),
        "The fabric of these plies; a file is named relative to the case's folder.",
    )
    .derived("the case's fabric"),
    number(
        "orientation_deg",
        DEG,
        within(-360.0, 360.0),
        "Angle of the warp to the pack's X axis, towards Y. At a multiple of 90 the ply covers the pack's rectangle; \
        at any other angle it is cut along its yarns, width along warp and height along weft, then laid turned.",
    )
    .default(0.0, "warp along the pack's X axis"),
    key(
        "edges",
        KeyType::WordOrObject(Edge::WORDS, EDGES),
        "How the sides are held, in the ply's own axes; sides left out of an object are clamped.",
    )
    .derived("the pack's edges"),
    key(
        "initial_velocity_m_s",
        KeyType::Numbers(M_S, within(-5000.0, 5000.0), [3, 3]),
        "Velocity of every free node, in the pack's axes.",
    )
    .derived("the pack's initial_velocity_m_s"),
];

static EDGES: &[CaseKey] = &[
    word("left", Edge::WORDS, "X = 0.").default_word("clamped", "a fixed frame, as in the paper"),
    word("right", Edge::WORDS, "X = width.").default_word("clamped", "a fixed frame, as in the paper"),
    word("bottom", Edge::WORDS, "Y = 0.").default_word("clamped", "a fixed frame, as in the paper"),
    word("top", Edge::WORDS, "Y = height.").default_word("clamped", "a fixed frame, as in the paper"),
];

static PRETENSION: &[CaseKey] = &[
    number("warp_n_per_m", N_M, within(0.0, 1e7), "Force along warp per width.").optional("warp keeps its length"),
    number("weft_n_per_m", N_M, within(0.0, 1e7), "Force along weft per width.").optional("weft keeps its length"),
];

static DEFLECTION: &[CaseKey] = &[
    number("amplitude_mm", MM, within(-1000.0, 1000.0), "Largest deflection."),
    key("warp_half_waves", KeyType::Whole(0, 1000), "m; 0: constant along warp."),
    key("weft_half_waves", KeyType::Whole(0, 1000), "n; 0: constant along weft."),
];

/// The shapes that have a length and edges, and those that can turn.
const LONG: &[&str] = &["cylinder", "cone", "ogive", "fragment"];
const TURNING: &[&str] = &["cylinder", "sphere", "cone", "ogive", "fragment"];

static PROJECTILE: &[CaseKey] = &[
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
        .default(0.0, "sharp edges")
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

static SOLVER: &[CaseKey] = &[
    number(
        "end_time_us",
        US,
        within(1e-6, 1e9),
        "End of the run. Needed where nothing flies freely into the pack, or run_until is \"end_time\".",
    )
    .derived("when the outcome is known, after 1000 µs at the latest"),
    word(
        "numerics",
        Numerics::WORDS,
        "The scheme that keys left out take their values from: ripstop's own, or the paper's (one even element per crossover, contact \
        at nodes, no viscosity).",
    )
    .default_word("default", "measured: tension shocks neither ring nor make energy"),
    word(
        "accuracy",
        Accuracy::WORDS,
        "How far the mesh around the hit is refined, where elements_per_crossover is left out.",
    )
    .default_word("default", "measured: the cheapest mesh whose ballistic limit is within 5 % of the converged one"),
    number("courant", NONE, above(0.0, 1.0), "Time step over the critical one.")
        .default(0.9, "model: margin for contact, shear and hourglass stiffness")
        .help("above 1 the time step exceeds the critical step and leapfrog integration is unstable"),
    number("hourglass", NONE, within(0.0, 1.0), "Hourglass stiffness over the full-integration stiffness.")
        .default(HOURGLASS, "model: keeps hourglass energy small without stiffening"),
    number(
        "shock_viscosity",
        NONE,
        within(0.0, 1.0),
        "Linear viscosity along the yarns over the stiffness, times length of an element over wave speed; 0: none, as in the paper.",
    )
    .derived("0.3, measured: tension behind a shock peaks at most a third above its plateau; 0 with \"numerics\": \"paper\""),
    number(
        "failure_length_mm",
        MM,
        within(0.0, 100.0),
        "Length along a yarn over which, and over its whole width, the strain that breaks it is averaged; 0: that of an element, as in \
        the paper.",
    )
    .derived("0.9, assumed: the order of a yarn's width; 0 with \"numerics\": \"paper\""),
    word("symmetry", Symmetry::WORDS, "Whether mirror symmetry may be used.")
        .default_word("auto", "same result, less work"),
    word(
        "contact_sampling",
        ContactSampling::WORDS,
        "Where contact with the projectile is sampled: at nodes, or also where the rim of a flat face crosses the edges \
        of elements.",
    )
    .derived("rim, measured: before failure nearer to a finer mesh than nodes; nodes with \"numerics\": \"paper\""),
    word("unit_cell", UnitCell::WORDS, "How the unit cell is solved: the result is the same to rounding.")
        .default_word("newton", "the faster one"),
    word(
        "run_until",
        RunUntil::WORDS,
        "When the run ends: with the outcome, when a projectile that stopped has flown back free of the fabric too, or at \
        end_time_us.",
    )
        .default_word("outcome", "nothing asked for happens after it"),
];

static OUTPUT: &[CaseKey] = &[
    number("history_interval_us", US, within(1e-6, 1e9), "Interval of history.csv, at most end_time_us.")
        .default(0.5, "a few hundred rows for a shot"),
    key("frames", KeyType::Whole(0, 10_000), "Frames for ParaView, evenly from impact to the end of the run.")
        .default(0.0, "none asked for"),
    key(
        "profile_times_us",
        KeyType::Numbers(US, within(0.0, 1e9), [0, 1000]),
        "Times of deflection profiles, ascending.",
    )
    .default_list(&[], "none asked for"),
    word("profile_along", Along::WORDS, "Direction of the profiles, through the point of impact.")
        .default_word("warp", "the first axis"),
];

static EXPECT: &[CaseKey] = &[
    key("quantity", KeyType::Text, "A name of summary.json, a column of history.csv, or a measured wave quantity."),
    key("value", KeyType::NumberOrText(within(-1e15, 1e15)), "The expected number or word.").optional(""),
    number("min", NONE, within(-1e15, 1e15), "Least value; instead of value.").optional(""),
    number("max", NONE, within(-1e15, 1e15), "Largest value; instead of value.").optional(""),
    key(
        "tolerance",
        KeyType::NumberOrPercent(within(0.0, 1e15)),
        "Allowed difference from a number, absolute or \"1%\".",
    )
    .optional(""),
    number("at_us", US, within(0.0, 1e9), "Time at which the quantity is read.").optional(""),
    key("between_us", KeyType::Numbers(US, within(0.0, 1e9), [2, 2]), "Interval of a measured speed or frequency.")
        .optional(""),
    key("source", KeyType::Text, "Where the statement comes from."),
    key("known_difference", KeyType::Text, "Why the statement is known not to hold: shown, and no failure.")
        .optional(""),
];

/// The key that a JSON pointer names, whether or not a document has it.
pub(super) fn lookup(pointer: &str) -> Option<&'static CaseKey> {
    let mut keys = CASE;
    let mut found: Option<&CaseKey> = None;
    // The keys of a list's items, where the next part is an index.
    let mut items: Option<&'static [CaseKey]> = None;
    for part in pointer.strip_prefix('/')?.split('/') {
        if let Some(of_item) = items.take()
            && index(part).is_some()
        {
            keys = of_item;
            continue;
        }
        let key = keys.iter().find(|key| key.name == part)?;
        (keys, items) = match key.kind {
            KeyType::Items(of_item, _) => (&[] as &[CaseKey], Some(of_item)),
            _ => (key.keys(), None),
        };
        found = Some(key);
    }
    found
}

/// Where a pointer stands in the order of this table: the place of each of its parts.
pub(super) fn order(pointer: &str) -> Vec<usize> {
    let mut keys = CASE;
    pointer
        .split('/')
        .skip(1)
        .map(|part| {
            let place = keys.iter().position(|key| key.name == part);
            keys = place.map_or(keys, |place| keys[place].keys());
            place.or_else(|| part.parse().ok()).unwrap_or(usize::MAX)
        })
        .collect()
}

/// Every pointer of the table; those below a list are left out.
pub(super) fn pointers() -> Vec<String> {
    let mut pointers = Vec::new();
    collect("", CASE, &mut pointers);
    pointers
}

fn collect(prefix: &str, keys: &[CaseKey], pointers: &mut Vec<String>) {
    for key in keys {
        let pointer = format!("{prefix}/{}", key.name);
        if !matches!(key.kind, KeyType::Items(..)) {
            collect(&pointer, key.keys(), pointers);
        }
        pointers.push(pointer);
    }
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
