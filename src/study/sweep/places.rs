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
mod tests {
    use std::f64::consts::PI;

    use super::super::design::SweepDesign;
    use super::super::factor::Factor;
    use super::*;

    #[test]
    fn values_that_a_group_shares_are_no_main_effect_and_a_group_with_a_failed_point_does_not_count() {
        let design = SweepDesign::Total(512);
        let range = format!("/x={}..{PI}", -PI);
        let factors: Vec<Factor> = (0..3).filter_map(|_| Factor::parse(&range).ok()).collect();
        let points = design.points(&factors).unwrap_or_default();
        let at = |point: &Vec<String>| {
            let x: Vec<f64> = point.iter().filter_map(|x| x.parse().ok()).collect();
            let response = x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin();
            PointResult { numbers: vec![Some(response)], reason: String::new() }
        };
        let mut results: Vec<PointResult> = points.iter().map(at).collect();
        let request = SweepRequest { factors, design, level: 0.9, points, cases: Vec::new() };
        let effects = key_effects(&request, &results);
        for (effect, [first, total]) in effects.iter().zip([[0.3139, 0.5576], [0.4424, 0.4424], [0.0, 0.2437]]) {
            let part = effect.main.as_ref().map_or(f64::NAN, |main| main.part);
            assert!((part - first).abs() < 0.04, "{part} {first}");
            assert!(effect.indices.is_some_and(|indices| (indices.total.value - total).abs() < 0.03), "{effect:?}");
        }
        results[7].numbers[0] = None;
        assert_eq!((groups(&request, &results).len(), places(&request, &results).len()), (511, 2559));
        assert!(key_effects(&request, &results).iter().all(|effect| effect.indices.is_some()));
    }
}
