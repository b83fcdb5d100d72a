//! Sums whose result does not depend on how many numbers are processed at once.

use crate::num::scalar::Real;

/// Partial sums by column modulo 32, so that one number at a time and 32 lanes at once add up the same
/// way, in double precision whatever the number type.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OrderedSum([f64; Self::WIDTH]);

impl OrderedSum {
    const WIDTH: usize = 32;

    /// Adds the lanes of `value`, the first of which belongs to `column`, a multiple of their number.
    #[inline(always)]
    pub(crate) fn add<R: Real>(&mut self, value: R, column: usize) {
        value.add_to(&mut self.0, column % Self::WIDTH);
    }

    /// The sum, in fixed order: halves are added to each other, so that no addition waits for more than four others.
    #[inline(always)]
    pub(crate) fn total(&self) -> f64 {
        let mut sums = self.0;
        let mut half = Self::WIDTH / 2;
        while half > 0 {
            for i in 0..half {
                sums[i] += sums[i + half];
            }
            half /= 2;
        }
        sums[0]
    }
}
