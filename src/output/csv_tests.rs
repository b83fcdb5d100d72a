use super::*;

#[test]
fn numbers_read_back_and_stay_short() {
    for value in [0.1, -3.25e-20, 1.0 / 3.0, 6.02e23, 42.0, f64::MIN_POSITIVE] {
        assert_eq!(number(value).parse(), Ok(value));
    }
    assert_eq!(number(-0.0), "0");
    assert_eq!(number(400.0), "400");
    assert_eq!(number(f64::NAN), "NaN");
}

#[test]
fn reads_between_rows_and_never_outside() {
    let row = |time: f64, velocity: f64| Sample { time, projectile_velocity: velocity, ..Sample::default() };
    let history = [row(0.0, 100.0), row(1e-6, 90.0), row(3e-6, 80.0)];
    let velocity = find("projectile_velocity_m_s");
    let read = |time: f64| velocity.and_then(|column| at(&history, column, time));
    assert_eq!(read(0.0), Some(100.0));
    assert_eq!(read(3e-6), Some(80.0));
    assert!(read(2e-6).is_some_and(|v| (v - 85.0).abs() < 1e-9));
    assert_eq!(read(3.1e-6), None);
    assert_eq!(read(-1e-9), None);
}
