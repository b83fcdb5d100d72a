//! Constants of the unit cell, from the fabric and for each number type: (12), (14), (15).

use crate::case::Fabric;
use crate::num::scalar::{Real, Scalar, bisect, each, is_double};
use crate::physics::yarn_law::{Curve, LawKernel, MAX_TERMS, YarnConstants, arc_length, terms_for};

/// Stands for the failure strain of a yarn that does not break.
pub(crate) const NEVER: f64 = 1e30;

/// Truncation error of the length of a yarn over its span [-]: less than it rounds to.
const TRUNCATION: f64 = 1e-17;
/// Truncation error in single precision [-].
const SINGLE_TRUNCATION: f64 = 1e-10;

/// Constants of the unit cell, rounded to the number type that uses them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitCellParameters<R> {
    /// Warp, weft.
    pub yarn: [YarnConstants<R>; 2],
    /// H = h01 + h02 − g, the sum of heights at zero contact force, at least 0 [m].
    pub height_sum: R,
    /// Compression constants a [m], b [m·N^(1/3)], (b/a)³ [N]; all zero when rigid.
    pub compression: [R; 3],
    /// a/b and 1/b, where there is compression; else 1 and 0.
    pub uncompressed_limit: R,
    /// See `uncompressed_limit`.
    pub per_b: R,
    /// Least stiffness of a contact force that Newton's steps reckon with [N/m].
    pub min_stiffness: R,
    /// Rounding of a contact force [N]; 0 in double precision.
    pub roundoff_tolerance: R,
    /// Index of the yarn whose height is the unknown: the softer one.
    pub pivot: usize,
    /// Residual accepted by the iteration [N].
    pub tolerance: R,
}

impl UnitCellParameters<f64> {
    /// Constants of `fabric`'s cell in double precision. Heights at rest solve (15).
    pub fn new(fabric: &Fabric) -> Self {
        Self::with_rest_height(fabric, rest_height)
    }

    /// Constants of `fabric`'s cell with heights at rest, over the half-span, by crimp.
    pub(crate) fn with_rest_height(fabric: &Fabric, rest_height: fn(f64) -> f64) -> Self {
        let yarn = [&fabric.warp, &fabric.weft].map(|y| YarnConstants {
            stiffness: if y.present { y.modulus * y.area(fabric.fibre_density) } else { 0.0 },
            half_span: y.half_span(),
            crimp: y.crimp,
            height: y.half_span() * rest_height(y.crimp),
            failure_strain: y.breaking_strain().unwrap_or(NEVER),
            slack_slope: 0.0,
            per_rest: 1.0 / (1.0 + y.crimp),
            terms: MAX_TERMS,
            law: fabric.crossover.law,
            curve: Curve::new(&y.curve, y.modulus),
        });
        let both = fabric.warp.present && fabric.weft.present;
        let height_sum = if both { (yarn[0].height + yarn[1].height - fabric.crossover.gap).max(0.0) } else { 0.0 };
        let yarn = yarn.map(|y| {
            let rise = rest_slope(&y);
            let slack = 2.0 * y.stiffness * (rise / rise.hypot(1.0)).max(0.05);
            YarnConstants { slack_slope: slack, terms: terms_for(steepest(&y, height_sum), TRUNCATION), ..y }
        });
        let [a, b] = fabric.crossover.compression.map_or([0.0; 2], |c| [c.a, c.b]);
        let offset = if a > 0.0 { (b / a).powi(3) } else { 0.0 };
        let softer = yarn[0].stiffness.min(yarn[1].stiffness);
        Self {
            yarn,
            height_sum,
            compression: [a, b, offset],
            uncompressed_limit: if a > 0.0 { a / b } else { 1.0 },
            per_b: if a > 0.0 { 1.0 / b } else { 0.0 },
            min_stiffness: 1e-6 * yarn[0].stiffness.max(yarn[1].stiffness) / yarn[0].half_span,
            roundoff_tolerance: 0.0,
            pivot: usize::from(yarn[1].stiffness < yarn[0].stiffness),
            tolerance: 1e-12 * softer,
        }
    }
}

impl<R: Real> UnitCellParameters<R> {
    /// The residual that counts as met where the contact force is `force` [N].
    #[inline(always)]
    pub fn accepted(&self, force: R) -> R {
        self.tolerance + force.splat_like(8.0 * R::EPSILON) * force.abs()
    }
}

impl<S: Scalar> UnitCellParameters<S> {
    /// The constants as another precision sees them.
    ///
    /// The crimp is taken from this precision's own arc length at its own rest height, plus a few roundings, so that a
    /// fabric at rest is exactly tension-free: what no wave has reached stays at rest to the last bit.
    pub fn cast<L: LawKernel>(cell: &UnitCellParameters<f64>) -> Self {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        let crimped = |bare: &YarnConstants<S>, height: S| {
            // At zero crimp the strain of the resting yarn is its length in excess of the span.
            let excess = L::yarn(bare, zero, height).strain;
            let crimp = excess * S::splat(1.0 + 4.0 * S::EPSILON);
            YarnConstants { crimp, per_rest: one / (one + crimp), ..*bare }
        };
        let cast = cell.map(S::splat);
        let truncation = if is_double::<S>() { TRUNCATION } else { SINGLE_TRUNCATION };
        let bare = each!(i in 2 => {
            let terms = terms_for(steepest(&cell.yarn[i], cell.height_sum), truncation);
            YarnConstants { crimp: zero, per_rest: one, terms, ..cast.yarn[i] }
        });
        // The other yarn rests at what the pivot leaves of the height, a rounding away from its own.
        let (p, o) = (cell.pivot, 1 - cell.pivot);
        let left = cast.height_sum - bare[p].height;
        let mut yarn = bare;
        yarn[p] = crimped(&bare[p], bare[p].height);
        yarn[o] = crimped(&bare[o], Real::max(left, bare[o].height));
        if is_double::<S>() {
            return Self { yarn, ..cast };
        }
        let noise = S::splat(0.05 * S::EPSILON * cell.yarn[p].stiffness);
        // The force of the stiffer yarn has no more digits than its strain, which the softer one cannot ask for.
        let stiffer = cell.yarn[0].stiffness.max(cell.yarn[1].stiffness);
        let tolerance = (cell.tolerance * 2e4).max(0.04 * S::EPSILON * stiffer);
        Self { yarn, roundoff_tolerance: noise, tolerance: S::splat(tolerance), ..cast }
    }

    /// Constants in other numbers.
    pub(crate) fn map<R>(&self, to: impl Fn(S) -> R) -> UnitCellParameters<R> {
        UnitCellParameters {
            yarn: self.yarn.map(|y| YarnConstants {
                stiffness: to(y.stiffness),
                half_span: to(y.half_span),
                crimp: to(y.crimp),
                height: to(y.height),
                failure_strain: to(y.failure_strain),
                slack_slope: to(y.slack_slope),
                per_rest: to(y.per_rest),
                terms: y.terms,
                law: y.law,
                curve: y.curve,
            }),
            height_sum: to(self.height_sum),
            compression: self.compression.map(&to),
            uncompressed_limit: to(self.uncompressed_limit),
            per_b: to(self.per_b),
            min_stiffness: to(self.min_stiffness),
            roundoff_tolerance: to(self.roundoff_tolerance),
            pivot: self.pivot,
            tolerance: to(self.tolerance),
        }
    }
}

/// The steepest end slope at which the length of a yarn matters.
fn steepest(yarn: &YarnConstants<f64>, height_sum: f64) -> f64 {
    steepest_taut(yarn, height_sum).max(rest_slope(yarn))
}

/// End slope of a yarn at rest.
fn rest_slope(yarn: &YarnConstants<f64>) -> f64 {
    yarn.height * std::f64::consts::FRAC_PI_2 / yarn.half_span
}

/// End slope at the shortest span at which the yarn is still taut at the greatest height there is: steeper yarns are
/// slack, and their length only has to be known to be too short.
fn steepest_taut(yarn: &YarnConstants<f64>, height_sum: f64) -> f64 {
    let slope = |length: f64| std::f64::consts::FRAC_PI_2 * height_sum / (yarn.half_span * length);
    let is_slack = |length: f64| length * (1.0 + arc_length(slope(length), MAX_TERMS).excess) < 1.0 + yarn.crimp;
    let [_, taut] = bisect([0.01, 1.0 + yarn.crimp], 50, is_slack);
    slope(taut)
}

/// Height over half-span at rest for a crimp (15): Newton on s(k) = 1 + crimp.
fn rest_height(crimp: f64) -> f64 {
    if crimp <= 0.0 {
        return 0.0;
    }
    let mut k = 2.0 * crimp.sqrt();
    for _ in 0..50 {
        let s = arc_length(k, MAX_TERMS);
        let step = (s.excess - crimp) / s.slope;
        k -= step;
        if step.abs() <= 1e-16 * k {
            break;
        }
    }
    k * std::f64::consts::FRAC_2_PI
}
