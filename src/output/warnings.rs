//! Warnings: what makes the numbers of a run less certain than they look. Few, numbered, and each with a threshold.
//!
//! A code and a name, once given, stay. What a code means is in [`KINDS`]; which of them a run calls for is decided here
//! and nowhere else, so that the table on the screen, `summary.json`, `ripstop check` and `ripstop explain` agree.

use serde_json::{Value, json};

use crate::case::{Case, Field, Motion, Shape};
use crate::output::breakage::Breakage;
use crate::output::number::{grouped, short};
use crate::run::Run;

/// What practitioners accept of the energy error, over the initial energy [-].
pub const ENERGY_LIMIT: f64 = 0.02;
/// Energy by state functions that nothing accounts for, over the initial energy, above which a run is to be looked at [-].
pub const GAINED_LIMIT: f64 = 0.01;
/// What practitioners accept of hourglass energy, over the internal energy [-].
pub const HOURGLASS_LIMIT: f64 = 0.05;
/// Depth of a node in the projectile, over the diagonal of the largest element [-]: no place of the fabric is farther from a node,
/// so where its surface runs between them is not known any better.
pub const PENETRATION_LIMIT: f64 = 0.5;
/// Depth of whole fabric in a neighbouring ply, over the thinnest fabric's thickness [-]: beyond it, plies have changed places.
pub const PLY_PENETRATION_LIMIT: f64 = 1.0;
/// Crossovers along the side of an element that resolve the failure of single yarns.
pub const CROSSOVERS_LIMIT: u32 = 1;
/// Least diameter of a projectile over the longest element side [-]: contact is sampled at nodes.
pub const CELLS_LIMIT: f64 = 3.0;

/// Mean densities a projectile may have [kg/m³]: from light plastics to osmium.
pub const DENSITY_LIMITS: [f64; 2] = [900.0, 22_600.0];
/// Difference of a given mass from that of the given density, over the latter [-].
pub const DENSITY_TOLERANCE: f64 = 0.05;

/// One numbered warning: what it says, whenever it is given.
#[derive(Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WarningKind {
    /// `W1`, `W2`, …
    pub code: &'static str,
    /// One word or two, for scripts and people.
    pub name: &'static str,
    /// What is measured.
    pub measured: &'static str,
    /// When it is given.
    pub given: &'static str,
    /// What it says about the result.
    pub means: &'static str,
    /// What to do.
    pub help: &'static str,
}

/// Every warning there is, in order of its code.
pub static KINDS: [WarningKind; 8] = [
    WarningKind {
        code: "W1",
        name: "assumed-parameters",
        measured: "Fields of the case whose value nobody published: `sources`, or the default's own source, begins with `assumed`.",
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

/// A warning that a case or a run calls for.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Warning {
    /// What it says, whenever it is given.
    pub kind: &'static WarningKind,
    /// One line: the number found and the one it is held against.
    pub message: String,
    /// What was measured; counts and fractions [-], depths [mm].
    pub value: f64,
    /// What it is held against, in the same unit.
    pub limit: f64,
}

impl Warning {
    /// As it stands in `summary.json`.
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

/// What can be said before a run, in order of code.
pub fn of_case(case: &Case) -> Vec<Warning> {
    [assumed(case), coarse_mesh(case), small_projectile(case), mass(case)].into_iter().flatten().collect()
}

/// What is to be said after a run, in order of code.
pub fn of_run(case: &Case, run: &Run) -> Vec<Warning> {
    let found = [energy(run), hourglass(run), penetration(case, run), ply_penetration(case, run), torn_off(case, run)];
    let mut all = of_case(case);
    all.extend(found.into_iter().flatten());
    all.sort_by_key(|warning| warning.kind.code);
    all
}

/// The fields nobody published.
pub fn assumed_fields(case: &Case) -> impl Iterator<Item = &Field> {
    case.fields.iter().filter(|field| field.assumed)
}

/// The warning of this number.
fn warning(number: usize, value: f64, limit: f64, message: String) -> Warning {
    Warning { kind: &KINDS[number - 1], message, value, limit }
}

fn assumed(case: &Case) -> Option<Warning> {
    let count = assumed_fields(case).count();
    let what = if count == 1 { "1 parameter is".to_owned() } else { format!("{count} parameters are") };
    (count > 0).then(|| warning(1, count as f64, 0.0, format!("{what} assumed, not published")))
}

fn energy(run: &Run) -> Option<Warning> {
    let gained = fraction(2, "energy that nothing accounts for", run.energy_gained.abs(), GAINED_LIMIT);
    gained.or_else(|| fraction(2, "the energy error", run.energy_error, ENERGY_LIMIT))
}

fn hourglass(run: &Run) -> Option<Warning> {
    fraction(3, "hourglass energy over internal energy", run.hourglass_fraction, HOURGLASS_LIMIT)
}

/// A fraction that is too large, or no number at all.
fn fraction(number: usize, what: &str, value: f64, limit: f64) -> Option<Warning> {
    let [found, accepted] = [value, limit].map(|part| part * 100.0);
    let message = || format!("{what} is {found:.1} %, above the {accepted:.0} % accepted");
    (!within(value, limit)).then(|| warning(number, value, limit, message()))
}

fn penetration(case: &Case, run: &Run) -> Option<Warning> {
    case.projectile.as_ref()?;
    depth(
        "the projectile",
        run.max_penetration,
        PENETRATION_LIMIT * longest_diagonal(case),
        "half an element's diagonal",
    )
}

fn ply_penetration(case: &Case, run: &Run) -> Option<Warning> {
    let thinnest = thinnest(case);
    depth("a neighbouring ply", run.max_ply_penetration, PLY_PENETRATION_LIMIT * thinnest, "the thinnest ply is thick")
}

fn torn_off(case: &Case, run: &Run) -> Option<Warning> {
    let broken = Breakage::of(case, run);
    let [found, limit] = [broken.torn_off, broken.at_hit];
    let message =
        || format!("{} pieces of yarn broke at the edges, {} at the hit", grouped(found as u64), grouped(limit as u64));
    broken.tore_off().then(|| warning(8, found as f64, limit as f64, message()))
}

/// A depth [m] into something against what it may be [m]: so much of what.
fn depth(into: &str, value: f64, limit: f64, of: &str) -> Option<Warning> {
    let [found, allowed] = [value, limit].map(|depth| depth * 1e3);
    let message = || format!("a node got {found:.3} mm into {into}, deeper than {of}, {allowed:.3} mm");
    (!within(found, allowed)).then(|| warning(4, found, allowed, message()))
}

/// Whether a number is one and no larger than it may be.
fn within(value: f64, limit: f64) -> bool {
    value <= limit
}

fn coarse_mesh(case: &Case) -> Option<Warning> {
    let [count, limit] = [case.pack.crossovers_per_element, CROSSOVERS_LIMIT];
    let message = || format!("an element holds {count} × {count} crossovers; more than one delays failure");
    (count > limit).then(|| warning(5, count.into(), limit.into(), message()))
}

fn small_projectile(case: &Case) -> Option<Warning> {
    let cells = cells_across(case)?;
    let message =
        || format!("the projectile is {cells:.1} elements wide; below {CELLS_LIMIT} it may slip between nodes");
    (cells < CELLS_LIMIT).then(|| warning(6, cells, CELLS_LIMIT, message()))
}

fn mass(case: &Case) -> Option<Warning> {
    let projectile = case.projectile.as_ref()?;
    if matches!(projectile.shape, Shape::Bar { .. }) || projectile.motion == Motion::Prescribed {
        return None;
    }
    let volume = projectile.shape.volume();
    let found = projectile.mass / volume;
    let body = format!("{} g in {} cm³ are {found:.0} kg/m³", short(projectile.mass * 1e3, 3), short(volume * 1e6, 3));
    let [lightest, densest] = DENSITY_LIMITS;
    match projectile.density {
        Some(given) if (found / given - 1.0).abs() > DENSITY_TOLERANCE => {
            Some(warning(7, found, given, format!("{body}, not the {given:.0} of /projectile/density_kg_m3")))
        }
        _ if found > densest => Some(warning(7, found, densest, format!("{body}, more than the densest metal has"))),
        _ if found < lightest => Some(warning(7, found, lightest, format!("{body}: hollow, or a slip of a unit"))),
        _ => None,
    }
}

/// Elements that a projectile is wide; of a bar, which meets whole rows of nodes, that says nothing.
pub(crate) fn cells_across(case: &Case) -> Option<f64> {
    let shape = case.projectile.as_ref()?.shape;
    (!matches!(shape, Shape::Bar { .. })).then(|| shape.diameter() / longest_side(case))
}

/// Thickness of the thinnest fabric [m].
pub(crate) fn thinnest(case: &Case) -> f64 {
    case.layers().iter().map(|layer| layer.fabric.thickness).fold(f64::INFINITY, f64::min)
}

/// Longest side of an element of any ply [m].
fn longest_side(case: &Case) -> f64 {
    case.layers().iter().map(|layer| layer.element_length_x.max(layer.element_length_y)).fold(0.0, f64::max)
}

/// Longest diagonal of an element of any ply [m].
pub(crate) fn longest_diagonal(case: &Case) -> f64 {
    case.layers().iter().map(|layer| layer.element_length_x.hypot(layer.element_length_y)).fold(0.0, f64::max)
}
