//! Numbered warnings, `W1` to `W8`. A code and a name, once given, stay. [`super::checks`] decides which of them a run calls for.

use serde::Serialize;

use super::number::short;
use crate::case::{Case, Field, Layer, Motion, Shape};

/// Mean densities a projectile may have [kg/m³]: from light plastics to osmium.
const DENSITY_LIMITS: [f64; 2] = [900.0, 22_600.0];
/// Areal density over that of the yarns, or the reverse, that no coating makes [-].
const AREAL_FACTOR: f64 = 3.0;
/// Difference of a given mass from that of the given density, over the latter [-].
const DENSITY_TOLERANCE: f64 = 0.05;

/// A warning that a case or a run calls for: the number found and the one it is held against.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Warning {
    /// Kind.
    #[serde(flatten)]
    pub kind: &'static WarningKind,
    /// Message of one line.
    pub message: String,
    /// Value measured; counts and fractions [-], depths [mm].
    pub value: f64,
    /// Limit in the same unit.
    pub limit: f64,
}

pub(super) fn warning(number: usize, value: f64, limit: f64, message: String) -> Warning {
    Warning { kind: &KINDS[number - 1], message, value, limit }
}

/// Fields without a published value.
pub fn assumed_fields(case: &Case) -> impl Iterator<Item = &Field> {
    case.fields.iter().filter(|field| field.assumed)
}

pub(super) fn assumed(case: &Case) -> Option<Warning> {
    let count = assumed_fields(case).count();
    let what = if count == 1 { "1 parameter is".to_owned() } else { format!("{count} parameters are") };
    (count > 0).then(|| warning(1, count as f64, 0.0, format!("{what} assumed, not published")))
}

/// Warning of a mass that no solid of this size has.
pub(super) fn mass(case: &Case) -> Option<Warning> {
    let projectile = case.projectile.as_ref()?;
    if matches!(projectile.shape, Shape::Bar { .. }) || projectile.motion == Motion::Prescribed {
        return None;
    }
    let volume = projectile.shape.volume();
    let found = projectile.mass / volume;
    let body = format!("{} g in {} cm³ are {found:.0} kg/m³", short(projectile.mass * 1e3, 3), short(volume * 1e6, 3));
    let [lightest, densest] = DENSITY_LIMITS;
    let (limit, words) = match projectile.density {
        Some(given) if (found / given - 1.0).abs() > DENSITY_TOLERANCE => {
            (given, format!(", not the {given:.0} of /projectile/density_kg_m3"))
        }
        _ if found > densest => (densest, ", more than the densest metal has".to_owned()),
        _ if found < lightest => (lightest, ": hollow, or a slip of a unit".to_owned()),
        _ => return None,
    };
    Some(warning(7, found, limit, body + &words))
}

/// Warning of a fabric that weighs other than its yarns.
pub(super) fn areal_density(case: &Case) -> Option<Warning> {
    let found = |layer: &Layer| [layer.fabric.areal_density, layer.fabric.areal_density_of_yarns()];
    let is_slip = |[given, yarns]: &[f64; 2]| !(yarns / AREAL_FACTOR..=yarns * AREAL_FACTOR).contains(given);
    let [given, yarns] = case.layers().iter().map(found).find(is_slip)?.map(|density| density * 1e3);
    let words = format!("a ply of {} g/m² has yarns of {} g/m²: a slip of a unit", short(given, 3), short(yarns, 3));
    Some(warning(7, given, yarns, words))
}

/// Kind of warning, with its words.
#[derive(Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct WarningKind {
    /// `W1`, `W2`, …
    pub code: &'static str,
    /// Name of a word or two, for scripts and people.
    pub name: &'static str,
    /// Quantity measured.
    #[serde(skip)]
    pub measured: &'static str,
    /// Threshold.
    #[serde(skip)]
    pub given: &'static str,
    /// Consequence for the result.
    #[serde(skip)]
    pub means: &'static str,
    /// Advice.
    #[serde(skip)]
    pub help: &'static str,
}

/// All kinds of warnings, in order of their codes.
pub static KINDS: [WarningKind; 8] = [
    WarningKind {
        code: "W1",
        name: "assumed-parameters",
        measured: "Fields without a published value: `sources`, or the default's own source, begins with `assumed`.",
        given: "for one or more",
        means: "The result rests on guesses; near the ballistic limit any may decide between stop and perforation.",
        help: "`ripstop check CASE` marks them with `*`. Measure what matters; vary the rest with --set.",
    },
    WarningKind {
        code: "W2",
        name: "energy",
        measured: "Energy that nothing accounts for, over the energy exchanged (`energy_gained`), and `energy_error`.",
        given: "above 1 % gained or lost, or a ledger error above 2 %, which is what practitioners accept",
        means: "Energy was made or lost by the arithmetic. Verdict and velocity are not to be trusted.",
        help: "Lower /solver/courant; on the GPU or in f32, run again with --backend cpu --precision f64.",
    },
    WarningKind {
        code: "W3",
        name: "hourglass",
        measured: "Largest hourglass energy over the largest internal energy of the fabric (`hourglass_fraction`).",
        given: "above 5 %, which is what practitioners accept",
        means: "Artificial stiffness of the elements has carried load: the fabric was stiffer than asked for.",
        help: "Refine the mesh (/pack/crossovers_per_element = 1), or round a sharp rim (/projectile/edge_radius_mm).",
    },
    WarningKind {
        code: "W4",
        name: "penetration",
        measured: "Deepest node in the projectile (`max_penetration_mm`) or in a ply (`max_ply_penetration_mm`).",
        given: "above half the diagonal of an element in the projectile; above the thinnest fabric's thickness between plies",
        means: "Fabric was where it cannot be. A few nodes behind torn yarns change little; whole fabric slipped through.",
        help: "Refine the mesh, or round the projectile's rim (/projectile/edge_radius_mm). Compare with a slower shot.",
    },
    WarningKind {
        code: "W5",
        name: "coarse-mesh",
        measured: "Crossovers along each side of an element (/pack/crossovers_per_element).",
        given: "above 1",
        means: "Yarns fail in bundles, which delays failure: near the limit a perforation may turn into a stop.",
        help: "Set /pack/crossovers_per_element to 1 for a verdict. `ripstop bench CASE` says what it costs.",
    },
    WarningKind {
        code: "W6",
        name: "small-projectile",
        measured: "Diameter of the projectile over the longest element side.",
        given: "below 3; a bar, which meets whole rows of nodes, is never too small",
        means: "Contact is sampled at nodes: the projectile may slip between them.",
        help: "Refine the mesh; or move the impact by parts of a cell (/projectile/offset_mm), the scatter is the error.",
    },
    WarningKind {
        code: "W7",
        name: "mass",
        measured: "Mass of the projectile over its volume, edges sharp, but for a bar; of a ply over that of its yarns.",
        given: "above 22 600, below 900 kg/m³; 5 % from /projectile/density_kg_m3, where given too; three times, a third of the yarns",
        means: "No solid of this size and material, no fabric of these yarns has this mass: a unit or a size may be wrong.",
        help: "Look at /projectile: lengths in mm, mass in g; at /fabric: g/m². Of a hollow body give mass_g alone.",
    },
    WarningKind {
        code: "W8",
        name: "torn-off",
        measured: "Yarns that broke first at held sides of a ply, at any time before the projectile was through.",
        given: "for more than had broken at the hit by then",
        means: "The fabric tore off its frame before it broke at the hit: a fast shot may be stopped where a slower one passes.",
        help: "Take a larger pack (/pack/width_mm, /pack/height_mm) or free edges, and compare.",
    },
];
