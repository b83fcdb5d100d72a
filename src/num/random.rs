//! Random numbers that are a function of what they are for: Philox4x32-10 (Salmon, Moraes, Dror & Shaw 2011).
//!
//! A draw is keyed by seed, shot, ply, yarn and element, and by nothing else: it does not depend on which shots ran before, or beside it.

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

    /// Yarn with its scale stated for another gauge length.
    pub fn at_gauge(&self, gauge: f64) -> Self {
        Self { scale: self.scale * (self.gauge / gauge).powf(1.0 / self.shape), gauge, ..*self }
    }

    /// Mean strength of a length.
    pub fn mean(&self, length: f64) -> f64 {
        self.at_gauge(length).scale * tgamma(1.0 + 1.0 / self.shape)
    }
}
