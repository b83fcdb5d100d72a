//! Random numbers, and strength drawn with them.

use std::collections::HashSet;

use ripstop::num::random::Weibull;
use ripstop::num::random::{DrawKey, philox, uniform};

use super::near;

/// `kat_vectors` of Random123.
#[test]
fn the_generator_is_the_published_one() {
    for (counter, key, expected) in [
        ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
        ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
        (
            [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
            [0xa409_3822, 0x299f_31d0],
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
        ),
    ] {
        assert_eq!(philox(counter, key), expected);
    }
}

/// Every part of a key counts, each in its own place; seeds differ in their upper half too.
#[test]
fn draws_for_different_things_differ() {
    let mut seen = HashSet::new();
    let values = [0, 1, 2, DrawKey::WHOLE];
    for seed in [0, 1, 1 << 32] {
        for shot in values {
            for ply in values {
                for yarn in values {
                    for element in values {
                        assert!(seen.insert(DrawKey { seed, shot, ply, yarn, element }.words()));
                    }
                }
            }
        }
    }
    assert_eq!(seen.len(), 3 * 256);
}

#[test]
fn uniform_numbers_are_exact_in_single_precision_and_never_0_or_1() {
    assert_eq!(uniform(0), 0.5 / 8_388_608.0);
    assert_eq!(uniform(u32::MAX), 1.0 - 0.5 / 8_388_608.0);
    for n in 0..1000 {
        for value in (DrawKey { element: n, ..DrawKey::default() }).uniform() {
            assert_eq!(f64::from(value as f32), value);
            assert!(value > 0.0 && value < 1.0);
        }
    }
}

/// Neighbouring shots, yarns and elements: means, variances and correlations within four standard errors.
#[test]
fn draws_of_neighbours_are_uniform_and_independent() {
    const COUNT: u32 = 40_000;
    let counts = f64::from(COUNT);
    let keys: [fn(u32) -> DrawKey; 3] = [
        |n| DrawKey { seed: 7, shot: n, ..DrawKey::default() },
        |n| DrawKey { seed: 7, yarn: n, ..DrawKey::default() },
        |n| DrawKey { seed: 7, element: n, ..DrawKey::default() },
    ];
    for key in keys {
        let draws: Vec<f64> = (0..COUNT).map(|n| key(n).uniform()[0] - 0.5).collect();
        let mean = draws.iter().sum::<f64>() / counts;
        near(mean, 0.0, 4.0 / (12.0 * counts).sqrt());
        let variance = draws.iter().map(|draw| draw * draw).sum::<f64>() / counts;
        near(variance, 1.0 / 12.0, 4.0 / (180.0 * counts).sqrt());
        let product = draws.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / counts;
        near(product, 0.0, 4.0 / (144.0 * counts).sqrt());
        let [first, second] = [0, 1].map(|word| (0..COUNT).map(move |n| key(n).uniform()[word] - 0.5));
        near(first.zip(second).map(|(a, b)| a * b).sum::<f64>() / counts, 0.0, 4.0 / (144.0 * counts).sqrt());
    }
}

/// Kevlar 49 of a gauge length of 50 mm.
const YARN: Weibull = Weibull { scale: 1933.0, shape: 21.7, gauge: 50.0 };

/// A chain of n pieces is Weibull with σ₀ n^(−1/m), exactly: Kolmogorov's distance of drawn chains to it, and mean and variation.
#[test]
fn the_weakest_of_many_pieces_has_the_closed_form() {
    const CHAINS: u32 = 20_000;
    let pieces = 8;
    let chain = |n: u32| {
        let draw = |piece: u32| {
            YARN.strength(50.0, DrawKey { seed: 11, yarn: n, element: piece, ..DrawKey::default() }.uniform()[0])
        };
        (0..pieces).map(draw).fold(f64::INFINITY, f64::min)
    };
    let mut strengths: Vec<f64> = (0..CHAINS).map(chain).collect();
    strengths.sort_by(f64::total_cmp);
    let whole = YARN.at_gauge(50.0 * f64::from(pieces));
    near(whole.scale, 1933.0 * f64::from(pieces).powf(-1.0 / 21.7), 1e-9);
    let distance = strengths
        .iter()
        .enumerate()
        .map(|(n, strength)| (whole.probability(whole.gauge, *strength) - (n as f64 + 0.5) / f64::from(CHAINS)).abs())
        .fold(0.0, f64::max);
    // One in a thousand samples lies farther off than 1.95/√n.
    assert!(distance < 1.95 / f64::from(CHAINS).sqrt(), "{distance}");
    let mean = strengths.iter().sum::<f64>() / f64::from(CHAINS);
    let deviation = (strengths.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / f64::from(CHAINS)).sqrt();
    near(mean, YARN.mean(50.0 * f64::from(pieces)), 4.0 * deviation / f64::from(CHAINS).sqrt());
    near(deviation / mean, YARN.variation(), 0.03 * YARN.variation());
}

#[test]
fn a_length_is_weaker_the_longer_it_is_and_draws_invert_the_chance() {
    near(YARN.probability(50.0, 1933.0), 1.0 - (-1.0_f64).exp(), 1e-12);
    for length in [1.0, 50.0, 425.0] {
        for u in [1e-6, 0.1, 0.5, 0.999] {
            near(YARN.probability(length, YARN.strength(length, u)), u, 1e-9);
        }
    }
    // An exponential distribution has mean and standard deviation alike.
    let exponential = Weibull { scale: 2.0, shape: 1.0, gauge: 1.0 };
    near(exponential.mean(4.0), 0.5, 1e-12);
    near(exponential.variation(), 1.0, 1e-12);
    // The normal approximation of the table: 1933 MPa and m = 21.7 vary by 5.8 %.
    near(YARN.variation(), 0.0576, 5e-4);
}
