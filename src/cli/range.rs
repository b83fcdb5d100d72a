//! `first[:last:count]`: a value or evenly spaced values, both ends included; and single numbers: times, percentages.

use std::str::FromStr;

/// The largest stretch that is solved.
const MAX_STRETCH: f64 = 2.0;
/// The largest number of values.
const MAX_COUNT: usize = 10_000;

/// A range of stretches Λ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StretchRange {
    first: f64,
    last: f64,
    count: usize,
}

impl StretchRange {
    /// The values in order.
    pub(crate) fn values(&self) -> Vec<f64> {
        let value = |n: usize| match n {
            0 => self.first,
            n if n + 1 == self.count => self.last,
            n => self.first + (self.last - self.first) * n as f64 / (self.count - 1) as f64,
        };
        (0..self.count).map(value).collect()
    }
}

impl FromStr for StretchRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        match parts[..] {
            [value] => Ok(Self { first: stretch(value)?, last: stretch(value)?, count: 1 }),
            [first, last, count] => {
                Ok(Self { first: stretch(first)?, last: stretch(last)?, count: self::count(count)? })
            }
            _ => Err("expected one stretch, or first:last:count like 1:1.05:26".to_owned()),
        }
    }
}

/// A range of velocities `A..B` [m/s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Velocities(pub(crate) [f64; 2]);

impl FromStr for Velocities {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends =
            text.split_once("..").and_then(|(low, high)| Some([low.trim().parse().ok()?, high.trim().parse().ok()?]));
        match ends {
            Some([low, high]) if low > 0.0 && high > low && high <= 5000.0 => Ok(Self([low, high])),
            _ => Err(format!("expected two velocities in m/s, the lower first, such as 150..250, found {text:?}")),
        }
    }
}

fn stretch(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| format!("expected a stretch, found {text:?}"))?;
    if value > 0.0 && value <= MAX_STRETCH {
        return Ok(value);
    }
    Err(format!("expected a stretch above 0 and at most {MAX_STRETCH}, found {value}; unstretched is 1"))
}

/// A time above 0 [µs], in s.
pub(crate) fn interval(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(interval) if interval > 0.0 && interval.is_finite() => Ok(interval * 1e-6),
        _ => Err(format!("expected a time above 0 in µs, found {text:?}")),
    }
}

/// A difference above 0 in percent, as a fraction.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    match text.trim().trim_end_matches('%').trim_end().parse::<f64>() {
        Ok(percent) if percent > 0.0 && percent.is_finite() => Ok(percent / 100.0),
        _ => Err(format!("expected a difference above 0 in percent, such as 2 or 0.5%, found {text:?}")),
    }
}

/// A two-sided confidence, between 0 and 1; or in percent with its sign.
pub(crate) fn level(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let level = match text.strip_suffix('%') {
        Some(percent) => percent.trim_end().parse::<f64>().map(|percent| percent / 100.0),
        None => text.parse::<f64>(),
    };
    match level {
        Ok(level) if (0.01..=0.9999).contains(&level) => Ok(level),
        _ => Err(format!("expected a confidence from 0.01 to 0.9999, such as 0.9 or 90%, found {text:?}")),
    }
}

fn count(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(count) if (2..=MAX_COUNT).contains(&count) => Ok(count),
        _ => Err(format!("expected a count between 2 and {MAX_COUNT}, found {text:?}")),
    }
}
