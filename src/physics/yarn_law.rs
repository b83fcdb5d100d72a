//! One yarn of the unit cell: its arc length, tension and contact force for a given stretch and height, (13)–(19), for every law.
//!
//! The form of a yarn is a type, a sine in every run; what its forces are is a constant of the yarn, so that kernels are compiled once for all.
//!
//! A yarn z = h cos(πx/2w) spans 2w and has slope k = πh/(2w) at its ends. Its length is that of half an ellipse
//! with semi-axes 1 and a = √(1+k²), scaled: S = 2w·s(k), s = (2/π)·E(−k²). The Gauss–Kummer series of the
//! ellipse's perimeter converges like λ^2n with λ = k²/(a+1)², which is 0.02 at the crimp of a Kevlar fabric, and
//! s − 1 comes out without cancellation.

use crate::case::Law;
use crate::num::scalar::{Real, each, is_double};

/// Span or leg over its rest length below which a collapsed cell is not followed: slack, but finite.
pub const SHORTEST: f64 = 1e-9;

/// Ramps of a curve at most.
pub const RAMPS: usize = 15;

/// Tension over stiffness of a yarn by its strain: a sum of ramps, Σ rise·max(0, ε − start), the first from 0; none: the strain itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curve {
    /// Ramps.
    pub count: usize,
    /// Strains where they begin [-].
    pub start: [f64; RAMPS],
    /// Their slopes [-].
    pub rise: [f64; RAMPS],
}

impl Curve {
    /// Curve through points of strain [-] and stress [Pa] that rise from nothing, straight in between and beyond; the steepest slope is `modulus`.
    pub(crate) fn new(points: &[[f64; 2]], modulus: f64) -> Self {
        let mut curve = Self { count: points.len().saturating_sub(1).min(RAMPS), ..Self::default() };
        let mut last = 0.0;
        for (ramp, ends) in points.windows(2).take(RAMPS).enumerate() {
            let slope = (ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0]) / modulus;
            (curve.start[ramp], curve.rise[ramp]) = (ends[0][0], slope - last);
            last = slope;
        }
        curve
    }

    /// Σ rise·f(max(0, ε − start)).
    #[inline(always)]
    fn sum<R: Real>(&self, strain: R, f: impl Fn(R) -> R) -> R {
        let mut sum = strain.zero();
        for (start, rise) in self.start.iter().zip(&self.rise).take(self.count) {
            sum = f((strain - strain.splat_like(*start)).max(strain.zero())).fused(strain.splat_like(*rise), sum);
        }
        sum
    }

    /// Tension over stiffness at a strain, at least 0 [-].
    #[inline(always)]
    pub(crate) fn tension<R: Real>(&self, strain: R) -> R {
        if self.count == 0 { strain } else { self.sum(strain, |over| over) }
    }

    /// Slope of that at a strain above 0 [-].
    #[inline(always)]
    fn slope<R: Real>(&self, strain: R) -> R {
        self.sum(strain, |over| R::select(over.zero().lt(over), over.one(), over.zero()))
    }
}

/// Constants of one yarn in the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YarnConstants<R> {
    /// Axial stiffness E·A [N]; zero when the yarn is absent.
    pub stiffness: R,
    /// Half-span w0 [m].
    pub half_span: R,
    /// Crimp as this number type sees it, S0/(2w0) − 1 [-].
    pub crimp: R,
    /// Height h0 of the centreline at rest [m].
    pub height: R,
    /// Failure strain [-].
    pub failure_strain: R,
    /// Slope of the continuation of the contact force to slack yarns, dF/dε [N]; see [`YarnResponse::force`].
    pub slack_slope: R,
    /// 1/(1 + crimp) [-].
    pub per_rest: R,
    /// Terms of the arc length series that matter while this yarn can be taut.
    pub terms: usize,
    /// Its forces, where it is a sine.
    pub law: Law,
    /// Tension over stiffness.
    pub curve: Curve,
}

/// Response of one yarn at a given height.
#[derive(Clone, Copy, Debug)]
pub struct YarnResponse<R> {
    /// Axial strain S/S0 − 1 [-] (17).
    pub strain: R,
    /// Contact force F [N], odd in h (18); of a slack yarn, which presses with nothing, a negative continuation that
    /// keeps growing with h. Newton steps over onsets of tension with it instead of bouncing between them.
    pub force: R,
    /// dF/dh of `force` [N/m].
    pub stiffness: R,
    /// dε/dh [1/m].
    pub growth: R,
}

impl<R: Real> YarnConstants<R> {
    /// Strain of the yarn without crimp, straightened, at stretch Λ = 1 + `stretch` [-].
    #[inline(always)]
    pub fn straight(&self, stretch: R) -> R {
        (stretch - self.crimp) * self.per_rest
    }

    /// Tension at a strain [N] (17): a yarn carries no compression.
    #[inline(always)]
    pub fn tension(&self, strain: R) -> R {
        self.stiffness * self.curve.tension(strain.max(strain.zero()))
    }

    /// dT/dε of a taut yarn [N].
    #[inline(always)]
    pub fn modulus(&self, strain: R) -> R {
        if self.curve.count == 0 { self.stiffness } else { self.stiffness * self.curve.slope(strain) }
    }

    /// Tension over its slope, of a taut yarn [-]: the strain where they are in proportion.
    #[inline(always)]
    pub(crate) fn secant_strain(&self, strain: R) -> R {
        if self.curve.count == 0 { strain } else { self.curve.tension(strain) / self.curve.slope(strain) }
    }

    /// Whether two strains lie on one straight piece.
    #[inline(always)]
    pub(crate) fn is_straight(&self, from: R, to: R) -> R::Mask {
        if self.curve.count == 0 {
            return !from.never();
        }
        let [from, to] = [self.curve.slope(from), self.curve.slope(to)];
        from.le(to) & to.le(from)
    }

    /// Twice the energy per rest length of a yarn at a tension and its strain [N]; nothing where the tension is none.
    #[inline(always)]
    pub(crate) fn twice_energy(&self, tension: R, strain: R) -> R {
        if self.curve.count == 0 {
            return tension * strain;
        }
        let energy = self.stiffness * self.curve.sum(strain, |over| over * over);
        R::select(strain.zero().lt(tension), energy, strain.zero())
    }
}

impl<R: Real> YarnResponse<R> {
    /// `yes` where `mask` is true, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            strain: R::select(mask, yes.strain, no.strain),
            force: R::select(mask, yes.force, no.force),
            stiffness: R::select(mask, yes.stiffness, no.stiffness),
            growth: R::select(mask, yes.growth, no.growth),
        }
    }

    /// The response of a taut yarn after a rise of its height too small to bend the curve.
    #[inline(always)]
    pub fn raised(&self, rise: R) -> Self {
        let strain = self.growth.fused(rise, self.strain);
        Self { strain, force: self.stiffness.fused(rise, self.force), ..*self }
    }

    /// The contact force without its continuation: 0 where the yarn is slack.
    #[inline(always)]
    pub(crate) fn real_force(&self) -> R {
        let zero = self.strain.zero();
        R::select(zero.lt(self.strain), self.force, zero)
    }
}

/// Part of a yarn's response that depends on its stretch alone.
#[derive(Clone, Copy, Debug)]
pub struct StretchResponse<R> {
    /// Λ − 1 [-].
    pub(crate) stretch: R,
    /// Strain of the yarn were it straight [-].
    straight: R,
    /// Strain per excess of the arc's length over its span, Λ/(1 + crimp) and a little where the cell has collapsed [-].
    scale: R,
    /// End slope over height, π/(2 w0 Λ) [1/m].
    pub(crate) rise: R,
}

impl<R: Real> StretchResponse<R> {
    /// Λ [-].
    #[inline(always)]
    pub(crate) fn length(&self) -> R {
        self.stretch.one() + self.stretch
    }
}

/// Formulas of a law; resolved at compile time.
pub trait LawKernel: Copy + Send + Sync + 'static {
    /// Part of the response that depends on the stretch Λ = 1 + `stretch` alone.
    #[inline(always)]
    fn span<R: Real>(yarn: &YarnConstants<R>, stretch: R) -> StretchResponse<R> {
        let length = (stretch.one() + stretch).max(stretch.splat_like(SHORTEST));
        let rise = stretch.splat_like(std::f64::consts::FRAC_PI_2) / (yarn.half_span * length);
        StretchResponse { stretch, straight: yarn.straight(stretch), scale: length * yarn.per_rest, rise }
    }
    /// Tension, contact force and their derivatives of one yarn at height `h`.
    fn respond<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> YarnResponse<R>;
    /// In-plane force over tension.
    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> R;
    /// The response at stretch Λ = 1 + `stretch` and height `h`.
    #[inline(always)]
    fn yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R> {
        Self::respond(yarn, &Self::span(yarn, stretch), h)
    }
}

/// A yarn on a sine, with the forces of its [`Law`].
#[derive(Clone, Copy, Debug)]
pub struct Sinusoidal;

impl LawKernel for Sinusoidal {
    #[inline(always)]
    fn respond<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> YarnResponse<R> {
        let k = h * span.rise;
        let arc = arc_length(k, yarn.terms);
        let strain = span.scale.fused(arc.excess, span.straight);
        let taut = h.zero().lt(strain);
        let tension = yarn.tension(strain);
        let growth = span.scale * span.rise * arc.slope;
        let modulus = yarn.modulus(strain);
        let (force, stiffness) = if yarn.law == Law::Variational {
            let pi = h.splat_like(std::f64::consts::PI);
            let stiffness = pi * (arc.curvature * span.rise * tension + arc.slope * (modulus * growth));
            (pi * arc.slope * tension, stiffness)
        } else {
            let cosine = arc.cosine;
            let twice = h.splat_like(2.0) * cosine;
            let sine = twice * k;
            let turning = tension * (twice * cosine.squared() * span.rise);
            (tension * sine, (modulus * growth).fused(sine, turning))
        };
        YarnResponse {
            strain,
            force: R::select(taut, force, yarn.slack_slope * strain),
            stiffness: R::select(taut, stiffness, yarn.slack_slope * growth),
            growth,
        }
    }

    #[inline(always)]
    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> R {
        if yarn.law == Law::Published {
            return h.one();
        }
        let k = h * span.rise;
        let arc = arc_length(k, yarn.terms);
        h.one() + arc.excess - k * arc.slope
    }
}

/// Squares of the binomial coefficients C(1/2, n), n = 1…12: the Gauss–Kummer series in λ².
pub const SERIES: [f64; 12] = [
    1.0 / 4.0,
    1.0 / 64.0,
    1.0 / 256.0,
    25.0 / 16384.0,
    49.0 / 65536.0,
    441.0 / 1_048_576.0,
    1089.0 / 4_194_304.0,
    184_041.0 / 1_073_741_824.0,
    511_225.0 / 4_294_967_296.0,
    5_909_761.0 / 68_719_476_736.0,
    17_631_601.0 / 274_877_906_944.0,
    863_948_449.0 / 17_592_186_044_416.0,
];

/// Coefficients of the derivative.
const SLOPES: [f64; MAX_TERMS] = {
    let mut slopes = SERIES;
    let mut n = 1;
    while n < MAX_TERMS {
        slopes[n] *= (n + 1) as f64;
        n += 1;
    }
    slopes
};

/// Length ratio of a sinusoidal yarn and its derivatives at end slope k.
#[derive(Clone, Copy, Debug)]
pub struct ArcLength<R> {
    /// s − 1 = S/(2w) − 1 [-].
    pub excess: R,
    /// ds/dk [-].
    pub slope: R,
    /// d²s/dk² [-].
    pub curvature: R,
    /// cos α = 1/√(1 + k²) [-].
    pub cosine: R,
}

/// Terms of the series that are ever needed.
pub const MAX_TERMS: usize = SERIES.len();

/// Terms that keep the truncation of s below `error` for end slopes up to `k`.
pub(crate) fn terms_for(k: f64, error: f64) -> usize {
    let secant = (1.0 + k * k).sqrt();
    let x = (k * k / (secant + 1.0).powi(2)).powi(2);
    let mut term = x;
    for n in 0..MAX_TERMS - 1 {
        term *= x;
        if SERIES[n + 1] * term < error {
            return n + 1;
        }
    }
    MAX_TERMS
}

/// Evaluates s(k) − 1, s′ and s″ for any real end slope k with the given number of terms, or one more.
///
/// Truncation error of s with all terms: below 1e-16 for |k| ≤ 1.5 (crimp of 40 %), 1e-9 at |k| = 4.4. Fewer terms
/// keep s increasing in |k|.
#[inline(always)]
pub fn arc_length<R: Real>(k: R, terms: usize) -> ArcLength<R> {
    let n = k;
    let one = n.one();
    let half = n.splat_like(0.5);
    let square = k.squared();
    let secant = k.fused(k, one).sqrt();
    let a2 = secant + one;
    // One division for 1/√(1 + k²) and 1/(√(1 + k²) + 1).
    let both = one / (secant * a2);
    let (inverse_secant, a1) = (a2 * both, secant * both);
    let a_minus_1 = square * a1;
    let lambda = a_minus_1 * a1;
    let x = lambda.squared();
    // Horner for the series G(x) − 1 = x·p(x) and its derivative G′(x), even powers beside odd ones: none waits for another.
    // One series after the other: both at once do not fit into sixteen registers.
    let square_x = x.squared();
    let (mut p, mut dg) = ([n.zero(); 2], [n.zero(); 2]);
    for pair in (0..terms.div_ceil(2)).rev() {
        p = each!(i in 2 => p[i].fused(square_x, n.splat_like(SERIES[2 * pair + i])));
    }
    for pair in (0..terms.div_ceil(2)).rev() {
        dg = each!(i in 2 => dg[i].fused(square_x, n.splat_like(SLOPES[2 * pair + i])));
    }
    let g_minus_1 = x * x.fused(p[1], p[0]);
    let dg = x.fused(dg[1], dg[0]);
    let excess = half * a2.fused(g_minus_1, a_minus_1);
    let twice = n.splat_like(2.0) * lambda;
    // In single precision in the order of the shaders.
    let b = if is_double::<R>() {
        (twice * a1).fused(dg, half.fused(g_minus_1, half))
    } else {
        half * (one + g_minus_1) + twice * dg * a1
    };
    let slope = k * inverse_secant * b;
    // E(−k²) obeys k s″ + s′ = k s/(1 + k²), which gives the second derivative without another series.
    let curvature = (one + excess) * inverse_secant.squared() - b * inverse_secant;
    ArcLength { excess, slope, curvature, cosine: inverse_secant }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_terms_are_exact_up_to_their_slope() {
        for k in [0.1_f64, 0.3, 0.6, 1.0] {
            let few = arc_length(k, terms_for(k, 1e-17)).excess;
            assert!((few - arc_length(k, MAX_TERMS).excess).abs() < 1e-16, "k = {k}");
            let few = terms_for(k, 1e-10);
            assert!((arc_length(k, few).excess - arc_length(k, MAX_TERMS).excess).abs() < 1e-10, "k = {k}");
            assert!(few < terms_for(k, 1e-17), "k = {k}");
        }
        assert!(terms_for(0.6, 1e-17) <= 6 && terms_for(3.0, 1e-17) == MAX_TERMS);
    }

    #[test]
    fn derivatives_match_differences() {
        for k in [0.02, 0.3, 0.9, 1.4, -0.4] {
            let at = |k| arc_length(k, MAX_TERMS);
            let step = 1e-5;
            let (s, plus, minus) = (at(k), at(k + step), at(k - step));
            assert!((s.slope - (plus.excess - minus.excess) / (2.0 * step)).abs() < 1e-9, "k = {k}");
            assert!((s.curvature - (plus.slope - minus.slope) / (2.0 * step)).abs() < 1e-9, "k = {k}");
        }
    }
}
