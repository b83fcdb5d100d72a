//! How far the backends may differ, kernel by kernel, and why.

/// How far a buffer may differ, relative to its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Kernel.
    pub kernel: &'static str,
    /// Quantity.
    pub buffer: &'static str,
    /// Allowed difference over the scale [-].
    pub tolerance: f64,
    /// What the scale is, and why so much.
    pub reason: &'static str,
}

const fn allow(kernel: &'static str, buffer: &'static str, tolerance: f64, reason: &'static str) -> Tolerance {
    Tolerance { kernel, buffer, tolerance, reason }
}

/// The tolerance table, in the order of a step.
pub const TOLERANCES: [Tolerance; 25] = [
    allow(
        "element_force",
        "membrane force",
        1e-5,
        "of the breaking force: strain rounds at 1e-7 of 1, failure is at 0.01 to 0.1",
    ),
    allow("element_force", "hourglass force", 1e-5, "of the breaking force, as above"),
    allow("element_force", "yarn height", 2e-2, "of the sum of heights: not unique where nothing presses"),
    allow("element_force", "yarn alive", 0.0, "the same yarns fail"),
    allow("element_force", "viscous force", 1e-5, "of the breaking force: velocities round at 1e-7 of the largest"),
    allow("node_update", "displacement", 1e-6, "of the largest: a few roundings"),
    allow("node_update", "velocity", 1e-6, "of the largest: a few roundings"),
    allow("ply_contact", "displacement", 2e-6, "of the largest: places in the pack round to 1e-8 m"),
    allow(
        "ply_contact",
        "velocity",
        5e-5,
        "of the largest, or a hundredth of displacement over time step: a gap that is closed rounds like a displacement",
    ),
    allow("projectile_contact", "displacement", 2e-6, "of the largest: a 6 × 6 solve in single precision"),
    allow(
        "projectile_contact",
        "velocity",
        5e-5,
        "of the largest, or a hundredth of displacement over time step: a gap that is closed rounds like a displacement",
    ),
    allow("projectile_contact", "body velocity", 1e-6, "of the impact velocity"),
    allow("projectile_contact", "body position", 1e-6, "of an element length: fixed point at 6e-11 m"),
    allow("projectile_contact", "body orientation", 1e-6, "of 1"),
    allow("projectile_contact", "angular momentum", 1e-6, "of mass × impact velocity × reach"),
    allow("projectile_rim", "displacement", 2e-6, "of the largest: solves of tens of points in single precision"),
    allow(
        "projectile_rim",
        "velocity",
        5e-5,
        "of the largest, or a hundredth of displacement over time step: a gap that is closed rounds like a displacement",
    ),
    allow("projectile_rim", "body velocity", 1e-6, "of the impact velocity"),
    allow("projectile_rim", "body position", 1e-6, "of an element length: fixed point at 6e-11 m"),
    allow("projectile_rim", "body orientation", 1e-6, "of 1"),
    allow("projectile_rim", "angular momentum", 1e-6, "of mass × impact velocity × reach"),
    allow("ledger", "kinetic energy", 1e-5, "of the energy there is: sums of single-precision numbers"),
    allow("ledger", "momentum", 1e-5, "of mass × velocity, as above"),
    allow("ledger", "stored energy", 1e-5, "of the energy there is, as above"),
    allow("ledger", "work", 1e-5, "of the energy there is, as above"),
];

/// The line of the table for a quantity of a kernel.
pub(super) fn line(kernel: &str, buffer: &str) -> usize {
    let found = TOLERANCES.iter().position(|line| line.kernel == kernel && line.buffer == buffer);
    found.unwrap_or_else(|| unreachable!("{buffer} of {kernel} is in no table"))
}
