use super::*;

#[test]
fn pairs_give_their_mean_ratio_and_students_interval() {
    let pairs = [[100.0, 103.0], [200.0, 202.0], [50.0, 51.0], [80.0, 83.2]];
    let Some(found) = Refinement::new(&pairs) else { unreachable!("there are pairs") };
    assert!((found.ratio - 1.025).abs() < 1e-12 && found.count == 4);
    let sigma = ((0.005_f64.powi(2) * 2.0 + 0.015_f64.powi(2) * 2.0) / 3.0).sqrt();
    assert!((found.sigma - sigma).abs() < 1e-12, "{found:?}");
    // Student's t of three degrees of freedom at 90 %: 2.353.
    assert!((found.half_width(0.9) - 1.5 * 2.353_363 * sigma / 2.0).abs() < 1e-6, "{}", found.half_width(0.9));
}

#[test]
fn one_pair_has_a_ratio_alone() {
    let found = Refinement::new(&[[180.0, 185.4]]);
    assert_eq!(found.map(|found| (found.count, found.half_width(0.9))), Some((1, 0.0)));
    // 180, 185.4, and 190.8 if the error is of first order: the middle of the last two, and half of what is between them.
    assert!(found.is_some_and(|found| (180.0 * found.factor() - 188.1).abs() < 1e-9));
    assert!(found.is_some_and(|found| (180.0 * found.open() - 2.7).abs() < 1e-9));
    assert_eq!(Refinement::new(&[]), None);
}
