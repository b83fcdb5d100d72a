use super::*;

#[test]
fn a_height_that_would_fall_or_rise_by_a_metre_a_stretch_is_not_followed() {
    let yarn = |force: f64| YarnResponse { strain: 0.5, force, stiffness: 1.0, growth: 1.0 };
    // t = F (1 + ε)/ε − h S, over S.
    let fall = |force: f64, height: f64| {
        let of = Predictor::of(&[yarn(force), yarn(force)], [1.0; 2], 0.0, [height; 2], [1.0; 2]);
        of.dh_dstretch[0]
    };
    assert_eq!(fall(0.1, 0.0), 0.1 * 1.5 / 0.5);
    assert_eq!([fall(0.5, 0.0), fall(0.0, 2.0)], [0.0; 2]);
    assert_eq!(fall(0.0, 0.5), -0.5);
}
