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
