use super::*;
use crate::case::{Shear, ShearModulus};

fn shear(g2: f64, [gamma1, gamma2]: [f64; 2]) -> ShearConstants<f64> {
    ShearConstants::new(Some(&Shear { g1: 1e7, g2, gamma1, gamma2, modulus: ShearModulus::Tangent }), 3e-4)
}

#[test]
fn arc_sine_is_exact_to_rounding() {
    for i in -1000..=1000 {
        let x = f64::from(i) / 1000.0;
        assert!((arc_sine(x) - x.asin()).abs() < 4e-16, "{x}");
        assert!((arc_sine(x as f32) - (x as f32).asin()).abs() < 3e-7, "{x}");
    }
}

#[test]
fn the_slope_over_the_sine_is_that_of_the_energy_at_any_angle() {
    let c = shear(1e9, [0.35, 0.6]);
    for i in -99..=99 {
        let (sine, step) = (0.01 * f64::from(i) + 0.0013, 1e-6);
        let energy = |sine: f64| trellis(&c, sine).energy(&c);
        let slope = (energy(sine + step) - energy(sine - step)) / (2.0 * step);
        let got = trellis(&c, sine).slope;
        assert!((slope - got).abs() < 1e-5 * got.abs().max(1e3), "{sine}: {slope} {got}");
    }
    // Whole at yarns that lie along each other.
    assert!(trellis(&c, 1.0).slope.is_finite() && trellis(&c, -1.0).energy(&c) > energy(&c, 1.3));
}

#[test]
fn resultant_is_odd_continuous_and_the_derivative_of_the_energy() {
    for (gamma1, gamma2) in [(0.35, 0.60), (0.0, 0.0), (0.2, 0.2)] {
        let c = shear(1e9, [gamma1, gamma2]);
        for i in 1..150 {
            let gamma = 0.01 * f64::from(i) + 0.001;
            let q = resultant(&c, gamma);
            assert_eq!(resultant(&c, -gamma), -q);
            let step = 1e-6;
            let slope = (energy(&c, gamma + step) - energy(&c, gamma - step)) / (2.0 * step);
            assert!((slope / q - 1.0).abs() < 1e-5, "{gamma}: {slope} {q}");
            let g = |y: f64| match y {
                y if y <= gamma1 => 1e7,
                y if y >= gamma2 => 1e9,
                y => 1e7 + 9.9e8 * (y - gamma1) / (gamma2 - gamma1),
            };
            // The midpoint rule is exact on each straight piece of G.
            let expected: f64 = [(0.0, gamma1), (gamma1, gamma2), (gamma2, gamma)]
                .map(|(from, to): (f64, f64)| (from.min(gamma), to.min(gamma)))
                .map(|(from, to)| if to > from { 3e-4 * g(0.5 * (from + to)) * (to - from) } else { 0.0 })
                .iter()
                .sum();
            assert!((q / expected - 1.0).abs() < 1e-12, "{gamma}: {q} {expected}");
        }
    }
}

#[test]
fn the_largest_tangent_is_the_steepest_slope_of_the_resultant() {
    let c = shear(1e9, [0.35, 0.6]);
    let slope = |gamma: f64| (resultant(&c, gamma + 1e-7) - resultant(&c, gamma - 1e-7)) / 2e-7;
    let steepest = (1..15_000).map(|i| slope(1e-4 * f64::from(i) + 3e-5)).fold(0.0, f64::max);
    let got = largest_tangent(&c);
    assert!((got / steepest - 1.0).abs() < 1e-3, "{got} for {steepest}");
    // Without locking it is the one modulus there is.
    let got = largest_tangent(&shear(1e7, [0.35, 0.6]));
    assert!((got / 3e3 - 1.0).abs() < 1e-12, "{got}");
}
