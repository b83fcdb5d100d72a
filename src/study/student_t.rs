//! Student's t distribution with a whole number of degrees of freedom.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use super::search::root;

/// t with P(|T| ≤ t) = `level`.
pub(super) fn quantile(level: f64, degrees: u64) -> f64 {
    let root_of_degrees = (degrees as f64).sqrt();
    root_of_degrees * root(|angle| within(angle, degrees) - level, 0.0, FRAC_PI_2, 1e-15).tan()
}

/// P(|T| ≤ √ν tan θ) as a finite sum (Abramowitz & Stegun 26.7.3, 26.7.4).
fn within(angle: f64, degrees: u64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let odd = degrees % 2;
    let mut term = if odd == 1 { cosine } else { 1.0 };
    let mut sum = 0.0;
    let mut n = 2 + odd;
    while n <= degrees {
        sum += term;
        term *= cosine * cosine * (n - 1) as f64 / n as f64;
        n += 2;
    }
    if odd == 1 { FRAC_2_PI * (angle + sine * sum) } else { sine * sum }
}

#[cfg(test)]
mod tests {
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
}
