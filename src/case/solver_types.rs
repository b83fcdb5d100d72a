//! Numerical choices.

/// The scheme that keys left out of a case take their values from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Numerics {
    /// Shock viscosity, contact at the rim, a mesh that is fine around the hit.
    Default,
    /// The paper's own: one even element per crossover, contact at nodes, stretches at the centre, no viscosity.
    Paper,
}

/// How far the mesh around the hit is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Accuracy {
    /// The cheapest mesh whose ballistic limit is near the converged one.
    Default,
    /// The mesh from which on the limit stays.
    Converged,
}

/// Time integration.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
    /// Where an element's stretches are taken.
    pub stretch_sampling: StretchSampling,
    /// When the run ends.
    pub run_until: RunUntil,
}

/// Where the lines of nodes of a graded mesh are counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinesFrom {
    /// Two lines cross where the projectile hits, so that the mesh around a hit does not depend on its place in the weave.
    Hit,
    /// Lines lie whole finest elements from the edges of the ply.
    Edges,
}

/// Whether mirror symmetry may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Symmetry {
    /// Where the scene has it.
    Auto,
    /// Never.
    None,
}

/// Where contact with the projectile is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ContactSampling {
    /// At nodes.
    Nodes,
    /// At nodes, and where the rim of a flat face crosses the edges of elements.
    Edges,
}

/// Where an element's stretches are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StretchSampling {
    /// At its centre.
    Centre,
    /// Over the element: the root of the mean of their squares.
    Mean,
}

/// When the run ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RunUntil {
    /// As soon as the outcome is known (or at `end_time`).
    Outcome,
    /// As soon as the projectile is through, or flies back free of the fabric (or at `end_time`).
    Separation,
    /// At `end_time`, whatever happened before.
    EndTime,
}
