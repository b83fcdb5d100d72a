#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use std::sync::atomic::AtomicBool;

use super::*;
use crate::output::checks::{Level, checks};
use crate::run::{self, Options};
use crate::solver::FailureEvent;

/// A 20 × 20 mm ply of S-720 (1.27 mm a crossover: 16 × 16) with this number of elements a crossover.
fn ply(mesh: &str) -> PlyLayout {
    let text = format!(
        r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 1}},
            "pack": {{"width_mm": 20.32, "height_mm": 20.32, {mesh}}}}}"#
    );
    let case = crate::case::from_str("t", &text, &[]).unwrap();
    PlyLayout::new(&case, &case.layers()[0])
}

#[test]
fn elements_of_a_crossover_are_one_yarn_and_an_element_of_several_has_several() {
    let fine = ply(r#""elements_per_crossover": 2"#);
    assert_eq!((fine.yarns(1, 0), fine.yarns(1, 1), fine.yarns(1, 2)), (0..1, 0..1, 1..2));
    // Lines of a mesh around a hit lie anywhere in a yarn.
    let shifted = PlyLayout { lines: [vec![0.0, 0.7, 1.2, 1.7], vec![0.0]], ..fine };
    assert_eq!((shifted.yarns(0, 0), shifted.yarns(0, 1), shifted.yarns(0, 2)), (0..1, 0..1, 1..2));
    let coarse = ply(r#""crossovers_per_element": 4"#);
    assert_eq!((coarse.yarns(0, 0), coarse.yarns(0, 3)), (0..4, 12..16));
}

#[test]
fn places_are_at_the_edge_or_so_far_from_the_hit() {
    let even = ply(r#""elements_per_crossover": 1"#);
    let at_edge = |ply: &PlyLayout, element| ply.is_at_edge(element, |_| true);
    assert!(at_edge(&even, [0, 8]) && at_edge(&even, [1, 8]) && at_edge(&even, [8, 15]));
    assert!(!at_edge(&even, [2, 8]) && !at_edge(&even, [8, 13]));
    // An element of four crossovers lies at the edge too.
    let coarse = ply(r#""crossovers_per_element": 4"#);
    assert!(at_edge(&coarse, [0, 1]) && at_edge(&coarse, [2, 3]) && !at_edge(&coarse, [1, 2]));
    // The middle of the element beside the centre is half a crossover off both ways.
    assert!((even.distance([8, 8], [0.0, 0.0]) - 0.635e-3 * 2.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn fabric_that_tears_off_its_frame_before_it_breaks_at_the_hit_is_warned_of() {
    let sets =
        ["/pack/width_mm=30", "/pack/height_mm=30", "/solver/end_time_us=1", "/solver/numerics=paper", "/expect=[]"];
    let case = crate::case::shipped(&sets);
    let run = run::run(&case, Options::default(), &AtomicBool::new(false), &mut ()).unwrap();
    let middle = [case.pack.columns as u32 / 2, case.pack.rows as u32 / 2];
    let hit = |step| FailureEvent { step, ply: 0, i: middle[0], j: middle[1], yarn: 0, strain: 0.04 };
    let edge = |step| FailureEvent { i: 0, ..hit(step) };
    let with = |outcome: Outcome, events: &[FailureEvent]| {
        let mut run = run.clone();
        (run.outcome, run.events) = (outcome, events.to_vec());
        let check = checks(&case, &run).into_iter().find(|check| check.name == "broken at the edges").unwrap();
        let warned = check.warning.is_some_and(|warning| warning.kind.code == "W8");
        assert_eq!(check.level, if warned { Level::Look } else { Level::Fine });
        (warned, check.value)
    };
    assert_eq!(with(Outcome::Stopped, &[]), (false, "0".to_owned()));
    assert_eq!(with(Outcome::Stopped, &[hit(1), edge(2)]), (false, "1".to_owned()));
    assert_eq!(with(Outcome::Stopped, &[hit(1), edge(2), edge(3)]), (true, "2".to_owned()));
    // What breaks behind a projectile that is through decides nothing.
    assert_eq!(with(Outcome::Perforated, &[hit(1), edge(2), edge(3)]), (false, "0".to_owned()));
    assert_eq!(with(Outcome::Perforated, &[edge(2), edge(3), hit(4), edge(5)]), (true, "2".to_owned()));
    // No frame is there to tear off where a side is free.
    let free = crate::case::shipped(&[&sets[..], &[r#"/pack/edges={"left": "free"}"#]].concat());
    let broken = Breakage::of(&free, &Run { events: vec![hit(1), edge(2), edge(3)], ..run.clone() });
    assert_eq!((broken.at_edges, broken.torn_off), (2, 0));
}
