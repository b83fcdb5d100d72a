//! How often the intervals from thresholds hold the truth: 10 000 synthetic campaigns.

use rayon::prelude::*;
use ripstop::num::link::Link;
use ripstop::num::random::DrawKey;
use ripstop::study::v50::sample::ThresholdSample;
use ripstop::study::v50::threshold::{FurtherShots, Rungs, ThresholdSearch, Wanted, middle};

/// Name, realisations, width of a bracket, and thresholds by quantile.
type Row<'a> = (&'a str, u32, f64, &'a (dyn Fn(f64) -> f64 + Sync));

/// Campaigns of each row.
const CAMPAIGNS: u32 = 10_000;
const LEVEL: f64 = 0.9;
const MU: f64 = 190.0;

/// Whether the intervals of V50 and V90 hold the truth; thresholds by quantile of a distribution, bisected.
fn campaign(number: u32, row: u32, count: u32, width: f64, threshold: impl Fn(f64) -> f64) -> [bool; 2] {
    let rungs = Rungs { width };
    let mut middles = Vec::new();
    let mut bracket = 0.0;
    for realisation in 0..count {
        let [u, ..] = DrawKey { seed: 11, shot: number, ply: row, yarn: realisation, element: 0 }.uniform();
        let threshold = threshold(u);
        let mut search = ThresholdSearch::new(rungs, MU, 4, FurtherShots { beside: true, beyond: &[] });
        while let Wanted::Shot(rung) = search.wanted() {
            search.see(rung, rungs.velocity(rung) > threshold);
        }
        let [low, high] = search.bracket().unwrap();
        middles.push(middle([low, high]));
        bracket += (high - low) / f64::from(count);
    }
    let sample = ThresholdSample::new(&middles, bracket).unwrap();
    [0.5, 0.9].map(|p| sample.interval(p, LEVEL).holds(threshold(p)))
}

#[test]
fn intervals_from_thresholds_hold_the_truth_as_often_as_the_book_says() {
    let mut table =
        "| thresholds | realisations | width of a bracket | V50 held % | V90 held % |\n|---|---|---|---|---|\n"
            .to_owned();
    let normal = |sigma: f64| move |u: f64| MU + sigma * Link::Probit.quantile(u);
    let weibull = |u: f64| MU * (-(1.0 - u).ln()).powf(1.0 / 12.0);
    let rows: [Row<'_>; 5] = [
        ("normal, σ 4 %", 8, 0.005, &normal(7.6)),
        ("normal, σ 4 %", 32, 0.005, &normal(7.6)),
        ("normal, σ 1 %", 8, 0.005, &normal(1.9)),
        ("normal, σ 0.3 %", 8, 0.005, &normal(0.57)),
        ("Weibull, m = 12", 16, 0.005, &weibull),
    ];
    for (row, (name, count, width, threshold)) in (0_u32..).zip(rows) {
        let held: Vec<[bool; 2]> =
            (0..CAMPAIGNS).into_par_iter().map(|number| campaign(number, row, count, width, threshold)).collect();
        let share = |which: usize| 100.0 * held.iter().filter(|held| held[which]).count() as f64 / f64::from(CAMPAIGNS);
        let [v50, v90] = [share(0), share(1)];
        table += &format!("| {name} | {count} | {} % | {v50:.1} | {v90:.1} |\n", 100.0 * width);
        // Normal and wider than a bracket: nominal within three standard errors of 10 000.
        if row < 3 {
            assert!((v50 - 90.0).abs() < 1.2, "{name}, {count}: {v50}");
            assert!((v90 - 90.0).abs() < 3.0, "{name}, {count}: {v90}");
        }
        // The mean of a skewed distribution is not its median: honest within some per cent where it is nearly normal.
        if row == 4 {
            assert!(v50 > 80.0, "{name}: {v50}");
        }
    }
    crate::docs::hold("coverage of intervals from thresholds, 10 000 synthetic campaigns", &table);
}
