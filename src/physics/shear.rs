//! Trellis shear with locking, (25).
//!
//! G is the tangent modulus, so the shear resultant is q = t·∫G dγ: odd in γ and continuous where locking begins and ends.

use crate::case::ShearModulus;
use crate::num::scalar::{Mask, Real, Scalar, is_double};

/// asin(x)/x as a polynomial in x² on |x| ≤ ½, highest power first: Chebyshev fit, error 2e-17.
pub(crate) const ARC_SINE: [f64; 13] = [
    0.031_879_621_400_812_84,
    -0.016_187_392_271_599_133,
    0.019_513_468_251_252_168,
    0.006_529_302_004_736_569,
    0.012_170_138_592_391_726,
    0.013_884_842_826_402_08,
    0.017_359_779_641_349_98,
    0.022_371_749_733_164_053,
    0.030_381_959_697_685_14,
    0.044_642_856_805_998_94,
    0.075_000_000_003_852_02,
    0.166_666_666_666_649_4,
    1.0,
];

/// Coefficients for single precision: error 3e-10.
pub const ARC_SINE_SINGLE: [f64; 7] = [
    0.037_677_139_309_900_15,
    0.014_295_255_316_288_355,
    0.031_857_189_096_626_805,
    0.044_508_709_472_211_19,
    0.075_005_713_811_841_76,
    0.166_666_576_395_722_35,
    1.000_000_000_230_778_5,
];

/// Constants of (25), modulus times thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearConstants<R> {
    /// G1·t [N/m].
    pub g1: R,
    /// (G2 − G1)·t [N/m].
    pub rise: R,
    /// Angle at which locking begins [rad].
    pub gamma1: R,
    /// γ2 − γ1 [rad].
    pub ramp: R,
    /// rise/ramp, or 0 where the ramp has no width [N/m per rad].
    pub slope: R,
}

impl<S: Scalar> ShearConstants<S> {
    /// Constants of `shear` for a fabric of the given thickness [m]; without shear all zero.
    pub fn new(shear: Option<&crate::case::Shear>, thickness: f64) -> Self {
        let none = crate::case::Shear { g1: 0.0, g2: 0.0, gamma1: 0.0, gamma2: 0.0, modulus: ShearModulus::Tangent };
        let shear = shear.unwrap_or(&none);
        let rise = (shear.g2 - shear.g1) * thickness;
        let ramp = shear.gamma2 - shear.gamma1;
        Self {
            g1: S::splat(shear.g1 * thickness),
            rise: S::splat(rise),
            gamma1: S::splat(shear.gamma1),
            ramp: S::splat(ramp),
            slope: S::splat(if ramp > 0.0 { rise / ramp } else { 0.0 }),
        }
    }
}

impl<S: Scalar> ShearConstants<S> {
    /// Constants in other numbers.
    pub(crate) fn map<R>(&self, to: impl Fn(S) -> R) -> ShearConstants<R> {
        ShearConstants {
            g1: to(self.g1),
            rise: to(self.rise),
            gamma1: to(self.gamma1),
            ramp: to(self.ramp),
            slope: to(self.slope),
        }
    }
}

/// Arc sine of a number in [−1, 1].
#[inline(always)]
pub(crate) fn arc_sine<R: Real>(x: R) -> R {
    let n = x;
    let half = n.splat_like(0.5);
    let size = x.abs().min(n.one());
    let small = size.le(half);
    // asin x = π/2 − 2 asin √((1 − x)/2) brings the upper half of the range into the polynomial's.
    let folds = (!small).any();
    let argument = if folds { R::select(small, size, (half * (n.one() - size)).sqrt()) } else { size };
    let square = argument.squared();
    // Horner for the even and for the odd powers of x²: neither waits for the other.
    let fourth = square.squared();
    let terms: &[f64] = if is_double::<R>() { &ARC_SINE } else { &ARC_SINE_SINGLE };
    let (mut even, mut odd) = (n.splat_like(terms[0]), n.zero());
    for pair in terms[1..].chunks_exact(2) {
        odd = odd.fused(fourth, n.splat_like(pair[0]));
        even = even.fused(fourth, n.splat_like(pair[1]));
    }
    let angle = argument * odd.fused(square, even);
    let angle = R::select(small, angle, n.splat_like(std::f64::consts::FRAC_PI_2) - n.splat_like(2.0) * angle);
    R::select(x.lt(n.zero()), -angle, angle)
}

/// Shear resultant q(γ) [N/m] at γ [rad].
#[inline(always)]
pub fn resultant<R: Real>(c: &ShearConstants<R>, gamma: R) -> R {
    let n = gamma;
    let size = gamma.abs();
    let into = (size - c.gamma1).max(n.zero()).min(c.ramp);
    let past = (size - c.gamma1 - c.ramp).max(n.zero());
    let q = c.g1 * size + n.splat_like(0.5) * c.slope * into.squared() + c.rise * past;
    R::select(gamma.lt(n.zero()), -q, q)
}

/// Shear energy per reference area, ∫q dγ [J/m²].
#[inline(always)]
pub fn energy<R: Real>(c: &ShearConstants<R>, gamma: R) -> R {
    let n = gamma;
    let size = gamma.abs();
    let half = n.splat_like(0.5);
    let third = n.splat_like(1.0 / 3.0);
    let into = (size - c.gamma1).max(n.zero()).min(c.ramp);
    let past = (size - c.gamma1 - c.ramp).max(n.zero());
    let base = half * c.g1 * size.squared();
    let ramp = half * third * c.slope * into * into * into;
    base + ramp + half * c.slope * into.squared() * past + half * c.rise * past.squared()
}

/// Sine of the shear angle, 79°, up to which (25) is followed. Beyond it the energy goes on at a constant slope over the sine, so that
/// yarns that come to lie along each other keep a finite force.
pub const STEEPEST: f64 = 0.98;

/// Trellis shear of an element at one time.
#[derive(Clone, Copy, Debug)]
pub struct Trellis<R> {
    /// dW/d(sin γ) [N/m]: q/cos γ up to [`STEEPEST`].
    pub slope: R,
    angle: R,
    beyond: R,
}

/// Trellis shear at the sine of an angle.
#[inline(always)]
pub fn trellis<R: Real>(c: &ShearConstants<R>, sine: R) -> Trellis<R> {
    let limit = sine.splat_like(STEEPEST);
    let followed = sine.max(-limit).min(limit);
    let angle = arc_sine(followed);
    let cosine = (-followed).fused(followed, sine.one()).sqrt();
    Trellis { slope: resultant(c, angle) / cosine, angle, beyond: (sine - followed).abs() }
}

impl<R: Real> Trellis<R> {
    /// Shear energy per reference area W [J/m²].
    #[inline(always)]
    pub fn energy(&self, c: &ShearConstants<R>) -> R {
        self.slope.abs().fused(self.beyond, energy(c, self.angle))
    }
}

/// Largest tangent modulus dq/dγ of the law [N/m], for the step bound.
pub(crate) fn largest_tangent(c: &ShearConstants<f64>) -> f64 {
    c.g1 + c.rise.max(0.0)
}

#[cfg(test)]
#[path = "shear_tests.rs"]
mod tests;
