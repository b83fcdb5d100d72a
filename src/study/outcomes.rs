//! Outcomes of shots: perforations and stops by velocity, and the arithmetic V50 of the standards.

use serde::Serialize;

use crate::output::number::short;

/// One shot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Impact velocity, in the unit of all others.
    pub velocity: f64,
    /// Whether the projectile passed.
    pub perforated: bool,
}

/// Shots of one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Impact velocity.
    pub velocity: f64,
    /// Shots that perforated.
    pub perforated: u64,
    /// Shots that were stopped.
    pub stopped: u64,
}

impl Group {
    /// Number of shots.
    pub fn count(&self) -> u64 {
        self.perforated + self.stopped
    }
}

/// Shots by velocity, ascending; every velocity once, none without a shot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcomes {
    groups: Vec<Group>,
}

impl Outcomes {
    /// Outcomes of groups, those of the same velocity put together.
    pub fn new(groups: impl IntoIterator<Item = Group>) -> Self {
        let mut all: Vec<Group> = groups.into_iter().filter(|group| group.count() > 0).collect();
        all.sort_by(|a, b| a.velocity.total_cmp(&b.velocity));
        all.dedup_by(|next, group| {
            let same = next.velocity == group.velocity;
            if same {
                group.perforated += next.perforated;
                group.stopped += next.stopped;
            }
            same
        });
        Self { groups: all }
    }

    /// Groups by velocity.
    pub fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Numbers of perforations and of stops.
    pub fn counts(&self) -> [u64; 2] {
        let sum = |of: fn(&Group) -> u64| self.groups.iter().map(of).sum();
        [sum(|group| group.perforated), sum(|group| group.stopped)]
    }

    /// Velocities of the slowest and the fastest shot; NaN where there is none.
    pub fn range(&self) -> [f64; 2] {
        [self.groups.first(), self.groups.last()].map(|group| group.map_or(f64::NAN, |group| group.velocity))
    }

    /// Velocity of the slowest perforation.
    pub fn slowest_perforation(&self) -> Option<f64> {
        self.groups.iter().find(|group| group.perforated > 0).map(|group| group.velocity)
    }

    /// Velocity of the fastest stop.
    pub fn fastest_stop(&self) -> Option<f64> {
        self.groups.iter().rev().find(|group| group.stopped > 0).map(|group| group.velocity)
    }

    /// Whether the fastest stop lies above the slowest perforation. Only then has the likelihood one maximum.
    pub fn overlap(&self) -> bool {
        let ends = self.slowest_perforation().zip(self.fastest_stop());
        ends.is_some_and(|(perforation, stop)| perforation < stop)
    }

    /// Mean velocities of perforations and of stops; NaN where there are none.
    pub fn means(&self) -> [f64; 2] {
        let mean = |of: fn(&Group) -> u64| {
            let sum: f64 = self.groups.iter().map(|group| of(group) as f64 * group.velocity).sum();
            sum / self.groups.iter().map(of).sum::<u64>() as f64
        };
        [mean(|group| group.perforated), mean(|group| group.stopped)]
    }
}

impl<'a> FromIterator<&'a Shot> for Outcomes {
    fn from_iter<T: IntoIterator<Item = &'a Shot>>(shots: T) -> Self {
        Self::new(shots.into_iter().map(|shot| {
            let perforated = u64::from(shot.perforated);
            Group { velocity: shot.velocity, perforated, stopped: 1 - perforated }
        }))
    }
}

/// Rules in use: standard, number of perforations and of stops, and largest less smallest velocity of all of them at most \[m/s\]: 60, 125,
/// 125 ft/s and 40 m/s. MIL-STD-662F leaves the choice to the specification of the armour.
const RULES: [(&str, u64, f64); 4] =
    [("MIL-STD-662F", 2, 18.0), ("MIL-STD-662F", 3, 38.0), ("MIL-STD-662F", 5, 38.0), ("STANAG 2920", 3, 40.0)];

/// Arithmetic V50 of a standard: mean of equally many lowest perforations and highest stops that lie close together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArithmeticV50 {
    /// Rule in words.
    pub rule: String,
    /// Standard that has it.
    pub standard: &'static str,
    /// Mean velocity [m/s]; `None` where it is refused.
    pub value: Option<f64>,
    /// Largest less smallest velocity [m/s], where there are enough shots.
    pub spread: Option<f64>,
    /// Reason of a refusal: too few shots, or too wide a spread.
    pub refused: Option<String>,
}

/// Arithmetic V50 by every rule; velocities in m/s.
pub fn arithmetic_v50(outcomes: &Outcomes) -> Vec<ArithmeticV50> {
    let counts = outcomes.counts();
    let [perforations, stops] = counts;
    let by = |(standard, pairs, most): (&'static str, u64, f64)| {
        let rule = format!("{pairs} + {pairs} within {most} m/s");
        if counts.iter().any(|count| *count < pairs) {
            let refused = Some(format!("perforations: {perforations}, stops: {stops}"));
            return ArithmeticV50 { rule, standard, value: None, spread: None, refused };
        }
        let lowest = first(outcomes.groups().iter(), |group| group.perforated, pairs);
        let highest = first(outcomes.groups().iter().rev(), |group| group.stopped, pairs);
        let all = || lowest.iter().chain(&highest).copied();
        let mean = all().sum::<f64>() / (2 * pairs) as f64;
        let spread = all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min);
        // A spread that is met to the last digit written is met.
        let is_met = spread <= most * (1.0 + 1e-12);
        let refused = (!is_met).then(|| format!("spread {} m/s, mean {} m/s", short(spread, 4), short(mean, 4)));
        ArithmeticV50 { rule, standard, value: is_met.then_some(mean), spread: Some(spread), refused }
    };
    RULES.map(by).to_vec()
}

/// Velocities of the first `count` shots of an outcome.
fn first<'a>(groups: impl Iterator<Item = &'a Group>, of: fn(&Group) -> u64, count: u64) -> Vec<f64> {
    let shots = groups.flat_map(|group| (0..of(group)).map(|_| group.velocity));
    shots.take(count as usize).collect()
}
