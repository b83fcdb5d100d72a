use super::*;

/// A history from 0 to `end` [µs] in steps of `step` [µs] with this velocity [m/s].
fn history(step: f64, end: f64, velocity: impl Fn(f64) -> f64) -> Vec<Sample> {
    let rows = 0..=(end / step).round() as usize;
    let row = |time: f64| Sample { time: time * 1e-6, projectile_velocity: velocity(time), ..Sample::default() };
    rows.map(|n| row(n as f64 * step)).collect()
}

#[test]
fn a_constant_difference_is_its_share_of_the_velocity_lost() {
    let reference = history(0.5, 10.0, |t| 100.0 - 2.0 * t);
    // The rows of the run that come later do not count.
    let found = velocity_error(&reference, &history(0.7, 14.0, |t| 101.0 - 2.0 * t)).flatten();
    assert!(found.is_some_and(|error| (error - 1.0 / 20.0).abs() < 1e-12), "{found:?}");
}

#[test]
fn a_growing_difference_has_its_root_mean_square() {
    let reference = history(0.25, 10.0, |t| 50.0 - t);
    // √(∫ (0.1 t)² dt / 10) = 1/√3 of 10, whichever of the two is faster.
    for slope in [1.1, 0.9] {
        let found = velocity_error(&reference, &history(0.01, 10.0, |t| 50.0 - slope * t)).flatten();
        assert!(found.is_some_and(|error| (error - 0.1 / 3.0_f64.sqrt()).abs() < 1e-6), "{found:?}");
    }
}

#[test]
fn there_is_no_error_where_no_velocity_is_lost_or_no_time_is_common() {
    let flight = history(0.5, 10.0, |_| 100.0);
    assert_eq!(velocity_error(&flight, &flight), Some(None));
    assert_eq!(velocity_error(&flight, &[]), None);
    assert_eq!(velocity_error(&flight, &flight[..1]), None);
    let stopping = history(0.5, 10.0, |t| 100.0 - t);
    assert_eq!(velocity_error(&stopping, &stopping), Some(Some(0.0)));
}
