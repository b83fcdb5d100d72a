//! Kinematics of an element, (1)–(10) in total form: F1 = ∂x/∂X and F2 = ∂x/∂Y at its centre, from displacements, so
//! nothing drifts and strains keep their precision.
//!
//! Across an element the gradient along its yarns runs from F1 − q1 at one edge to F1 + q1 at the other. The stretch is the root of the
//! mean of its square, Λ1² = |F1|² + |q1|²/3. At its centre alone an element is shorter than its yarns wherever a kink runs across it, as
//! at the rim of a projectile and at the front of the transverse wave: then limits are lower and converge slowly (docs/decisions/06).

use crate::num::scalar::{Real, each};
use crate::physics::element_geometry::ElementGeometry;

/// Gradients, stretches and directions of an element.
pub(crate) struct Kinematics<R> {
    /// Λ − 1 [-].
    pub(crate) extension: [R; 2],
    /// F/Λ: of the yarns. A unit vector where both edges of the element have the same gradient.
    pub(crate) direction: [Vector<R>; 2],
    /// Difference of opposite edges [m], x1 − x2 + x3 − x4.
    pub(crate) mode: Vector<R>,
    /// Slope of the stretch over that difference, over q: share/(2·L·Λ) of warp and weft [1/m].
    pub(crate) per_mode: [R; 2],
    /// 1/Λ [-].
    pub(crate) per_stretch: [R; 2],
    /// Sine of the shear angle.
    pub(crate) sine: R,
}

/// Keeps quotients finite where an element has shrunk to nothing: least Λ, Λ² or change of Λ [-].
pub const TINY: f64 = 1e-12;

pub(crate) type Vector<R> = [R; 3];

#[inline(always)]
pub(crate) fn dot<R: Real>(a: &Vector<R>, b: &Vector<R>) -> R {
    a[2].fused(b[2], a[1].fused(b[1], a[0] * b[0]))
}

/// Differences over an element of corner values 0…3 (counter-clockwise): twice the edge differences along X and
/// Y, and the hourglass combination.
#[inline(always)]
pub(crate) fn differences<R: Real>(corner: &[R; 4]) -> [R; 3] {
    let [a, b, c, d] = *corner;
    let (bottom, top) = (b - a, c - d);
    [bottom + top, (d - a) + (c - b), top - bottom]
}

/// Kinematics of an element from the [`differences`] of its corners' displacements, component by component [m].
#[inline(always)]
pub(crate) fn kinematics<R: Real>(c: &ElementGeometry<R>, u: [&Vector<R>; 3]) -> Kinematics<R> {
    let n = c.area;
    let one = n.one();
    let two = n.splat_like(2.0);
    let g1 = each!(a in 3 => u[a][0] * c.gradient[0]);
    let g2 = each!(a in 3 => u[a][1] * c.gradient[1]);
    let mode = each!(a in 3 => u[a][2]);
    let apart = c.mode_share * dot(&mode, &mode);
    let (q1, q2) = (apart * c.gradient[0].squared(), apart * c.gradient[1].squared());
    let f1 = [one + g1[0], g1[1], g1[2]];
    let f2 = [g2[0], one + g2[1], g2[2]];
    let tiny = n.splat_like(TINY);
    let l1 = (dot(&f1, &f1) + q1).sqrt().max(tiny);
    let l2 = (dot(&f2, &f2) + q2).sqrt().max(tiny);
    // Λ − 1 from the displacement gradient: no cancellation at small strain.
    let s1 = two.fused(g1[0], dot(&g1, &g1) + q1) / (one + l1);
    let s2 = two.fused(g2[1], dot(&g2, &g2) + q2) / (one + l2);
    let (i1, i2) = (one / l1, one / l2);
    let sine = (g2[0] + g1[1] + dot(&g1, &g2)) * i1 * i2;
    Kinematics {
        extension: [s1, s2],
        direction: [[f1[0] * i1, f1[1] * i1, f1[2] * i1], [f2[0] * i2, f2[1] * i2, f2[2] * i2]],
        mode,
        per_mode: [c.mode_share * c.gradient[0] * i1, c.mode_share * c.gradient[1] * i2],
        per_stretch: [i1, i2],
        sine: sine.max(-one).min(one),
    }
}

/// Growth along warp and weft in a step.
pub(crate) struct Growth<R> {
    /// Growth of the gradient at the centre, along the yarn [-], and its square.
    pub(crate) along: [R; 2],
    pub(crate) square: [R; 2],
    /// Growth with q, the part of the hourglass mode.
    pub(crate) whole: [R; 2],
    pub(crate) whole_square: [R; 2],
}

impl<R: Real> Growth<R> {
    /// In the time `dt` [s]. `v`: differences of velocities over the element, component by component.
    #[inline(always)]
    pub(crate) fn new(size: &ElementGeometry<R>, k: &Kinematics<R>, v: &[Vector<R>; 3], dt: R) -> Self {
        let per_length = each!(i in 2 => dt * size.gradient[i]);
        let mode = each!(a in 3 => v[a][2]);
        let (on_mode, of_mode) = (dot(&k.mode, &mode), size.mode_share * dot(&mode, &mode));
        let parts = each!(i in 2 => {
            let step = each!(a in 3 => v[a][i] * per_length[i]);
            (dot(&k.direction[i], &step), dot(&step, &step))
        });
        Self {
            along: [parts[0].0, parts[1].0],
            square: [parts[0].1, parts[1].1],
            whole: each!(i in 2 => (k.per_mode[i] * per_length[i]).fused(on_mode, parts[i].0)),
            whole_square: each!(i in 2 => per_length[i].squared().fused(of_mode, parts[i].1)),
        }
    }

    /// Growth of the stretches, to second order.
    #[inline(always)]
    pub(crate) fn stretching(&self, k: &Kinematics<R>) -> [R; 2] {
        each!(i in 2 => {
            let half = k.per_stretch[i].splat_like(0.5) * k.per_stretch[i];
            self.whole[i] - half * (self.whole_square[i] - self.whole[i].squared())
        })
    }
}

#[cfg(test)]
#[path = "kinematics_tests.rs"]
mod tests;
