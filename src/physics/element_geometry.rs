//! Constants of an element, and what of them depends on its size: in a graded mesh each element has its own.

use crate::num::scalar::{Real, Scalar};
use crate::physics::shear::ShearConstants;
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
    /// Share of |q|² in Λ² [-]: ⅓ where stretches are means over the element, 0 where they are those at its centre.
    pub mode_share: R,
    /// Crossovers per element, and element area [m²], for energies.
    pub cells: R,
    /// [m²]
    pub area: R,
}

impl<S: Scalar> ElementConstants<S> {
    /// Constants in every lane of numbers like `n`.
    pub fn spread<R: Real<Scalar = S>>(&self, n: R) -> ElementConstants<R> {
        self.map(self.cell.spread(n), |value| n.broadcast(value))
    }

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

#[cfg(test)]
#[path = "element_geometry_tests.rs"]
mod tests;
