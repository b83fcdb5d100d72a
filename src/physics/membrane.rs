//! In-plane forces of an element: yarns, trellis shear that fades where a yarn is folded, shock viscosity.

use crate::num::scalar::{Mask, Real, each};
use crate::physics::element_geometry::ElementConstants;
use crate::physics::element_geometry::ElementGeometry;
use crate::physics::kinematics::{Growth, Kinematics, TINY, Vector, dot};
use crate::physics::shear;
use crate::physics::shear::ShearConstants;

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
    let trellis = shear::trellis(c, k.sine);
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

/// Shock viscosity of a yarn: its force at the last and at this step, and the work of both on the stretch in between.
pub(crate) struct Viscous<R> {
    /// Now [N].
    pub(crate) force: [R; 2],
    /// Work since the last step over ½ of the element's length times its yarns [N], warp and weft: (V⁻ ΔΛ⁻ + V⁺ ΔΛ⁺).
    pub(crate) work: [R; 2],
}

/// Viscous forces of warp and weft [N]: stiffness times viscosity [s] times the rate of stretch, so large at a shock and small
/// elsewhere. In coarse elements the viscosity grows with the steepness of the front. A slack yarn has none, and a yarn never pushes.
/// `elastic`: in-plane forces of the yarns [N]; `before`: viscous forces at the last step [N]; `v`: differences of velocities over the
/// element; `dt` [s].
#[inline(always)]
pub(crate) fn viscous<R: Real>(
    c: &ElementConstants<R>,
    size: &ElementGeometry<R>,
    k: &Kinematics<R>,
    v: &[[R; 3]; 3],
    elastic: &[R; 2],
    before: [R; 2],
    dt: R,
) -> Viscous<R> {
    // Kept from the prediction of heights it would have to leave its registers.
    let grown = Growth::new(size, k, v, dt);
    let parts = each!(i in 2 => {
        let zero = dt.zero();
        let rate = dot(&k.direction[i], &each!(a in 3 => v[a][i])) * size.gradient[i];
        let steepness = (rate.abs() * size.steep_viscosity[i] * c.per_steep).min(dt.one());
        let viscosity = size.viscosity[i] + (size.steep_viscosity[i] - size.viscosity[i]) * steepness;
        let force = c.cell.yarn[i].stiffness * viscosity * rate;
        let force = R::select(elastic[i].le(zero), zero, force.max(-elastic[i]));
        // The same rate along the direction of the last step, from Λ² − 1 there.
        let now = dt.one() + k.extension[i];
        let more = k.extension[i] * (now + dt.one()) - dt.splat_like(2.0) * now * grown.whole[i] + grown.whole_square[i];
        let last = (dt.one() + more).max(dt.splat_like(TINY)).sqrt();
        // A yarn that went slack since dissipates on its way to slack, and no further: more than it stored would be booked.
        let extension = more / (dt.one() + last);
        let taut = (extension / (extension - k.extension[i]).max(dt.splat_like(TINY))).min(dt.one());
        let taut = R::select(elastic[i].le(zero), R::select(extension.le(zero), dt.one(), taut), dt.one());
        let before = taut * before[i] * ((now * grown.along[i] - grown.square[i]) / last);
        (force, force * grown.along[i] + before)
    });
    Viscous { force: [parts[0].0, parts[1].0], work: [parts[0].1, parts[1].1] }
}

#[cfg(test)]
#[path = "membrane_tests.rs"]
mod tests;
