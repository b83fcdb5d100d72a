//! The number type the kernels are generic over.
//!
//! Kernels are written once, branch-free, with masks and [`Real::select`] as in WGSL. `f64` is the reference,
//! `f32` the twin of the shaders; a lane type can implement the same trait. Every operation used is correctly
//! rounded (`+ − × ÷ √`) or built from such operations, so results do not depend on the machine.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Outcome of a comparison, one truth value per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The same truth value in every lane.
    fn splat(value: bool) -> Self;
    /// True if any lane is.
    fn any(self) -> bool;
    /// Number of true lanes.
    fn count(self) -> u32;
    /// Truth value of one lane.
    fn lane(self, lane: usize) -> bool;
}

/// A storable floating-point number: the element type of state arrays.
pub trait Scalar: Real<Scalar = Self, Mask = bool> + Default + PartialOrd + Send + Sync + std::fmt::Debug {
    /// The value in double precision.
    fn to_f64(self) -> f64;
    /// Name in reports: `f64` or `f32`.
    const NAME: &'static str;
}

/// What a kernel may do with a number.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Element type in memory.
    type Scalar: Scalar;
    /// Result of comparisons.
    type Mask: Mask;
    /// Numbers per value.
    const LANES: usize;
    /// Distance from 1 to the next larger number.
    const EPSILON: f64;

    /// The same value in every lane, rounded to this precision.
    fn splat(value: f64) -> Self;
    /// `LANES` consecutive numbers of `source`, starting at `index`.
    fn load(source: &[Self::Scalar], index: usize) -> Self;
    /// Writes the lanes to `target`, starting at `index`.
    fn store(self, target: &mut [Self::Scalar], index: usize);
    /// One lane.
    fn lane(self, lane: usize) -> Self::Scalar;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// self < other
    fn lt(self, other: Self) -> Self::Mask;
    /// self ≤ other
    fn le(self, other: Self) -> Self::Mask;
    /// `yes` where `mask` is true, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// An estimate of the cube root of a positive number within 4 %, from its exponent.
    fn cube_root_estimate(self) -> Self;
    /// Zero.
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }
    /// One.
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }
    /// The larger of two numbers.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    /// The smaller of two numbers.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    /// The square.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
    /// Cube root of a positive number: Halley's iteration (cubic convergence) from the exponent's estimate.
    #[inline(always)]
    fn cube_root(self) -> Self {
        let mut y = self.cube_root_estimate();
        let two = Self::splat(2.0);
        let rounds = if Self::EPSILON < 1e-10 { 3 } else { 2 };
        for _ in 0..rounds {
            let cube = y * y * y;
            y = y * (cube + two * self) / (two * cube + self);
        }
        y
    }
}

impl Mask for bool {
    fn splat(value: bool) -> Self {
        value
    }
    fn any(self) -> bool {
        self
    }
    fn count(self) -> u32 {
        u32::from(self)
    }
    fn lane(self, _: usize) -> bool {
        self
    }
}

macro_rules! scalar {
    ($type:ident, $bits:ident, $third:expr) => {
        impl Scalar for $type {
            const NAME: &'static str = stringify!($type);
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
        }

        impl Real for $type {
            type Scalar = Self;
            type Mask = bool;
            const LANES: usize = 1;
            const EPSILON: f64 = $type::EPSILON as f64;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                value as Self
            }
            #[inline(always)]
            fn load(source: &[Self], index: usize) -> Self {
                source[index]
            }
            #[inline(always)]
            fn store(self, target: &mut [Self], index: usize) {
                target[index] = self;
            }
            #[inline(always)]
            fn lane(self, _: usize) -> Self {
                self
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn cube_root_estimate(self) -> Self {
                // A third of the exponent: bits/3 + two thirds of the bias, less what balances the error.
                Self::from_bits(self.to_bits() / 3 + $third)
            }
        }
    };
}

scalar!(f64, u64, 0x2a9f_7893_0000_0000);
scalar!(f32, u32, 0x2a51_2ce3);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_root_is_exact_to_rounding() {
        let mut x = 1e-12_f64;
        while x < 1e12 {
            let y = x.cube_root();
            assert!((y / x.cbrt() - 1.0).abs() < 4.0 * f64::EPSILON, "f64 {x}: {y}");
            let z = (x as f32).cube_root();
            assert!((z / (x as f32).cbrt() - 1.0).abs() < 4.0 * f32::EPSILON, "f32 {x}: {z}");
            x *= 1.37;
        }
    }

    #[test]
    fn min_and_max_follow_the_order() {
        assert_eq!(Real::max(1.0_f64, 2.0), 2.0);
        assert_eq!(Real::min(1.0_f32, 2.0), 1.0);
    }
}
