//! How far the backends may differ, kernel by kernel, and why.

/// Largest relative error of a rounding to single precision [-].
pub(super) const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;
/// Roundings of a card for each of a device that rounds to the nearest: a division may be off by five of them, a root by four, and a
/// product and a sum may be one rounding or two (WGSL, accuracy of expressions).
const CARD: f64 = 5.0;

/// How far a quantity may differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tolerance {
    /// Kernel.
    pub(super) kernel: &'static str,
    /// Quantity.
    pub(super) quantity: &'static str,
    /// Roundings of either backend that add up; 0: no difference is allowed.
    pub(super) roundings: f64,
    /// How much each of them grows on the way to the quantity.
    pub(super) condition: f64,
    /// How many times as much is allowed on a card.
    pub(super) card: f64,
    /// What the difference is measured by.
    pub(super) scale: &'static str,
    /// Which roundings they are, and why they grow.
    pub(super) reason: &'static str,
}

impl Tolerance {
    /// Allowed difference over the scale [-]. `hardware`: whether the device is a card; software rounds every operation to the nearest.
    pub(super) fn limit(&self, hardware: bool) -> f64 {
        self.roundings * self.condition * ROUNDING * if hardware { self.card } else { 1.0 }
    }

    /// The same with more on a card than its operations explain: measured, for a solver that ends elsewhere.
    const fn on_card(self, card: f64) -> Self {
        Self { card, ..self }
    }
}

const fn allow(
    [kernel, quantity]: [&'static str; 2],
    [roundings, condition]: [f64; 2],
    scale: &'static str,
    reason: &'static str,
) -> Tolerance {
    Tolerance { kernel, quantity, roundings, condition, card: CARD, scale, reason }
}

const fn exact(names: [&'static str; 2], reason: &'static str) -> Tolerance {
    allow(names, [0.0, 1.0], "one", reason)
}

/// A strain is the small difference of a stretch and one: its roundings are those of one, over the strain that breaks a yarn.
const STRAIN: f64 = 1.0 / 0.035;

const BREAKING_FORCE: &str = "force of an element that is about to break, and its own";
const BREAKING_ENERGY: &str = "energy of an element that is about to break, and its own";
const BREAKING_IMPULSE: &str = "impulse that breaks an element in a step, and its own";
const STRAIN_SCALE: &str = "failure strain, and its own";
const LENGTH: &str = "largest displacement, an element's length at least";
const CLOSING: &str = "velocity that closes a gap of the largest displacement in a step, and the largest speed; of a whole run also of a third of the depth of the pack and of the radius of a rim by a slope";
const CLOSED: &str = "way of such a velocity in a step";
const PUSHED: &str = "impulse of a node at that velocity over the body's mass, and the body's speed";
const CELL: &str = "an element's length, or the way of such a velocity in a step";
const IMPULSE: &str = "impulse of a node at that velocity, and its own";
const SPIN: &str = "angular momentum of such an impulse at the body's reach, and its own";
const CONTACT_ENERGY: &str = "energy of such an impulse at the largest speed, and its own";
const KINETIC: &str = "kinetic energy, and that of such an impulse at the largest speed";

const SAME_REACH: &str = "the same nodes may have moved";
const GAP: &str =
    "a gap: positions of node and body, 2 roundings each, over and along the normal, 4 each with a division; closed";
const FIXED_POINT: &str =
    "counted in 6e-11 m, up to 3 roundings of an element's length, before and after; and the velocity's";
const QUATERNION: &str = "a product of quaternions, made one long: 3 roundings";
const BODY: &str = "sums of impulses as below, of either sign, that are rounded once";
const DEPTH: &str = "a gap as above, read off the deepest node";

/// The table, in the order of a step.
pub(super) const TOLERANCES: [Tolerance; 48] = [
    exact(["element_force", "yarn alive"], "the same yarns fail"),
    exact(["element_force", "failures"], "the same events are reported"),
    allow(
        ["element_force", "membrane force"],
        [2.0, STRAIN],
        BREAKING_FORCE,
        "a stretch is the root of squares over the length at rest: one rounding of the root, one of the quotient",
    ),
    allow(
        ["element_force", "hourglass force"],
        [8.0, 1.0],
        BREAKING_FORCE,
        "a sum of four displacements, by a stiffness",
    ),
    allow(
        ["element_force", "viscous force"],
        [8.0, 1.0],
        "force that breaks an element",
        "a sum of four velocities, by a length",
    ),
    allow(
        ["element_force", "yarn height"],
        [16.0, 1.0],
        "half a span of a yarn",
        "the misfit of compatibility at which the solver of the unit cell ends: 4 roundings on either backend, up to twice as much in a height; \
        where yarns hardly touch a card ends elsewhere",
    )
    .on_card(200.0),
    allow(
        ["element_force", "predicted height"],
        [8.0, STRAIN],
        "half a span of a yarn, or one",
        "a height as above, over a difference of strains",
    )
    .on_card(30.0),
    allow(
        ["element_force", "strain"],
        [0.5, STRAIN],
        STRAIN_SCALE,
        "half of the roundings of a stretch: the other is common",
    ),
    allow(["element_force", "failure strain"], [0.5, STRAIN], STRAIN_SCALE, "a strain as above"),
    allow(
        ["element_force", "residual"],
        [11.0, 1.0],
        "force of an element that is about to break",
        "what is left is rounding",
    ),
    allow(
        ["element_force", "evaluations"],
        [1.0, 3e4],
        "their number",
        "a solve ends at a misfit of a few roundings: in one of 500 a rounding costs or spares a step of Newton's",
    )
    .on_card(100.0),
    allow(
        ["node_update", "displacement"],
        [3.0, 1.0],
        LENGTH,
        "velocity by step, added: 2 roundings, and those of the velocity",
    ),
    allow(
        ["node_update", "velocity"],
        [8.0, 1.0],
        "largest speed",
        "forces of four elements, by step and mass, added: 8 roundings",
    ),
    allow(
        ["node_update", "support"],
        [16.0, 1.0],
        BREAKING_IMPULSE,
        "a sum of forces in another order, over two steps",
    ),
    exact(["ply_contact", "contacts"], "the same nodes touch the same plies"),
    exact(["ply_contact", "cells"], "the same cells are found, or where cells share an edge one beside them"),
    exact(["ply_contact", "reach"], SAME_REACH),
    allow(
        ["ply_contact", "displacement"],
        [16.0, 1.0],
        LENGTH,
        "a gap as of the projectile: positions of a node and four corners, over and along a normal, closed in counts",
    ),
    allow(["ply_contact", "velocity"], [12.0, 1.0], CLOSING, "as the displacement"),
    allow(["ply_contact", "penetration"], [4.0, 1.0], LENGTH, "a gap of a node and four corners"),
    allow(
        ["ply_contact", "energy"],
        [6.0, 19.0],
        "energy of a node at the largest speed, and its own",
        "differences of squares of velocities as above, of all nodes: of energies that are larger",
    ),
    allow(
        ["ply_contact", "support"],
        [6.0, 11.0],
        "momentum of a node at the largest speed, and its own",
        "differences of velocities as above, of held nodes",
    ),
    exact(["projectile_contact", "reach"], SAME_REACH),
    allow(["projectile_contact", "displacement"], [24.0, 1.0], CLOSED, GAP),
    allow(["projectile_contact", "velocity"], [12.0, 1.0], CLOSING, GAP),
    allow(["projectile_contact", "body velocity"], [13.0, 1.0], PUSHED, BODY),
    allow(["projectile_contact", "body position"], [13.0, 1.0], CELL, FIXED_POINT),
    allow(["projectile_contact", "body orientation"], [3.0, 1.0], "one", QUATERNION),
    allow(["projectile_contact", "angular momentum"], [6.0, 1.0], SPIN, BODY),
    allow(["projectile_contact", "impulse"], [16.0, 1.0], IMPULSE, GAP),
    allow(["projectile_contact", "energy"], [17.0, 2.0], CONTACT_ENERGY, GAP),
    allow(["projectile_contact", "penetration"], [16.0, 1.0], LENGTH, DEPTH),
    exact(["step", "counters"], "counts"),
    exact(["step", "cleared"], "marks and sums that begin anew"),
    exact(["step", "untouched"], "what nothing has reached keeps every bit"),
    exact(["ledger", "covered"], "yes or no"),
    allow(["ledger", "work"], [12.0, 1.0], BREAKING_ENERGY, "forces by displacements: 8 roundings, and 4 of the sum"),
    allow(
        ["ledger", "released energy"],
        [8.0, 1.0],
        BREAKING_ENERGY,
        "squares of strains: 8 roundings; few yarns break in a step",
    ),
    allow(
        ["ledger", "stored energy"],
        [12.0, 1.0],
        BREAKING_ENERGY,
        "squares of strains: 8 roundings, and 4 of the sum; on a card with heights as above",
    )
    .on_card(10.0),
    allow(["ledger", "law energy"], [12.0, 1.0], BREAKING_ENERGY, "squares of strains: 8 roundings, and 4 of the sum"),
    allow(
        ["ledger", "tension"],
        [8.0, 1.0],
        BREAKING_FORCE,
        "a force, read off the tautest yarn: of a stretch with three squares and that of the hourglass mode",
    ),
    allow(["ledger", "load"], [8.0, 1.0], "one, and its own", "a strain over a failure strain"),
    allow(["ledger", "deflection"], [3.0, 1.0], LENGTH, "a displacement"),
    allow(["ledger", "support"], [25.0, 1.0], BREAKING_IMPULSE, "impulses of two steps, and 9 of the sum"),
    allow(["ledger", "kinetic energy"], [16.0, 1.0], KINETIC, "squares of velocities, and 4 of the sum"),
    allow(["ledger", "kinetic energy now"], [16.0, 1.0], KINETIC, "squares of velocities, and 4 of the sum"),
    allow(
        ["ledger", "largest square of speed"],
        [16.0, 2.7],
        "its own",
        "the square of a velocity, which may be the difference of larger ones",
    ),
    allow(
        ["ledger", "momentum"],
        [16.0, 10.0],
        "sum of all m|v|",
        "velocities, that contact may have rounded ten times as much, and 8 of the sum",
    ),
];

/// The line of the table for a quantity of a kernel.
///
/// # Panics
/// For names that are in no line.
pub(super) fn line(kernel: &str, quantity: &str) -> usize {
    let found = TOLERANCES.iter().position(|line| line.kernel == kernel && line.quantity == quantity);
    found.unwrap_or_else(|| unreachable!("{quantity} of {kernel} is in no table"))
}
