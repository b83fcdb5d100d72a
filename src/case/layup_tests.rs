use super::*;

#[test]
fn only_odd_quarter_turns_exchange_the_sizes() {
    for degrees in [90, -90, 270, -270_i32] {
        assert!(lies_across(f64::from(degrees).to_radians()), "{degrees}");
    }
    for degrees in [0, 180, -180, 360, -360, 45, 89, 91, 30_i32] {
        assert!(!lies_across(f64::from(degrees).to_radians()), "{degrees}");
    }
}
