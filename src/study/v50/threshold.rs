//! The threshold of one realisation: same fabric, same hit, other velocities.
//!
//! Velocities lie on a ladder whose rungs are a given part apart, so that a threshold does not depend on where its search began. The search
//! goes up or down in steps that double until it has both outcomes, then halves. Two shots beside the bracket look whether the outcome
//! turns once only.

/// Rungs from the bracket at which the outcome is looked at again.
const BESIDE: i32 = 3;
/// Velocities that are searched [m/s].
const SEARCHED: [f64; 2] = [2.0, 4900.0];

/// Velocities that are tried: powers of 1 + width, rounded to mm/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rungs {
    /// Distance of neighbours over the lower one [-].
    pub width: f64,
}

impl Rungs {
    /// Velocity of a rung [m/s].
    pub fn velocity(&self, rung: i32) -> f64 {
        ((1.0 + self.width).powi(rung) * 1e3).round() / 1e3
    }

    /// The rung nearest to a velocity [m/s].
    pub fn nearest(&self, velocity: f64) -> i32 {
        (velocity.ln() / self.width.ln_1p()).round() as i32
    }
}

/// Where the threshold of a bracket is taken to lie: its geometric mean, for rungs are powers [m/s].
pub fn middle([low, high]: [f64; 2]) -> f64 {
    (low * high).sqrt()
}

/// What is known of a threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct ThresholdSearch {
    rungs: Rungs,
    /// Where it begins, and the first step away from there.
    begin: i32,
    step: i32,
    /// What else is shot once the bracket is known.
    further: FurtherShots,
    /// Outcomes by rung.
    seen: Vec<(i32, bool)>,
    /// Highest stop and lowest perforation of the search itself.
    low: Option<i32>,
    high: Option<i32>,
}

/// Shots that a search wants besides those that find its bracket.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FurtherShots {
    /// Two beside the bracket, to see whether the outcome turns once only.
    pub beside: bool,
    /// At these velocities over the threshold, for residual velocities [-].
    pub beyond: &'static [f64],
}

impl FurtherShots {
    /// None.
    pub const NONE: Self = Self { beside: false, beyond: &[] };
}

/// What a search wants next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wanted {
    /// A shot at a rung.
    Shot(i32),
    /// Nothing: the bracket is one rung wide.
    Nothing,
    /// There is no threshold among velocities that can be shot.
    NoThreshold,
}

impl ThresholdSearch {
    /// A search from a velocity [m/s] on, in steps of at least `step` rungs.
    pub fn new(rungs: Rungs, velocity: f64, step: i32, further: FurtherShots) -> Self {
        let begin = rungs.nearest(velocity);
        Self { rungs, begin, step: step.max(1), further, seen: Vec::new(), low: None, high: None }
    }

    /// The next shot.
    pub fn wanted(&self) -> Wanted {
        let next = match (self.low, self.high) {
            (None, None) => self.begin,
            (Some(low), None) => low + self.step,
            (None, Some(high)) => high - self.step,
            (Some(low), Some(high)) if high - low > 1 => low + (high - low) / 2,
            (Some(low), Some(high)) => {
                let beyond = self.further.beyond.iter();
                let beyond = beyond.map(|part| self.rungs.nearest(self.rungs.velocity(high) * part));
                let beside = [low - BESIDE, high + BESIDE].into_iter().filter(|_| self.further.beside);
                let mut open = beside.chain(beyond).filter(|rung| !self.seen.iter().any(|(seen, _)| seen == rung));
                return open.next().map_or(Wanted::Nothing, Wanted::Shot);
            }
        };
        // A long step ends where the search does.
        let [lowest, highest] = SEARCHED.map(|velocity| self.rungs.nearest(velocity));
        let next = next.clamp(lowest, highest);
        let is_known = self.seen.iter().any(|(seen, _)| *seen == next);
        if is_known { Wanted::NoThreshold } else { Wanted::Shot(next) }
    }

    /// Takes note of an outcome.
    pub fn see(&mut self, rung: i32, perforated: bool) {
        self.seen.push((rung, perforated));
        if self.is_bracketed() {
            return;
        }
        let found = if perforated { &mut self.high } else { &mut self.low };
        let first_of_both = found.is_none() && self.seen.len() > 1;
        *found = Some(rung);
        if self.seen.len() > 1 && !first_of_both {
            self.step *= 2;
        }
    }

    fn is_bracketed(&self) -> bool {
        matches!((self.low, self.high), (Some(low), Some(high)) if high - low <= 1)
    }

    /// Velocities of the highest stop and the lowest perforation around the threshold [m/s].
    pub fn bracket(&self) -> Option<[f64; 2]> {
        Some([self.rungs.velocity(self.low?), self.rungs.velocity(self.high?)])
    }

    /// Whether no stop that was seen lies above a perforation.
    pub(crate) fn is_monotone(&self) -> bool {
        let stop = self.seen.iter().filter(|(_, perforated)| !perforated).map(|(rung, _)| *rung).max();
        let perforation = self.seen.iter().filter(|(_, perforated)| *perforated).map(|(rung, _)| *rung).min();
        stop.zip(perforation).is_none_or(|(stop, perforation)| stop < perforation)
    }
}

#[cfg(test)]
#[path = "threshold_tests.rs"]
mod tests;
