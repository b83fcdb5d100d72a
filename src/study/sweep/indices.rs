//! Sobol's first and total index of each key, with intervals.
//!
//! The first index is the part of the variance that a key explains by itself; the total one is the part that goes once all other keys are
//! known, so that it has what the key does together with others. With mean M and variance V over A and B of all n groups, and AB being A with
//! that key's value of B:
//!
//! S = Σ (f(B) − M) (f(AB) − f(A)) / (n V)   Saltelli et al. 2010, (b) of Table 2: nothing for a key that does nothing,
//!
//! T = Σ (f(A) − f(AB))² / (2 n V)   Jansen 1999.
//!
//! Intervals are those of the percentile bootstrap over groups. They take the groups as drawn by chance: Sobol's are more even, and the
//! intervals rather too wide.

use crate::num::counter_random::DrawKey;

/// Groups without which there is no interval.
const LEAST: usize = 8;
/// Samples of the bootstrap.
const RESAMPLES: u32 = 1000;
/// What the draws of the bootstrap are for: the `yarn` of their key.
const STREAM: u32 = 7;

/// An index and its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Index {
    /// \[-\]
    pub value: f64,
    /// Ends of its interval; `None` of few groups.
    pub bounds: Option<[f64; 2]>,
}

/// Both indices of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyIndices {
    /// Part of the variance that the key explains by itself.
    pub first: Index,
    /// That and what it does together with other keys.
    pub total: Index,
}

/// Indices of every key, from groups of responses: at A, at B, and at A with the value of B of each key. `level`: confidence of the intervals.
/// `None` of no group, or where the response does not vary.
pub fn indices(groups: &[Vec<f64>], level: f64) -> Option<Vec<KeyIndices>> {
    let keys = groups.first()?.len().checked_sub(2)?;
    let all: Vec<usize> = (0..groups.len()).collect();
    let values = estimates(groups, &all, keys)?;
    let mut resampled = vec![Vec::new(); 2 * keys];
    if groups.len() >= LEAST {
        for sample in 0..RESAMPLES {
            let Some(found) = estimates(groups, &drawn(groups.len(), sample), keys) else { continue };
            resampled.iter_mut().zip(found).for_each(|(all, value)| all.push(value));
        }
    }
    let bounds: Vec<Option<[f64; 2]>> = resampled.into_iter().map(|values| percentiles(values, level)).collect();
    let index = |at: usize| Index { value: values[at], bounds: bounds[at] };
    Some((0..keys).map(|key| KeyIndices { first: index(key), total: index(keys + key) }).collect())
}

/// So many groups with replacement.
fn drawn(count: usize, sample: u32) -> Vec<usize> {
    let numbers = (0..)
        .flat_map(|element| DrawKey { seed: 0, shot: sample, ply: DrawKey::WHOLE, yarn: STREAM, element }.uniform());
    numbers.take(count).map(|u| (u * count as f64) as usize).collect()
}

/// First indices of all keys, then total ones, from the groups of these numbers.
fn estimates(groups: &[Vec<f64>], numbers: &[usize], keys: usize) -> Option<Vec<f64>> {
    let sum = |of: &dyn Fn(&[f64]) -> f64| numbers.iter().map(|n| of(&groups[*n])).sum::<f64>();
    let n = numbers.len() as f64;
    let mean = sum(&|group| group[0] + group[1]) / (2.0 * n);
    let variance = sum(&|group| (group[0] - mean).powi(2) + (group[1] - mean).powi(2)) / (2.0 * n);
    if variance.is_nan() || variance <= 0.0 {
        return None;
    }
    let first = |key: usize| sum(&|group| (group[1] - mean) * (group[2 + key] - group[0])) / (n * variance);
    let total = |key: usize| sum(&|group| (group[0] - group[2 + key]).powi(2)) / (2.0 * n * variance);
    Some((0..keys).map(first).chain((0..keys).map(total)).collect())
}

fn percentiles(mut values: Vec<f64>, level: f64) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)? as f64;
    let at = |part: f64| values[(part * last).round() as usize];
    Some([at(0.5 - 0.5 * level), at(0.5 + 0.5 * level)])
}

#[cfg(test)]
#[path = "indices_tests.rs"]
mod tests;
