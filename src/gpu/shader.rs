//! Kernels: WGSL sources, bindings, and the constants that compile out what a scene lacks.

use super::buffers::BufferId;
use crate::case::Law;
use crate::model::features::Features;

/// Use of a buffer by a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read only.
    Read,
    /// Read and written.
    Write,
}

use Access::{Read, Write};

/// Stage of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `element_force`
    Elements,
    /// `node_update`
    Nodes,
    /// `ply_search`, `ply_impulse`, `ply_move`
    Plies,
    /// `projectile_points`, and `projectile_contact` with the motion of the body.
    Projectile,
    /// `energy_balance`, of steps with a sample.
    EnergyBalance,
}

impl Stage {
    /// A whole step.
    pub const ALL: [Self; 5] = [Self::Elements, Self::Nodes, Self::Plies, Self::Projectile, Self::EnergyBalance];

    /// Key in `summary.json`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Elements => "element_force",
            Self::Nodes => "node_update",
            Self::Plies => "ply_contact",
            Self::Projectile => "projectile_contact",
            Self::EnergyBalance => "energy_balance",
        }
    }
}

/// One compute kernel.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name of the file and of the entry point. The file says where its twin is.
    pub name: &'static str,
    /// Stage of a step that it belongs to.
    pub stage: Stage,
    /// The kernel, then what it shares with others: line numbers of the kernel stay right.
    pub sources: &'static [&'static str],
    /// Bindings of group 1 in order; group 0 is the scene, the step, the plies, their grid lines and the shots.
    pub bindings: &'static [(BufferId, Access)],
}

/// A kernel's own sources; every one ends with the pack, its grid lines, the shot, the scene and numbers.
macro_rules! sources {
    ($($name:literal),+ $(,)?) => {
        &[
            $(include_str!(concat!("../../shaders/", $name, ".wgsl")),)+
            include_str!("../../shaders/pack.wgsl"),
            include_str!("../../shaders/grid_lines.wgsl"),
            include_str!("../../shaders/shot.wgsl"),
            include_str!("../../shaders/scene.wgsl"),
            include_str!("../../shaders/scalar.wgsl"),
        ]
    };
}

/// Extensions, unit cells, shear, failure and forces of the elements.
const ELEMENT_FORCE: Kernel = Kernel {
    name: "element_force",
    stage: Stage::Elements,
    sources: sources!(
        "element_force",
        "element_geometry",
        "kinematics",
        "membrane",
        "failure",
        "law_energy",
        "crossover",
        "coupled_newton",
        "yarn_law",
        "arc_length",
        "shear",
        "active_region"
    ),
    bindings: &[
        (BufferId::Nodes, Read),
        (BufferId::Forces, Write),
        (BufferId::Heights, Write),
        (BufferId::Flags, Write),
        (BufferId::Accounts, Write),
        (BufferId::Status, Write),
        (BufferId::Events, Write),
        (BufferId::Yarns, Write),
    ],
};

/// Gather, kick and drift of the nodes.
const NODE_UPDATE: Kernel = Kernel {
    name: "node_update",
    stage: Stage::Nodes,
    sources: sources!("node_update", "gather", "supports", "projectile_shape", "rigid_body", "active_region"),
    bindings: &[
        (BufferId::Nodes, Write),
        (BufferId::Forces, Read),
        (BufferId::Supports, Write),
        (BufferId::Status, Write),
        (BufferId::Body, Read),
        (BufferId::Candidates, Write),
    ],
};

/// Places where the projectile may touch.
const PROJECTILE_POINTS: Kernel = Kernel {
    name: "projectile_points",
    stage: Stage::Projectile,
    sources: sources!(
        "projectile_points",
        "projectile_motion",
        "contact_candidates",
        "intact",
        "projectile_shape",
        "rigid_body",
        "active_region"
    ),
    bindings: &[
        (BufferId::Nodes, Read),
        (BufferId::Flags, Read),
        (BufferId::Status, Write),
        (BufferId::Body, Write),
        (BufferId::Candidates, Write),
        (BufferId::Points, Write),
        (BufferId::Over, Read),
        (BufferId::Touches, Write),
    ],
};

/// Contact at those places, and motion of the projectile.
const PROJECTILE_CONTACT: Kernel = Kernel {
    name: "projectile_contact",
    stage: Stage::Projectile,
    sources: sources!(
        "projectile_contact",
        "edge_contact",
        "projectile_motion",
        "gather",
        "rigid_body",
        "active_region"
    ),
    bindings: &[
        (BufferId::Nodes, Write),
        (BufferId::Forces, Read),
        (BufferId::Status, Write),
        (BufferId::Body, Write),
        (BufferId::Points, Write),
        (BufferId::Touches, Write),
        (BufferId::Members, Write),
        (BufferId::Matrix, Write),
    ],
};

/// Contacts between plies, and their number at each node.
const PLY_SEARCH: Kernel = Kernel {
    name: "ply_search",
    stage: Stage::Plies,
    sources: sources!("ply_search", "ply_contact", "ply_view", "intact", "active_region"),
    bindings: &[
        (BufferId::Nodes, Read),
        (BufferId::Flags, Read),
        (BufferId::Over, Write),
        (BufferId::Contacts, Write),
        (BufferId::Shares, Write),
        (BufferId::Status, Write),
    ],
};

/// Impulses of the contacts between plies.
const PLY_IMPULSE: Kernel = Kernel {
    name: "ply_impulse",
    stage: Stage::Plies,
    sources: sources!("ply_impulse", "ply_contact", "ply_view"),
    bindings: &[
        (BufferId::Nodes, Read),
        (BufferId::Over, Read),
        (BufferId::Contacts, Read),
        (BufferId::Shares, Read),
        (BufferId::Impulses, Write),
        (BufferId::Accounts, Write),
        (BufferId::Status, Write),
    ],
};

/// Impulses of contact between plies, applied to the nodes.
const PLY_MOVE: Kernel = Kernel {
    name: "ply_move",
    stage: Stage::Plies,
    sources: sources!("ply_move", "ply_view", "gather", "element_geometry", "supports", "active_region"),
    bindings: &[
        (BufferId::Nodes, Write),
        (BufferId::Forces, Read),
        (BufferId::Shares, Write),
        (BufferId::Impulses, Write),
        (BufferId::Accounts, Write),
        (BufferId::Supports, Write),
        (BufferId::Status, Write),
        (BufferId::Yarns, Read),
    ],
};

/// Sums of energy, momentum and counts.
const ENERGY_BALANCE: Kernel = Kernel {
    name: "energy_balance",
    stage: Stage::EnergyBalance,
    sources: sources!("energy_balance", "gather", "projectile_shape", "rigid_body"),
    bindings: &[
        (BufferId::Nodes, Read),
        (BufferId::Forces, Read),
        (BufferId::Flags, Write),
        (BufferId::Accounts, Write),
        (BufferId::Supports, Write),
        (BufferId::Body, Write),
        (BufferId::Status, Write),
        (BufferId::Samples, Write),
    ],
};

/// Every kernel, in the order of a step.
pub const KERNELS: [Kernel; 8] = [
    ELEMENT_FORCE,
    NODE_UPDATE,
    PLY_SEARCH,
    PLY_IMPULSE,
    PLY_MOVE,
    PROJECTILE_POINTS,
    PROJECTILE_CONTACT,
    ENERGY_BALANCE,
];

impl Kernel {
    /// The whole source.
    pub fn source(&self) -> String {
        self.sources.concat()
    }

    /// Whether steps of a scene with these features run it.
    pub fn is_in(&self, features: &Features) -> bool {
        match self.stage {
            Stage::Plies => features.plies,
            Stage::Projectile => features.projectile,
            _ => true,
        }
    }
}

/// Rounding of relative velocities in single precision, over the largest speed of the body [-]; in double precision
/// [`projectile_contact::NOISE`](crate::solver::projectile_contact::NOISE).
const NOISE: f64 = 1e-6;
/// Part of a finest cell by which a yarn may run on too short [-]: what a sum of widths rounds to in single precision.
const WITHIN: f64 = 1e-3;
/// Counts that make a whole share of a node's mass. The processor shares masses out in real numbers.
const SHARE_UNIT: u32 = 1 << 20;

/// Values of the pipeline-overridable constants, by name. `ledger`: the step fills in the energies of the state.
pub fn constants(terms: &Features, ledger: bool) -> [(&'static str, f64); 20] {
    let flag = |yes: bool| f64::from(u8::from(yes));
    [
        ("ROUNDOFF_TOLERANCE", NOISE),
        ("WITHIN", WITHIN),
        ("SHARE_UNIT", f64::from(SHARE_UNIT)),
        ("VARIATIONAL", flag(terms.law == Law::Variational)),
        ("PIVOT", terms.pivot as f64),
        ("TERMS", terms.series as f64),
        ("COMPRESSION", flag(terms.compression)),
        ("SHEAR", flag(terms.shear)),
        ("HOURGLASS", flag(terms.hourglass || terms.mean_stretch)),
        ("VISCOUS", flag(terms.viscous)),
        ("STRENGTH", flag(terms.strength)),
        ("LAW_ENERGY", flag(terms.law_energy)),
        ("PROJECTILE", flag(terms.projectile)),
        ("FRICTION", flag(terms.friction)),
        ("EDGES", flag(terms.edges)),
        ("ROTATION", flag(terms.rotation)),
        ("SAMPLED", flag(ledger)),
        ("PLIES", flag(terms.plies)),
        ("PLY_FRICTION", flag(terms.ply_friction)),
        ("GRADED", flag(terms.graded)),
    ]
}
