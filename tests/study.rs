//! Ballistic limits from shots.
//!
//! Promises: estimates and intervals are those of published sets, digit by digit as far as they were printed; how often intervals
//! hold the truth is measured on synthetic ranges and stands in the book; random numbers are the published generator's.

mod campaign;
mod coverage;
mod estimation;
mod variability;

use ripstop::study::binary_response::{Group, Outcomes};
use ripstop::study::limit::Bounds;

/// Wu & Tian 2014, Table 1: range 0 to 22, σ guessed as 3.
const WU_TIAN: &str =
    "5.5/0 16.5/1 11/0 13.8/1 10.1/0 14.7/1 10.4/1 11.7/1 9.7/1 7.3/0 7.8/0 8.1/0 12.2/1 8.5/0 11.8/1";
/// The same, and the third phase of the overview of the package `gonogo`.
const GONOGO: &str = "11.7106/1 11.40675/1 11.15419/0 12.46178/1 12.27455/1 12.10918/1 11.96126/1 11.82756/1 11.70565/1 11.59367/1 \
                      11.49016/1 11.39395/1 11.3041/1 11.21983/1 11.1405/1";
/// Neyer 1994, as in MIL-STD-331: V50 guessed between 0.6 and 1.4, σ as 0.1.
const NEYER: &str = "1/0 1.2/0 1.4/0 1.8/0 2.6/0 4.2/1 3.4/0 3.8/0 4/0 4.1/0 4.28/0 4.52/0 5.55/1 5.24/0 6.37/1 6.08/0 7.38/1 \
                     7.09/1 6.89/1 6.74/1";

/// Outcomes of shots written as velocity/outcome.
fn outcomes(text: &str) -> Outcomes {
    let shot = |word: &str| {
        let (velocity, outcome) = word.split_once('/').unwrap();
        let perforated = u64::from(outcome == "1");
        Group { velocity: velocity.parse().unwrap(), perforated, stopped: 1 - perforated }
    };
    Outcomes::new(text.split_whitespace().map(shot))
}

/// Whether a value lies inside an interval.
fn holds(bounds: Bounds, value: f64) -> bool {
    bounds.low.is_none_or(|low| low <= value) && bounds.high.is_none_or(|high| value <= high)
}

#[track_caller]
fn near(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "{got} instead of {expected} ± {tolerance}");
}
