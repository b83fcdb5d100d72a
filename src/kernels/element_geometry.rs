//! What of the element kernel's constants depends on the size of an element: in a graded mesh each has its own.

use crate::kernels::element_force::ElementConstants;
use crate::num::scalar::Real;

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

    /// The same for elements as long as `width` of the finest.
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
