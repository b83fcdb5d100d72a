//! Curves through residual velocities.

use ripstop::num::link::Link;
use ripstop::num::random::DrawKey;
use ripstop::study::residual_fit::{Passed, ResidualModel, TooFew, residual_fit};

use super::near;

fn exact(factor: f64, exponent: f64, limit: f64) -> Vec<Passed> {
    let shot = |n: i32| {
        let impact = limit + 25.0 * f64::from(n);
        let residual = factor * (impact.powf(exponent) - limit.powf(exponent)).powf(1.0 / exponent);
        Passed { impact, residual, count: 1 }
    };
    (1..=12).map(shot).collect()
}

#[test]
fn a_curve_is_found_again_from_its_own_points() {
    for (factor, exponent, limit) in [(1.0, 2.0, 300.0), (0.8, 2.5, 420.0), (0.95, 1.3, 150.0)] {
        let found = residual_fit(ResidualModel::LambertJonas, &exact(factor, exponent, limit), 0.9).unwrap();
        near(found.limit, limit, 1e-4);
        near(found.factor, factor, 1e-6);
        near(found.exponent, exponent, 1e-5);
        near(
            found.residual(limit + 100.0),
            factor * ((limit + 100.0).powf(exponent) - limit.powf(exponent)).powf(1.0 / exponent),
            1e-4,
        );
        assert_eq!(found.residual(limit - 1.0), 0.0);
    }
    let found = residual_fit(ResidualModel::RechtIpson, &exact(1.0, 2.0, 300.0), 0.9).unwrap();
    near(found.limit, 300.0, 1e-5);
    assert_eq!((found.factor, found.exponent), (1.0, 2.0));
}

/// Far above the limit Recht's and Ipson's curve is a line of V₀²: the interval is then the textbook's.
#[test]
fn far_from_the_limit_the_interval_is_that_of_a_line() {
    let noise = [3.0, -2.0, 1.0, -4.0, 2.0];
    let shots: Vec<Passed> = noise
        .iter()
        .enumerate()
        .map(|(n, noise)| {
            let impact = 2000.0 + 50.0 * n as f64;
            Passed { impact, residual: (impact * impact - 300.0 * 300.0).sqrt() + noise, count: 1 }
        })
        .collect();
    let found = residual_fit(ResidualModel::RechtIpson, &shots, 0.9).unwrap();
    // dVr/dV₀ = −V₀/Vr; t of 4 degrees of freedom at 90 % is 2.1318.
    let squares: f64 = shots.iter().map(|shot| (found.limit / found.residual(shot.impact)).powi(2)).sum();
    let sum: f64 = shots.iter().map(|shot| (shot.residual - found.residual(shot.impact)).powi(2)).sum();
    near(found.scatter, (sum / 4.0).sqrt(), 1e-6);
    let half = 2.1318 * found.scatter / squares.sqrt();
    near(found.bounds.high.unwrap() - found.bounds.low.unwrap(), 2.0 * half, 0.02 * half);
}

#[test]
fn intervals_hold_the_limit_as_often_as_they_say() {
    let mut held = [0; 2];
    let ranges = 400;
    for range in 0..ranges {
        let noise = |n: u32| {
            8.0 * Link::Probit.quantile(DrawKey { seed: 3, shot: range, element: n, ..DrawKey::default() }.uniform()[0])
        };
        let range = |factor: f64, exponent: f64| -> Vec<Passed> {
            let shot = |n: u32| {
                let impact = 300.0 + 15.0 * f64::from(n);
                let residual = factor * (impact.powf(exponent) - 300_f64.powf(exponent)).powf(1.0 / exponent);
                Passed { impact, residual: (residual + noise(n)).clamp(0.0, impact), count: 1 }
            };
            (1..=10).map(shot).collect()
        };
        for (held, (curve, shots)) in held
            .iter_mut()
            .zip([(ResidualModel::RechtIpson, range(1.0, 2.0)), (ResidualModel::LambertJonas, range(0.8, 2.2))])
        {
            *held += u32::from(residual_fit(curve, &shots, 0.9).unwrap().bounds.holds(300.0));
        }
    }
    // Four standard errors of a share of 90 % among 400 are 6 %.
    for held in held {
        let share = f64::from(held) / f64::from(ranges);
        assert!((share - 0.9).abs() < 0.06, "{share}");
    }
}

#[test]
fn counts_are_shots_and_too_few_are_refused() {
    let mut shots = exact(0.9, 2.0, 300.0);
    shots[3].residual += 10.0;
    let twice: Vec<Passed> = shots.iter().chain(&shots).copied().collect();
    let counted: Vec<Passed> = shots.iter().map(|shot| Passed { count: 2, ..*shot }).collect();
    let [a, b] = [twice, counted].map(|shots| residual_fit(ResidualModel::LambertJonas, &shots, 0.9).unwrap());
    near(a.limit, b.limit, 1e-6);
    near(a.scatter, b.scatter, 1e-9);
    assert_eq!((a.count, b.count), (24, 24));
    assert_eq!(residual_fit(ResidualModel::LambertJonas, &shots[..3], 0.9), Err(TooFew { have: 3, need: 4 }));
    let same = [shots[0]; 5];
    assert_eq!(residual_fit(ResidualModel::RechtIpson, &same, 0.9), Err(TooFew { have: 1, need: 2 }));
}
