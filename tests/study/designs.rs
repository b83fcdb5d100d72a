//! Designs replay published paths.

use ripstop::num::link::Link;
use ripstop::study::binary_response::fit;
use ripstop::study::designs::{Langlie, Neyer, RobbinsMonro, ThreePod, UpDown, d_optimal};
use ripstop::study::outcomes::Shot;

use super::{NEYER, WU_TIAN, near, shots};

/// Wu and Tian's guesses.
const POD: ThreePod = ThreePod { low: 0.0, high: 22.0, sigma: 3.0, d_optimal: 6, quantile: Some(0.9) };

fn shot(velocity: f64, perforated: bool) -> Shot {
    Shot { velocity, perforated }
}

/// All 20 levels: outward, halving, the first D-optimal ones with the guess, then with the estimate. Levels were fired as printed.
#[test]
fn neyers_published_path_is_followed() {
    let design = Neyer { low: 0.6, high: 1.4, sigma: 0.1 };
    let all = shots(NEYER);
    for (n, shot) in all.iter().enumerate() {
        near(design.next(&all[..n]), shot.velocity, 0.005);
    }
    // Mirrored: all perforate at first.
    let mirror = |shot: &Shot| self::shot(2.0 - shot.velocity, !shot.perforated);
    let mirrored: Vec<Shot> = all.iter().map(mirror).collect();
    for (n, shot) in mirrored.iter().enumerate() {
        near(design.next(&mirrored[..n]), shot.velocity, 0.005);
    }
}

/// The published path has overlap after one shot that was placed with the guess. Without it the next one takes 0.8 of the guess: the gap
/// from 1 to 1.02 is narrower than that, and shots outside leave it as it is.
#[test]
fn neyers_guess_shrinks_with_each_shot_that_gave_no_overlap() {
    let design = Neyer { low: 0.6, high: 1.4, sigma: 0.1 };
    let mut all = shots("0.6/0 1.4/1 1/0 1.02/1");
    let mut sigma = 0.1;
    for _ in 0..3 {
        let seen = all.iter().collect();
        let velocity = design.next(&all);
        near(velocity, d_optimal(&seen, 1.01, sigma), 1e-9);
        assert!((velocity - d_optimal(&seen, 1.01, sigma / 0.8)).abs() > 1e-3);
        assert!(!(0.999..1.021).contains(&velocity), "{velocity}");
        all.push(shot(velocity, velocity > 1.01));
        sigma *= 0.8;
    }
}

/// Table 1: the first nine levels as fired, to the digit printed; the six of the second phase as published.
#[test]
fn wu_and_tians_published_path_is_followed() {
    let all = shots(WU_TIAN);
    for (n, shot) in all.iter().enumerate().take(9) {
        near(POD.next(&all[..n]), shot.velocity, 0.05);
    }
    for (n, level) in [7.26, 7.75, 8.08, 12.16, 8.52, 11.83].into_iter().enumerate() {
        near(POD.next(&all[..9 + n]), level, 0.0055);
    }
    // The third phase starts at μ + 1.2816 σ. The published 11.7106 comes from an estimate that is 0.0014 off the maximum.
    near(POD.next(&all), 11.7106, 0.002);
    let found = fit(Link::Probit, &all.iter().collect()).unwrap();
    near(POD.next(&all), found.velocity(0.9), 1e-9);
}

/// From the published start, in the unit of the data as published: y = 1, 1, 0, then 1. β = 0.4306 is what the published levels tell of
/// it. The covariance counts only through its bound.
#[test]
fn robbins_and_monros_published_steps_are_taken() {
    let sigma = 0.5 / 0.4306;
    let covariance = [[0.3, 0.0], [0.0, 0.3]];
    let mut search = RobbinsMonro::new(0.9, sigma, covariance, 1.0);
    let mut velocity = 11.7106;
    let mut path = Vec::new();
    for n in 0..15 {
        velocity = search.next(velocity, n != 2);
        path.push(velocity);
    }
    for (got, expected) in path.iter().zip([11.4896, 11.2980, 12.3899, 12.2393]) {
        near(*got, expected, 6e-5);
    }
    near(path[14], 11.1925, 6e-5);
    // In units of σ: the overview of `gonogo`, which prints β = 0.4302985.
    let sigma = 0.5 / 0.4302985;
    let mut search = RobbinsMonro::new(0.9, sigma, covariance, sigma);
    let mut velocity = 11.7106;
    for (n, shot) in shots(super::GONOGO).iter().enumerate() {
        near(velocity, shot.velocity, 1e-4);
        velocity = search.next(velocity, n != 2);
    }
}

/// The steps are the same whatever the unit.
#[test]
fn a_range_in_other_units_is_the_same_range() {
    let scaled = ThreePod { low: 300.0, high: 300.0 + 22.0 * 7.0, sigma: 21.0, ..POD };
    let to = |velocity: f64| 300.0 + 7.0 * velocity;
    let all = shots(&format!("{WU_TIAN} 11.7/1 11.4/1 11.2/0 12.5/1"));
    let moved: Vec<Shot> = all.iter().map(|shot| self::shot(to(shot.velocity), shot.perforated)).collect();
    for n in 0..=all.len() {
        near(scaled.next(&moved[..n]), to(POD.next(&all[..n])), 2e-4);
    }
}

/// Every branch of the search ends in overlap: synthetic thresholds far from the guesses, and guesses of σ that are far off.
#[test]
fn three_phases_find_overlap_wherever_the_limit_is() {
    let thresholds = [0.8, -0.9, 0.3, -0.2, 1.4, -1.1, 0.1, -0.5, 0.6, -0.7, 1.0, -1.5, 0.4, -0.3, 0.2, -0.1];
    for limit in [-40.0, 2.0, 11.0, 20.0, 80.0] {
        for sigma in [0.3, 3.0] {
            let design = ThreePod { low: 0.0, high: 22.0, sigma, d_optimal: 5, quantile: None };
            let mut all: Vec<Shot> = Vec::new();
            for n in 0..60 {
                let velocity = design.next(&all);
                assert!(velocity.is_finite(), "{limit} {sigma}: {all:?}");
                all.push(shot(velocity, velocity > limit + thresholds[n % thresholds.len()]));
            }
            let found = fit(Link::Probit, &all.iter().collect()).unwrap();
            assert!((found.mu - limit).abs() < 1.0, "{} instead of {limit}", found.mu);
        }
    }
    // The slower shot perforated, the faster one did not: three σ beyond the guesses on both sides.
    let odd = [shot(5.5, true), shot(16.5, false)];
    assert_eq!(POD.next(&odd), -9.0);
    assert_eq!(POD.next(&[&odd[..], &[shot(-9.0, false)]].concat()), 31.0);
}

/// Langlie's rule on paper: halfway back to the shot that balances the outcomes, not to the middle of the mixed interval.
#[test]
fn langlies_rule_is_followed() {
    let design = Langlie { low: 0.0, high: 100.0 };
    let path = [
        (50.0, true),
        // No balance: towards the lower limit.
        (25.0, true),
        (12.5, false),
        // Shots 2 and 3 balance.
        (18.75, false),
        // Shots 1 to 4 balance.
        (34.375, true),
        // Shots 4 and 5 balance.
        (26.5625, true),
        // Shots 3 to 6 balance. The middle of the mixed interval, 21.9, would be wrong.
        (19.53125, false),
    ];
    let mut all = Vec::new();
    for (velocity, perforated) in path {
        near(design.next(&all), velocity, 1e-12);
        all.push(shot(velocity, perforated));
    }
    assert_eq!(Langlie { low: 0.0, high: 100.0 }.next(&[shot(50.0, false)]), 75.0);
}

/// Dixon and Mood's formulas: a published staircase of steps of 20, with responses at 300 three times and at 280 twice.
#[test]
fn the_published_staircase_has_its_mean_and_scatter() {
    let design = UpDown { start: 300.0, step: 20.0 };
    let mut all = Vec::new();
    for perforated in [true, false, true, true, false, false, true, true, false, false] {
        all.push(shot(design.next(&all), perforated));
    }
    let responses = |at: f64| all.iter().filter(|shot| shot.perforated && shot.velocity == at).count();
    assert_eq!((responses(300.0), responses(280.0)), (3, 2), "{all:?}");
    let found = design.estimate(&all).unwrap();
    near(found.mu, 282.0, 1e-9);
    near(found.sigma, 10.6, 1e-9);
    assert!(!found.scattered);
    assert_eq!(design.estimate(&[shot(300.0, true)]), None);
}

/// The formula with scatter, by hand: stops are rarer, at levels 0, 1, 1, 3: A = 5, B = 11, N = 4, M = 19/16.
#[test]
fn the_rarer_outcome_counts_from_its_own_lowest_level() {
    let design = UpDown { start: 0.0, step: 10.0 };
    let stops = [400.0, 410.0, 410.0, 430.0].map(|velocity| shot(velocity, false));
    let passes = [410.0, 420.0, 420.0, 430.0, 440.0].map(|velocity| shot(velocity, true));
    let found = design.estimate(&[&stops[..], &passes].concat()).unwrap();
    near(found.mu, 400.0 + 10.0 * (5.0 / 4.0 + 0.5), 1e-9);
    near(found.sigma, 16.2 * (19.0 / 16.0 + 0.029), 1e-9);
    assert!(found.scattered);
}
