//! Links: how the chance of a perforation grows with velocity.
//!
//! P = F(η) with η = (v − μ)/σ. Both links are symmetric: 1 − F(η) = F(−η). All of it holds far out in the tails, where F itself is 0
//! or 1 to every digit.

use std::f64::consts::{PI, SQRT_2};

use libm::erfc;

/// Below this the normal distribution is nearer to zero than numbers can be, and its logarithm is taken from the asymptotic series.
const SERIES: f64 = -35.0;

/// Distribution of the thresholds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Link {
    /// Normal.
    #[default]
    Probit,
    /// Logistic.
    Logit,
}

impl Link {
    /// The word in JSON.
    pub fn word(self) -> &'static str {
        ["probit", "logit"][self as usize]
    }

    /// F(η), the chance of a perforation \[-\].
    pub fn probability(self, eta: f64) -> f64 {
        match self {
            Self::Probit => 0.5 * erfc(-eta / SQRT_2),
            Self::Logit => 1.0 / (1.0 + (-eta).exp()),
        }
    }

    /// η where the chance is `p`, 0 < p < 1.
    pub fn quantile(self, p: f64) -> f64 {
        match self {
            Self::Probit => normal_quantile(p),
            Self::Logit => (p / (1.0 - p)).ln(),
        }
    }

    /// ln F(η).
    pub fn ln_probability(self, eta: f64) -> f64 {
        match self {
            Self::Probit if eta > 0.0 => (-0.5 * erfc(eta / SQRT_2)).ln_1p(),
            Self::Probit if eta > SERIES => (0.5 * erfc(-eta / SQRT_2)).ln(),
            Self::Probit => {
                let r = 1.0 / (eta * eta);
                let series = 1.0 - r * (1.0 - 3.0 * r * (1.0 - 5.0 * r * (1.0 - 7.0 * r)));
                ln_density(eta) - (-eta).ln() + series.ln()
            }
            Self::Logit if eta > 0.0 => -(-eta).exp().ln_1p(),
            Self::Logit => eta - eta.exp().ln_1p(),
        }
    }

    /// d ln F/dη; for the normal distribution the inverse of Mills' ratio.
    pub fn slope(self, eta: f64) -> f64 {
        match self {
            Self::Probit => (ln_density(eta) - self.ln_probability(eta)).exp(),
            Self::Logit => self.probability(-eta),
        }
    }

    /// d ln F/dη and −d² ln F/dη², both above zero.
    pub(crate) fn slope_and_curvature(self, eta: f64) -> [f64; 2] {
        let slope = self.slope(eta);
        match self {
            Self::Probit => [slope, slope * (slope + eta)],
            Self::Logit => [slope, slope * (1.0 - slope)],
        }
    }

    /// Information of one shot on η, f²/\[F (1 − F)\].
    pub fn information(self, eta: f64) -> f64 {
        self.slope(eta) * self.slope(-eta)
    }

    /// d ln(information)/dη.
    pub(crate) fn ln_information_slope(self, eta: f64) -> f64 {
        match self {
            Self::Probit => self.slope(-eta) - self.slope(eta) - 2.0 * eta,
            Self::Logit => self.probability(-eta) - self.probability(eta),
        }
    }
}

/// ln φ(z) of the standard normal density.
fn ln_density(z: f64) -> f64 {
    -0.5 * (z * z + (2.0 * PI).ln())
}

/// Quantile of the standard normal distribution. A rough start (Abramowitz & Stegun 26.2.23), then Halley's method: its error is cubed
/// with each step.
fn normal_quantile(p: f64) -> f64 {
    let tail = p.min(1.0 - p);
    let t = (-2.0 * tail.ln()).sqrt();
    let start =
        t - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
    let mut z = -start;
    for _ in 0..3 {
        let error = (Link::Probit.ln_probability(z) - tail.ln()) / Link::Probit.slope(z);
        z -= error / (1.0 + 0.5 * error * (z + Link::Probit.slope(z)));
    }
    if p < 0.5 { z } else { -z }
}

#[cfg(test)]
mod tests {
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
}
