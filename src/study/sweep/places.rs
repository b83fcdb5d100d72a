//! The points of a sweep as numbers.

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
}

/// Points whose values and response are numbers. Words are numbered in their order.
pub(super) fn places(request: &SweepRequest, results: &[PointResult]) -> Vec<Place> {
    let columns = request.columns();
    let bounds = |result: &PointResult| {
        let at = |name: &str| columns.iter().position(|column| *column == name).and_then(|n| result.numbers[n]);
        Some([at("low_m_s")?, at("high_m_s")?])
    };
    let mut words: Vec<Vec<String>> = vec![Vec::new(); request.factors.len()];
    let mut places = Vec::new();
    for (values, result) in request.points.iter().zip(results) {
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
            places.push(Place { values, response, bounds: bounds(result) });
        }
    }
    places
}
