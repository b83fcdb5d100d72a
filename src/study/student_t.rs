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
#[path = "student_t_tests.rs"]
mod tests;
