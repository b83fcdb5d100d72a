use super::*;
use crate::solver::energy_balance::Balance;

#[test]
fn finds_the_frequency_of_a_vibration_between_its_samples() {
    let frequency_hz = 1234.5;
    let row = |n: u32| {
        let time = f64::from(n) * 7e-6;
        let velocity = (std::f64::consts::TAU * frequency_hz * time).sin();
        Sample { time, balance: Balance { kinetic: velocity * velocity, ..Balance::default() }, ..Sample::default() }
    };
    let history: Vec<Sample> = (0..800).map(row).collect();
    let all = [f64::NEG_INFINITY, f64::INFINITY];
    let got = frequency(&history, all).unwrap_or_default();
    assert!((got / frequency_hz - 1.0).abs() < 1e-4, "{got}");
    assert_eq!(frequency(&history[..40], all), None);
    assert_eq!(frequency(&[], all), None);
}

#[test]
fn a_parabola_has_its_vertex_wherever_its_points_are() {
    let point = |x: f64| [x, 3.0 - 2.0 * (x - 1.3).powi(2)];
    assert!((vertex(&[point(0.0), point(1.0), point(4.0)]) - 1.3).abs() < 1e-12);
}

#[test]
fn bounds_hold_at_their_ends_and_for_the_right_kind() {
    let value = Bound::Value { value: 10.0, tolerance: 1.0 };
    assert!(holds(&value, &json!(11)) && !holds(&value, &json!(11.01)) && !holds(&value, &Value::Null));
    let range = Bound::Range { min: 0.0, max: f64::INFINITY };
    assert!(holds(&range, &json!(0)) && !holds(&range, &json!("0")));
    assert!(holds(&Bound::Word("stopped".to_owned()), &json!("stopped")));
    assert!(!holds(&Bound::Word("stopped".to_owned()), &json!("perforated")));
    assert!(holds(&Bound::Word("false".to_owned()), &json!(false)));
}
