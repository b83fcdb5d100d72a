//! The points of a sweep as numbers, and what each key does to the response.

use super::effects::{MainEffect, main_effect};
use super::indices::{KeyIndices, indices};
use super::{PointResult, SweepRequest};

/// A point with numbers for values.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// By key.
    pub(super) values: Vec<f64>,
    /// What the page shows.
    pub(super) response: f64,
    /// Ends of its interval, where it has one.
    pub(super) bounds: Option<[f64; 2]>,
    /// Whether it shares no value with another point of its group.
    independent: bool,
}

/// What a key does to the response.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyEffect {
    /// Mean of the response at each value; `None` of a single key, or where the response does not vary.
    pub main: Option<MainEffect>,
    /// Sobol's indices, where the points are those that they need.
    pub indices: Option<KeyIndices>,
}

/// What each key does to the response.
pub(crate) fn key_effects(request: &SweepRequest, results: &[PointResult]) -> Vec<KeyEffect> {
    let places = places(request, results);
    let keys = request.factors.len();
    let groups = groups(request, results);
    let indices = indices(&groups, request.level);
    let effect = |key: usize| {
        let independent = places.iter().filter(|place| place.independent);
        let pairs: Vec<[f64; 2]> = independent.map(|place| [place.values[key], place.response]).collect();
        KeyEffect {
            main: main_effect(&pairs).filter(|_| keys > 1),
            indices: indices.as_ref().and_then(|indices| indices.get(key).copied()),
        }
    };
    (0..keys).map(effect).collect()
}

/// Responses of the groups that have all of theirs.
pub(super) fn groups(request: &SweepRequest, results: &[PointResult]) -> Vec<Vec<f64>> {
    let Some(size) = request.design.group(request.factors.len()) else { return Vec::new() };
    let response = |result: &PointResult| result.numbers.first().copied().flatten();
    results.chunks(size).filter_map(|group| group.iter().map(response).collect()).collect()
}

/// Points whose values and response are numbers. Words are numbered in their order.
pub(super) fn places(request: &SweepRequest, results: &[PointResult]) -> Vec<Place> {
    let columns = request.columns();
    let bounds = |result: &PointResult| {
        let at = |name: &str| columns.iter().position(|column| *column == name).and_then(|n| result.numbers[n]);
        Some([at("low_m_s")?, at("high_m_s")?])
    };
    let group = request.design.group(request.factors.len());
    let mut words: Vec<Vec<String>> = vec![Vec::new(); request.factors.len()];
    let mut places = Vec::new();
    for (n, (values, result)) in request.points.iter().zip(results).enumerate() {
        let values = values.iter().zip(&mut words).map(|(value, words)| {
            value.parse().unwrap_or_else(|_| {
                let known = words.iter().position(|word| word == value);
                known.unwrap_or_else(|| {
                    words.push(value.clone());
                    words.len() - 1
                }) as f64
            })
        });
        let values = values.collect();
        if let Some(response) = result.numbers.first().copied().flatten() {
            let independent = group.is_none_or(|group| n % group < 2);
            places.push(Place { values, response, bounds: bounds(result), independent });
        }
    }
    places
}

#[cfg(test)]
#[path = "places_tests.rs"]
mod tests;
