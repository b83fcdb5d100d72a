//! Sums whose result does not depend on how many numbers are processed at once.

use crate::number::Real;

/// Partial sums by column modulo 32, so that one number at a time and 32 lanes at once add up the same
/// way, in double precision whatever the number type.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally([f64; Self::WIDTH]);

impl Tally {
    const WIDTH: usize = 32;

    /// Adds the lanes of `value`, the first of which belongs to `column`, a multiple of their number.
    #[inline(always)]
    pub(crate) fn add<R: Real>(&mut self, value: R, column: usize) {
        value.add_to(&mut self.0, column % Self::WIDTH);
    }

    /// The sum, in fixed order.
    pub(crate) fn total(&self) -> f64 {
        self.0.iter().sum()
    }
}
