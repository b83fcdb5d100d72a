use super::*;

/// A history from 0 to `end` [µs] in steps of `step` [µs] with this velocity [m/s].
fn history(step: f64, end: f64, velocity: impl Fn(f64) -> f64) -> Vec<Sample> {
    let rows = 0..=(end / step).round() as usize;
    let row = |time: f64| Sample {
        time: time * 1e-6,
        projectile_velocity: velocity(time),
        deflection: time,
        ..Sample::default()
    };
    rows.map(|n| row(n as f64 * step)).collect()
}

#[test]
fn a_constant_difference_is_its_share_of_the_velocity_lost() {
    let reference = history(0.5, 10.0, |t| 100.0 - 2.0 * t);
    let run = history(0.7, 14.0, |t| 101.0 - 2.0 * t);
    let found = histories(&reference, &run).unwrap_or_default();
    assert!((found.span - 10e-6).abs() < 1e-18);
    assert!(found.velocity.is_some_and(|error| (error - 1.0 / 20.0).abs() < 1e-12), "{found:?}");
    // 101 − 28 against 100 − 20 at the ends of both.
    assert!((found.residual_velocity + 7.0).abs() < 1e-9);
    // 9.8 against 10 within the common time; what comes later does not count.
    assert!(found.deflection.is_some_and(|error| (error + 0.02).abs() < 1e-12), "{found:?}");
    assert_eq!((found.tension, found.stop_time), (None, None));
}

#[test]
fn a_growing_difference_has_its_root_mean_square() {
    let reference = history(0.25, 10.0, |t| 50.0 - t);
    let run = history(0.01, 10.0, |t| 50.0 - 1.1 * t);
    let error = histories(&reference, &run).and_then(|found| found.velocity).unwrap_or(f64::NAN);
    // √(∫ (0.1 t)² dt / 10) = 1/√3 of 10.
    assert!((error - 0.1 / 3.0_f64.sqrt()).abs() < 1e-6, "{error}");
    let mirrored = histories(&reference, &history(0.01, 10.0, |t| 50.0 - 0.9 * t)).and_then(|found| found.velocity);
    assert!(mirrored.is_some_and(|other| (other - error).abs() < 1e-12));
}

#[test]
fn nothing_is_said_where_nothing_is_lost_or_common() {
    let flight = history(0.5, 10.0, |_| 100.0);
    assert_eq!(histories(&flight, &flight).and_then(|found| found.velocity), None);
    assert_eq!(histories(&flight, &[]), None);
    assert_eq!(histories(&flight, &flight[..1]), None);
    let stopping = history(0.5, 10.0, |t| 100.0 - t);
    assert_eq!(histories(&stopping, &stopping).and_then(|found| found.velocity), Some(0.0));
}

#[test]
fn the_front_holds_what_nothing_beats() {
    let points = [
        Some([1.0, 0.10]),
        Some([2.0, 0.05]),
        Some([3.0, 0.06]), // slower and worse than the second
        Some([4.0, 0.01]),
        Some([4.0, 0.02]), // as slow as the fourth and worse
        None,
        Some([1.0, 0.10]), // as good as the first: neither beats the other
        Some([0.5, f64::INFINITY]),
    ];
    assert_eq!(front(&points), [true, true, false, true, false, false, true, true]);
    assert_eq!(front(&[]), Vec::<bool>::new());
}
