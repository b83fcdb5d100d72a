use super::*;
use crate::case;

/// The projectile of the README's shot, with another velocity [m/s].
fn body(velocity: [f64; 3]) -> RigidBody {
    let model = Model::<f64>::new(&case::shipped(&[])).unwrap_or_else(|error| unreachable!("{error}"));
    let Some(body) = model.projectile.clone() else { unreachable!("there is one") };
    RigidBody { velocity: velocity.into(), ..body }
}

#[test]
fn a_pack_is_quiet_below_a_thousandth_of_what_a_patch_of_twenty_radii_takes() {
    let body = body([0.0, 0.0, 100.0]);
    let patch = 0.2 * std::f64::consts::PI * (20.0 * body.body.radius).powi(2);
    for mass in [1e-3 * patch, 1e3 * patch] {
        let quiet = Tracker::new(&body, mass, 0.2, None).quiet_impulse;
        let expected = 1e-3 * mass.min(patch) * 100.0;
        assert!((quiet / expected - 1.0).abs() < 1e-12, "{mass}: {quiet} for {expected}");
    }
}

#[test]
fn what_keeps_a_tenth_of_its_speed_along_the_pack_has_rebounded() {
    for (left, expected) in [(9.0, Outcome::Stopped), (11.0, Outcome::Rebounded)] {
        let mut tracker = Tracker::new(&body([0.0, 0.0, 100.0]), 1e-3, 0.2, None);
        tracker.update(1e-6, &body([left, 0.0, 50.0]), 0.0, false, || false);
        tracker.update(2e-6, &body([left, 0.0, -1.0]), 0.0, false, || false);
        assert_eq!(tracker.outcome, expected, "{left} m/s");
    }
}

/// A tracker of a shot at 100 m/s, whose pack is quiet below this impulse [N·s].
fn tracker() -> (Tracker, f64) {
    let tracker = Tracker::new(&body([0.0, 0.0, 100.0]), 1e-3, 1e3, None);
    let quiet = tracker.quiet_impulse;
    assert!((quiet / 1e-4 - 1.0).abs() < 1e-12, "{quiet}");
    (tracker, quiet)
}

#[test]
fn a_pack_is_quiet_when_the_last_twenty_microseconds_took_little() {
    let forward = body([0.0, 0.0, 50.0]);
    // Nothing touches: quiet from 20 µs on, to the last bit.
    for (time, expected) in [(19.999e-6, Outcome::Running), (20e-6, Outcome::Perforated)] {
        let (mut tracker, _) = tracker();
        assert_eq!(tracker.may_be_quiet(time), expected == Outcome::Perforated);
        tracker.update(time, &forward, 0.0, true, || false);
        assert_eq!(tracker.outcome, expected, "{time}");
    }
    // An impulse counts for 20 µs; as much as the bound is too much, and two halves are one.
    for (impulses, time, expected) in [
        ([0.5, 0.5], 23.9e-6, Outcome::Running),
        ([0.5, 0.5], 24.1e-6, Outcome::Perforated),
        ([0.5, 0.499], 23.0e-6, Outcome::Perforated),
        ([0.0, 1.0], 24.1e-6, Outcome::Running),
        ([0.0, 1.0], 25.1e-6, Outcome::Perforated),
    ] {
        let (mut tracker, quiet) = tracker();
        for (at, impulse) in [4e-6, 5e-6].into_iter().zip(impulses) {
            tracker.update(at, &forward, impulse * quiet, true, || false);
        }
        assert_eq!(tracker.may_be_quiet(time), expected == Outcome::Perforated, "{impulses:?} {time}");
        tracker.update(time, &forward, 0.0, true, || false);
        assert_eq!(tracker.outcome, expected, "{impulses:?} {time}");
        assert!(!tracker.may_be_quiet(time) || expected == Outcome::Running);
    }
}

#[test]
fn what_is_through_flies_forward_past_fabric_it_met_and_is_not_covered() {
    let time = 30e-6;
    for (speed, met, covered, expected) in [
        (50.0, true, false, Outcome::Perforated),
        (50.0, false, false, Outcome::Running),
        (50.0, true, true, Outcome::Running),
        (0.0, true, false, Outcome::Running),
        (-50.0, true, false, Outcome::Running),
    ] {
        let (mut tracker, _) = tracker();
        tracker.update(time, &body([0.0, 0.0, speed]), 0.0, met, || covered);
        assert_eq!((tracker.outcome, tracker.in_doubt), (expected, covered), "{speed} {met} {covered}");
    }
    // What is driven has no outcome.
    let driven = RigidBody { prescribed: true, ..body([0.0, 0.0, 50.0]) };
    let mut tracker = Tracker::new(&driven, 1e-3, 1e3, None);
    assert_eq!(tracker.quiet_impulse, 0.0);
    tracker.update(time, &driven, 0.0, true, || false);
    assert_eq!(tracker.outcome, Outcome::Running);
}

#[test]
fn a_stop_is_timed_between_samples_and_followed_by_a_rebound_from_a_hundredth_of_the_speed_on() {
    let (mut tracker, quiet) = tracker();
    tracker.update(10e-6, &body([0.0, 0.0, 6.0]), 0.0, false, || false);
    tracker.update(14e-6, &body([0.0, 0.0, -2.0]), 0.5 * quiet, false, || false);
    // Three quarters of the way from 6 to −2 m/s.
    assert!(tracker.stop_time.is_some_and(|time| (time - 13e-6).abs() < 1e-18), "{tracker:?}");
    assert_eq!((tracker.outcome, tracker.rebound_velocity), (Outcome::Stopped, None));
    tracker.update(21e-6, &body([0.0, 0.0, -0.9]), 0.0, false, || false);
    assert_eq!(tracker.outcome, Outcome::Stopped, "below a hundredth");
    tracker.update(22e-6, &body([0.0, 0.0, -3.0]), 2.0 * quiet, false, || false);
    assert_eq!(tracker.outcome, Outcome::Stopped, "not quiet");
    tracker.update(42.1e-6, &body([0.0, 0.0, -3.0]), 0.5 * quiet, false, || false);
    assert_eq!((tracker.outcome, tracker.rebound_velocity), (Outcome::Rebounded, Some(3.0)));
    assert!(!tracker.separated, "touched a moment ago");
    tracker.update(62.2e-6, &body([0.0, 0.0, -4.0]), 0.0, false, || false);
    assert!(tracker.separated && tracker.rebound_velocity == Some(4.0));
    assert!(tracker.stop_time.is_some_and(|time| (time - 13e-6).abs() < 1e-18));
}

#[test]
fn a_free_pack_stops_what_it_covers_at_their_common_velocity() {
    // Three parts of fabric to one of projectile, at rest and on its way: a quarter of 100 m/s, and 3/4 of 20 m/s more.
    for (momentum, common) in [(0.0, 25.0), (3e-3 * 20.0, 40.0)] {
        let new = || Tracker::new(&body([0.0, 0.0, 100.0]), 1e-3, 1e3, Some([3e-3, momentum]));
        let crossing = |covered: bool| {
            let mut tracker = new();
            tracker.update(10e-6, &body([0.0, 0.0, common + 6.0]), 0.0, true, || covered);
            tracker.update(14e-6, &body([0.0, 0.0, common - 2.0]), 1.0, true, || covered);
            tracker
        };
        let mut tracker = crossing(true);
        assert_eq!((tracker.outcome, tracker.carried), (Outcome::Stopped, true));
        assert!(tracker.stop_time.is_some_and(|time| (time - 13e-6).abs() < 1e-15), "{tracker:?}");
        assert_eq!(tracker.carried_velocity(), Some(common - 2.0));
        // It goes on, and is free when nothing has touched it for 20 µs.
        tracker.update(20e-6, &body([0.0, 0.0, common - 3.0]), 1e-9, true, || true);
        tracker.update(34.1e-6, &body([0.0, 0.0, common - 3.0]), 0.0, true, || true);
        assert!(!tracker.separated, "touched a moment ago");
        tracker.update(40.1e-6, &body([0.0, 0.0, common - 3.0]), 0.0, true, || true);
        assert!(tracker.separated && tracker.carried_velocity() == Some(common - 3.0));
        assert_eq!((tracker.outcome, tracker.rebound_velocity), (Outcome::Stopped, None));
        // One that flies back from it has bounced off it.
        let mut tracker = crossing(true);
        tracker.update(34.1e-6, &body([0.0, 0.0, -3.0]), 0.0, true, || true);
        assert_eq!((tracker.outcome, tracker.rebound_velocity), (Outcome::Rebounded, Some(3.0)));
        assert_eq!(tracker.carried_velocity(), None);
        // What nothing covers goes on, however slow.
        let tracker = crossing(false);
        assert_eq!((tracker.outcome, tracker.carried, tracker.stop_time), (Outcome::Running, false, None));
    }
    // A pack that flies against the projectile as hard brings it to rest.
    let mut tracker = Tracker::new(&body([0.0, 0.0, 100.0]), 1e-3, 1e3, Some([3e-3, -0.2]));
    tracker.update(10e-6, &body([0.0, 0.0, 6.0]), 0.0, true, || true);
    tracker.update(14e-6, &body([0.0, 0.0, -2.0]), 1.0, true, || true);
    assert_eq!((tracker.outcome, tracker.carried), (Outcome::Stopped, false));
}

#[test]
fn what_is_in_doubt_is_decided_by_what_holds() {
    let flying = body([0.0, 0.0, 50.0]);
    for (slowest, outcome, carried) in [
        (Some(49.0), Outcome::Running, None),
        (Some(50.0), Outcome::Running, None),
        (Some(51.0), Outcome::Stopped, Some(50.0)),
        (None, Outcome::Perforated, None),
    ] {
        let (mut tracker, _) = tracker();
        tracker.update(30e-6, &flying, 0.0, true, || true);
        assert!(tracker.in_doubt);
        tracker.look(30e-6, &flying, |speed| slowest.is_some_and(|slowest: f64| slowest <= speed));
        assert_eq!((tracker.outcome, tracker.carried_velocity()), (outcome, carried), "{slowest:?}");
        assert_eq!(tracker.stop_time, carried.map(|_| 30e-6));
    }
}
