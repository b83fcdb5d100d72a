#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use std::f64::consts::PI;

use super::*;

/// A function at even steps.
fn sampled(of: impl Fn(f64) -> f64, from: f64, to: f64, count: u32) -> Points {
    let time = |n: u32| from + (to - from) * f64::from(n) / f64::from(count);
    (0..=count).map(|n| [time(n), of(time(n))]).collect()
}

fn near(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "{got} instead of {expected}");
}

/// sin(t + φ) − sin t = 2 sin(φ/2) cos(t + φ/2): that is its amplitude, and over a period its root mean square is amplitude/√2.
#[test]
fn a_shifted_sine_differs_by_its_closed_form() {
    let (phase, period) = (0.3_f64, 2.0 * PI);
    let amplitude = 2.0 * (0.5 * phase).sin();
    // Steps that never meet, so that both are interpolated.
    let (a, b) = (sampled(f64::sin, 0.0, period, 4001), sampled(|t| (t + phase).sin(), 0.0, period, 2500));
    let found = difference(&a, &b, 0.1).unwrap();
    assert_eq!(found.span, [0.0, period]);
    near(found.largest.abs(), amplitude, 2e-6);
    near(found.rms, amplitude / 2.0_f64.sqrt(), 2e-6);
    near(found.scale, 1.0, 1e-6);
    // The difference is largest where the cosine is, at a multiple of π less φ/2.
    near((found.at + 0.5 * phase).sin(), 0.0, 3e-3);
    // It begins at 2 sin(φ/2) cos(φ/2) = sin φ, already parted.
    assert_eq!(found.parts_at, Some(0.0));
}

#[test]
fn an_offset_is_the_same_everywhere() {
    let (a, b) = (sampled(|t| 3.0 * t, 0.0, 10.0, 7), sampled(|t| 3.0 * t + 0.6, 0.0, 10.0, 13));
    let found = difference(&a, &b, 0.01).unwrap();
    near(found.largest, 0.6, 1e-12);
    near(found.rms, 0.6, 1e-12);
    near(found.share().unwrap(), 0.02, 1e-12);
    near(found.rms_share().unwrap(), 0.02, 1e-12);
    assert_eq!(found.parts_at, Some(0.0));
    // With its sign: the other one less the first.
    near(difference(&b, &a, 0.01).unwrap().largest, -0.6, 1e-12);
}

/// A curve that starts late and ends early counts only where it is.
#[test]
fn only_the_common_time_counts() {
    let long = vec![[0.0, 100.0], [4.0, 0.0], [8.0, 0.0], [9.0, 500.0]];
    let short = vec![[2.0, 50.0], [6.0, 6.0]];
    let found = difference(&long, &short, 0.1).unwrap();
    assert_eq!(found.span, [2.0, 6.0]);
    // At 4 the short one has 28, the long one 0; the peaks of the long one at 0 and 9 are outside.
    assert_eq!((found.largest, found.at, found.scale), (28.0, 4.0, 50.0));
    // From 0 to 28 in two, then from 28 to 6 in two.
    let expected = ((2.0 * 28.0 * 28.0 + 2.0 * (28.0 * 28.0 + 28.0 * 6.0 + 36.0)) / 3.0 / 4.0_f64).sqrt();
    near(found.rms, expected, 1e-12);
    // A tenth of 50 is passed on the way from 0 to 28.
    near(found.parts_at.unwrap(), 2.0 + 2.0 * 5.0 / 28.0, 1e-12);
    assert_eq!(at(&short, 1.999), None);
    assert_eq!(at(&short, 6.001), None);
}

#[test]
fn a_ramp_parts_where_it_passes_the_share() {
    let (a, b) = (vec![[0.0, 10.0], [100.0, 10.0]], vec![[0.0, 10.0], [100.0, 12.0]]);
    let found = difference(&a, &b, 0.05).unwrap();
    near(found.parts_at.unwrap(), 25.0, 1e-12);
    near(found.rms, (4.0_f64 / 3.0).sqrt(), 1e-12);
    assert_eq!((found.largest, found.at), (2.0, 100.0));
    // A fifth is the most there is, and not exceeded.
    assert_eq!(difference(&a, &b, 0.2).unwrap().parts_at, None);
}

#[test]
fn the_same_curve_does_not_differ_and_zero_is_no_scale() {
    let curve = sampled(|t| (7.0 * t).cos() / 3.0, 0.1, 2.3, 97);
    let found = difference(&curve, &curve, 0.0).unwrap();
    assert_eq!((found.largest, found.rms, found.parts_at, found.share()), (0.0, 0.0, None, Some(0.0)));
    assert!(found.is_zero());
    let (zero, one) = (vec![[0.0, 0.0], [1.0, 0.0]], vec![[0.0, 0.0], [1.0, 1.0]]);
    let found = difference(&zero, &one, 0.01).unwrap();
    assert_eq!((found.share(), found.parts_at), (None, Some(0.0)));
}

#[test]
fn one_common_moment_is_enough_and_none_is_not() {
    let (a, b) = (vec![[0.0, 1.0], [5.0, 2.0]], vec![[5.0, 5.0], [9.0, 0.0]]);
    let found = difference(&a, &b, 0.01).unwrap();
    assert_eq!((found.span, found.largest, found.rms), ([5.0, 5.0], 3.0, 3.0));
    assert_eq!(difference(&a, &[[5.1, 0.0], [6.0, 0.0]], 0.01), None);
    assert_eq!(difference(&a, &[], 0.01), None);
}
