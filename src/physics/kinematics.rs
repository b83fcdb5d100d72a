//! Kinematics of an element, (1)–(10) in total form: F1 = ∂x/∂X and F2 = ∂x/∂Y at its centre, from displacements, so
//! nothing drifts and strains keep their precision.
//!
//! Across an element the gradient along its yarns runs from F1 − q1 at one edge to F1 + q1 at the other. The stretch is the root of the
//! mean of its square, Λ1² = |F1|² + |q1|²/3. At its centre alone an element is shorter than its yarns wherever a kink runs across it, as
//! at the rim of a projectile and at the front of the transverse wave: then limits are lower and converge slowly (docs/decisions/07).

use crate::num::scalar::{Real, Scalar, each};
use crate::physics::membrane::ShearConstants;
use crate::physics::unit_cell_parameters::UnitCellParameters;

/// Constants of the element kernel; lengths are those of the finest elements.
#[derive(Clone, Copy, Debug)]
pub struct ElementConstants<R> {
    /// Unit cell.
    pub cell: UnitCellParameters<R>,
    /// Trellis shear.
    pub shear: ShearConstants<R>,
    /// 1/(2·Lx), 1/(2·Ly) [1/m].
    pub gradient: [R; 2],
    /// Tension to force: (Ly/2)/(2·w02) and (Lx/2)/(2·w01) [-].
    pub membrane: [R; 2],
    /// Shear resultant to force: Ly/2, Lx/2 [m].
    pub half_length: [R; 2],
    /// Hourglass stiffness contributed by each yarn while both are alive [N/m].
    pub hourglass: [R; 2],
    /// Shock viscosity of warp and weft over the stiffness, q1·L/c with c the wave speed of the straight yarn in the fabric [s].
    pub viscosity: [R; 2],
    /// Length of an element along x and y above which the shock viscosity of smooth waves grows no more, over that of the finest [-].
    pub viscous_length: [R; 2],
    /// 1 over the stretch that a front adds while it crosses an element, and from which the viscosity of the whole length acts, over the
    /// coefficient of the viscosity [-].
    pub per_steep: R,
    /// Stress of the yarns by the rate of strain; `None`: none.
    pub rate: Option<RateConstants<R>>,
    /// Share of |q|² in Λ² [-]: ⅓ where stretches are means over the element, 0 where they are those at its centre.
    pub mode_share: R,
    /// Crossovers per element, and element area [m²], for energies.
    pub cells: R,
    /// [m²]
    pub area: R,
}

/// Law of Cowper and Symonds for the stress that the rate of strain adds.
#[derive(Clone, Copy, Debug)]
pub struct RateConstants<R> {
    /// C [1/s].
    pub c: R,
    /// P [-].
    pub power: f64,
    /// Most that it adds, over the stress [-].
    pub most: R,
}

impl<S: Scalar> ElementConstants<S> {
    /// Constants in other numbers, with the unit cell as they see it.
    pub(crate) fn map<R>(&self, cell: UnitCellParameters<R>, to: impl Fn(S) -> R) -> ElementConstants<R> {
        let pair = |values: [S; 2]| values.map(&to);
        ElementConstants {
            cell,
            shear: self.shear.map(&to),
            gradient: pair(self.gradient),
            membrane: pair(self.membrane),
            half_length: pair(self.half_length),
            hourglass: pair(self.hourglass),
            viscosity: pair(self.viscosity),
            viscous_length: pair(self.viscous_length),
            per_steep: to(self.per_steep),
            rate: self.rate.map(|rate| RateConstants { c: to(rate.c), power: rate.power, most: to(rate.most) }),
            mode_share: to(self.mode_share),
            cells: to(self.cells),
            area: to(self.area),
        }
    }
}

/// The constants of an element's own size, otherwise as in [`ElementConstants`].
#[derive(Clone, Copy)]
pub(crate) struct ElementGeometry<R> {
    pub(crate) gradient: [R; 2],
    pub(crate) membrane: [R; 2],
    pub(crate) half_length: [R; 2],
    pub(crate) hourglass: [R; 2],
    pub(crate) viscosity: [R; 2],
    /// That in proportion to the whole length, which acts at steep fronts.
    pub(crate) steep_viscosity: [R; 2],
    /// Along the row.
    pub(crate) viscous_length: R,
    pub(crate) mode_share: R,
    pub(crate) cells: R,
    pub(crate) area: R,
}

impl<R: Real> ElementGeometry<R> {
    /// Elements of the finest length, as high as `height` of the finest.
    #[inline(always)]
    pub(crate) fn of_row(c: &ElementConstants<R>, height: f64) -> Self {
        let (size, per_size) = (c.area.splat_like(height), c.area.splat_like(1.0 / height));
        Self {
            gradient: [c.gradient[0], c.gradient[1] * per_size],
            membrane: [c.membrane[0] * size, c.membrane[1]],
            half_length: [c.half_length[0] * size, c.half_length[1]],
            // A surface twisted alike has a mode in proportion to the area: with a stiffness in proportion to its inverse coarse elements
            // hold no more hourglass energy than fine ones.
            hourglass: [c.hourglass[0], c.hourglass[1] * per_size * per_size],
            viscosity: [c.viscosity[0], c.viscosity[1] * size.min(c.viscous_length[1])],
            steep_viscosity: [c.viscosity[0], c.viscosity[1] * size],
            viscous_length: c.viscous_length[0],
            mode_share: c.mode_share,
            cells: c.cells * size,
            area: c.area * size,
        }
    }

    /// Elements as long as `width` of the finest, as high as these.
    #[inline(always)]
    pub(crate) fn of_columns(&self, width: R, per_width: R) -> Self {
        Self {
            gradient: [self.gradient[0] * per_width, self.gradient[1]],
            membrane: [self.membrane[0], self.membrane[1] * width],
            half_length: [self.half_length[0], self.half_length[1] * width],
            hourglass: [self.hourglass[0] * per_width * per_width, self.hourglass[1]],
            viscosity: [self.viscosity[0] * width.min(self.viscous_length), self.viscosity[1]],
            steep_viscosity: [self.steep_viscosity[0] * width, self.steep_viscosity[1]],
            viscous_length: self.viscous_length,
            mode_share: self.mode_share,
            cells: self.cells * width,
            area: self.area * width,
        }
    }
}

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
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

    use super::*;
    /// Elements of 2 × 1.5 mm.
    const SIZE: ElementGeometry<f64> = ElementGeometry {
        gradient: [250.0, 1.0 / 3e-3],
        membrane: [1.0; 2],
        half_length: [1.0; 2],
        hourglass: [0.0; 2],
        viscosity: [0.0; 2],
        steep_viscosity: [0.0; 2],
        viscous_length: 1.0,
        mode_share: 1.0 / 3.0,
        cells: 1.0,
        area: 3e-6,
    };

    #[test]
    fn a_stretch_is_the_root_of_the_mean_square_over_the_element() {
        // Corners of an element of 2 × 1.5 mm, moved anyhow, counter-clockwise.
        let place =
            [[0.1, 0.2, -0.3], [2.3, 0.1, 0.4], [1.9, 1.6, -0.2], [-0.2, 1.4, 0.5]].map(|p| p.map(|x| 1e-3 * x));
        let flat = [[0.0, 0.0, 0.0], [2e-3, 0.0, 0.0], [2e-3, 1.5e-3, 0.0], [0.0, 1.5e-3, 0.0]];
        let [x, y, z] = [0, 1, 2].map(|a| differences(&[0, 1, 2, 3].map(|c: usize| place[c][a] - flat[c][a])));
        // Gradients across the element, and Simpson's rule, which is exact for their squares.
        let gradient = |from: [usize; 2], to: [usize; 2], length: f64, at: f64| {
            let edge = |i: usize, a: usize| (place[to[i]][a] - place[from[i]][a]) / length;
            (0..3).map(|a| ((1.0 - at) * edge(0, a) + at * edge(1, a)).powi(2)).sum::<f64>()
        };
        let mean = |from, to, length| {
            let [low, middle, high] = [0.0, 0.5, 1.0].map(|at| gradient(from, to, length, at));
            ((low + 4.0 * middle + high) / 6.0).sqrt()
        };
        let k = kinematics(&SIZE, [&x, &y, &z]);
        let (warp, weft) = (mean([0, 3], [1, 2], 2e-3), mean([0, 1], [3, 2], 1.5e-3));
        assert!((k.extension[0] - (warp - 1.0)).abs() < 1e-14 && (k.extension[1] - (weft - 1.0)).abs() < 1e-14);
        // The paper's stretch is that at the centre.
        let centre = kinematics(&ElementGeometry { mode_share: 0.0, ..SIZE }, [&x, &y, &z]);
        assert!(centre.extension[0] < k.extension[0] - 1e-3);
    }

    #[test]
    fn stretches_grow_by_what_their_rates_say_to_second_order() {
        // By component: differences along X and Y, and of opposite edges [m], [m/s].
        let u = [[2e-4, 4e-4, -6e-4], [-3e-4, 1e-4, 3e-4], [5e-4, -6e-4, 9e-4]];
        let v = [[30.0, -20.0, 25.0], [14.0, 35.0, -31.0], [-25.0, 40.0, 18.0]];
        let now = kinematics(&SIZE, u.each_ref());
        let off = |dt: f64| {
            let before = [0, 1, 2].map(|a: usize| [0, 1, 2].map(|i: usize| u[a][i] - dt * v[a][i]));
            let before = kinematics(&SIZE, before.each_ref());
            let grown = Growth::new(&SIZE, &now, &v, dt).stretching(&now);
            [0, 1].map(|i| (grown[i] - (now.extension[i] - before.extension[i])).abs())
        };
        let [coarse, fine] = [off(4e-6), off(2e-6)];
        for i in 0..2 {
            // The error is of third order.
            assert!(coarse[i] < 1e-3 && fine[i] < coarse[i] / 6.0, "{coarse:?} {fine:?}");
        }
    }
}
