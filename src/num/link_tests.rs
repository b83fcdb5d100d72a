use super::*;
fn near(got: f64, expected: f64, relative: f64) {
    assert!((got - expected).abs() <= relative * expected.abs(), "{got:e} instead of {expected:e}");
}

/// Printed values of the normal distribution; the tail from its asymptotic series at 40 digits.
#[test]
fn the_normal_distribution_is_the_published_one() {
    let probit = Link::Probit;
    near(probit.quantile(0.975), 1.959_963_984_540_054, 1e-14);
    near(probit.quantile(0.9), 1.281_551_565_544_600_5, 1e-14);
    near(probit.quantile(1e-10), -6.361_340_902_404_056, 1e-12);
    near(probit.probability(-1.0), 0.158_655_253_931_457_05, 1e-14);
    near(probit.probability(2.0), 0.977_249_868_051_820_8, 1e-14);
    near(probit.probability(-10.0), 7.619_853_024_160_527e-24, 1e-13);
    near(probit.ln_probability(8.0), -6.220_960_574_271_786e-16, 1e-13);
    near(probit.ln_probability(-40.0), -804.608_442_013_753_8, 1e-14);
}

/// The series takes over from the function without a step; slopes are those of finite differences.
#[test]
fn tails_are_smooth_and_slopes_are_derivatives() {
    let probit = Link::Probit;
    let [above, below] = [SERIES + 1e-9, SERIES - 1e-9].map(|eta| probit.ln_probability(eta));
    near(above - below, 2e-9 * 35.028, 0.01);
    for link in [Link::Probit, Link::Logit] {
        for eta in [-36.0, -20.0, -3.0, -0.4, 0.0, 0.7, 4.0] {
            let h = 1e-5;
            let slope = (link.ln_probability(eta + h) - link.ln_probability(eta - h)) / (2.0 * h);
            assert!((link.slope(eta) - slope).abs() < 1e-7 * (1.0 + slope), "{link:?} at {eta}");
            let curvature = (link.slope(eta - h) - link.slope(eta + h)) / (2.0 * h);
            assert!(
                (link.slope_and_curvature(eta)[1] - curvature).abs() < 1e-6 * (1.0 + curvature),
                "{link:?} at {eta}"
            );
            let slope = (link.information(eta + h).ln() - link.information(eta - h).ln()) / (2.0 * h);
            assert!((link.ln_information_slope(eta) - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{link:?} {eta}");
            if eta.abs() < 5.0 {
                near(link.quantile(link.probability(eta)) + 10.0, eta + 10.0, 1e-10);
            }
        }
    }
}
