//! Random numbers, and the distributions of Weibull and Gauss.
//!
//! Numbers are a function of what they are for, by Philox4x32-10 (Salmon, Moraes, Dror & Shaw 2011). A draw is keyed by seed, shot, ply, yarn
//! and element, and by nothing else: it does not depend on which shots ran before, or beside it.

use libm::tgamma;

/// Multipliers and key increments of the published generator.
const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const INCREMENTS: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];
const ROUNDS: usize = 10;

/// Key of a draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct DrawKey {
    /// Seed of the campaign.
    pub seed: u64,
    /// Shot, from 0.
    pub shot: u32,
    /// Ply, from 0; or [`DrawKey::WHOLE`].
    pub ply: u32,
    /// Yarn of that ply, from 0; or [`DrawKey::WHOLE`].
    pub yarn: u32,
    /// Element of that yarn, from 0; or [`DrawKey::WHOLE`].
    pub element: u32,
}

impl DrawKey {
    /// In place of a ply, a yarn or an element: the draw is for all of them.
    pub const WHOLE: u32 = u32::MAX;

    /// Four independent words of random bits.
    pub fn words(self) -> [u32; 4] {
        philox([self.shot, self.ply, self.yarn, self.element], [self.seed as u32, (self.seed >> 32) as u32])
    }

    /// Four independent numbers, uniform between 0 and 1, never either.
    pub fn uniform(self) -> [f64; 4] {
        self.words().map(uniform)
    }
}

/// The middle of one of 2²³ equal parts of (0, 1): exact in single precision too.
pub fn uniform(word: u32) -> f64 {
    (f64::from(word >> 9) + 0.5) / f64::from(1_u32 << 23)
}

/// Philox4x32-10: a bijection of the counter for every key.
pub fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for round in 0..ROUNDS {
        if round > 0 {
            key = [key[0].wrapping_add(INCREMENTS[0]), key[1].wrapping_add(INCREMENTS[1])];
        }
        let product = |i: usize| u64::from(MULTIPLIERS[i]) * u64::from(counter[2 * i]);
        let [(high0, low0), (high1, low1)] = [product(0), product(1)].map(|p| ((p >> 32) as u32, p as u32));
        counter = [high1 ^ counter[1] ^ key[0], low1, high0 ^ counter[3] ^ key[1], low0];
    }
    counter
}

/// Strength of a length of yarn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weibull {
    /// Scale σ₀, in any unit of stress: 63.2 % of pieces of the gauge length are weaker.
    pub scale: f64,
    /// Shape m \[-\].
    pub shape: f64,
    /// Gauge length L₀ of the scale, in any unit of length.
    pub gauge: f64,
}

impl Weibull {
    /// Strength of a length; `uniform` between 0 and 1 is the chance of a weaker one.
    pub fn strength(&self, length: f64, uniform: f64) -> f64 {
        self.scale * (-(-uniform).ln_1p() * self.gauge / length).powf(1.0 / self.shape)
    }

    /// Mean strength of a length.
    pub fn mean(&self, length: f64) -> f64 {
        self.scale * (self.gauge / length).powf(1.0 / self.shape) * tgamma(1.0 + 1.0 / self.shape)
    }
}

/// The normal distribution. All of it holds far out in the tails, where F itself is 0 or 1 to every digit.
pub mod normal {
    use std::f64::consts::{PI, SQRT_2};

    use libm::erfc;

    /// Below this the distribution is nearer to zero than numbers can be, and its logarithm is taken from the asymptotic series.
    const SERIES: f64 = -35.0;

    /// F(η), the chance of less than η.
    pub fn probability(eta: f64) -> f64 {
        0.5 * erfc(-eta / SQRT_2)
    }

    /// η where the chance is `p`, 0 < p < 1. A rough start (Abramowitz & Stegun 26.2.23), then Halley's method: its error is cubed
    /// with each step.
    pub fn quantile(p: f64) -> f64 {
        let tail = p.min(1.0 - p);
        let t = (-2.0 * tail.ln()).sqrt();
        let start = t
            - (2.515_517 + t * (0.802_853 + t * 0.010_328)) / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308)));
        let mut z = -start;
        for _ in 0..3 {
            let error = (ln_probability(z) - tail.ln()) / slope(z);
            z -= error / (1.0 + 0.5 * error * (z + slope(z)));
        }
        if p < 0.5 { z } else { -z }
    }

    /// ln F(η).
    pub fn ln_probability(eta: f64) -> f64 {
        if eta > 0.0 {
            return (-0.5 * erfc(eta / SQRT_2)).ln_1p();
        }
        if eta > SERIES {
            return (0.5 * erfc(-eta / SQRT_2)).ln();
        }
        let r = 1.0 / (eta * eta);
        let series = 1.0 - r * (1.0 - 3.0 * r * (1.0 - 5.0 * r * (1.0 - 7.0 * r)));
        ln_density(eta) - (-eta).ln() + series.ln()
    }

    /// d ln F/dη, the inverse of Mills' ratio; −d² ln F/dη² is this times its sum with η.
    pub fn slope(eta: f64) -> f64 {
        (ln_density(eta) - ln_probability(eta)).exp()
    }

    /// Information of one shot on η, f²/\[F (1 − F)\].
    pub fn information(eta: f64) -> f64 {
        slope(eta) * slope(-eta)
    }

    /// d ln(information)/dη.
    pub(crate) fn ln_information_slope(eta: f64) -> f64 {
        slope(-eta) - slope(eta) - 2.0 * eta
    }

    /// ln φ(z) of the standard normal density.
    fn ln_density(z: f64) -> f64 {
        -0.5 * (z * z + (2.0 * PI).ln())
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        fn near(got: f64, expected: f64, relative: f64) {
            assert!((got - expected).abs() <= relative * expected.abs(), "{got:e} instead of {expected:e}");
        }

        /// Printed values; the tail from its asymptotic series at 40 digits.
        #[test]
        fn the_normal_distribution_is_the_published_one() {
            near(quantile(0.975), 1.959_963_984_540_054, 1e-14);
            near(quantile(0.9), 1.281_551_565_544_600_5, 1e-14);
            near(quantile(1e-10), -6.361_340_902_404_056, 1e-12);
            near(probability(-1.0), 0.158_655_253_931_457_05, 1e-14);
            near(probability(2.0), 0.977_249_868_051_820_8, 1e-14);
            near(probability(-10.0), 7.619_853_024_160_527e-24, 1e-13);
            near(ln_probability(8.0), -6.220_960_574_271_786e-16, 1e-13);
            near(ln_probability(-40.0), -804.608_442_013_753_8, 1e-14);
        }

        /// The series takes over from the function without a step; slopes are those of finite differences.
        #[test]
        fn tails_are_smooth_and_slopes_are_derivatives() {
            let [above, below] = [SERIES + 1e-9, SERIES - 1e-9].map(ln_probability);
            near(above - below, 2e-9 * 35.028, 0.01);
            for eta in [-36.0, -20.0, -3.0, -0.4, 0.0, 0.7, 4.0] {
                let h = 1e-5;
                let rise = (ln_probability(eta + h) - ln_probability(eta - h)) / (2.0 * h);
                assert!((slope(eta) - rise).abs() < 1e-7 * (1.0 + rise), "{eta}");
                let curvature = (slope(eta - h) - slope(eta + h)) / (2.0 * h);
                assert!((slope(eta) * (slope(eta) + eta) - curvature).abs() < 1e-6 * (1.0 + curvature), "{eta}");
                let rise = (information(eta + h).ln() - information(eta - h).ln()) / (2.0 * h);
                assert!((ln_information_slope(eta) - rise).abs() < 1e-6 * (1.0 + rise.abs()), "{eta}");
                if eta.abs() < 5.0 {
                    near(quantile(probability(eta)) + 10.0, eta + 10.0, 1e-10);
                }
            }
        }
    }
}
