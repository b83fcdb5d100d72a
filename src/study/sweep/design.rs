//! Which points a sweep has: a grid, Sobol's points, or those that total indices need.

use super::factor::{Factor, Values};
use super::sobol::{MAX_DIMENSIONS, sobol};
use crate::output::csv::number;
use crate::study::StudyError;

/// By which B is turned around, in each key: the golden ratio, so that no value of B is one of A. Sobol's first points have many alike.
const TURN: f64 = 0.618_033_988_749_894_9;
/// Points of a sweep at most.
pub(super) const MAX_POINTS: usize = 10_000;

/// Which points a sweep has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SweepDesign {
    /// All combinations of the values, the last key fastest.
    Grid,
    /// So many of Sobol's points.
    Sobol(usize),
    /// So many groups of points for total indices (Saltelli et al. 2010): two points A and B that have nothing to do with each other, then for
    /// each key A with that key's value of B.
    Total(usize),
}

impl SweepDesign {
    /// Points of a group, the first two of which are independent of each other; `None`: there are no groups.
    pub fn group(self, keys: usize) -> Option<usize> {
        matches!(self, Self::Total(_)).then_some(keys + 2)
    }

    /// The points, each with a value for each key, as the case file would have them.
    ///
    /// # Errors
    /// When a range has no step in a grid, a list stands among ranges to be filled, or there are too many points.
    pub fn points(self, factors: &[Factor]) -> Result<Vec<Vec<String>>, StudyError> {
        let keys = factors.len();
        match self {
            Self::Grid => grid(factors),
            Self::Sobol(count) => {
                let ranges = ranges(factors, MAX_DIMENSIONS, count)?;
                Ok(sobol(keys, count).iter().map(|point| placed(point, &ranges)).collect())
            }
            Self::Total(count) => {
                let ranges = ranges(factors, MAX_DIMENSIONS / 2, count.saturating_mul(keys + 2))?;
                let group = |point: Vec<f64>| -> Vec<Vec<String>> {
                    let turned: Vec<f64> = point[keys..].iter().map(|part| (part + TURN).fract()).collect();
                    let [a, b] = [&point[..keys], &turned].map(|half| placed(half, &ranges));
                    let with = |key: usize| {
                        let mut mixed = a.clone();
                        mixed[key].clone_from(&b[key]);
                        mixed
                    };
                    let mixed: Vec<Vec<String>> = (0..keys).map(with).collect();
                    [vec![a, b], mixed].concat()
                };
                Ok(sobol(2 * keys, count).into_iter().flat_map(group).collect())
            }
        }
    }
}

fn of(factor: &Factor) -> String {
    format!("--over {}", factor.pointer)
}

/// The ranges that points fill.
fn ranges(factors: &[Factor], keys: usize, points: usize) -> Result<Vec<[f64; 2]>, StudyError> {
    if factors.len() > keys || points > MAX_POINTS {
        let found = format!("{} keys and {points} points", factors.len());
        let expected = format!("at most {keys} keys and {MAX_POINTS} points");
        return Err(StudyError::new("--sobol", expected, found, "vary fewer keys, take fewer points, or a grid"));
    }
    let range = |factor: &Factor| match factor.values {
        Values::Between(range) => Ok(range),
        Values::List(_) => {
            let help = "write /pointer=A..B without a step, or leave --sobol out";
            Err(StudyError::new(of(factor), "a range A..B for Sobol's points", "a list of values", help))
        }
    };
    factors.iter().map(range).collect()
}

/// A point between 0 and 1 in its ranges.
fn placed(point: &[f64], ranges: &[[f64; 2]]) -> Vec<String> {
    // Six digits fill a range as evenly as sixteen.
    point.iter().zip(ranges).map(|(part, [low, high])| short_number(low + part * (high - low))).collect()
}

/// A number with six digits.
fn short_number(value: f64) -> String {
    format!("{value:.5e}").parse().map_or_else(|_| number(value), number)
}

fn grid(factors: &[Factor]) -> Result<Vec<Vec<String>>, StudyError> {
    let mut points = vec![Vec::new()];
    for factor in factors {
        let Values::List(values) = &factor.values else {
            let help = "write /pointer=A..B:STEP, or add --sobol N";
            return Err(StudyError::new(of(factor), "values, or a range with a step", "a range without a step", help));
        };
        if points.len() * values.len() > MAX_POINTS {
            let found = format!("{} of them at {}", points.len() * values.len(), factor.pointer);
            return Err(StudyError::new("--over", format!("at most {MAX_POINTS} points"), found, "take longer steps"));
        }
        let with = |point: Vec<String>| -> Vec<Vec<String>> {
            values.iter().map(|value| [point.clone(), vec![value.clone()]].concat()).collect()
        };
        points = points.into_iter().flat_map(with).collect();
    }
    Ok(points)
}

#[cfg(test)]
#[path = "design_tests.rs"]
mod tests;
