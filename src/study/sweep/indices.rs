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

use crate::math::counter_random::DrawKey;

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
mod tests {
    use std::f64::consts::PI;

    use super::super::design::SweepDesign;
    use super::super::factor::Factor;
    use super::*;

    fn ishigami(x: &[f64]) -> f64 {
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }

    /// Groups of responses over the box from −π to π.
    fn groups(count: usize, f: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
        let range = format!("/x={}..{PI}", -PI);
        let factors: Vec<Factor> = (0..3).filter_map(|_| Factor::parse(&range).ok()).collect();
        let points = SweepDesign::Total(count).points(&factors).unwrap_or_default();
        let at = |point: &Vec<String>| f(&point.iter().filter_map(|x| x.parse().ok()).collect::<Vec<f64>>());
        points.chunks(5).map(|group| group.iter().map(at).collect()).collect()
    }

    #[test]
    fn both_indices_of_ishigamis_function_are_the_known_ones() {
        let found = indices(&groups(1999, ishigami), 0.9).unwrap_or_default();
        assert_eq!(found.len(), 3);
        for (key, [first, total]) in found.iter().zip([[0.3139, 0.5576], [0.4424, 0.4424], [0.0, 0.2437]]) {
            for (index, expected) in [(key.first, first), (key.total, total)] {
                assert!((index.value - expected).abs() < 0.01, "{key:?} {expected}");
                assert!(index.bounds.is_some_and(|[low, high]| low < expected && expected < high), "{key:?}");
                assert!(index.bounds.is_some_and(|[low, high]| high - low < 0.12), "{key:?}");
            }
        }
    }

    #[test]
    fn intervals_hold_about_as_often_as_they_say() {
        // Groups drawn by chance, as the bootstrap takes them.
        let known = [0.3139, 0.4424, 0.0, 0.5576, 0.4424, 0.2437];
        let (mut held, campaigns) = ([0; 6], 200);
        for campaign in 0..campaigns {
            let of = |group: u32| {
                let key = |element| DrawKey { seed: 1, shot: campaign, ply: group, yarn: 0, element };
                let [u, v] = [key(0).uniform(), key(1).uniform()];
                let [a, b] = [&u[..3], &v[..3]].map(|u| [0, 1, 2].map(|n: usize| PI * (2.0 * u[n] - 1.0)));
                let with = |key: usize| ishigami(&[0, 1, 2].map(|n| if n == key { b[n] } else { a[n] }));
                vec![ishigami(&a), ishigami(&b), with(0), with(1), with(2)]
            };
            let found = indices(&(0..128).map(of).collect::<Vec<_>>(), 0.9).unwrap_or_default();
            let all = found.iter().map(|key| key.first).chain(found.iter().map(|key| key.total));
            for ((held, known), index) in held.iter_mut().zip(known).zip(all) {
                *held += u32::from(index.bounds.is_some_and(|[low, high]| low <= known && known <= high));
            }
        }
        let parts = held.map(|held| f64::from(held) / f64::from(campaigns));
        assert!(parts.iter().all(|part| (0.80..=0.97).contains(part)), "{parts:?}");
    }

    #[test]
    fn keys_that_only_add_have_one_index_and_what_does_not_vary_has_none() {
        let found = indices(&groups(512, |x| 2.0 * x[0] + x[1]), 0.9).unwrap_or_default();
        for (key, expected) in found.iter().zip([0.8, 0.2, 0.0]) {
            let off = [key.first, key.total].map(|index| (index.value - expected).abs());
            assert!(off.iter().all(|off| *off < 0.02), "{found:?}");
        }
        assert!(found.get(2).is_some_and(|key| key.first.value == 0.0 && key.total.value == 0.0), "{found:?}");
        assert!(indices(&groups(64, |_| 3.0), 0.9).is_none() && indices(&[], 0.9).is_none());
        let few = indices(&groups(7, ishigami), 0.9).unwrap_or_default();
        assert!(few.len() == 3 && few.iter().all(|key| key.total.bounds.is_none()));
    }
}
