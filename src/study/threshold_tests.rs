use super::*;

const RUNGS: Rungs = Rungs { width: 0.005 };

/// Bracket that a search from here finds, and how many shots it takes.
fn found(begin: f64, step: i32, perforates: impl Fn(f64) -> bool) -> (Option<[f64; 2]>, usize) {
    let mut count = 0;
    let found = bracket(RUNGS, RUNGS.nearest(begin), step, |rung| {
        count += 1;
        assert!(count < 60);
        Ok(perforates(RUNGS.velocity(rung)))
    });
    (found.ok().map(|ends| ends.map(|rung| RUNGS.velocity(rung))), count)
}

#[test]
fn a_threshold_does_not_depend_on_where_its_search_begins() {
    for threshold in [7.3, 184.2, 455.0, 2100.0] {
        let (bracket, _) = found(100.0, 20, |velocity| velocity > threshold);
        assert!(bracket.is_some_and(|[low, high]| low <= threshold && threshold < high && high / low < 1.0052));
        for (begin, step) in [(90.0, 1), (184.0, 4), (700.0, 50), (threshold, 1)] {
            let (other, count) = found(begin, step, |velocity| velocity > threshold);
            assert!(other == bracket, "{threshold} {begin}");
            assert!(begin != threshold || count <= 4, "{count} shots from the threshold itself");
        }
    }
    assert_eq!(found(100.0, 20, |_| false).0, None);
}

/// Threshold of realisation 3 or 9 by replays, and the rungs that were fired.
fn replayed(realisation: u32, perforates: impl Fn(f64) -> bool) -> (FoundThreshold, Vec<i32>) {
    let mut fired: Vec<ShotOrder> = Vec::new();
    loop {
        let outcome = |_: usize, order: ShotOrder| {
            let velocity = order.velocity.unwrap_or_default();
            fired.contains(&order).then(|| Ok(Shot { velocity, perforated: perforates(velocity) }))
        };
        match threshold(realisation, RUNGS, Start { velocity: 170.0, step: 4 }, false, outcome) {
            Ok(found) => {
                let rungs = fired.iter().map(|order| RUNGS.nearest(order.velocity.unwrap_or_default()));
                return (found, rungs.collect());
            }
            Err((_, order)) => fired.push(order),
        }
    }
}

#[test]
fn further_shots_lie_beside_the_bracket_and_of_the_first_realisations_beyond() {
    let (found, rungs) = replayed(9, |velocity| velocity > 184.2);
    let ends = found.bracket.map(|ends| ends.map(|velocity| RUNGS.nearest(velocity)));
    let Ok([low, high]) = ends else { unreachable!("there is a threshold") };
    assert!([low - BESIDE, high + BESIDE].iter().all(|beside| rungs.contains(beside)), "{rungs:?}");
    let (_, more) = replayed(3, |velocity| velocity > 184.2);
    assert_eq!(more[..rungs.len()], rungs);
    let beyond = more[rungs.len()..].iter().map(|rung| RUNGS.velocity(*rung) / 184.2);
    assert!(beyond.zip(FURTHER.1).all(|(got, part)| (got / part - 1.0).abs() < 0.01) && more.len() == rungs.len() + 2);
}

#[test]
fn an_outcome_that_turns_back_is_seen() {
    assert!(!replayed(9, |velocity| velocity > 184.0 && !(186.5..187.5).contains(&velocity)).0.monotone);
    assert!(replayed(9, |velocity| velocity > 190.0).0.monotone);
}

#[test]
fn pairs_give_their_mean_ratio_and_students_interval() {
    let pairs = [[100.0, 103.0], [200.0, 202.0], [50.0, 51.0], [80.0, 83.2]];
    let Some(found) = Refinement::new(&pairs) else { unreachable!("there are pairs") };
    assert!((found.ratio - 1.025).abs() < 1e-12 && found.count == 4);
    let sigma = ((0.005_f64.powi(2) * 2.0 + 0.015_f64.powi(2) * 2.0) / 3.0).sqrt();
    assert!((found.sigma - sigma).abs() < 1e-12, "{found:?}");
    // Student's t of three degrees of freedom at 90 %: 2.353.
    assert!((found.half_width(0.9) - 1.5 * 2.353_363 * sigma / 2.0).abs() < 1e-6, "{}", found.half_width(0.9));
}

#[test]
fn one_pair_has_a_ratio_alone() {
    let found = Refinement::new(&[[180.0, 185.4]]);
    assert_eq!(found.map(|found| (found.count, found.half_width(0.9))), Some((1, 0.0)));
    // 180, 185.4, and 190.8 if the error is of first order: the middle of the last two, and half of what is between them.
    assert!(found.is_some_and(|found| (180.0 * found.factor() - 188.1).abs() < 1e-9));
    assert!(found.is_some_and(|found| (180.0 * found.open() - 2.7).abs() < 1e-9));
    assert_eq!(Refinement::new(&[]), None);
}

#[test]
fn the_interval_of_the_mean_is_students() {
    let thresholds = [181.0, 184.5, 190.2, 186.1, 179.4, 188.8, 185.0];
    let Some(sample) = ThresholdSample::new(&thresholds, 0.0) else { unreachable!("there are thresholds") };
    let half = student_t(0.9, 6) * sample.sigma / 7.0_f64.sqrt();
    let bounds = sample.interval(0.5, 0.9);
    let off = |end: Option<f64>, expected: f64| end.is_none_or(|end| (end - expected).abs() > 1e-5);
    assert!(!off(bounds.low, sample.mean - half) && !off(bounds.high, sample.mean + half), "{bounds:?} {half}");
    assert!(sample.interval(0.9, 0.9).high > bounds.high && sample.interval(0.5, 0.99).low < bounds.low);
}

#[test]
fn brackets_alone_are_no_scatter() {
    let sample = ThresholdSample::new(&[99.5, 100.5, 99.5, 100.5], 2.0 * 3.0_f64.sqrt());
    assert!(sample.is_some_and(|sample| sample.sigma < 0.6));
    assert!(ThresholdSample::new(&[], 1.0).is_none());
    let one = ThresholdSample::new(&[100.0], 1.0);
    assert!(one.is_some_and(|one| one.interval(0.5, 0.9) == Bounds::default() && one.probability(101.0) == 1.0));
}
