//! One yarn of the unit cell: tension and contact force for a given stretch and height, (13)–(19), for every law.
//!
//! The form of a yarn is a type, a sine in every run; what its forces are is a constant of the yarn, so that kernels are compiled once for all.

use crate::case::Law;
use crate::num::scalar::Real;
use crate::physics::arc_length::arc_length;

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
