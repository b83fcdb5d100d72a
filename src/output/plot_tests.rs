use super::*;

fn labels(axis: &Axis) -> String {
    axis.ticks().iter().map(|tick| label(*tick)).collect::<Vec<_>>().join(" ")
}

#[test]
fn a_linear_axis_has_round_ticks_whatever_its_range() {
    assert_eq!(labels(&Axis::linear([0.0, 155.0], [0.0, 1.0])), "0 50 100 150");
    assert_eq!(labels(&Axis::linear([-0.3, 0.3], [0.0, 1.0])), "−0.2 0 0.2");
    assert_eq!(labels(&Axis::linear(rounded_up([0.0, 0.7]), [0.0, 1.0])), "0 0.2 0.4 0.6 0.8");
    for range in [[0.0, 0.0], [f64::NAN, f64::NAN], [2.0, f64::INFINITY], [f64::INFINITY, f64::NEG_INFINITY]] {
        let axis = Axis::linear(range, [0.0, 1.0]);
        assert!(axis.at(1.0).is_finite() && !axis.ticks().is_empty(), "{range:?}");
    }
}

#[test]
fn a_line_that_is_too_dense_keeps_its_peaks_and_ends() {
    let mut points: Vec<[f64; 2]> = (0..10_000).map(|n| [f64::from(n), (f64::from(n) * 0.01).sin()]).collect();
    points[4321][1] = 9.0;
    let thin = thinned(&points, 400);
    assert!(thin.len() <= 404, "{}", thin.len());
    assert!(thin.contains(&[4321.0, 9.0]) && thin[0] == points[0] && thin.last() == points.last());
    assert!(thin.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
    assert_eq!(thinned(&points[..300], 400), points[..300]);
}

#[test]
fn what_is_no_number_is_not_drawn_and_words_are_only_words() {
    let axis = Axis::linear([0.0, 1.0], [0.0, 10.0]);
    let drawn = line(&axis, &axis, [[0.0, 0.0], [f64::NAN, 1.0], [1.0, 1.0]].into_iter(), "");
    assert!(drawn.contains("\"0.0,0.0 10.0,10.0\""), "{drawn}");
    assert_eq!(escape("</title>\"'&"), "&lt;/title&gt;&quot;&#39;&amp;");
}
