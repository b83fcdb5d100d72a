//! `verify --stress`: the list, the long run and some random scenes, on the processor in both precisions.
//!
//! Promised: no number that is not finite, no unit cell without equilibrium, no panic, a ledger that closes, no energy that nobody put
//! in; what is impossible is named. Red when: the judge finds one of these (as it did with a midpoint rule for spin and with an
//! energy scale that forgot the hourglass energy of a bent ply), or when it finds nothing where it must.

use std::sync::atomic::AtomicBool;

use ripstop::run::Precision;
use ripstop::study::verify::stress::{self, Report, SceneNumbers, StressBackend, StressPlan};

const BOTH: [StressBackend<'static>; 2] = [StressBackend::Cpu(Precision::F64), StressBackend::Cpu(Precision::F32)];

fn run(plan: &StressPlan<'_>) -> Report {
    stress::run(plan, &AtomicBool::new(false), &|_, _, _| {})
}

fn random(scenes: u64, threads: usize) -> StressPlan<'static> {
    StressPlan {
        machines: BOTH.to_vec(),
        scenes: SceneNumbers::First(scenes),
        steps: 0,
        seed: 1,
        threads: Some(threads),
        list: false,
    }
}

#[track_caller]
fn assert_sound(report: &Report) {
    let failed: Vec<_> = report.rows.iter().filter(|row| !row.pass).collect();
    assert!(failed.is_empty() && report.found.is_empty(), "{failed:#?} {:#?}", report.found);
}

#[test]
fn the_list_and_a_shorter_long_run_are_sound() {
    let report = run(&StressPlan { steps: 20_000, list: true, ..random(0, 2) });
    assert_sound(&report);
    let of = |group: &str| report.rows.iter().filter(|row| row.group == group).count();
    assert!(of("stress, cpu f64") >= 28 && of("stress, cpu f64") == of("stress, cpu f32"), "{:#?}", report.rows);
}

#[test]
fn fifty_random_scenes_are_sound_and_few_are_refused() {
    let report = run(&random(50, 2));
    assert_sound(&report);
    assert!(report.refused.len() <= 6, "{:?}", report.refused);
    assert_eq!(report.rows.len(), 2);
}

#[test]
fn threads_and_time_do_not_change_the_report() {
    let [one, two] = [1, 3].map(|threads| run(&random(12, threads)));
    assert_eq!(one.rows, two.rows);
    assert_eq!(one.refused, two.refused);
}

#[test]
fn an_interrupt_leaves_no_verdict() {
    let report = stress::run(&random(12, 2), &AtomicBool::new(true), &|_, _, _| {});
    assert!(report.rows.is_empty() && report.found.is_empty());
}
