use super::*;

#[test]
fn the_interval_of_the_mean_is_students() {
    let thresholds = [181.0, 184.5, 190.2, 186.1, 179.4, 188.8, 185.0];
    let Some(sample) = ThresholdSample::new(&thresholds, 0.0) else { unreachable!("there are thresholds") };
    let half = student_t::quantile(0.9, 6) * sample.sigma / 7.0_f64.sqrt();
    let bounds = sample.interval(0.5, 0.9);
    let off = |end: Option<f64>, expected: f64| end.is_none_or(|end| (end - expected).abs() > 1e-5);
    assert!(!off(bounds.low, sample.mean - half) && !off(bounds.high, sample.mean + half), "{bounds:?} {half}");
    assert!(sample.interval(0.9, 0.9).high > bounds.high && sample.interval(0.5, 0.99).low < bounds.low);
}

#[test]
fn brackets_alone_are_no_scatter() {
    let sample = ThresholdSample::new(&[99.5, 100.5, 99.5, 100.5], 2.0 * 3.0_f64.sqrt());
    assert!(sample.is_some_and(|sample| sample.sigma < 0.6));
    assert!(ThresholdSample::new(&[], 1.0).is_none());
    let one = ThresholdSample::new(&[100.0], 1.0);
    assert!(one.is_some_and(|one| one.interval(0.5, 0.9) == Bounds::default() && one.probability(101.0) == 1.0));
}
