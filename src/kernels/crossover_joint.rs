//! The unit cell's fast iteration: Newton on both heights and the compression together.
//!
//! Compatibility (22) says x + y + d = H. With q = (F + (b/a)³)^(−1/3) the compression d = a − b q is linear, so the
//! one strong nonlinearity of the cell, the crossover's stiffening, is not in the way of Newton's steps: each
//! linearises the contact forces of both yarns at their heights and that of the compression at q, and finds the
//! force the three have in balance. Both yarns are evaluated side by side, without waiting for each other.
//!
//! Three steps suffice from one time step to the next. Nothing guards it: cells it leaves go to the bracketed
//! iteration of [`super::crossover`], which cannot fail.

use crate::kernels::cell_constants::CellConstants;
use crate::kernels::yarn_law::{LawKernel, Span, YarnResponse};
use crate::number::{Mask, Real, each};

/// Evaluations allowed before the bracketed iteration takes over.
pub const JOINT_ITERATIONS: u32 = 7;

/// Misfit of compatibility accepted, over the sum of heights [-], as far as the precision goes.
pub const SLIP: f64 = 1e-12;

/// Where the iteration ended.
pub(super) struct Joint<R: Real> {
    /// Heights of the pivot and of the other yarn [m].
    pub(super) height: [R; 2],
    /// Their responses there.
    pub(super) yarn: [YarnResponse<R>; 2],
    /// Evaluations.
    pub(super) iterations: R,
    /// Where equilibrium and compatibility are met.
    pub(super) met: R::Mask,
}

/// Iterates the cells of `active` from the heights of the pivot and of the other yarn.
#[inline(always)]
pub(super) fn iterate<R: Real, L: LawKernel>(
    cell: &CellConstants<R>,
    span: &[Span<R>; 2],
    height: [R; 2],
    active: R::Mask,
) -> Joint<R> {
    let n = cell.height_sum;
    let (zero, one) = (n.zero(), n.one());
    let index = [cell.pivot, 1 - cell.pivot];
    let [a, b, offset] = cell.compression;
    let rigid = a.le(zero);
    let loose = cell.loose;
    let tight = n.with(1e-2) * loose;
    let slip = n.with(SLIP.max(8.0 * R::EPSILON)) * cell.height_sum;
    let mut x = height[0];
    let mut q = opening(cell, x + height[1]).max(tight);
    let mut height = [x, other_height(cell, x, q)];
    let mut yarn = each!(i in 2 => L::respond(&cell.yarn[index[i]], &span[index[i]], height[i]));
    let mut iterations = R::select(active, one, zero);
    let mut met = n.never();
    let mut pending = active;
    for round in 0..JOINT_ITERATIONS {
        let cube = q * q * q;
        // The force that compresses by a − b q, and its compliance.
        let force = R::select(rigid, yarn[0].force, one / cube - offset);
        let give = b * q * cube * n.with(1.0 / 3.0);
        let [sp, so] = each!(i in 2 => yarn[i].stiffness.max(cell.softest));
        // How far the heights miss the compression of the pivot's force, but for what that rounds to; and with it what
        // the residual F_p(x) − F_o(H − d(F_p) − x) would be, at most.
        let misfit = give * ((yarn[0].force - force).abs() - cell.noise).max(zero);
        let off = (yarn[0].force - yarn[1].force).abs() + so * misfit;
        // Both yarns slack although the crossover is not compressed: nothing presses.
        let slack = (rigid | loose.le(q)) & yarn[0].strain.le(zero) & yarn[1].strain.le(zero);
        let done = (off.le(cell.accepted(yarn[0].force)) & misfit.le(slip)) | slack;
        met = met | (pending & done);
        pending = pending & !done;
        if round + 1 == JOINT_ITERATIONS || !pending.any() {
            break;
        }
        // The force they have in common, Σ F/S over Σ 1/S; one division for all.
        let product = sp * so;
        let sum = sp + so + give * product;
        let inverse = one / (product * sum);
        let balance = (yarn[0].force * so + yarn[1].force * sp + force * give * product) * (product * inverse);
        let pivot = (x + (balance - yarn[0].force) * (so * sum * inverse)).max(zero).min(cell.height_sum);
        let other = height[1] + (balance - yarn[1].force) * (sp * sum * inverse);
        let next = opening(cell, pivot + other).max(q * n.with(0.3));
        x = R::select(pending, pivot, x);
        q = R::select(pending, next, q);
        height = [x, other_height(cell, x, q)];
        yarn = each!(i in 2 => L::respond(&cell.yarn[index[i]], &span[index[i]], height[i]));
        iterations = iterations + R::select(pending, one, zero);
    }
    Joint { height, yarn, iterations, met }
}

/// q = (a − d)/b where the heights sum up to `sum`; a compression that is none but for rounding is none.
#[inline(always)]
fn opening<R: Real>(cell: &CellConstants<R>, sum: R) -> R {
    let q = (sum - (cell.height_sum - cell.compression[0])) * cell.per_b;
    let least = cell.loose - sum.with(4.0 * R::EPSILON) * cell.height_sum * cell.per_b;
    R::select(least.le(q), cell.loose, q)
}

/// Height that compatibility leaves the other yarn: H − d − x, where d = a − b q is 0 once the crossover is loose.
#[inline(always)]
fn other_height<R: Real>(cell: &CellConstants<R>, x: R, q: R) -> R {
    let [a, b, _] = cell.compression;
    let d = R::select(cell.loose.le(q), x.zero(), a - b * q);
    cell.height_sum - d - x
}
