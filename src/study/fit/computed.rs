//! A computed V50 to hold measured shots against: `v50.json` of `ripstop v50`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::Fit;
use crate::num::link::Link;
use crate::output::number::short;
use crate::study::StudyError;
use crate::study::interval::Bounds;

/// A computed limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComputedLimit {
    /// V50 [m/s].
    pub v50: f64,
    /// Its interval [m/s].
    pub bounds: Bounds,
    /// Scatter of the thresholds [m/s]; `None` where nothing varied.
    pub sigma: Option<f64>,
}

impl ComputedLimit {
    /// Reads `v50.json`.
    ///
    /// # Errors
    /// When it cannot be read, or holds no V50.
    pub fn read(path: &Path) -> Result<Self, StudyError> {
        let place = path.display().to_string();
        let wrong = |found: String| {
            StudyError::new(
                &place,
                "v50.json of `ripstop v50`",
                found,
                "give the v50.json in the folder of a `ripstop v50`",
            )
        };
        let text = fs::read_to_string(path).map_err(|error| wrong(error.to_string()))?;
        let found: Value = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let number = |name: &str| found[name].as_f64();
        let v50 = number("v50_m_s").filter(|v50| *v50 > 0.0).ok_or_else(|| wrong("no v50_m_s".to_owned()))?;
        let bounds = Bounds { low: number("low_m_s"), high: number("high_m_s") };
        Ok(Self { v50, bounds, sigma: number("sigma_m_s").filter(|sigma| *sigma > 0.0) })
    }

    /// Chance of a perforation at a velocity.
    pub fn probability(&self, velocity: f64) -> f64 {
        match self.sigma {
            Some(sigma) => Link::Probit.probability((velocity - self.v50) / sigma),
            None => f64::from(u8::from(velocity >= self.v50)),
        }
    }

    /// What a reader is told of measured and computed.
    pub fn words(&self, fit: &Fit) -> String {
        let [low, high] = self.bounds.words();
        let computed = format!("computed V50 {} m/s, {low} to {high} m/s", short(self.v50, 4));
        let Some((value, bounds)) = fit.v50().and_then(|v50| Some((v50.value?, v50.bounds))) else { return computed };
        let off = 100.0 * (self.v50 / value - 1.0);
        let below = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| a < b);
        let apart = below(self.bounds.high, bounds.low) || below(bounds.high, self.bounds.low);
        let overlap = if apart { "the intervals do not overlap" } else { "the intervals overlap" };
        format!("{computed}: {}{} % of the measured one; {overlap}", if off > 0.0 { "+" } else { "" }, short(off, 2))
    }
}
