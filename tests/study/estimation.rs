//! Maximum likelihood, Firth's penalty, refusals.

use ripstop::num::link::Link;
use ripstop::study::binary_response::{Estimate, Method, NoEstimate, fit};
use ripstop::study::outcomes::{Group, Outcomes};

use super::{GONOGO, NEYER, WU_TIAN, near, outcomes};

fn probit(text: &str) -> Estimate {
    fit(Link::Probit, &outcomes(text)).unwrap()
}

#[test]
fn published_sets_give_the_published_estimates() {
    let nine: Vec<&str> = WU_TIAN.split(' ').take(9).collect();
    let found = probit(&nine.join(" "));
    near(found.mu, 9.9726, 5e-5);
    near(found.sigma, 2.0705, 5e-5);
    // The published σ is R's, which stops when the deviance changes by less than 1e-8: 3e-5 from the maximum.
    let found = probit(&format!("{WU_TIAN} {GONOGO}"));
    near(found.mu, 10.17033, 5e-5);
    near(found.sigma, 0.93398, 5e-5);
    near(found.deviance(), 14.139, 5e-4);
    let found = probit(NEYER);
    near(found.mu, 5.39218, 6e-6);
    near(found.sigma, 1.04123, 6e-6);
}

/// The data of Collett (1991) in Venables & Ripley, section 7.2: budworms, 20 at each dose, one slope for both sexes. Males are put
/// on the scale of the females by the shift that fits best: then one line fits both.
#[test]
fn budworms_have_the_published_doses_and_standard_errors() {
    let female = [0, 2, 6, 10, 12, 16];
    let male = [1, 4, 9, 13, 18, 20];
    let groups = |dead: [u64; 6], shift: f64| {
        dead.into_iter().enumerate().map(move |(dose, dead)| Group {
            velocity: dose as f64 + shift,
            perforated: dead,
            stopped: 20 - dead,
        })
    };
    let with = |shift: f64| fit(Link::Logit, &Outcomes::new(groups(female, 0.0).chain(groups(male, shift)))).unwrap();
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let [a, b] = [low + 0.4 * (high - low), low + 0.6 * (high - low)];
        if with(a).log_likelihood < with(b).log_likelihood { low = a } else { high = b }
    }
    let shift = 0.5 * (low + high);
    let found = with(shift);
    for (p, dose, error) in [(0.25, 2.231265, 0.2499089), (0.5, 3.263587, 0.2297539), (0.75, 4.29591, 0.2746874)] {
        near(found.velocity(p), dose, 2e-6);
        near(standard_error(&found, p, [groups(female, 0.0).collect(), groups(male, shift).collect()]), error, 2e-6);
    }
}

/// Standard error of a dose of the first group, where the second has an intercept of its own: by the delta method.
fn standard_error(found: &Estimate, p: f64, [first, second]: [Vec<Group>; 2]) -> f64 {
    let sums = |groups: &[Group]| {
        groups.iter().fold([0.0; 3], |sum, group| {
            let w = group.count() as f64 * found.link.information((group.velocity - found.mu) / found.sigma);
            [sum[0] + w, sum[1] + w * group.velocity, sum[2] + w * group.velocity * group.velocity]
        })
    };
    let ([w, s, q], [w2, s2, q2]) = (sums(&first), sums(&second));
    let q = q + q2 - s2 * s2 / w2;
    let (x, determinant) = (found.velocity(p), w * q - s * s);
    found.sigma * ((q - 2.0 * x * s + x * x * w) / determinant).sqrt()
}

/// One sex alone has a line of its own. Held to the condition of a maximum, and to the expected information by hand.
#[test]
fn an_estimate_is_a_maximum_and_its_covariance_the_inverse_information() {
    for link in [Link::Probit, Link::Logit] {
        let outcomes = outcomes(&format!("{WU_TIAN} {GONOGO}"));
        let found = fit(link, &outcomes).unwrap();
        let likelihood = |mu: f64, sigma: f64| -> f64 {
            let term = |group: &Group| {
                let eta = (group.velocity - mu) / sigma;
                group.perforated as f64 * link.ln_probability(eta) + group.stopped as f64 * link.ln_probability(-eta)
            };
            outcomes.groups().iter().map(term).sum()
        };
        let (mu, sigma, h) = (found.mu, found.sigma, 1e-4);
        near(found.log_likelihood, likelihood(mu, sigma), 1e-12);
        near((likelihood(mu + h, sigma) - likelihood(mu - h, sigma)) / (2.0 * h), 0.0, 1e-6);
        near((likelihood(mu, sigma + h) - likelihood(mu, sigma - h)) / (2.0 * h), 0.0, 1e-6);
        let [[a, b], [_, c]] = found.covariance;
        for p in [0.1, 0.5, 0.9] {
            let z = link.quantile(p);
            near(found.standard_error(p).powi(2), a + 2.0 * z * b + z * z * c, 1e-12);
        }
        let mut product = [0.0; 3];
        for group in outcomes.groups() {
            let z = (group.velocity - mu) / sigma;
            let w = link.information(z) / (sigma * sigma);
            product[0] += w * (a + z * b);
            product[1] += w * (b + z * c);
            product[2] += w * z * (b + z * c);
        }
        near(product[0], 1.0, 1e-9);
        near(product[1], 0.0, 1e-9);
        near(product[2], 1.0, 1e-9);
    }
}

/// In the logistic case the penalty's gradient is that of Firth (1993): Σ (y − π + h (½ − π)) (1, v) = 0. Two shots have a closed form:
/// each is held halfway between its outcome and one half, π = ¾, so σ = half the distance over ln 3.
#[test]
fn without_overlap_firths_penalty_gives_the_estimate_and_says_so() {
    let found = fit(Link::Logit, &outcomes("400/0 500/1")).unwrap();
    assert_eq!(found.method, Method::Firth);
    near(found.mu, 450.0, 1e-9);
    near(found.sigma, 50.0 / 3.0_f64.ln(), 1e-7);
    let outcomes = outcomes("400/0 430/0 445/0 460/1 500/1");
    assert!(!outcomes.overlap());
    let found = fit(Link::Logit, &outcomes).unwrap();
    let eta = |velocity: f64| (velocity - found.mu) / found.sigma;
    let info = |of: fn(f64) -> f64| -> f64 {
        outcomes
            .groups()
            .iter()
            .map(|group| Link::Logit.information(eta(group.velocity)) * of(eta(group.velocity)))
            .sum()
    };
    let (s0, s1, s2) = (info(|_| 1.0), info(|z| z), info(|z| z * z));
    let mut score = [0.0; 2];
    for group in outcomes.groups() {
        let z = eta(group.velocity);
        let (pi, y) = (Link::Logit.probability(z), group.perforated as f64);
        let leverage = Link::Logit.information(z) * (s2 - 2.0 * z * s1 + z * z * s0) / (s0 * s2 - s1 * s1);
        let residual = y - pi + leverage * (0.5 - pi);
        score[0] += residual;
        score[1] += residual * z;
    }
    near(score[0], 0.0, 1e-9);
    near(score[1], 0.0, 1e-9);
}

#[test]
fn shots_that_tell_nothing_are_refused_with_the_reason() {
    for (text, why) in [
        ("", NoEstimate::NoShots),
        ("400/0 450/0 500/0", NoEstimate::AllStopped),
        ("400/1 450/1", NoEstimate::AllPerforated),
        ("400/1 400/0 400/1", NoEstimate::OneVelocity),
        ("400/1 450/0", NoEstimate::Inverted),
        ("400/1 450/0 500/0 500/1", NoEstimate::Inverted),
        // Perforations and stops of the same mean velocity: σ is infinite.
        ("400/1 450/0 500/1", NoEstimate::Inverted),
    ] {
        for link in [Link::Probit, Link::Logit] {
            assert_eq!(fit(link, &outcomes(text)), Err(why), "{text}");
        }
    }
}

/// Velocities in other units, and many shots on one line, are the same shots.
#[test]
fn units_and_counts_do_not_matter() {
    let found = probit(WU_TIAN);
    let scaled: Outcomes = Outcomes::new(outcomes(WU_TIAN).groups().iter().map(|group| Group {
        velocity: 3000.0 + 100.0 * group.velocity,
        perforated: 7 * group.perforated,
        stopped: 7 * group.stopped,
    }));
    let same = fit(Link::Probit, &scaled).unwrap();
    near(same.mu, 3000.0 + 100.0 * found.mu, 1e-6);
    near(same.sigma, 100.0 * found.sigma, 1e-6);
    near(same.deviance(), 7.0 * found.deviance(), 1e-8);
    near(same.standard_error(0.9), 100.0 * found.standard_error(0.9) / 7.0_f64.sqrt(), 1e-6);
}
