//! Numbered warnings, `W1` to `W8`. A code and a name, once given, stay. [`super::checks`] decides which of them a run calls for.

use serde_json::{Value, json};

use super::number::short;
use crate::case::{Case, Field, Motion, Shape};

/// Mean densities a projectile may have [kg/m³]: from light plastics to osmium.
const DENSITY_LIMITS: [f64; 2] = [900.0, 22_600.0];
/// Difference of a given mass from that of the given density, over the latter [-].
const DENSITY_TOLERANCE: f64 = 0.05;
/// Kind of warning, with its words.
#[derive(Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WarningKind {
    /// `W1`, `W2`, …
    pub code: &'static str,
    /// Name of a word or two, for scripts and people.
    pub name: &'static str,
    /// Quantity measured.
    pub measured: &'static str,
    /// Threshold.
    pub given: &'static str,
    /// Consequence for the result.
    pub means: &'static str,
    /// Advice.
    pub help: &'static str,
}

/// All kinds of warnings, in order of their codes.
pub static KINDS: [WarningKind; 8] = [
    WarningKind {
        code: "W1",
        name: "assumed-parameters",
        measured: "Fields of the case without a published value: `sources`, or the default's own source, begins with `assumed`.",
        given: "for one or more",
        means: "The result rests on guesses as far as these fields matter; near the ballistic limit any of them may decide \
                between a stop and a perforation.",
        help: "`ripstop check CASE` marks them with `*`. Measure what matters, give the value and name its origin in `sources`; \
               vary the rest with --set and see how far the answer moves.",
    },
    WarningKind {
        code: "W2",
        name: "energy",
        measured: "Energy that nothing accounts for: what state functions hold and what was dissipated, less what was put in and what the \
                   unit-cell law makes, over the initial energy (`energy_gained`); and the error of the work ledger (`energy_error`), \
                   which sees assembly, contact and failure but not the step.",
        given: "above 1 % gained or lost, or a ledger error above 2 %, which is what practitioners accept",
        means: "Energy was made or lost by the arithmetic. Verdict and velocity are not to be trusted.",
        help: "Lower /solver/courant; on the GPU or in f32, run again with --backend cpu --precision f64. `history.csv` tells when \
               it began. If it stays, it is a defect worth reporting.",
    },
    WarningKind {
        code: "W3",
        name: "hourglass",
        measured: "Largest hourglass energy over the largest internal energy of the fabric (`hourglass_fraction`).",
        given: "above 5 %, which is what practitioners accept",
        means: "The artificial stiffness that holds one-point elements in shape has carried load: the fabric was stiffer than asked for.",
        help: "Refine the mesh (/pack/crossovers_per_element = 1), round a sharp rim (/projectile/edge_radius_mm), or look \
               whether the deformation is finer than an element: wrinkles and folds are not resolved.",
    },
    WarningKind {
        code: "W4",
        name: "penetration",
        measured: "Deepest node inside the projectile (`max_penetration_mm`), and deepest node of whole fabric inside a neighbouring ply \
                   (`max_ply_penetration_mm`).",
        given: "above half the diagonal of an element in the projectile; above the thickness of the thinnest fabric between plies",
        means: "Somewhere fabric was where it cannot be. A few nodes behind torn yarns change little; whole fabric in the projectile \
                means that it slipped between nodes, and the run is too kind to it.",
        help: "Look at `shot.svg`, in a pack at `plies.csv`. Refine the mesh or round the projectile's rim \
               (/projectile/edge_radius_mm). Between plies it comes with fast shots that crumple what they have torn: \
               compare the verdict with that of a slower one.",
    },
    WarningKind {
        code: "W5",
        name: "coarse-mesh",
        measured: "Crossovers along each side of an element (/pack/crossovers_per_element).",
        given: "above 1",
        means: "Yarns fail in bundles, which delays failure: near the ballistic limit a perforation may turn into a stop.",
        help: "Set /pack/crossovers_per_element to 1 for a verdict; keep the coarse mesh for a first look. `ripstop bench CASE` says \
               what it costs and how far it is off.",
    },
    WarningKind {
        code: "W6",
        name: "small-projectile",
        measured: "Diameter of the projectile over the longest element side.",
        given: "below 3; a bar, which meets whole rows of nodes, is never too small",
        means: "Contact is sampled at nodes: the projectile may slip between them, and the result depends on where it hits.",
        help: "Refine the mesh as far as one crossover per element. If that is not enough, move the impact by parts of a cell \
               (/projectile/offset_mm) and take the scatter as the error.",
    },
    WarningKind {
        code: "W7",
        name: "mass",
        measured: "Mass of the projectile over its volume, edges sharp: its mean density. A bar has no mass of its own length.",
        given: "above 22 600 kg/m³, the densest metal; below 900 kg/m³, lighter than plastics; or 5 % from /projectile/density_kg_m3 \
                where the case gives mass and density",
        means: "No solid of this size and material has this mass: a unit, a diameter or a length may be wrong.",
        help: "Look at /projectile: lengths in mm, mass in g. Give density_kg_m3 alone and the mass follows; of a hollow body \
               give mass_g alone.",
    },
    WarningKind {
        code: "W8",
        name: "torn-off",
        measured: "Pieces of yarn that broke at sides of a ply that are held (`failures_at` counts free ones too); of a \
                   perforation, those before the last one at the hit.",
        given: "for more than broke at the hit",
        means: "The fabric tore off its frame, where a wave of tension doubles, before it broke at the hit. From then on it flies with \
                the projectile: a fast shot may be stopped where a slower one passes. In a test fabric slips in its clamps, which is \
                not computed.",
        help: "Take a larger pack (/pack/width_mm, /pack/height_mm), from whose edges the wave comes back later, or free edges, and \
               compare. A ballistic limit from such shots is one of the frame.",
    },
];

/// A warning that a case or a run calls for: the number found and the one it is held against.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Warning {
    /// Kind.
    pub kind: &'static WarningKind,
    /// Message of one line.
    pub message: String,
    /// Value measured; counts and fractions [-], depths [mm].
    pub value: f64,
    /// Limit in the same unit.
    pub limit: f64,
}

impl Warning {
    /// Warning as it stands in `summary.json`.
    pub fn to_json(&self) -> Value {
        json!({
            "code": self.kind.code,
            "name": self.kind.name,
            "message": self.message,
            "value": self.value,
            "limit": self.limit,
        })
    }
}

/// Fields without a published value.
pub fn assumed_fields(case: &Case) -> impl Iterator<Item = &Field> {
    case.fields.iter().filter(|field| field.assumed)
}

/// The warning of a number.
pub(super) fn warning(number: usize, value: f64, limit: f64, message: String) -> Warning {
    Warning { kind: &KINDS[number - 1], message, value, limit }
}

pub(super) fn assumed(case: &Case) -> Option<Warning> {
    let count = assumed_fields(case).count();
    let what = if count == 1 { "1 parameter is".to_owned() } else { format!("{count} parameters are") };
    (count > 0).then(|| warning(1, count as f64, 0.0, format!("{what} assumed, not published")))
}

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
