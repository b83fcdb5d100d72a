//! Kernels: WGSL sources, bindings, and the constants that compile out what a scene lacks.

use super::buffers::{BufferId, Sizes};
use crate::case::Law;
use crate::model::Features;

/// Use of a buffer by a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Read only.
    Read,
    /// Read and written.
    Write,
}

/// Stage of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `sweep`
    Sweep,
    /// `ply_search`, `ply_impulse`, `ply_move`
    Plies,
    /// In packs `projectile_search`; `projectile_contact`, with the motion of the body.
    Projectile,
    /// `yarn_load` and `energy_balance`, in steps with a sample alone.
    EnergyBalance,
}

impl Stage {
    /// A whole step.
    pub const ALL: [Self; 4] = [Self::Sweep, Self::Plies, Self::Projectile, Self::EnergyBalance];

    /// Key in `summary.json`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sweep => "sweep",
            Self::Plies => "ply_contact",
            Self::Projectile => "projectile_contact",
            Self::EnergyBalance => "energy_balance",
        }
    }
}

/// What a kernel has an invocation or a workgroup for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// A workgroup for every tile, by ply types.
    Tiles,
    /// An invocation for every element, by ply types.
    Elements,
    /// An invocation for every node.
    Nodes,
    /// A workgroup for every ply of a pack.
    Plies,
    /// One workgroup.
    Shot,
    /// The workgroups of the energy balance.
    Balance,
}

/// One compute kernel.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// Name of the file and of the entry point. The file says where its twin is.
    pub name: &'static str,
    /// Stage of a step that it belongs to.
    pub stage: Stage,
    /// What it runs over.
    pub extent: Extent,
    /// The kernel, then what it shares with others: line numbers of the kernel stay right.
    pub sources: &'static [&'static str],
    /// Overridable constants that it is compiled for: those that its code reads, of `GRADED`, `FRAME` and `BACKING` only those that are worth it.
    /// Scenes that agree in them share the compiled kernel.
    pub constants: &'static [&'static str],
    /// Bindings of group 1 in order; group 0 is the scene, the step, the plies and the shots.
    pub bindings: &'static [(BufferId, Access)],
}

/// Kernels: stage, name, extent, sources besides the kernel's own, constants, and bindings. Every source ends with the pack, its grid lines,
/// the scene and numbers.
macro_rules! kernels {
    ($($stage:ident $name:literal $extent:ident [$($source:literal),+] ($($constant:ident)+) {$($id:ident $access:ident),+};)+) => {
        [$(Kernel {
            name: $name,
            stage: Stage::$stage,
            extent: Extent::$extent,
            sources: &[
                include_str!(concat!("../../shaders/", $name, ".wgsl")),
                $(include_str!(concat!("../../shaders/", $source, ".wgsl")),)+
                include_str!("../../shaders/pack.wgsl"),
                include_str!("../../shaders/grid_lines.wgsl"),
                include_str!("../../shaders/scene.wgsl"),
                include_str!("../../shaders/scalar.wgsl"),
            ],
            constants: &[$(stringify!($constant)),+],
            bindings: &[$((BufferId::$id, Access::$access)),+],
        }),+]
    };
}

/// Every kernel, in the order of a step.
pub const KERNELS: [Kernel; 8] = kernels! {
    // Forces of the elements, and motion of the nodes.
    Sweep "sweep" Tiles
        ["element_force", "node_update", "kinematics", "membrane", "viscous_force", "failure", "crossover", "coupled_newton",
         "yarn_law", "cells", "sums", "supports", "projectile_shape", "rigid_body"]
        (VARIATIONAL PIVOT TERMS COMPRESSION CURVE SHEAR VISCOUS RATE STRENGTH EDGES GRADED FRAME BACKING TILE_ROWS)
        {Nodes Write, Cells Write, Tiles Write, Status Write, Events Write, Supports Write, Body Read,
         Candidates Write};
    // Contacts between plies, and their number at each node.
    Plies "ply_search" Nodes
        ["ply_contact", "cells"]
        (GRADED)
        {Nodes Read, Cells Read, Over Write, Contacts Write, Shares Write, Status Write};
    // Impulses of the contacts between plies.
    Plies "ply_impulse" Nodes
        ["ply_contact"]
        (GRADED FRAME)
        {Nodes Read, Over Read, Contacts Read, Shares Read, Impulses Write, ContactWork Write, Status Write};
    // Impulses of contact between plies, applied to the nodes.
    Plies "ply_move" Nodes
        ["ply_contact", "kinematics", "cells", "supports"]
        (VISCOUS GRADED FRAME BACKING)
        {Nodes Write, Cells Read, Shares Write, Impulses Write, ContactWork Write, Supports Write, Status Write};
    // Where the projectile may touch the plies of a pack.
    Projectile "projectile_search" Plies
        ["projectile_points", "projectile_touches", "edge_contact", "projectile_motion", "broad_phase", "cells",
         "projectile_shape", "rigid_body"]
        (EDGES WIDTH)
        {Nodes Read, Cells Read, Status Write, Body Read, Candidates Write, Points Write, Over Read, Touches Write,
         Members Write, Matrix Write};
    // Contact of the projectile where it may touch, and its motion.
    Projectile "projectile_contact" Shot
        ["projectile_points", "projectile_touches", "edge_contact", "projectile_motion", "broad_phase", "cells",
         "projectile_shape", "rigid_body"]
        (EDGES PACK WIDTH)
        {Nodes Write, Cells Read, Status Write, Body Write, Candidates Write, Points Write, Over Read, Touches Write,
         Members Write, Matrix Write};
    // Tensions and loads of yarns.
    EnergyBalance "yarn_load" Elements
        ["failure", "yarn_law", "cells", "sums"]
        (CURVE STRENGTH TILE_ROWS)
        {Nodes Read, Cells Read, Tiles Write, Status Write};
    // Sums of energy, momentum and counts.
    EnergyBalance "energy_balance" Balance
        ["cells", "sums", "projectile_shape", "rigid_body"]
        (TILE_ROWS)
        {Nodes Write, Cells Read, Tiles Write, ContactWork Write, Supports Write, Body Write, Status Write,
         Samples Write};
};

impl Kernel {
    /// The whole source.
    pub fn source(&self) -> String {
        self.sources.concat()
    }

    /// Whether steps of a scene with these features run it.
    pub fn is_in(&self, features: &Features) -> bool {
        match self.stage {
            Stage::Plies => features.plies,
            Stage::Projectile => features.projectile && (features.plies || self.extent != Extent::Plies),
            _ => true,
        }
    }
}

/// Values of the pipeline-overridable constants of a kernel, by name.
pub fn constants(kernel: &Kernel, features: &Features, sizes: &Sizes) -> [(&'static str, f64); 16] {
    let flag = |yes: bool| f64::from(u8::from(yes));
    [
        ("VARIATIONAL", flag(features.law == Law::Variational)),
        ("PIVOT", features.pivot as f64),
        ("TERMS", features.series as f64),
        ("COMPRESSION", flag(features.compression)),
        ("CURVE", features.curve as f64),
        ("SHEAR", flag(features.shear)),
        ("VISCOUS", flag(features.viscous)),
        ("RATE", flag(features.rate)),
        ("STRENGTH", flag(features.strength)),
        ("EDGES", flag(features.edges)),
        ("GRADED", flag(features.graded)),
        ("FRAME", flag(features.frame)),
        ("BACKING", flag(features.backing)),
        ("PACK", flag(features.plies)),
        ("WIDTH", f64::from(sizes.contact_groups[usize::from(kernel.extent == Extent::Plies)])),
        ("TILE_ROWS", f64::from(sizes.tile_rows)),
    ]
}
