//! The number type the kernels are generic over.
//!
//! Kernels are written once, branch-free, with masks and [`Real::select`] as in WGSL. `f64` is the reference,
//! `f32` the twin of the shaders; [`crate::num::simd`] has vectors of both. Every operation used is correctly
//! rounded (`+ − × ÷ √`, in double precision × and + in one) or built from such operations, so results do not depend on the
//! machine.
//!
//! Vector registers may only be filled where the processor is known to have them, and only a vector at hand proves
//! that: constants are made from a number of the same kind, `n.with(0.5)`, not from its type.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Range, Sub};

use bytemuck::Pod;
use fearless_simd::Simd;

use crate::num::simd::{F32s, F64s, Pair};

/// An array of an expression for every component: `each!(a in 3 => force[a])`.
///
/// Closures would do the same, but a closure is a function, and vector instructions are only inlined into functions
/// compiled for them.
macro_rules! each {
    ($a:ident in 2 => $value:expr) => {
        [each!(@ $a 0 $value), each!(@ $a 1 $value)]
    };
    ($a:ident in 3 => $value:expr) => {
        [each!(@ $a 0 $value), each!(@ $a 1 $value), each!(@ $a 2 $value)]
    };
    (@ $a:ident $at:literal $value:expr) => {{
        let $a: usize = $at;
        $value
    }};
}
pub(crate) use each;

/// Outcome of a comparison, one truth value per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Truth values.
    const LANES: usize;
    /// A bit for every lane, the first one lowest.
    fn bits(self) -> u64;
    /// True if any lane is.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// Truth value of one lane.
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.bits() >> lane & 1 != 0
    }
}

/// A storable floating-point number: the element type of state arrays.
pub trait Scalar:
    Real<Scalar = Self, Mask = bool> + Pod + Default + PartialOrd + Send + Sync + std::fmt::Debug + 'static
{
    /// The nearest number of this precision.
    fn splat(value: f64) -> Self;
    /// The value in double precision.
    fn to_f64(self) -> f64;
    /// Name in reports: `f64` or `f32`.
    const NAME: &'static str;
    /// As many as a register holds.
    type Lanes<V: Simd>: Real<Scalar = Self> + Send + Sync + 'static;
    /// Zeros in a register.
    fn lanes<V: Simd>(simd: V) -> Self::Lanes<V>;
    /// As many as the kernels take at once where there are 32 wide registers: two chains of operations side by side hide their
    /// latency, but more cells wait for the slowest beside them, which outweighs it in single precision.
    type Many<V: Simd>: Real<Scalar = Self> + Send + Sync + 'static;
    /// Zeros in these.
    fn many<V: Simd>(simd: V) -> Self::Many<V>;
}

/// Operations of a kernel on a number.
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
    /// Speed below which a node is at rest [m/s]. Far ahead of a wave speeds shrink until their squares are numbers that
    /// processors compute ten times slower. Shaders go on: graphics processors take no longer, or flush such numbers themselves.
    const REST: f64 = if is_double::<Self>() { 1e-100 } else { 1e-12 };

    /// `value` in every lane of a number like this one, rounded to its precision.
    #[inline(always)]
    fn splat_like(self, value: f64) -> Self {
        self.broadcast(Self::Scalar::splat(value))
    }
    /// Value of this precision in every lane of a number like this one.
    fn broadcast(self, value: Self::Scalar) -> Self;
    /// `LANES` consecutive numbers of `source`, starting at `index`, as a number like this one.
    fn load(self, source: &[Self::Scalar], index: usize) -> Self;
    /// True in the lanes that fall into `range` when the first one is `first`.
    fn within(self, first: usize, range: &Range<usize>) -> Self::Mask;
    /// Adds the lanes in double precision to consecutive sums, starting at `index`.
    fn add_to(self, sums: &mut [f64], index: usize);
    /// Calls a function compiled for the processor that numbers like this one need.
    fn vectorize<T>(self, call: impl FnOnce() -> T) -> T;
    /// Writes the lanes to `target`, starting at `index`.
    fn store(self, target: &mut [Self::Scalar], index: usize);
    /// One lane.
    fn lane(self, lane: usize) -> Self::Scalar;
    /// self × factor + term: rounded once in double precision; twice in single, since shaders cannot promise to round once.
    fn fused(self, factor: Self, term: Self) -> Self;
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
    /// An estimate of 1/∛x of a positive number within 6 %, from its exponent.
    fn inverse_cube_root_estimate(self) -> Self;
    /// A number that is not below 0 to a power that is not either, lane by lane in single precision.
    fn power(self, exponent: f64) -> Self;
    /// Zero.
    #[inline(always)]
    fn zero(self) -> Self {
        self.splat_like(0.0)
    }
    /// One.
    #[inline(always)]
    fn one(self) -> Self {
        self.splat_like(1.0)
    }
    /// False in every lane.
    #[inline(always)]
    fn never(self) -> Self::Mask {
        self.within(0, &(0..0))
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
    /// The largest lane, or 0 where none is positive.
    #[inline(always)]
    fn reduce_max(self) -> f64 {
        (0..Self::LANES).map(|lane| self.lane(lane).to_f64()).fold(0.0, f64::max)
    }
    /// The square.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
    /// 1/∛x of a positive number: two rounds of fourth order from the exponent's estimate, without a division.
    #[inline(always)]
    fn inverse_cube_root(self) -> Self {
        let mut y = self.inverse_cube_root_estimate();
        let one = self.one();
        for _ in 0..2 {
            // (1 − r)^(−1/3) = 1 + r/3 + 2r²/9 + 14r³/81 + …
            let r = (-self).fused(y * y * y, one);
            let more = r * r
                .fused(r.fused(self.splat_like(14.0 / 81.0), self.splat_like(2.0 / 9.0)), self.splat_like(1.0 / 3.0));
            y = y.fused(more, y);
        }
        y
    }
}

impl Mask for bool {
    const LANES: usize = 1;

    #[inline(always)]
    fn bits(self) -> u64 {
        u64::from(self)
    }
}

macro_rules! scalar {
    ($type:ident, $lanes:ident, $many:ty, $of:path, $half:expr, $third:expr, $magic:expr) => {
        impl Scalar for $type {
            const NAME: &'static str = stringify!($type);
            type Lanes<V: Simd> = $lanes<V>;
            #[inline(always)]
            fn lanes<V: Simd>(simd: V) -> $lanes<V> {
                $lanes::new(simd)
            }
            type Many<V: Simd> = $many;
            #[inline(always)]
            fn many<V: Simd>(simd: V) -> $many {
                $of(Self::lanes(simd))
            }
            #[inline(always)]
            fn splat(value: f64) -> Self {
                value as Self
            }
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
            fn broadcast(self, value: Self) -> Self {
                value
            }
            #[inline(always)]
            fn load(self, source: &[Self], index: usize) -> Self {
                source[index]
            }
            #[inline(always)]
            fn within(self, first: usize, range: &Range<usize>) -> bool {
                range.contains(&first)
            }
            #[inline(always)]
            fn add_to(self, sums: &mut [f64], index: usize) {
                sums[index] += f64::from(self);
            }
            #[inline(always)]
            fn vectorize<T>(self, call: impl FnOnce() -> T) -> T {
                call()
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
            fn fused(self, factor: Self, term: Self) -> Self {
                if is_double::<Self>() { self.mul_add(factor, term) } else { self * factor + term }
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
            fn power(self, exponent: f64) -> Self {
                libm::powf(self as f32, exponent as f32).into()
            }
            #[inline(always)]
            fn inverse_cube_root_estimate(self) -> Self {
                // Bits of what is no positive number wrap, as in registers.
                Self::from_bits($magic.wrapping_sub((self.to_bits() >> $half).wrapping_mul($third)))
            }
        }
    };
}

// A third of the bits, which hold the exponent, taken from four thirds of the bias, less what balances the error.
scalar!(f64, F64s, Pair<F64s<V>>, Pair::of, 32, F64_THIRD, F64_BIAS);
scalar!(f32, F32s, F32s<V>, std::convert::identity, 16, F32_THIRD, F32_BIAS);

/// Most numbers that a kernel takes at once.
pub(crate) const WIDEST: usize = 16;

/// Numbers from one on in double precision.
#[inline(always)]
pub(crate) fn widen<D: Real<Scalar = f64>, S: Scalar>(d: D, numbers: &[S], at: usize) -> D {
    let mut wide = [0.0; WIDEST];
    for (wide, number) in wide[..D::LANES].iter_mut().zip(&numbers[at..at + D::LANES]) {
        *wide = number.to_f64();
    }
    d.load(&wide, 0)
}

/// Writes the lanes in another precision, from one number on.
#[inline(always)]
pub(crate) fn narrow<D: Real<Scalar = f64>, S: Scalar>(d: D, numbers: &mut [S], at: usize) {
    let mut wide = [0.0; WIDEST];
    d.store(&mut wide, 0);
    for (number, wide) in numbers[at..at + D::LANES].iter_mut().zip(&wide[..D::LANES]) {
        *number = S::splat(*wide);
    }
}

/// Whether numbers are of double precision.
#[inline(always)]
pub(crate) const fn is_double<R: Real>() -> bool {
    R::EPSILON < 1e-10
}

/// A third of 2³², and of 2¹⁶: multiplied with the upper half of a number's bits they give a third of them.
pub(crate) const F64_THIRD: u64 = 0x5555_5556;
pub(crate) const F32_THIRD: u32 = 0x5556;
/// Rest of the bits of 1/∛x when a third of those of x is taken away.
pub(crate) const F64_BIAS: u64 = 0x553e_f0ff_289d_d796;
pub(crate) const F32_BIAS: u32 = 0x54a2_fa8c;

/// Partial sums by column modulo 32, so that one number at a time and 32 lanes at once add up the same
/// way, in double precision whatever the number type. A sum of nothing takes no time: most are of sampled steps and of failures.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OrderedSum(Option<[f64; Self::WIDTH]>);

impl OrderedSum {
    const WIDTH: usize = 32;

    /// Adds the lanes of `value`, the first of which belongs to `column`, a multiple of their number.
    #[inline(always)]
    pub(crate) fn add<R: Real>(&mut self, value: R, column: usize) {
        value.add_to(self.0.get_or_insert([0.0; Self::WIDTH]), column % Self::WIDTH);
    }

    /// The sum, in fixed order: halves are added to each other, so that no addition waits for more than four others.
    #[inline(always)]
    pub(crate) fn total(&self) -> f64 {
        let Some(mut sums) = self.0 else { return 0.0 };
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

/// A range after so many halvings, around the number up to which `is_low` holds.
pub(crate) fn bisect([mut low, mut high]: [f64; 2], halvings: u32, is_low: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if is_low(middle) { low = middle } else { high = middle }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn the_inverse_cube_root_is_exact_to_rounding() {
        let mut x = 1e-12_f64;
        while x < 1e12 {
            let estimate = x.inverse_cube_root_estimate() * x.cbrt();
            assert!((estimate - 1.0).abs() < 0.06, "{x}: {estimate}");
            let y = x.inverse_cube_root() * x.cbrt();
            assert!((y - 1.0).abs() < 4.0 * f64::EPSILON, "f64 {x}: {y}");
            let x_32 = x as f32;
            let z = f64::from(x_32.inverse_cube_root()) * f64::from(x_32).cbrt();
            assert!((z - 1.0).abs() < 3.0 * f64::from(f32::EPSILON), "f32 {x}: {z}");
            x *= 1.37;
        }
    }
}
