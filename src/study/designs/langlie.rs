//! Langlie's one-shot design (1962): between two limits, halfway to the shot that balances the last outcomes.

use crate::study::outcomes::Shot;

/// Limits between which the velocity of V50 is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Langlie {
    /// Lower limit.
    pub low: f64,
    /// Upper limit.
    pub high: f64,
}

impl Langlie {
    /// Velocity of the next shot.
    ///
    /// Back from the last shot, the first one is sought since which as many perforated as were stopped: the next velocity is the mean of
    /// those two. Where there is none, it is the mean of the last one and a limit.
    pub fn next(&self, shots: &[Shot]) -> f64 {
        let Some(last) = shots.last() else { return 0.5 * (self.low + self.high) };
        let mut balance = 0;
        for shot in shots.iter().rev() {
            balance += if shot.perforated { 1 } else { -1 };
            if balance == 0 {
                return 0.5 * (last.velocity + shot.velocity);
            }
        }
        0.5 * (last.velocity + if last.perforated { self.low } else { self.high })
    }
}
