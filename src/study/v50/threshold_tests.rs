use super::*;

const RUNGS: Rungs = Rungs { width: 0.005 };

/// The bracket that a search from here finds, and how many shots it takes.
fn found(begin: f64, step: i32, perforates: impl Fn(f64) -> bool) -> (Option<[f64; 2]>, usize, bool) {
    let mut search = ThresholdSearch::new(RUNGS, begin, step, FurtherShots { beside: true, beyond: &[] });
    while let Wanted::Shot(rung) = search.wanted() {
        search.see(rung, perforates(RUNGS.velocity(rung)));
        assert!(search.seen.len() < 60);
    }
    (search.bracket(), search.seen.len(), search.is_monotone())
}

#[test]
fn a_threshold_does_not_depend_on_where_its_search_begins() {
    for threshold in [7.3, 184.2, 455.0, 2100.0] {
        let (bracket, ..) = found(100.0, 20, |velocity| velocity > threshold);
        assert!(bracket.is_some_and(|[low, high]| low <= threshold && threshold < high && high / low < 1.0052));
        for (begin, step) in [(90.0, 1), (184.0, 4), (700.0, 50), (threshold, 1)] {
            let (other, count, monotone) = found(begin, step, |velocity| velocity > threshold);
            assert!(other == bracket && monotone, "{threshold} {begin}");
            assert!(begin != threshold || count <= 6, "{count} shots from the threshold itself");
        }
    }
    assert_eq!(found(100.0, 20, |_| false).0, None);
}

#[test]
fn further_shots_are_those_asked_for() {
    let shots = |further: FurtherShots| {
        let mut search = ThresholdSearch::new(RUNGS, 184.0, 1, further);
        let mut rungs = Vec::new();
        while let Wanted::Shot(rung) = search.wanted() {
            search.see(rung, RUNGS.velocity(rung) > 184.2);
            rungs.push(rung);
        }
        rungs
    };
    let none = shots(FurtherShots::NONE);
    let beside = shots(FurtherShots { beside: true, beyond: &[] });
    let all = shots(FurtherShots { beside: true, beyond: &[1.5] });
    assert_eq!(beside.len(), none.len() + 2);
    assert_eq!(all[..beside.len()], beside);
    assert!((RUNGS.velocity(all[beside.len()]) / 184.2 - 1.5).abs() < 0.01, "{all:?}");
}

#[test]
fn an_outcome_that_turns_back_is_seen() {
    let island = |velocity: f64| (184.0..186.0).contains(&velocity) || velocity > 190.0;
    assert!(!found(170.0, 1, |velocity| velocity > 184.0 && !(186.5..187.5).contains(&velocity)).2);
    assert!(!found(170.0, 16, island).2 || !found(184.5, 1, island).2);
    assert!(found(170.0, 4, |velocity| velocity > 190.0).2);
}
