use std::f64::consts::PI;

use super::super::sobol::sobol;
use super::*;

#[test]
fn first_indices_of_ishigamis_function_are_the_known_ones() {
    let points: Vec<Vec<f64>> =
        sobol(3, 8191).into_iter().map(|p| p.iter().map(|x| PI * (2.0 * x - 1.0)).collect()).collect();
    let f = |x: &[f64]| x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin();
    let values: Vec<f64> = points.iter().map(|x| f(x)).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / values.len() as f64;
    assert!((variance - 13.8446).abs() < 0.05, "{variance}");
    for (axis, expected) in [0.3139, 0.4424, 0.0].into_iter().enumerate() {
        let pairs: Vec<[f64; 2]> = points.iter().zip(&values).map(|(x, y)| [x[axis], *y]).collect();
        let part = main_effect(&pairs).map_or(f64::NAN, |effect| effect.part);
        assert!((part - expected).abs() < 0.012, "{axis}: {part}");
    }
}

#[test]
fn few_points_do_not_make_an_effect_of_chance() {
    let points = sobol(2, 24);
    let part = |axis: usize| {
        let pairs: Vec<[f64; 2]> = points.iter().map(|point| [point[axis], 3.0 * point[1]]).collect();
        main_effect(&pairs).map_or(f64::NAN, |effect| effect.part)
    };
    assert!(part(0) < 0.2 && part(1) > 0.85, "{} {}", part(0), part(1));
}

#[test]
fn a_grid_keeps_its_values() {
    let pairs: Vec<[f64; 2]> = [1.0, 2.0, 4.0].iter().flat_map(|x| [0.0, 1.0].map(|y| [*x, 10.0 * x + y])).collect();
    let effect = main_effect(&pairs);
    assert!(effect.as_ref().is_some_and(|effect| effect.levels.len() == 3 && effect.part > 0.99), "{effect:?}");
    assert!(effect.is_some_and(|effect| effect.levels[2].mean == 40.5));
    assert!(main_effect(&[[1.0, 2.0], [2.0, 2.0]]).is_none() && main_effect(&[]).is_none());
}
