//! How often intervals hold the truth: 6000 synthetic ranges, and the table that the book shows.

use rayon::prelude::*;
use ripstop::num::link::Link;
use ripstop::num::random::DrawKey;
use ripstop::study::binary_response::fit;
use ripstop::study::interval::{Interval, interval};
use ripstop::study::outcomes::{Outcomes, Shot};

/// Scatter of the thresholds [m/s]; V50 lies evenly between 480 and 520.
const SIGMA: f64 = 20.0;
/// Ranges of each row.
const RANGES: u32 = 1000;
const LEVEL: f64 = 0.9;

/// Chooser of the next velocity [m/s] from the shots so far and how many there will be.
type Design = fn(&[Shot], usize) -> f64;

const DESIGNS: [(&str, Design); 3] = [
    ("evenly from 460 to 540 m/s", |shots, count| 460.0 + 80.0 * shots.len() as f64 / (count - 1) as f64),
    ("Langlie", |shots, _| langlie(shots)),
    ("up and down", |shots, _| match shots.last() {
        None => 500.0,
        Some(shot) if shot.perforated => shot.velocity - SIGMA,
        Some(shot) => shot.velocity + SIGMA,
    }),
];

/// Langlie's one-shot design (1962) between 420 and 580 m/s: halfway to the shot that balances the last outcomes, or to a limit.
fn langlie(shots: &[Shot]) -> f64 {
    let Some(last) = shots.last() else { return 500.0 };
    let mut balance = 0;
    for shot in shots.iter().rev() {
        balance += if shot.perforated { 1 } else { -1 };
        if balance == 0 {
            return 0.5 * (last.velocity + shot.velocity);
        }
    }
    0.5 * (last.velocity + if last.perforated { 420.0 } else { 580.0 })
}

/// What became of one range: whether there was an estimate, whether it needed Firth's penalty, which intervals held the truth.
#[derive(Clone, Copy, Default)]
struct Range {
    estimate: bool,
    firth: bool,
    open: bool,
    /// V50 by likelihood and by Wald, V90 by both.
    held: [bool; 4],
}

fn range(number: u32, row: usize, design: Design, count: usize) -> Range {
    let key = |element: u32| DrawKey { seed: 25, shot: number, ply: row as u32, yarn: 0, element };
    let mu = 500.0 + 40.0 * (key(DrawKey::WHOLE).uniform()[0] - 0.5);
    let mut shots: Vec<Shot> = Vec::new();
    for n in 0..count {
        let velocity = design(&shots, count);
        let threshold = mu + SIGMA * Link::Probit.quantile(key(n as u32).uniform()[0]);
        shots.push(Shot { velocity, perforated: velocity > threshold });
    }
    let outcomes: Outcomes = shots.iter().collect();
    let Ok(found) = fit(Link::Probit, &outcomes) else { return Range::default() };
    let truth = |p: f64| mu + SIGMA * Link::Probit.quantile(p);
    let mut open = false;
    let held = [(Interval::Likelihood, 0.5), (Interval::Wald, 0.5), (Interval::Likelihood, 0.9), (Interval::Wald, 0.9)]
        .map(|(kind, p)| {
            let bounds = interval(kind, Link::Probit, &outcomes, Some(&found), p, LEVEL);
            open |= bounds.low.is_none() || bounds.high.is_none();
            bounds.holds(truth(p))
        });
    Range { estimate: true, firth: !outcomes.overlap(), open, held }
}

fn percent(count: usize, of: usize) -> f64 {
    100.0 * count as f64 / of as f64
}

#[test]
fn intervals_hold_the_truth_as_often_as_the_book_says() {
    let mut table =
        "| design | shots | no overlap % | open % | V50, likelihood | V50, Wald | V90, likelihood | V90, Wald |\n\
                     |---|---|---|---|---|---|---|---|\n"
            .to_owned();
    // The number of a row is part of the key of its draws.
    for (first, count) in [(1, 12), (6, 30)] {
        for (row, (name, design)) in (first..).zip(DESIGNS) {
            let ranges: Vec<Range> = (0..RANGES).into_par_iter().map(|n| range(n, row, design, count)).collect();
            let with: Vec<&Range> = ranges.iter().filter(|range| range.estimate).collect();
            let share =
                |of: &dyn Fn(&Range) -> bool| percent(with.iter().filter(|range| of(range)).count(), with.len());
            let held = [0, 1, 2, 3].map(|kind| share(&|range| range.held[kind]));
            let [v50, v50_wald, v90, v90_wald] = held;
            table += &format!(
                "| {name} | {count} | {:.0} | {:.0} | {v50:.0} | {v50_wald:.0} | {v90:.0} | {v90_wald:.0} |\n",
                share(&|range| range.firth),
                share(&|range| range.open)
            );
            assert!(with.len() > RANGES as usize * 98 / 100, "{name}: {} estimates", with.len());
            // Likelihood ratios are the default because the others are too short.
            assert!(v50 > v50_wald - 1.5 && v90 > v90_wald, "{name}, {count}: {held:?}");
            assert!((77.0..98.0).contains(&v50) && (77.0..98.0).contains(&v90), "{name}, {count}: {held:?}");
            // Velocities that do not depend on outcomes: what theory promises, within three standard errors and the bias of few shots.
            if row == 6 {
                assert!((v50 - 90.0).abs() < 4.0 && (v90 - 90.0).abs() < 4.0, "{name}, {count}: {held:?}");
            }
        }
    }
    crate::docs::hold("coverage of intervals, 6000 synthetic ranges", &table);
}
