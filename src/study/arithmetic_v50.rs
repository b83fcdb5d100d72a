//! The arithmetic V50 of the standards: the mean of equally many lowest perforations and highest stops, where they lie close together.

use super::outcomes::{Group, Outcomes};

/// How many shots, and how close.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Where it is used.
    pub standard: &'static str,
    /// Perforations, and stops.
    pub pairs: u64,
    /// Largest less smallest velocity of all of them at most, in the unit of the velocities.
    pub spread: f64,
}

/// Rules in use \[m/s\]: 60, 125, 125 ft/s and 40 m/s. MIL-STD-662F leaves the choice to the specification of the armour.
pub const RULES: [Rule; 4] = [
    Rule { standard: "MIL-STD-662F", pairs: 2, spread: 18.0 },
    Rule { standard: "MIL-STD-662F", pairs: 3, spread: 38.0 },
    Rule { standard: "MIL-STD-662F", pairs: 5, spread: 38.0 },
    Rule { standard: "STANAG 2920", pairs: 3, spread: 40.0 },
];

/// Mean and spread of the shots that a rule takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arithmetic {
    /// Mean velocity.
    pub mean: f64,
    /// Largest less smallest velocity.
    pub spread: f64,
}

/// Why a rule gives no V50.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// Too few shots of an outcome.
    TooFew {
        /// Perforations and stops that there are.
        counts: [u64; 2],
    },
    /// They lie too far apart.
    TooWide(Arithmetic),
}

/// The V50 of a rule.
///
/// # Errors
/// Where there are too few shots, or where they spread over more than the rule allows.
pub fn arithmetic_v50(outcomes: &Outcomes, rule: &Rule) -> Result<Arithmetic, Refusal> {
    let counts = outcomes.counts();
    if counts.iter().any(|count| *count < rule.pairs) {
        return Err(Refusal::TooFew { counts });
    }
    let groups = outcomes.groups();
    let lowest = first(groups.iter(), |group| group.perforated, rule.pairs);
    let highest = first(groups.iter().rev(), |group| group.stopped, rule.pairs);
    let all = || lowest.iter().chain(&highest);
    let [least, most] =
        [all().copied().fold(f64::INFINITY, f64::min), all().copied().fold(f64::NEG_INFINITY, f64::max)];
    let found = Arithmetic { mean: all().sum::<f64>() / (2 * rule.pairs) as f64, spread: most - least };
    // A spread that is met to the last digit written is met.
    if found.spread <= rule.spread * (1.0 + 1e-12) { Ok(found) } else { Err(Refusal::TooWide(found)) }
}

/// Velocities of the first `count` shots of an outcome.
fn first<'a>(groups: impl Iterator<Item = &'a Group>, of: fn(&Group) -> u64, count: u64) -> Vec<f64> {
    let mut found = Vec::new();
    for group in groups {
        let left = count - found.len() as u64;
        found.extend((0..of(group).min(left)).map(|_| group.velocity));
    }
    found
}
