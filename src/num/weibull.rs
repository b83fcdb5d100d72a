//! Strength of yarns: Weibull's distribution, P(break below σ) = 1 − exp\[−(L/L₀)(σ/σ₀)^m\].
//!
//! A yarn of n pieces breaks where its weakest piece does. Its strength is Weibull's again, with the same m and σ₀ n^(−1/m), exactly.

use libm::tgamma;

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
    /// Chance that a length breaks below a stress.
    pub fn probability(&self, length: f64, stress: f64) -> f64 {
        -(-(length / self.gauge) * (stress / self.scale).powf(self.shape)).exp_m1()
    }

    /// Strength of a length; `uniform` between 0 and 1 is the chance of a weaker one.
    pub fn strength(&self, length: f64, uniform: f64) -> f64 {
        self.scale * (-(-uniform).ln_1p() * self.gauge / length).powf(1.0 / self.shape)
    }

    /// The same yarn, its scale stated for another gauge length.
    pub fn at_gauge(&self, gauge: f64) -> Self {
        Self { scale: self.scale * (self.gauge / gauge).powf(1.0 / self.shape), gauge, ..*self }
    }

    /// Mean strength of a length.
    pub fn mean(&self, length: f64) -> f64 {
        self.at_gauge(length).scale * tgamma(1.0 + 1.0 / self.shape)
    }

    /// Standard deviation over mean; that of any length.
    pub fn variation(&self) -> f64 {
        let mean = tgamma(1.0 + 1.0 / self.shape);
        (tgamma(1.0 + 2.0 / self.shape) / (mean * mean) - 1.0).sqrt()
    }
}
