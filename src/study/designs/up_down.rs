//! Up and down (Dixon & Mood 1948): a step down after a perforation, a step up after a stop.

use crate::study::outcomes::Shot;

/// Where it starts, and the height of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpDown {
    /// First velocity.
    pub start: f64,
    /// Height of a step.
    pub step: f64,
}

/// What Dixon's and Mood's formulas give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Staircase {
    /// V50.
    pub mu: f64,
    /// Standard deviation of the thresholds.
    pub sigma: f64,
    /// Whether the formula of σ holds; else σ is 0.53 of a step, whatever the shots.
    pub scattered: bool,
}

impl UpDown {
    /// Velocity of the next shot.
    pub fn next(&self, shots: &[Shot]) -> f64 {
        match shots.last() {
            None => self.start,
            Some(shot) if shot.perforated => shot.velocity - self.step,
            Some(shot) => shot.velocity + self.step,
        }
    }

    /// V50 and scatter from the rarer outcome, its levels counted from its own lowest. `None` where it never came.
    pub fn estimate(&self, shots: &[Shot]) -> Option<Staircase> {
        let perforated = shots.iter().filter(|shot| shot.perforated).count();
        let rarer = 2 * perforated <= shots.len();
        let of_rarer = || shots.iter().filter(|shot| shot.perforated == rarer).map(|shot| shot.velocity);
        let lowest = of_rarer().min_by(f64::total_cmp)?;
        let (mut n, mut a, mut b) = (0.0, 0.0, 0.0);
        for velocity in of_rarer() {
            let level = ((velocity - lowest) / self.step).round();
            n += 1.0;
            a += level;
            b += level * level;
        }
        let half = if rarer { -0.5 } else { 0.5 };
        let spread = (n * b - a * a) / (n * n);
        let scattered = spread >= 0.3;
        let sigma = self.step * if scattered { 1.62 * (spread + 0.029) } else { 0.53 };
        Some(Staircase { mu: lowest + self.step * (a / n + half), sigma, scattered })
    }
}
