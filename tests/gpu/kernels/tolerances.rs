//! How far the two backends may be apart, in one table, and what was seen.

use std::collections::BTreeMap;

use ripstop::kernels::projectile_contact::HELD;

use crate::gpu::harness::Outcome;

/// Set to 1 to see the differences of every comparison, which then fails.
const SHOW: &str = "RIPSTOP_SHOW_DIFFERENCES";

/// What may differ, and by how much of its scale.
pub(crate) struct Tolerance {
    pub(crate) quantity: &'static str,
    pub(crate) limit: f64,
    /// What it is measured in, and why it is not zero.
    pub(crate) reason: &'static str,
}

const fn row(quantity: &'static str, limit: f64, reason: &'static str) -> Tolerance {
    Tolerance { quantity, limit, reason }
}

/// The table. Limits are about four times what was seen in any scene.
pub(crate) const TOLERANCES: [Tolerance; 51] = [
    row("alive", 0.0, "the same yarns must break"),
    row("failures", 0.0, "the same events must be reported"),
    row("counters", 0.0, "counts"),
    row("cleared", 0.0, "marks and sums that begin anew"),
    row("covered", 0.0, "yes or no"),
    row("contacts", 0.0, "the same nodes must touch the same plies"),
    row("over", 0.0, "the same cells must be found"),
    row("reach", 0.0, "the same nodes may have moved"),
    row("untouched", 0.0, "what nothing has reached keeps every bit"),
    row("force", 5e-6, "of the breaking force of an element and its own: the last Newton step"),
    row("hourglass", 1e-6, "of the breaking force of an element and its own"),
    row("height", 1e-6, "of the sum of heights: the misfit of compatibility accepted"),
    row("guide", 4e-5, "of the sum of heights by the failure strain; of one"),
    row("viscous force", 1e-6, "of the breaking force: velocities are those of the scene, so a few roundings"),
    row("law energy", 1.5e-6, "of the breaking energy of an element and itself"),
    row("load", 1e-6, "of one: strain over failure strain"),
    row("strain", 1e-6, "of the failure strain and itself"),
    row("failure strain", 1e-6, "of the failure strain and itself"),
    row("residual", 1e-6, "of the breaking force: both are roundings"),
    row("evaluations", 4e-3, "of their number: a rounding may cost or spare a Newton step"),
    row("work", 1.5e-6, "of the breaking energy of an element and itself"),
    row("released", 1e-6, "of the breaking energy of an element and itself"),
    row("stored", 1.5e-6, "of the breaking energy of an element and itself"),
    row("tension", 5e-7, "of the breaking force of an element and itself"),
    row("deflection", 5e-7, "of an element length"),
    row("displacement", 5e-7, "of an element length"),
    row("velocity", 5e-7, "of the largest speed"),
    row("support", 4e-6, "of the impulse that breaks an element in a step and itself: order of summation"),
    row("contact displacement", 7e-5, "of the way of the body in a step: its gap is a small difference of positions"),
    row("contact velocity", 7.5e-5, "of the speed of the body"),
    row("body velocity", 1.5e-4, "of what the nodes near it could change, or rounding of itself"),
    row("body position", 1e-5, "of the way of the body in a step"),
    row("orientation", 2e-7, "a quaternion of length one"),
    row("angular momentum", 3e-5, "of that of the nodes near the body at its speed and reach, and itself"),
    row("impulse", 7e-5, "of the momentum of a node at the speed of the body and itself"),
    row("contact energy", 1.3e-5, "of the energy of a node at the speed of the body and itself"),
    row("penetration", 4e-6, "of an element length"),
    row("kinetic", 1e-5, "of itself"),
    row("kinetic now", 1e-5, "of the kinetic energy"),
    row("fastest", 3e-6, "of itself"),
    row("momentum", 2e-5, "of the sum of all m|v|"),
    row(
        "ply displacement",
        1e-4,
        "of the way at the largest speed in a step: a gap is a small difference of positions",
    ),
    row("ply velocity", 1.5e-5, "of the largest speed: a gap that is closed within a step"),
    row("ply energy", 7e-6, "of the energy of a node at the largest speed and itself"),
    row("ply support", 4e-6, "of the momentum of a node at the largest speed and itself"),
    row(
        "contact displacement, held",
        AT_HELD,
        "of the way of the body in a step: the body's motion rounds, and all that hangs on it",
    ),
    row("contact velocity, held", AT_HELD, "of the speed of the body, likewise"),
    row("body velocity, held", AT_HELD, "of the speed of the body"),
    row("body position, held", AT_HELD, "of the way of the body in a step"),
    row("impulse, held", AT_HELD, "of the momentum of the body at its speed, and itself"),
    row("contact energy, held", AT_HELD, "of mass times speed squared of the body, and itself"),
];

/// Where a free body meets held nodes its momentum is a small difference of sums with the mass of `HELD` bodies. It is rounded
/// six times on the way to an impulse: the sum, the factor, forwards, backwards, the velocity that is left, its product with the mass.
/// Largest seen: 1.9e-4.
const AT_HELD: f64 = 6.0 * HELD * 0.5 * f32::EPSILON as f64;

/// The largest differences seen, over their scale, and where.
#[derive(Default)]
pub(crate) struct Seen(BTreeMap<&'static str, (f64, String)>);

impl Seen {
    /// Takes note of a pair of numbers. `scale`: size of which an error is a fraction.
    pub(crate) fn see(
        &mut self,
        quantity: &'static str,
        got: f64,
        expected: f64,
        scale: f64,
        place: impl FnOnce() -> String,
    ) {
        let error = if got == expected { 0.0 } else { (got - expected).abs() / scale };
        let error = if error.is_nan() { f64::INFINITY } else { error };
        let worst = self.0.entry(quantity).or_default();
        if error > worst.0 {
            *worst = (error, format!("{}: {got:e} for {expected:e}", place()));
        }
    }

    /// Everything against the table.
    pub(crate) fn verdict(&self) -> Outcome {
        let limit = |quantity: &str| {
            TOLERANCES.iter().find(|t| t.quantity == quantity).unwrap_or_else(|| panic!("{quantity} is in no table"))
        };
        let show = std::env::var(SHOW).is_ok_and(|value| value == "1");
        let rows = self.0.iter().filter(|(quantity, (error, _))| show || *error > limit(quantity).limit);
        let lines: Vec<String> = rows
            .map(|(quantity, (error, place))| {
                let t = limit(quantity);
                format!("{quantity}: {error:.2e} > {:.1e} ({}) at {place}", t.limit, t.reason)
            })
            .collect();
        if lines.is_empty() { Ok(()) } else { Err(lines.join("\n")) }
    }
}
