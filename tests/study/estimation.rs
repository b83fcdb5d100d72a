//! Maximum likelihood, Firth's penalty, intervals, arithmetic V50, residual velocities, refusals.

use ripstop::num::random::{DrawKey, normal};
use ripstop::study::binary_response::{self as binary, Estimate, Group, Outcomes, fit, interval};
use ripstop::study::fit::{VelocityUnit, arithmetic_v50};
use ripstop::study::limit::{Bounds, Passed, ResidualModel, residual_fit};

use super::{GONOGO, NEYER, WU_TIAN, holds, outcomes};
use crate::support::near;

fn estimate(text: &str) -> Estimate {
    fit(&outcomes(text)).unwrap()
}

#[test]
fn published_sets_give_the_published_estimates() {
    let nine: Vec<&str> = WU_TIAN.split(' ').take(9).collect();
    let found = estimate(&nine.join(" "));
    near(found.mu, 9.9726, 5e-5);
    near(found.sigma, 2.0705, 5e-5);
    // The published σ is R's, which stops when the deviance changes by less than 1e-8: 3e-5 from the maximum.
    let found = estimate(&format!("{WU_TIAN} {GONOGO}"));
    near(found.mu, 10.17033, 5e-5);
    near(found.sigma, 0.93398, 5e-5);
    near(found.deviance(), 14.139, 5e-4);
    let found = estimate(NEYER);
    near(found.mu, 5.39218, 6e-6);
    near(found.sigma, 1.04123, 6e-6);
}

fn log_likelihood(outcomes: &Outcomes, mu: f64, sigma: f64) -> f64 {
    let term = |group: &Group| {
        let eta = (group.velocity - mu) / sigma;
        group.perforated as f64 * normal::ln_probability(eta) + group.stopped as f64 * normal::ln_probability(-eta)
    };
    outcomes.groups().iter().map(term).sum()
}

/// The likelihood times the square root of the information's determinant is largest at the estimate; of two shots that is their middle.
#[test]
fn without_overlap_firths_penalty_gives_the_estimate_and_says_so() {
    near(fit(&outcomes("400/0 500/1")).unwrap().mu, 450.0, 1e-9);
    let outcomes = outcomes("400/0 430/0 445/0 460/1 500/1");
    let found = fit(&outcomes).unwrap();
    assert!(found.firth && !outcomes.overlap());
    let penalised = |mu: f64, sigma: f64| {
        let sum = |power: i32| -> f64 {
            let of = |velocity: f64| normal::information((velocity - mu) / sigma) * (velocity - 450.0).powi(power);
            outcomes.groups().iter().map(|group| of(group.velocity)).sum()
        };
        log_likelihood(&outcomes, mu, sigma) + 0.5 * (sum(0) * sum(2) - sum(1).powi(2)).ln()
    };
    let (mu, sigma, h) = (found.mu, found.sigma, 1e-3);
    near((penalised(mu + h, sigma) - penalised(mu - h, sigma)) / (2.0 * h), 0.0, 1e-7);
    near((penalised(mu, sigma + h) - penalised(mu, sigma - h)) / (2.0 * h), 0.0, 1e-7);
}

#[test]
fn shots_that_tell_nothing_are_refused_with_the_reason() {
    for (text, why) in [
        ("", binary::NO_SHOTS),
        ("400/0 450/0 500/0", binary::ALL_STOPPED),
        ("400/1 450/1", binary::ALL_PERFORATED),
        ("400/1 400/0 400/1", binary::ONE_VELOCITY),
        ("400/1 450/0", binary::INVERTED),
        ("400/1 450/0 500/0 500/1", binary::INVERTED),
        // Perforations and stops of the same mean velocity: σ is infinite.
        ("400/1 450/0 500/1", binary::INVERTED),
    ] {
        assert_eq!(fit(&outcomes(text)), Err(why), "{text}");
    }
}

/// Velocities in other units, and many shots on one line, are the same shots.
#[test]
fn units_and_counts_do_not_matter() {
    let found = estimate(WU_TIAN);
    let scaled: Outcomes = Outcomes::new(outcomes(WU_TIAN).groups().iter().map(|group| Group {
        velocity: 3000.0 + 100.0 * group.velocity,
        perforated: 7 * group.perforated,
        stopped: 7 * group.stopped,
    }));
    let same = fit(&scaled).unwrap();
    near(same.mu, 3000.0 + 100.0 * found.mu, 1e-6);
    near(same.sigma, 100.0 * found.sigma, 1e-6);
    near(same.deviance(), 7.0 * found.deviance(), 1e-8);
}

fn bounds(text: &str, p: f64, level: f64) -> Bounds {
    let outcomes = outcomes(text);
    let found = fit(&outcomes).ok();
    interval(&outcomes, found.as_ref(), p, level)
}

#[track_caller]
fn ends(got: Bounds, expected: [f64; 2], tolerance: f64) {
    near(got.low.unwrap(), expected[0], tolerance);
    near(got.high.unwrap(), expected[1], tolerance);
}

#[test]
fn published_sets_give_the_published_intervals() {
    let all = format!("{WU_TIAN} {GONOGO}");
    ends(bounds(&all, 0.5, 0.9), [9.1593, 10.7550], 6e-5);
    // The published search stops at a log-likelihood within 1e-5: the fourth digit is not sure.
    ends(bounds(&all, 0.9, 0.9), [10.7655, 12.2565], 2e-4);
    ends(bounds(NEYER, 0.5, 0.95), [4.487, 6.530], 6e-4);
}

/// Where a constant chance explains the shots within the confidence, no velocity can be left out.
#[test]
fn few_shots_give_an_interval_without_an_end() {
    // 3 ln ½ − ln-likelihood of the fit is above −½ χ² at 99 %: both ends are open.
    assert_eq!(bounds("400/0 450/1 440/0 420/1 500/1", 0.5, 0.99), Bounds::default());
    // At 50 % it is not.
    let found = bounds("400/0 450/1 440/0 420/1 500/1", 0.5, 0.5);
    assert!(found.low.is_some() && found.high.is_some(), "{found:?}");
}

/// Three stops: at V50 = t below all, each had at most a chance of one half to be stopped; 2⁻³ is less than exp(−½ χ²).
#[test]
fn one_outcome_alone_bounds_the_limit_on_one_side() {
    let found = bounds("400/0 400/0 400/0", 0.5, 0.9);
    near(found.low.unwrap(), 400.0, 1e-6);
    assert_eq!(found.high, None);
    let found = bounds("400/1 400/1 400/1", 0.5, 0.9);
    near(found.high.unwrap(), 400.0, 1e-6);
    assert_eq!(found.low, None);
    // One shot is not enough: ½ is more than exp(−½ χ²) = 0.26.
    assert_eq!(bounds("400/0", 0.5, 0.9), Bounds::default());
}

/// The definition, at the ends of the interval of a quantile: the best likelihood there is less by half the quantile of χ².
#[test]
fn at_an_end_the_likelihood_has_fallen_by_half_of_chi_square() {
    let all = outcomes(&format!("{WU_TIAN} {GONOGO}"));
    let found = fit(&all).unwrap();
    for p in [0.1, 0.5, 0.9] {
        let bounds = interval(&all, Some(&found), p, 0.95);
        for t in [bounds.low.unwrap(), bounds.high.unwrap()] {
            let at = |sigma: f64| log_likelihood(&all, t - normal::quantile(p) * sigma, sigma);
            let best = (0..20_000).map(|n| at(0.1 * (3e-4 * f64::from(n)).exp())).fold(f64::NEG_INFINITY, f64::max);
            // 1.959964² = 3.841459.
            near(found.log_likelihood - best, 0.5 * 3.841459, 2e-6);
        }
    }
}

/// Lowest perforations and highest stops. A published set of 3 + 3 has the mean 1241.5 and the spread 478: its extremes are kept here.
#[test]
fn the_arithmetic_v50_takes_equally_many_close_perforations_and_stops() {
    let by = |text: &str, rule: usize| arithmetic_v50(&outcomes(text), VelocityUnit::default(), None)[rule].clone();
    let text = "480/0 500/0 505/0 512/0 508/1 515/1 520/1 560/1";
    let found = by(text, 1);
    assert_eq!((found.rule.as_str(), found.standard), ("3 + 3 within 38 m/s", "MIL-STD-662F"));
    near(found.value.unwrap(), (500.0 + 505.0 + 512.0 + 508.0 + 515.0 + 520.0) / 6.0, 1e-9);
    near(found.spread.unwrap(), 20.0, 1e-9);
    near(by(text, 0).value.unwrap(), (505.0 + 512.0 + 508.0 + 515.0) / 4.0, 1e-9);
    let wide = by("1000/0 1200/0 1250/0 1240/1 1281/1 1478/1", 1);
    assert_eq!((wide.value, wide.refused.as_deref()), (None, Some("spread 478 m/s, mean 1242 m/s")));
    // A spread that is just met is met.
    let within = |fastest: &str| by(&format!("400/0 410/0 420/0 425/1 430/1 {fastest}/1"), 1).value;
    assert!(within("438").is_some() && within("438.1").is_none());
    let few = by("400/0 410/0 430/1 432/1 434/1", 1);
    assert_eq!((few.spread, few.refused.as_deref()), (None, Some("perforations: 3, stops: 2")));
}

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
    let shot = |(impact, noise): (f64, f64)| Passed {
        impact,
        residual: (impact * impact - 300.0 * 300.0).sqrt() + noise,
        count: 1,
    };
    let shots = [(2000.0, 3.0), (2050.0, -2.0), (2100.0, 1.0), (2150.0, -4.0), (2200.0, 2.0)].map(shot);
    let found = residual_fit(ResidualModel::RechtIpson, &shots, 0.9).unwrap();
    // dVr/dV₀ = −V₀/Vr; t of 4 degrees of freedom at 90 % is 2.1318.
    let squares: f64 = shots.iter().map(|shot| (found.limit / found.residual(shot.impact)).powi(2)).sum();
    let sum: f64 = shots.iter().map(|shot| (shot.residual - found.residual(shot.impact)).powi(2)).sum();
    near(found.scatter, (sum / 4.0).sqrt(), 1e-6);
    let half = 2.1318 * found.scatter / squares.sqrt();
    near(found.bounds.high.unwrap() - found.bounds.low.unwrap(), 2.0 * half, 0.02 * half);
}

#[test]
fn intervals_of_lambert_and_jonas_hold_the_limit_as_often_as_they_say() {
    let ranges = 400;
    let is_held = |range: &u32| {
        let shot = |n: u32| {
            let drawn = DrawKey { seed: 3, shot: *range, element: n, ..DrawKey::default() }.uniform()[0];
            let impact = 300.0 + 15.0 * f64::from(n);
            let residual = 0.8 * (impact.powf(2.2) - 300_f64.powf(2.2)).powf(1.0 / 2.2);
            Passed { impact, residual: (residual + 8.0 * normal::quantile(drawn)).clamp(0.0, impact), count: 1 }
        };
        let shots: Vec<Passed> = (1..=10).map(shot).collect();
        holds(residual_fit(ResidualModel::LambertJonas, &shots, 0.9).unwrap().bounds, 300.0)
    };
    // Four standard errors of a share of 90 % among 400 are 6 %.
    let share = (0..ranges).filter(is_held).count() as f64 / f64::from(ranges);
    assert!((share - 0.9).abs() < 0.06, "{share}");
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
    for (model, shots, [least, found]) in
        [(ResidualModel::LambertJonas, &shots[..3], [4, 3]), (ResidualModel::RechtIpson, &[shots[0]; 5], [2, 1])]
    {
        let why = format!("needs {least} different velocities of shots that passed, there are {found}");
        assert_eq!(residual_fit(model, shots, 0.9), Err(why));
    }
}
