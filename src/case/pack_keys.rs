//! The keys of `pack`.

use super::fabric_keys::FABRIC;
use super::fields::{CaseKey, KeyType, key, number, within, word};
use super::units::{DEG, M_S, MM, N_M, NONE};
use super::words::Word;
use super::{Edge, LinesFrom};

/// Plies of a pack at most.
pub(super) const MAX_PLIES: u32 = 64;
/// Where the mesh comes from.
const MESH: &str = "numerics and accuracy: around a projectile's hit four elements per crossover (under a point six; converged: eight), \
    graded beyond; where a bar strikes two (eight), even; one even element for the paper's numerics, no projectile, or several \
    crossovers per element";

pub(super) static PACK: &[CaseKey] = &[
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
        crossovers_per_element. The way of a point that strikes obliquely goes on while it pushes the ply in, by an eighth of \
        the smaller side, at most that far.",
    )
    .derived("two radii of the projectile, and as far as a yawed tail swings out"),
    number("growth_ratio", NONE, within(1.0, 2.0), "Largest ratio of the lengths of neighbouring elements.")
        .default(1.2, "measured: smaller ones keep the outcome no better"),
    key("max_crossovers", KeyType::Whole(1, 64), "Crossovers along a side of the largest elements.")
        .default(6.0, "measured: smaller ones keep the outcome no better"),
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
