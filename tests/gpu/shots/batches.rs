//! The same bits every time, and for every batch length.

use ripstop::gpu::Device;
use ripstop::run::{Run, Skips};

use super::{Outcome, Tests, run_in_batches, run_on, simulated};
use crate::kept::result;
use crate::scene::builtin;

pub(super) const TESTS: Tests = &[
    ("a_run_gives_the_same_bits_again", again),
    ("the_batch_length_does_not_matter", lengths),
    ("what_is_left_at_rest_changes_no_bit", front),
];

/// 1280 elements struck at 300 m/s, with failures, friction, rotation, and profiles on and between samples.
fn shot() -> ripstop::case::Case {
    let sets = ["/output/profile_times_us=[10,30.03,50]", "/output/history_interval_us=0.7"];
    builtin("cases/verify/mirror.json", &sets)
}

#[track_caller]
fn equal(one: &Run, two: &Run, what: &str) {
    let [one, two] = [one, two].map(|run| result(&shot(), run));
    for (one, two) in one.iter().zip(&two) {
        assert_eq!(one, two, "{what}");
    }
    assert_eq!(one.len(), two.len(), "{what}");
}

/// Every row and every failure, every digit.
#[track_caller]
pub(super) fn equal_rows(one: &Run, two: &Run, what: &str) {
    assert_eq!(one.events, two.events, "{what}");
    for (one, two) in one.history.iter().zip(&two.history) {
        assert_eq!(format!("{one:?}"), format!("{two:?}"), "{what}");
    }
    assert_eq!(one.history.len(), two.history.len(), "{what}");
}

/// A long strip: the wave takes most of the run to its ends. Yarns break in the middle meanwhile.
fn front(device: &'static Device) -> Outcome {
    let sets =
        ["/pack/width_mm=30", "/projectile/velocity_m_s=400", "/solver/end_time_us=16", "/output/profile_times_us=[]"];
    let case = builtin("cases/s720-1ply-155.json", &sets);
    let [part, whole] =
        [false, true].map(|whole| simulated(device, &case, Skips { wavefront: !whole, ..Skips::WHOLE }));
    assert!(part.events.len() > 10, "{}", part.events.len());
    equal_rows(&part, &whole, "the whole strip");
    assert_eq!(whole.element_steps_computed, whole.steps * whole.elements as u64);
    let saved = 1.0 - part.element_steps_computed as f64 / whole.element_steps_computed as f64;
    assert!(saved > 0.25, "{saved}");
    Ok(())
}

fn again(device: &'static Device) -> Outcome {
    let run = run_on(device, &shot());
    assert!(run.events.len() > 20 && run.profiles.len() == 3, "{} {}", run.events.len(), run.profiles.len());
    equal(&run, &run_on(device, &shot()), "the second time");
    Ok(())
}

fn lengths(device: &'static Device) -> Outcome {
    let one = run_in_batches(device, &shot(), 1);
    for steps in [7, 64, 256] {
        equal(&one, &run_in_batches(device, &shot(), steps), &format!("batches of {steps} steps"));
    }
    equal(&one, &run_on(device, &shot()), "batches of the run's own choice");
    Ok(())
}
