use super::*;

/// Table of Abramowitz & Stegun, 26.10: P(|T| ≤ t).
#[test]
fn quantiles_are_the_printed_ones() {
    for (level, degrees, expected) in [
        (0.9, 1, 6.314),
        (0.9, 2, 2.920),
        (0.9, 3, 2.353),
        (0.9, 10, 1.812),
        (0.9, 30, 1.697),
        (0.95, 5, 2.571),
        (0.95, 4, 2.776),
        (0.99, 7, 3.499),
        (0.99, 120, 2.617),
    ] {
        let got = quantile(level, degrees);
        assert!((got - expected).abs() < 6e-4, "{level} {degrees}: {got} instead of {expected}");
    }
}
