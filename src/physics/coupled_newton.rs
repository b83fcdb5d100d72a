//! The unit cell's fast iteration: Newton on both heights and the compression together.
//!
//! Compatibility (22) says x + y + d = H. With q = (F + (b/a)³)^(−1/3) the compression d = a − b q is linear, so the
//! one strong nonlinearity of the cell, the crossover's stiffening, is not in the way of Newton's steps: each
//! linearises the contact forces of both yarns at their heights and that of the compression at q, and finds the
//! force the three have in balance. Both yarns are evaluated side by side, without waiting for each other.
//!
//! Two evaluations suffice from one time step to the next, most often: where a step is so small that the curves cannot bend away
//! from their tangents by more than the residual accepted, it is taken along the tangents. Nothing guards the iteration:
//! cells it leaves go to the safeguarded one of [`super::crossover`], which cannot fail.

use crate::num::scalar::{Mask, Real, each};
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::{LawKernel, StretchResponse, YarnResponse};

/// Evaluations allowed before the safeguarded iteration takes over.
pub const NEWTON_ITERATIONS: u32 = 7;

/// Misfit of compatibility accepted, over the sum of heights [-], as far as the precision goes.
pub const COMPATIBILITY_TOLERANCE: f64 = 1e-12;

/// Strain by which a step along the tangents may miss the curve, as far as the precision goes [-].
pub(crate) const ROUNDOFF_TOLERANCE: f64 = 5e-15;

/// End of the iteration.
pub(crate) struct NewtonResult<R: Real> {
    /// Heights of the pivot and of the other yarn [m].
    pub(crate) height: [R; 2],
    /// Their responses there.
    pub(crate) yarn: [YarnResponse<R>; 2],
    /// Predictor of the heights.
    pub(crate) predictor: Predictor<R>,
    /// Evaluations.
    pub(crate) iterations: R,
    /// Bound of the error of the responses, where these are tangents [N].
    pub(crate) bound: R,
    /// Cells where equilibrium and compatibility are met.
    pub(crate) met: R::Mask,
}

/// Iterates the cells of `active` from the heights of the pivot and of the other yarn.
#[inline(always)]
pub(crate) fn iterate<R: Real, L: LawKernel>(
    cell: &UnitCellParameters<R>,
    span: &[StretchResponse<R>; 2],
    height: [R; 2],
    active: R::Mask,
) -> NewtonResult<R> {
    let n = cell.height_sum;
    let (zero, one) = (n.zero(), n.one());
    let index = [cell.pivot, 1 - cell.pivot];
    let [a, b, offset] = cell.compression;
    let rigid = a.le(zero);
    let uncompressed = cell.uncompressed_limit;
    let tight = n.splat_like(1e-2) * uncompressed;
    let compatibility = n.splat_like(COMPATIBILITY_TOLERANCE.max(8.0 * R::EPSILON)) * cell.height_sum;
    let roundoff = n.splat_like(ROUNDOFF_TOLERANCE.max(0.5 * R::EPSILON));
    let mut q = opening(cell, height[0] + height[1]).max(tight);
    let mut height = [height[0], other_height(cell, height[0], q)];
    let mut yarn = each!(i in 2 => L::respond(&cell.yarn[index[i]], &span[index[i]], height[i]));
    let mut iterations = R::select(active, one, zero);
    let mut bound = zero;
    let mut pending = active;
    for round in 0..NEWTON_ITERATIONS {
        let cube = q * q * q;
        // The force that compresses by a − b q, and its compliance.
        let force = R::select(rigid, yarn[0].force, one / cube - offset);
        let compliance = b * q * cube * n.splat_like(1.0 / 3.0);
        let [sp, so] = each!(i in 2 => yarn[i].stiffness.max(cell.min_stiffness));
        // How far the heights miss the compression of the pivot's force, but for what that rounds to; and with it what
        // the residual F_p(x) − F_o(H − d(F_p) − x) would be, at most.
        let misfit = compliance * ((yarn[0].force - force).abs() - cell.roundoff_tolerance).max(zero);
        let off = so.fused(misfit, (yarn[0].force - yarn[1].force).abs());
        let limit = cell.accepted(yarn[0].force);
        let taut = each!(i in 2 => zero.lt(yarn[i].strain));
        // Both yarns slack although the crossover is not compressed: nothing presses.
        let slack = (rigid | uncompressed.le(q)) & !(taut[0] | taut[1]);
        let done = (off.le(limit) & misfit.le(compatibility)) | slack;
        pending = pending & !done;
        if round + 1 == NEWTON_ITERATIONS || !pending.any() {
            break;
        }
        let (new, next) = along_tangents(cell, &yarn, [sp, so], height, q, [force, compliance]);
        let rise = each!(i in 2 => new[i] - height[i]);
        let raised = each!(i in 2 => yarn[i].raised(rise[i]));
        // What the curves bend away from their tangents over this step: F″h ≤ 3F′ and ε″h ≤ ε′ of a yarn in any law, twice
        // as much for q.
        let bend = each!(i in 2 => {
            let square = rise[i].squared();
            let force = (n.splat_like(4.0) * yarn[i].stiffness * square).le(limit * height[i]);
            force & (yarn[i].growth * square).le(roundoff * height[i])
        });
        let bend_q = (n.splat_like(4.0) * b * (next - q).squared()).le(compatibility * q);
        let balanced = (raised[0].force - raised[1].force).abs().le(limit);
        let stays = each!(i in 2 => {
            let is_straight = cell.yarn[index[i]].is_straight(yarn[i].strain, raised[i].strain);
            taut[i] & zero.lt(raised[i].strain) & is_straight
        });
        let last = pending & bend[0] & bend[1] & bend_q & balanced & stays[0] & stays[1];
        height = each!(i in 2 => R::select(pending, new[i], height[i]));
        q = R::select(pending, next, q);
        yarn = each!(i in 2 => YarnResponse::select(last, raised[i], yarn[i]));
        bound = R::select(last, limit, bound);
        pending = pending & !last;
        if !pending.any() {
            break;
        }
        yarn = each!(i in 2 => {
            let there = L::respond(&cell.yarn[index[i]], &span[index[i]], height[i]);
            YarnResponse::select(pending, there, yarn[i])
        });
        iterations = iterations + R::select(pending, one, zero);
    }
    let compliance = b * q * (q * q * q) * n.splat_like(1.0 / 3.0);
    let stiffness = each!(i in 2 => yarn[i].stiffness.max(cell.min_stiffness));
    let secant = each!(i in 2 => cell.yarn[index[i]].secant_strain(yarn[i].strain));
    let length = each!(i in 2 => span[index[i]].length());
    let predictor = Predictor::of(&yarn, secant, stiffness, compliance, height, length);
    NewtonResult { height, yarn, predictor, iterations, bound, met: active & !pending }
}

/// Heights of both yarns, and q, where the tangents have one force: Σ F/S over Σ 1/S. `force`, `compliance`: the force of the compression at
/// `q` and its compliance.
#[inline(always)]
fn along_tangents<R: Real>(
    cell: &UnitCellParameters<R>,
    yarn: &[YarnResponse<R>; 2],
    [sp, so]: [R; 2],
    height: [R; 2],
    q: R,
    [force, compliance]: [R; 2],
) -> ([R; 2], R) {
    let n = cell.height_sum;
    // One division for all.
    let product = sp * so;
    let soft = compliance * product;
    let sum = sp + so + soft;
    let inverse = n.one() / (product * sum);
    let between = yarn[1].force - yarn[0].force;
    let climb = [
        so * between.fused(sp, (force - yarn[0].force) * soft),
        sp * (-between).fused(so, (force - yarn[1].force) * soft),
    ];
    let pivot = climb[0].fused(inverse, height[0]).max(n.zero()).min(cell.height_sum);
    let other = climb[1].fused(inverse, height[1]);
    let next = opening(cell, pivot + other).max(q * n.splat_like(0.3));
    ([pivot, other_height(cell, pivot, next)], next)
}

/// q = (a − d)/b where the heights sum up to `sum`; a compression that is none but for rounding is none.
#[inline(always)]
fn opening<R: Real>(cell: &UnitCellParameters<R>, sum: R) -> R {
    let q = (sum - (cell.height_sum - cell.compression[0])) * cell.per_b;
    let least = cell.uncompressed_limit - sum.splat_like(4.0 * R::EPSILON) * cell.height_sum * cell.per_b;
    R::select(least.le(q), cell.uncompressed_limit, q)
}

/// Height that compatibility leaves the other yarn: H − d − x, where d = a − b q is 0 once the crossover is uncompressed.
#[inline(always)]
fn other_height<R: Real>(cell: &UnitCellParameters<R>, x: R, q: R) -> R {
    let [a, b, _] = cell.compression;
    let d = R::select(cell.uncompressed_limit.le(q), x.zero(), a - b * q);
    cell.height_sum - d - x
}

/// Strain below which a yarn is not followed: F/ε is of two numbers that vanish.
pub const LEAST_STRAIN: f64 = 1e-6;

/// Change of the two heights of a cell with its two stretches, to first order.
#[derive(Clone, Copy, Debug)]
pub struct Predictor<R> {
    /// t: what a height falls by, per stretch, at constant contact force [m].
    pub dh_dstretch: [R; 2],
    /// 1/S over 1/S₁ + 1/S₂ + c [-].
    pub force_share: [R; 2],
}

impl<R: Real> Predictor<R> {
    /// Predictor of a cell in equilibrium: its yarns, their tensions over the slopes of these [-], slopes S [N/m], the compliance c of the crossover [m/N], heights [m] and stretches Λ.
    #[inline(always)]
    pub(crate) fn of(
        yarn: &[YarnResponse<R>; 2],
        secant: [R; 2],
        slope: [R; 2],
        compliance: R,
        height: [R; 2],
        length: [R; 2],
    ) -> Self {
        let one = compliance.one();
        let least = compliance.splat_like(LEAST_STRAIN);
        let below = each!(i in 2 => secant[i].max(least) * slope[i] * length[i]);
        let per_both = one / (below[0] * below[1]);
        let per_sum = one / compliance.fused(slope[0] * slope[1], slope[0] + slope[1]);
        Self {
            dh_dstretch: each!(i in 2 => {
                let strain = yarn[i].strain;
                let above = yarn[i].force.fused(one + strain, -(height[i] * slope[i] * secant[i]));
                let fall = above * (below[1 - i] * per_both);
                // No number that is not finite passes either.
                R::select(least.lt(strain) & fall.abs().lt(one), fall, compliance.zero())
            }),
            force_share: each!(i in 2 => slope[1 - i] * per_sum),
        }
    }

    /// Heights after the stretches have grown by `change`.
    #[inline(always)]
    pub fn heights(&self, height: [R; 2], change: [R; 2]) -> [R; 2] {
        let push = self.dh_dstretch[0].fused(change[0], self.dh_dstretch[1] * change[1]);
        each!(i in 2 => self.force_share[i].fused(push, height[i]) - self.dh_dstretch[i] * change[i])
    }
}
