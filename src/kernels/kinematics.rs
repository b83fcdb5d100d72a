//! Kinematics of an element, (1)–(10) in total form: F1 = ∂x/∂X and F2 = ∂x/∂Y at its centre, from displacements, so
//! nothing drifts and strains keep their precision.

use crate::kernels::element_geometry::ElementGeometry;
use crate::math::scalar::{Real, each};

/// What one element is before forces: gradients, stretches and directions.
pub(crate) struct Kinematics<R> {
    /// Λ − 1 [-].
    pub(crate) extension: [R; 2],
    /// e, of the yarns.
    pub(super) direction: [Vector<R>; 2],
    /// 1/Λ [-].
    pub(super) per_stretch: [R; 2],
    /// Of the shear angle.
    pub(crate) sine: R,
}

pub(super) type Vector<R> = [R; 3];

#[inline(always)]
pub(super) fn dot<R: Real>(a: &Vector<R>, b: &Vector<R>) -> R {
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

/// Kinematics of an element from the sums of its edge differences along X and Y [m].
#[inline(always)]
pub(crate) fn kinematics<R: Real>(c: &ElementGeometry<R>, dx: &Vector<R>, dy: &Vector<R>) -> Kinematics<R> {
    let n = c.area;
    let one = n.one();
    let two = n.splat_like(2.0);
    let g1 = [dx[0] * c.gradient[0], dx[1] * c.gradient[0], dx[2] * c.gradient[0]];
    let g2 = [dy[0] * c.gradient[1], dy[1] * c.gradient[1], dy[2] * c.gradient[1]];
    let f1 = [one + g1[0], g1[1], g1[2]];
    let f2 = [g2[0], one + g2[1], g2[2]];
    let tiny = n.splat_like(1e-12);
    let l1 = dot(&f1, &f1).sqrt().max(tiny);
    let l2 = dot(&f2, &f2).sqrt().max(tiny);
    // Λ − 1 from the displacement gradient: no cancellation at small strain.
    let s1 = two.fused(g1[0], dot(&g1, &g1)) / (one + l1);
    let s2 = two.fused(g2[1], dot(&g2, &g2)) / (one + l2);
    let (i1, i2) = (one / l1, one / l2);
    let sine = (g2[0] + g1[1] + dot(&g1, &g2)) * i1 * i2;
    Kinematics {
        extension: [s1, s2],
        direction: [[f1[0] * i1, f1[1] * i1, f1[2] * i1], [f2[0] * i2, f2[1] * i2, f2[2] * i2]],
        per_stretch: [i1, i2],
        sine: sine.max(-one).min(one),
    }
}

/// What the stretches have grown by in the time `dt` [s], to second order. `v`: differences of velocities over the element.
#[inline(always)]
pub(super) fn stretching<R: Real>(size: &ElementGeometry<R>, k: &Kinematics<R>, v: [&Vector<R>; 3], dt: R) -> [R; 2] {
    let half = dt.splat_like(0.5);
    each!(i in 2 => {
        let per_length = dt * size.gradient[i];
        let step = [v[0][i] * per_length, v[1][i] * per_length, v[2][i] * per_length];
        let along = dot(&k.direction[i], &step);
        along - half * k.per_stretch[i] * (dot(&step, &step) - along.squared())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elements of 2 × 1.5 mm.
    const SIZE: ElementGeometry<f64> = ElementGeometry {
        gradient: [250.0, 1.0 / 3e-3],
        membrane: [1.0; 2],
        half_length: [1.0; 2],
        hourglass: [0.0; 2],
        viscosity: [0.0; 2],
        cells: 1.0,
        area: 3e-6,
    };

    #[test]
    fn stretches_grow_by_what_their_rates_say_to_second_order() {
        let (dx, dy) = ([2e-4, -3e-4, 5e-4], [4e-4, 1e-4, -6e-4]);
        // By component and direction [m/s].
        let v = [[30.0, -20.0], [14.0, 35.0], [-25.0, 40.0]];
        let now = kinematics(&SIZE, &dx, &dy);
        let off = |dt: f64| {
            let earlier = |d: &Vector<f64>, i: usize| [0, 1, 2].map(|a| d[a] - dt * v[a][i]);
            let before = kinematics(&SIZE, &earlier(&dx, 0), &earlier(&dy, 1));
            let transposed = [0, 1, 2].map(|a| [v[a][0], v[a][1], 0.0]);
            let grown = stretching(&SIZE, &now, [&transposed[0], &transposed[1], &transposed[2]], dt);
            [0, 1].map(|i| (grown[i] - (now.extension[i] - before.extension[i])).abs())
        };
        let [coarse, fine] = [off(4e-6), off(2e-6)];
        for i in 0..2 {
            // The error is of third order.
            assert!(coarse[i] < 1e-3 && fine[i] < coarse[i] / 6.0, "{coarse:?} {fine:?}");
        }
    }
}
