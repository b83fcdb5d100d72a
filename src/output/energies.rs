//! Where the energy went, at the end of a run.

use super::summary::absorbed_energy;
use crate::run::Run;

/// What the fabric was given and where it is.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Energies {
    /// Kinetic energy that the projectile lost [J].
    pub absorbed: f64,
    /// That, and the work of prescribed motion [J].
    pub given: f64,
    /// What became of it [J]; they add up to what was given.
    pub shares: Vec<(&'static str, f64)>,
    /// The largest of them [J].
    pub scale: f64,
}

/// What a share is, for somebody who meets it for the first time.
pub(super) fn meaning(share: &str) -> &'static str {
    match share {
        "fabric, kinetic" => "the fabric moves",
        "fabric, elastic" => "held by stretched yarns, pressed crossovers and shear",
        "shock viscosity" => "what tension shocks dissipate",
        "ply separation" => "taken by moving plies out of each other; negative: given, an error of ply contact",
        "unit-cell law" => "taken by the published law, whose force is not the slope of an energy; negative: given",
        "hourglass" => "artificial stiffness that keeps elements in shape; should be small",
        "contact" => "lost where bodies meet and go on together, an inelastic impact",
        "friction" => "sliding of projectile and plies",
        "yarn failure" => "held by yarns when they broke",
        "unaccounted" => "error of the arithmetic",
        _ => "",
    }
}

impl Energies {
    /// Of the last state of a run; `None` without energy in it, or with numbers that are not finite.
    pub fn of(run: &Run) -> Option<Self> {
        let (first, last) = (run.history.first()?, run.history.last()?);
        let (start, end) = (&first.balance, &last.balance);
        let absorbed = absorbed_energy(run);
        let given = absorbed + end.external;
        // The first row stands after the first contact: what the fabric moved with before is what balances it.
        let kinetic = start.kinetic + start.contact + start.friction + start.projectile
            - start.separation
            - start.external
            - run.impact_energy;
        let mut shares = vec![
            ("fabric, kinetic", end.kinetic - kinetic),
            ("fabric, elastic", end.stored - start.stored),
            ("hourglass", end.hourglass - start.hourglass),
            ("shock viscosity", end.viscous),
            ("contact", end.contact),
            ("friction", end.friction),
            ("yarn failure", end.failure),
        ];
        if end.law != 0.0 {
            shares.push(("unit-cell law", -end.law));
        }
        if end.separation != 0.0 {
            shares.push(("ply separation", -end.separation));
        }
        let found: f64 = shares.iter().map(|share| share.1).sum();
        shares.push(("unaccounted", given - found));
        let scale = shares.iter().map(|share| share.1.abs()).fold(given.abs(), f64::max);
        let finite = shares.iter().all(|share| share.1.is_finite());
        (finite && scale > 0.0).then_some(Self { absorbed, given, shares, scale })
    }

    /// An energy [J] with unit and decimals that suit the largest.
    pub fn text(&self, energy: f64) -> String {
        let (factor, unit) = match self.scale {
            0.1.. => (1.0, "J"),
            1e-4.. => (1e3, "mJ"),
            _ => (1e6, "µJ"),
        };
        let decimals = (4.0 - (factor * self.scale).log10().floor()).clamp(0.0, 4.0) as usize;
        format!("{} {unit}", super::number::fixed(factor * energy, decimals))
    }

    /// A share of what was given, in per cent; empty where nothing was.
    pub fn percent(&self, energy: f64) -> String {
        if self.given > 1e-9 * self.scale {
            format!("{} %", super::number::fixed(100.0 * energy / self.given, 1))
        } else {
            String::new()
        }
    }
}
