//! The unit cell's fast iteration: Newton on both heights and the compression together.
//!
//! Compatibility (22) says x + y + d = H. With q = (F + (b/a)³)^(−1/3) the compression d = a − b q is linear, so the
//! one strong nonlinearity of the cell, the crossover's stiffening, is not in the way of Newton's steps: each
//! linearises the contact forces of both yarns at their heights and that of the compression at q, and finds the
//! force the three have in common. Both yarns are evaluated side by side, without waiting for each other.
//!
//! Three steps suffice from one time step to the next. Nothing guards it: cells it leaves go to the bracketed
//! iteration of [`super::crossover`], which cannot fail.

use crate::kernels::cell_constants::CellConstants;
use crate::kernels::yarn_law::{LawKernel, Span, YarnResponse};
use crate::number::{Mask, Real, each};

/// Evaluations allowed before the bracketed iteration takes over.
pub const JOINT_ITERATIONS: u32 = 7;

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
    let mut height = height;
    let mut q = ((height[0] + height[1] - (cell.height_sum - a)) * cell.per_b).max(tight).min(loose);
    let mut yarn = each!(i in 2 => L::respond(&cell.yarn[index[i]], &span[index[i]], height[i]));
    let mut iterations = R::select(active, one, zero);
    let mut met = n.never();
    let mut pending = active;
    for round in 0..JOINT_ITERATIONS {
        let cube = q * q * q;
        // The force that compresses by a − b q, and its compliance.
        let force = R::select(rigid, yarn[0].force, one / cube - offset);
        let give = b * q * cube * n.with(1.0 / 3.0);
        let misfit = height[0] + height[1] - b * q - (cell.height_sum - a);
        let [sp, so] = each!(i in 2 => yarn[i].stiffness.max(cell.softest));
        // What the residual F_p(x) − F_o(H − d(F_p) − x) would be, at most; heights are as good as their rounding.
        let gap = misfit.abs() + give * (yarn[0].force - force).abs();
        let off =
            (yarn[0].force - yarn[1].force).abs() + so * (gap - cell.height_sum * n.with(32.0 * R::EPSILON)).max(zero);
        // Both yarns slack although the crossover is not compressed: nothing presses.
        let open = (cell.height_sum * n.with(1.0 - 4.0 * R::EPSILON)).le(height[0] + height[1]);
        let slack = open & yarn[0].strain.le(zero) & yarn[1].strain.le(zero);
        let done = off.le(cell.accepted(yarn[0].force)) | slack;
        met = met | (pending & done);
        pending = pending & !done;
        if round + 1 == JOINT_ITERATIONS || !pending.any() {
            break;
        }
        // Common force: Σ F/S over Σ 1/S, less what closes the misfit; one division for all.
        let product = sp * so;
        let sum = sp + so + give * product;
        let inverse = one / (product * sum);
        let common =
            (yarn[0].force * so + yarn[1].force * sp + (force * give - misfit) * product) * (product * inverse);
        let x = height[0] + (common - yarn[0].force) * (so * sum * inverse);
        let y = height[1] + (common - yarn[1].force) * (sp * sum * inverse);
        let x = x.max(zero).min(cell.height_sum);
        let y = y.max(zero).min(cell.height_sum);
        let next = ((x + y - (cell.height_sum - a)) * cell.per_b).max(q * n.with(0.3)).min(loose);
        height = [R::select(pending, x, height[0]), R::select(pending, y, height[1])];
        q = R::select(pending, next, q);
        yarn = each!(i in 2 => L::respond(&cell.yarn[index[i]], &span[index[i]], height[i]));
        iterations = iterations + R::select(pending, one, zero);
    }
    Joint { height, yarn, iterations, met }
}
