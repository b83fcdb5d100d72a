use super::*;

const DT: f64 = 1e-6;

/// Steps kept of a run.
fn kept(wanted: usize, end_time: f64, steps: u64) -> Vec<u64> {
    let mut schedule = Schedule::new(wanted, end_time);
    (0..=steps).for_each(|step| schedule.pass(step, DT));
    schedule.kept().collect()
}

#[test]
fn at_any_time_between_as_many_as_asked_for_and_twice_as_many_lie_evenly() {
    for steps in 64..=4000 {
        let kept = kept(61, 4e-3, steps);
        assert!((61..=121).contains(&kept.len()), "{} after {steps} steps", kept.len());
        let gap = kept[1] - kept[0];
        assert_eq!(kept[0], 0);
        assert!(kept.windows(2).all(|pair| pair[1] - pair[0] <= gap + 1 && pair[1] - pair[0] + 1 >= gap), "{kept:?}");
        assert!(steps - kept[kept.len() - 1] <= gap + 1, "the last of {steps}: {kept:?}");
    }
}

#[test]
fn a_run_that_reaches_its_end_time_has_frames_at_the_times_of_that() {
    for (wanted, steps) in [(2, 60), (6, 60), (6, 6), (13, 60), (61, 60), (200, 60)] {
        let steps_kept = kept(wanted, steps as f64 * DT, steps);
        let times: Vec<f64> = steps_kept.iter().map(|step| *step as f64 * DT).collect();
        let chosen: Vec<u64> = even(&times, wanted).iter().map(|at| steps_kept[*at]).collect();
        let ideal = |number: usize| (number as f64 * steps as f64 / (wanted - 1) as f64).round() as u64;
        let mut expected: Vec<u64> = (0..wanted).map(ideal).collect();
        expected.dedup();
        let off = chosen.iter().zip(&expected).map(|(got, expected)| got.abs_diff(*expected)).max();
        assert_eq!((chosen.len(), off <= Some(1)), (expected.len(), true), "{chosen:?}");
    }
    assert_eq!(kept(1, 60e-6, 60), [0]);
    assert!(kept(0, 60e-6, 60).is_empty());
}

#[test]
fn what_is_chosen_begins_and_ends_with_the_run_and_is_as_many_as_asked_for() {
    let times: Vec<f64> = (0..97).map(f64::from).chain([96.3]).collect();
    for wanted in 2..=98 {
        let chosen = even(&times, wanted);
        assert_eq!((chosen.len(), chosen[0], chosen[wanted - 1]), (wanted, 0, 97));
        assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]), "{chosen:?}");
    }
    assert_eq!(even(&times, 3), [0, 48, 97]);
    assert_eq!((even(&times, 1), even(&times, 0), even(&times[..2], 3)), (vec![0], vec![], vec![0, 1]));
}

#[test]
fn a_schedule_that_goes_on_keeps_what_the_whole_run_keeps() {
    let dt = 1e-6;
    let on = |mut schedule: Schedule, from: u64| {
        (from..100).for_each(|step| schedule.pass(step, dt));
        schedule.kept().collect::<Vec<_>>()
    };
    for (frames, end_time) in [(1, 60e-6), (2, 60e-6), (13, 60.5e-6), (200, 60e-6), (7, 1.0)] {
        let whole = on(Schedule::new(frames, end_time), 0);
        assert_eq!(whole[0], 0);
        for step in 0..100 {
            assert_eq!(on(Schedule::resume(frames, end_time, step, dt), step), whole, "{frames} frames, step {step}");
        }
    }
}
