//! What of the element kernel's constants depends on the size of an element: in a graded mesh each has its own.

use crate::kernels::element_force::ElementConstants;
use crate::math::scalar::Real;

/// The constants of an element's own size, otherwise as in [`ElementConstants`].
#[derive(Clone, Copy)]
pub(crate) struct ElementGeometry<R> {
    pub(crate) gradient: [R; 2],
    pub(crate) membrane: [R; 2],
    pub(crate) half_length: [R; 2],
    pub(crate) hourglass: [R; 2],
    pub(crate) viscosity: [R; 2],
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
            hourglass: [c.hourglass[0] * size, c.hourglass[1] * per_size],
            viscosity: [c.viscosity[0], c.viscosity[1] * size],
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
            hourglass: [self.hourglass[0] * per_width, self.hourglass[1] * width],
            viscosity: [self.viscosity[0] * width, self.viscosity[1]],
            mode_share: self.mode_share,
            cells: self.cells * width,
            area: self.area * width,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::case;
    use crate::model::Model;

    #[test]
    fn a_larger_element_has_the_constants_of_its_own_lengths() {
        let case = case::shipped(&[]);
        // Every constant another number, so that no two can be mistaken for each other.
        let c = ElementConstants::<f64> {
            gradient: [2.0, 3.0],
            membrane: [5.0, 7.0],
            half_length: [11.0, 13.0],
            hourglass: [17.0, 19.0],
            viscosity: [23.0, 29.0],
            mode_share: 41.0,
            cells: 31.0,
            area: 37.0,
            ..Model::<f64>::new(&case).unwrap().ply_types[0].element
        };
        // Four times as high, eight times as long: powers of two round nothing.
        let size = ElementGeometry::of_row(&c, 4.0).of_columns(8.0, 0.125);
        assert_eq!(size.gradient, [2.0 / 8.0, 3.0 / 4.0]);
        assert_eq!(size.membrane, [5.0 * 4.0, 7.0 * 8.0]);
        assert_eq!(size.half_length, [11.0 * 4.0, 13.0 * 8.0]);
        assert_eq!(size.hourglass, [17.0 * 4.0 / 8.0, 19.0 * 8.0 / 4.0]);
        assert_eq!(size.viscosity, [23.0 * 8.0, 29.0 * 4.0]);
        assert_eq!(size.mode_share, 41.0);
        assert_eq!([size.cells, size.area], [31.0 * 32.0, 37.0 * 32.0]);
    }
}
