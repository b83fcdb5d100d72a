//! Ends of intervals.

use ripstop::num::link::Link;
use ripstop::study::binary_response::fit;
use ripstop::study::interval::{Bounds, Interval, interval};

use super::{GONOGO, NEYER, WU_TIAN, near, outcomes};

fn bounds(text: &str, kind: Interval, p: f64, level: f64) -> Bounds {
    let outcomes = outcomes(text);
    let found = fit(Link::Probit, &outcomes).ok();
    interval(kind, Link::Probit, &outcomes, found.as_ref(), p, level)
}

#[track_caller]
fn ends(got: Bounds, expected: [f64; 2], tolerance: f64) {
    near(got.low.unwrap(), expected[0], tolerance);
    near(got.high.unwrap(), expected[1], tolerance);
}

#[test]
fn published_sets_give_the_published_intervals() {
    let all = format!("{WU_TIAN} {GONOGO}");
    ends(bounds(&all, Interval::Wald, 0.5, 0.9), [9.4078, 10.9329], 6e-5);
    ends(bounds(&all, Interval::Likelihood, 0.5, 0.9), [9.1593, 10.7550], 6e-5);
    // The published search stops at a log-likelihood within 1e-5: the fourth digit is not sure.
    ends(bounds(&all, Interval::Likelihood, 0.9, 0.9), [10.7655, 12.2565], 2e-4);
    ends(bounds(NEYER, Interval::Likelihood, 0.5, 0.95), [4.487, 6.530], 6e-4);
}

/// Many shots at two velocities: V50 lies where both counts are alike, and the interval is that of two binomials. At V50 = t the best β
/// solves a line through (t, ½); here the symmetric pair makes both ends lie alike around the middle.
#[test]
fn a_symmetric_set_has_a_symmetric_interval() {
    let text = ["400/0"; 9].join(" ") + " 400/1 500/0 " + &["500/1"; 9].join(" ");
    let found = bounds(&text, Interval::Likelihood, 0.5, 0.9);
    near(found.low.unwrap() + found.high.unwrap(), 900.0, 1e-5);
    assert!(found.low.unwrap() > 400.0 && found.high.unwrap() < 500.0, "{found:?}");
}

/// Where a constant chance explains the shots within the confidence, no velocity can be left out.
#[test]
fn few_shots_give_an_interval_without_an_end() {
    // 3 ln ½ − ln-likelihood of the fit is above −½ χ² at 99 %: both ends are open.
    assert_eq!(bounds("400/0 450/1 440/0 420/1 500/1", Interval::Likelihood, 0.5, 0.99), Bounds::default());
    // At 50 % it is not.
    let found = bounds("400/0 450/1 440/0 420/1 500/1", Interval::Likelihood, 0.5, 0.5);
    assert!(found.low.is_some() && found.high.is_some(), "{found:?}");
}

/// Three stops: at V50 = t below all, each had at most a chance of one half to be stopped; 2⁻³ is less than exp(−½ χ²).
#[test]
fn one_outcome_alone_bounds_the_limit_on_one_side() {
    let found = bounds("400/0 400/0 400/0", Interval::Likelihood, 0.5, 0.9);
    near(found.low.unwrap(), 400.0, 1e-6);
    assert_eq!(found.high, None);
    let found = bounds("400/1 400/1 400/1", Interval::Likelihood, 0.5, 0.9);
    near(found.high.unwrap(), 400.0, 1e-6);
    assert_eq!(found.low, None);
    // One shot is not enough: ½ is more than exp(−½ χ²) = 0.26.
    assert_eq!(bounds("400/0", Interval::Likelihood, 0.5, 0.9), Bounds::default());
    assert_eq!(bounds("400/0 400/0 400/0", Interval::Wald, 0.5, 0.9), Bounds::default());
}

/// The definition, at the ends of the interval of a quantile: the best likelihood there is less by half the quantile of χ².
#[test]
fn at_an_end_the_likelihood_has_fallen_by_half_of_chi_square() {
    let all = outcomes(&format!("{WU_TIAN} {GONOGO}"));
    for link in [Link::Probit, Link::Logit] {
        let found = fit(link, &all).unwrap();
        for p in [0.1, 0.5, 0.9] {
            let bounds = interval(Interval::Likelihood, link, &all, Some(&found), p, 0.95);
            for t in [bounds.low.unwrap(), bounds.high.unwrap()] {
                let at = |sigma: f64| -> f64 {
                    let mu = t - link.quantile(p) * sigma;
                    let terms = all.groups().iter().map(|group| {
                        let eta = (group.velocity - mu) / sigma;
                        group.perforated as f64 * link.ln_probability(eta)
                            + group.stopped as f64 * link.ln_probability(-eta)
                    });
                    terms.sum()
                };
                let best = (0..20_000).map(|n| at(0.1 * (3e-4 * f64::from(n)).exp())).fold(f64::NEG_INFINITY, f64::max);
                // 1.959964² = 3.841459.
                near(found.log_likelihood - best, 0.5 * 3.841459, 2e-6);
            }
        }
    }
}
