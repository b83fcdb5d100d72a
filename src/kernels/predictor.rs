//! What predicts the heights of a cell from one step to the next.
//!
//! Contact forces depend on height and stretch, F(h, Λ). In every law the strain is 1 + ε = Λ·s(h/Λ) over a constant and
//! F = ε·f(h/Λ), so with the slope S = ∂F/∂h the other one is ∂F/∂Λ = (F (1 + ε)/ε − h S)/Λ: at constant force a height falls by
//! t = ∂F/∂Λ / S per stretch. Both yarns and the crossover, of compliance c, share the force, so
//!
//!   dF (1/S₁ + 1/S₂ + c) = t₁ dΛ₁ + t₂ dΛ₂  and  dhᵢ = dF/Sᵢ − tᵢ dΛᵢ.
//!
//! A start to first order spares Newton's iteration most of an evaluation; what is accepted in the end is the same.

use crate::kernels::yarn_law::YarnResponse;
use crate::num::scalar::{Real, each};

/// Strain below which a yarn is not followed: F/ε is of two numbers that vanish.
pub const LEAST_STRAIN: f64 = 1e-6;

/// How the two heights of a cell follow its two stretches, to first order.
#[derive(Clone, Copy, Debug)]
pub struct Predictor<R> {
    /// t: what a height falls by, per stretch, at constant contact force [m].
    pub dh_dstretch: [R; 2],
    /// 1/S over 1/S₁ + 1/S₂ + c [-].
    pub force_share: [R; 2],
}

impl<R: Real> Predictor<R> {
    /// Of a cell in equilibrium: its yarns, their slopes S [N/m], the compliance c of the crossover [m/N], heights [m] and stretches Λ.
    #[inline(always)]
    pub(super) fn of(yarn: &[YarnResponse<R>; 2], slope: [R; 2], give: R, height: [R; 2], length: [R; 2]) -> Self {
        let one = give.one();
        let least = give.splat_like(LEAST_STRAIN);
        let below = each!(i in 2 => yarn[i].strain.max(least) * slope[i] * length[i]);
        let per_both = one / (below[0] * below[1]);
        let per_sum = one / give.fused(slope[0] * slope[1], slope[0] + slope[1]);
        Self {
            dh_dstretch: each!(i in 2 => {
                let strain = yarn[i].strain;
                let above = yarn[i].force.fused(one + strain, -(height[i] * slope[i] * strain));
                let fall = above * (below[1 - i] * per_both);
                // No number that is not finite passes either.
                R::select(least.lt(strain) & fall.abs().lt(one), fall, give.zero())
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

#[cfg(test)]
#[path = "predictor_tests.rs"]
mod tests;
