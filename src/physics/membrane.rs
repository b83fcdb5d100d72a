//! In-plane forces of an element: yarns, trellis shear (25) that fades where a yarn is folded.
//!
//! The shear modulus G is the tangent modulus, so the shear resultant is q = t·∫G dγ: odd in γ and continuous where locking begins and ends.

use crate::case::{Shear, ShearModulus};
use crate::num::scalar::{Mask, Real, Scalar, each, is_double};
use crate::physics::kinematics::{ElementGeometry, Kinematics, Vector};

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
    pub fn new(shear: Option<&Shear>, thickness: f64) -> Self {
        let none = Shear { g1: 0.0, g2: 0.0, gamma1: 0.0, gamma2: 0.0, modulus: ShearModulus::Tangent };
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
pub fn shear_energy<R: Real>(c: &ShearConstants<R>, gamma: R) -> R {
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
        self.slope.abs().fused(self.beyond, shear_energy(c, self.angle))
    }
}

/// Largest tangent modulus dq/dγ of the law [N/m], for the step bound.
pub(crate) fn largest_tangent(c: &ShearConstants<f64>) -> f64 {
    c.g1 + c.rise.max(0.0)
}

/// Stretch of a yarn below which it counts as folded: its element's trellis energy fades with the stretch, so that a crumpled
/// element keeps a bounded stiffness and a force that is the slope of an energy. Enters the step bound.
pub const FOLDED_STRETCH: f64 = 0.5;
/// Largest fade(Λ)/Λ: the lever of shear in a folded element over 1.
pub const LONGEST_LEVER: f64 = 1.125 / FOLDED_STRETCH;

/// Trellis shear of an element as its membrane feels it, fading where a yarn is folded: the energy per reference area is
/// fade(Λ1) fade(Λ2) W(sin γ).
#[derive(Clone, Copy)]
pub(crate) struct FadedShear<R> {
    /// Slope of that energy over sin γ, over Λ1 and over Λ2 [N/m].
    pub(crate) slope: R,
    pub(crate) along: [R; 2],
    /// The energy [J/m²].
    pub(crate) energy: R,
}

/// `wanted`: whether the energy is asked for.
#[inline(always)]
pub(crate) fn trellis_shear<R: Real>(c: &ShearConstants<R>, k: &Kinematics<R>, wanted: bool) -> FadedShear<R> {
    let trellis = trellis(c, k.sine);
    let (zero, one) = (k.sine.zero(), k.sine.one());
    let part = each!(i in 2 => ((one + k.extension[i]) * one.splat_like(1.0 / FOLDED_STRETCH)).min(one));
    if !(part[0].lt(one) | part[1].lt(one)).any() {
        let energy = if wanted { trellis.energy(c) } else { zero };
        return FadedShear { slope: trellis.slope, along: [zero; 2], energy };
    }
    let fade = each!(i in 2 => part[i].squared() * (one.splat_like(3.0) - one.splat_like(2.0) * part[i]));
    let rise = each!(i in 2 => one.splat_like(6.0 / FOLDED_STRETCH) * part[i] * (one - part[i]));
    let energy = trellis.energy(c);
    FadedShear {
        slope: trellis.slope * (fade[0] * fade[1]),
        along: [energy * (rise[0] * fade[1]), energy * (rise[1] * fade[0])],
        energy: energy * (fade[0] * fade[1]),
    }
}

impl<R: Real> FadedShear<R> {
    /// Shear where `mask` is true, nothing elsewhere.
    #[inline(always)]
    pub(crate) fn only(&self, mask: R::Mask) -> Self {
        let zero = self.slope.zero();
        let part = |x: R| R::select(mask, x, zero);
        Self { slope: part(self.slope), along: self.along.map(part), energy: part(self.energy) }
    }
}

/// P1·Ly/2 and P2·Lx/2 [N] from in-plane yarn forces and trellis shear, if there is any.
#[inline(always)]
pub(crate) fn membrane<R: Real>(
    c: &ElementGeometry<R>,
    k: &Kinematics<R>,
    in_plane: &[R; 2],
    shear: Option<&FadedShear<R>>,
) -> (Vector<R>, Vector<R>) {
    let [e1, e2] = k.direction;
    let (n1, n2) = (in_plane[0] * c.membrane[0], in_plane[1] * c.membrane[1]);
    let Some(shear) = shear else {
        return (each!(a in 3 => n1 * e1[a]), each!(a in 3 => n2 * e2[a]));
    };
    let n1 = shear.along[0].fused(c.half_length[0], n1);
    let n2 = shear.along[1].fused(c.half_length[1], n2);
    let q1 = shear.slope * c.half_length[0] * k.per_stretch[0];
    let q2 = shear.slope * c.half_length[1] * k.per_stretch[1];
    (
        each!(a in 3 => n1.fused(e1[a], q1 * (-k.sine).fused(e1[a], e2[a]))),
        each!(a in 3 => n2.fused(e2[a], q2 * (-k.sine).fused(e2[a], e1[a]))),
    )
}

/// Force on the difference of opposite edges [N], which corners have with the signs of the hourglass mode. `in_plane`: in-plane forces of the
/// yarns without shock viscosity, which acts along the yarn at the centre alone.
#[inline(always)]
pub(crate) fn mode_force<R: Real>(
    c: &ElementGeometry<R>,
    k: &Kinematics<R>,
    in_plane: &[R; 2],
    shear: Option<&FadedShear<R>>,
) -> Vector<R> {
    let along = each!(i in 2 => {
        let n = in_plane[i] * c.membrane[i];
        match shear {
            // The sine of the shear angle falls as the stretch grows.
            Some(shear) => c.half_length[i].fused(shear.along[i] - shear.slope * k.per_stretch[i] * k.sine, n),
            None => n,
        }
    });
    let stiffness = along[0].fused(k.per_mode[0], along[1] * k.per_mode[1]);
    each!(a in 3 => stiffness * k.mode[a])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shear([gamma1, gamma2]: [f64; 2]) -> ShearConstants<f64> {
        ShearConstants::new(Some(&Shear { g1: 1e7, g2: 1e9, gamma1, gamma2, modulus: ShearModulus::Tangent }), 3e-4)
    }

    #[test]
    fn arc_sine_is_exact_to_rounding() {
        for i in -1000..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((arc_sine(x) - x.asin()).abs() < 4e-16, "{x}");
            assert!((arc_sine(x as f32) - (x as f32).asin()).abs() < 3e-7, "{x}");
        }
    }

    #[test]
    fn the_slope_over_the_sine_is_that_of_the_energy_at_any_angle() {
        for (i, range) in (-99..=99).flat_map(|i| [[0.35, 0.6], [0.0, 0.0], [0.2, 0.2]].map(|range| (i, range))) {
            let c = shear(range);
            let (sine, step) = (0.01 * f64::from(i) + 0.0013, 1e-6);
            let energy = |sine: f64| trellis(&c, sine).energy(&c);
            let slope = (energy(sine + step) - energy(sine - step)) / (2.0 * step);
            let got = trellis(&c, sine).slope;
            assert!((slope - got).abs() < 1e-5 * got.abs().max(1e3), "{range:?} {sine}: {slope} {got}");
        }
    }

    #[test]
    fn the_largest_tangent_is_the_steepest_slope_of_the_resultant() {
        let c = shear([0.35, 0.6]);
        let slope = |gamma: f64| (resultant(&c, gamma + 1e-7) - resultant(&c, gamma - 1e-7)) / 2e-7;
        let steepest = (1..15_000).map(|i| slope(1e-4 * f64::from(i) + 3e-5)).fold(0.0, f64::max);
        let got = largest_tangent(&c);
        assert!((got / steepest - 1.0).abs() < 1e-3, "{got} for {steepest}");
    }
}
