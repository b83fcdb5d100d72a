//! Robbins's and Monro's search for one quantile, with Joseph's steps for binary outcomes (2004), as 3POD ends with it.

use crate::num::link::{Link, normal_density};

/// Bounds of the first τ²: (3/z)² and (5/z)² with the 97.5 % quantile z, as published.
const FIRST: [f64; 2] = [2.3429, 6.5079];

/// A search for the velocity with chance `p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobbinsMonro {
    /// Quantile of the standard normal distribution.
    z: f64,
    /// Unit in which τ and β are taken.
    unit: f64,
    beta: f64,
    /// Variance of what is known of the place.
    tau_square: f64,
}

impl RobbinsMonro {
    /// A search that goes out from an estimate: its σ as used for β, and the covariance of (μ, σ). The published rule bounds τ² in the unit
    /// of the data, which `unit` 1 does; with σ as the unit the steps do not depend on whether velocities are in m/s or ft/s.
    pub fn new(p: f64, sigma: f64, covariance: [[f64; 2]; 2], unit: f64) -> Self {
        let z = Link::Probit.quantile(p);
        let variance = (covariance[0][0] + z * z * covariance[1][1]) / (unit * unit);
        Self { z, unit, beta: 0.5 * unit / sigma, tau_square: variance.clamp(FIRST[0], FIRST[1]) }
    }

    /// Velocity after a shot.
    pub fn next(&mut self, velocity: f64, perforated: bool) -> f64 {
        let Self { z, beta, tau_square, .. } = *self;
        let k = (1.0 + beta * beta * tau_square).sqrt();
        let b = Link::Probit.probability(z / k);
        let a = beta * tau_square * normal_density(z / k) / (k * b * (1.0 - b));
        self.tau_square = tau_square - b * (1.0 - b) * a * a;
        velocity - self.unit * a * (f64::from(u8::from(perforated)) - b)
    }
}
