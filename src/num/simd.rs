//! Several numbers at once: the kernels' fast path on the CPU, and memory that they load and store well.
//!
//! Vectors of the widest registers that the processor has (AVX-512, AVX2, Neon, in a browser those of 128 bits), chosen when the program runs.
//! Not SSE2: it has no fused multiply-add, without which f64 is as slow as one number at a time.
//! Every lane does exactly what one number alone would do, so results are the same bits for any width.
//! A vector in memory must not straddle lines of the cache, which takes the processor twice as long.

use std::marker::PhantomData;
use std::ops::{Add, BitAnd, BitOr, Deref, DerefMut, Div, Mul, Neg, Not, Range, Sub};

use bytemuck::{Pod, Zeroable};
use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdFrom, SimdMask};

use crate::num::scalar::{F32_BIAS, F32_THIRD, F64_BIAS, F64_THIRD, Mask, Real, is_double};

/// The registers the kernels use. They decide how fast a run is, never what it finds.
#[derive(Clone, Copy, Debug)]
pub enum Vectors {
    /// One number at a time.
    None,
    /// 512 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512(fearless_simd::Avx512),
    /// 256 bits.
    #[cfg(all(target_arch = "x86_64", not(feature = "quick-build")))]
    Avx2(fearless_simd::Avx2),
    /// 128 bits.
    #[cfg(target_arch = "aarch64")]
    Neon(fearless_simd::Neon),
    /// 128 bits, in a browser.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    Wasm(fearless_simd::WasmSimd128),
}

impl Vectors {
    /// Every kind this processor can compute with, the widest first.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let level = fearless_simd::Level::new();
            all.extend(level.as_avx512().map(Self::Avx512));
            #[cfg(not(feature = "quick-build"))]
            all.extend(level.as_avx2().map(Self::Avx2));
        }
        #[cfg(target_arch = "aarch64")]
        all.extend(fearless_simd::Level::new().as_neon().map(Self::Neon));
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        all.extend(fearless_simd::Level::new().as_wasm_simd128().map(Self::Wasm));
        all.push(Self::None);
        all
    }

    /// The widest there are.
    pub fn widest() -> Self {
        Self::all()[0]
    }

    /// Name of the instruction set.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "scalar",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(_) => "avx512",
            #[cfg(all(target_arch = "x86_64", not(feature = "quick-build")))]
            Self::Avx2(_) => "avx2",
            #[cfg(target_arch = "aarch64")]
            Self::Neon(_) => "neon",
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Self::Wasm(_) => "simd128",
        }
    }
}

macro_rules! lanes {
    ($name:ident, $mask:ident, $vector:ident, $truth:ident, $scalar:ident, $half:literal, $third:expr, $bias:expr) => {
        /// As many numbers as a register holds.
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $name<S: Simd>(S::$vector);

        /// As many truth values.
        #[derive(Clone, Copy, Debug)]
        #[repr(transparent)]
        pub struct $mask<S: Simd>(S::$truth);

        impl<S: Simd> $name<S> {
            /// Zeros.
            pub fn new(simd: S) -> Self {
                Self(S::$vector::simd_from(simd, 0.0))
            }
        }

        lanes!(@operator $name Add add other);
        lanes!(@operator $name Sub sub other);
        lanes!(@operator $name Mul mul other);
        lanes!(@operator $name Div div other);
        lanes!(@operator $name Neg neg);
        lanes!(@operator $mask BitAnd bitand other);
        lanes!(@operator $mask BitOr bitor other);
        lanes!(@operator $mask Not not);

        impl<S: Simd> Mask for $mask<S> {
            const LANES: usize = <S::$truth as SimdMask<S>>::LEN;

            #[inline(always)]
            fn any(self) -> bool {
                self.0.any_true()
            }
            #[inline(always)]
            fn bits(self) -> u64 {
                self.0.to_bitmask()
            }
        }

        impl<S: Simd> Real for $name<S> {
            type Scalar = $scalar;
            type Mask = $mask<S>;
            const LANES: usize = <S::$vector as SimdBase<S>>::LEN;
            const EPSILON: f64 = <$scalar as Real>::EPSILON;

            #[inline(always)]
            fn broadcast(self, value: $scalar) -> Self {
                Self(S::$vector::simd_from(self.0.token(), value))
            }
            #[inline(always)]
            fn load(self, source: &[$scalar], index: usize) -> Self {
                Self(S::$vector::from_slice(self.0.token(), &source[index..index + Self::LANES]))
            }
            #[inline(always)]
            fn store(self, target: &mut [$scalar], index: usize) {
                self.0.store_slice(&mut target[index..index + Self::LANES]);
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> $scalar {
                self.0[lane]
            }
            #[inline(always)]
            fn within(self, first: usize, range: &Range<usize>) -> $mask<S> {
                let below = |end: usize| (1_u64 << end.saturating_sub(first).min(Self::LANES)) - 1;
                $mask(S::$truth::from_bitmask(self.0.token(), below(range.end) & !below(range.start)))
            }
            #[inline(always)]
            fn add_to(self, sums: &mut [f64], index: usize) {
                let sums = &mut sums[index..index + Self::LANES];
                for (sum, x) in sums.iter_mut().zip(self.0.as_slice()) {
                    *sum += f64::from(*x);
                }
            }
            #[inline(always)]
            fn vectorize<T>(self, call: impl FnOnce() -> T) -> T {
                self.0.token().vectorize(call)
            }
            #[inline(always)]
            fn fused(self, factor: Self, term: Self) -> Self {
                if is_double::<Self>() {
                    Self(self.0.mul_add_precise(factor.0, term.0))
                } else {
                    self * factor + term
                }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.sqrt())
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }
            #[inline(always)]
            fn lt(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_lt(other.0))
            }
            #[inline(always)]
            fn le(self, other: Self) -> $mask<S> {
                $mask(self.0.simd_le(other.0))
            }
            #[inline(always)]
            fn select(mask: $mask<S>, yes: Self, no: Self) -> Self {
                Self(mask.0.select(yes.0, no.0))
            }
            // On other processors a register's maximum may differ from that of one number in the sign of a zero.
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(self.0.max(other.0))
            }
            #[cfg(target_arch = "x86_64")]
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(self.0.min(other.0))
            }
            fn power(mut self, exponent: f64) -> Self {
                self.0.as_mut_slice().iter_mut().for_each(|x| *x = x.power(exponent));
                self
            }
            #[inline(always)]
            fn inverse_cube_root_estimate(self) -> Self {
                let third = (self.0.to_bits() >> $half) * $third;
                let bias = <S::$vector as SimdFloat<S>>::Bits::simd_from(self.0.token(), $bias);
                Self(S::$vector::from_bits(bias - third))
            }
        }
    };
    (@operator $name:ident $trait:ident $method:ident $($other:ident)?) => {
        impl<S: Simd> $trait for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self $(, $other: Self)?) -> Self {
                Self(self.0.$method($($other.0)?))
            }
        }
    };
}

lanes!(F64s, F64Mask, f64s, mask64s, f64, 32, F64_THIRD, F64_BIAS);
lanes!(F32s, F32Mask, f32s, mask32s, f32, 16, F32_THIRD, F32_BIAS);

/// Pair as many numbers: two chains of operations side by side hide each other's latency.
#[derive(Clone, Copy, Debug)]
pub struct Pair<R>(R, R);

macro_rules! pair {
    ($($trait:ident $method:ident $($other:ident)?),+) => {$(
        impl<R: $trait<Output = R>> $trait for Pair<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self $(, $other: Self)?) -> Self {
                Self(self.0.$method($($other.0)?), self.1.$method($($other.1)?))
            }
        }
    )+};
}

pair!(Add add other, Sub sub other, Mul mul other, Div div other, Neg neg, BitAnd bitand other, BitOr bitor other, Not not);

impl<M: Mask> Mask for Pair<M> {
    const LANES: usize = 2 * M::LANES;

    #[inline(always)]
    fn bits(self) -> u64 {
        self.0.bits() | self.1.bits() << M::LANES
    }
    #[inline(always)]
    fn any(self) -> bool {
        (self.0 | self.1).any()
    }
}

impl<R: Real> Pair<R> {
    /// Pair of equal numbers.
    pub fn of(number: R) -> Self {
        Self(number, number)
    }
}

/// Methods that do the same to both.
macro_rules! on_both {
    ($($method:ident($($argument:ident),*))+ -> $result:ty) => {$(
        #[inline(always)]
        fn $method(self, $($argument: Self),*) -> $result {
            Pair(self.0.$method($($argument.0),*), self.1.$method($($argument.1),*))
        }
    )+};
}

impl<R: Real> Real for Pair<R> {
    type Scalar = R::Scalar;
    type Mask = Pair<R::Mask>;
    const LANES: usize = 2 * R::LANES;
    const EPSILON: f64 = R::EPSILON;

    #[inline(always)]
    fn broadcast(self, value: R::Scalar) -> Self {
        Self(self.0.broadcast(value), self.1.broadcast(value))
    }
    #[inline(always)]
    fn load(self, source: &[R::Scalar], index: usize) -> Self {
        let source = &source[index..index + Self::LANES];
        Self(self.0.load(source, 0), self.1.load(source, R::LANES))
    }
    #[inline(always)]
    fn store(self, target: &mut [R::Scalar], index: usize) {
        let target = &mut target[index..index + Self::LANES];
        self.0.store(target, 0);
        self.1.store(target, R::LANES);
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> R::Scalar {
        if lane < R::LANES { self.0.lane(lane) } else { self.1.lane(lane - R::LANES) }
    }
    #[inline(always)]
    fn within(self, first: usize, range: &Range<usize>) -> Self::Mask {
        Pair(self.0.within(first, range), self.1.within(first + R::LANES, range))
    }
    #[inline(always)]
    fn add_to(self, sums: &mut [f64], index: usize) {
        self.0.add_to(sums, index);
        self.1.add_to(sums, index + R::LANES);
    }
    #[inline(always)]
    fn vectorize<T>(self, call: impl FnOnce() -> T) -> T {
        self.0.vectorize(call)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(R::select(mask.0, yes.0, no.0), R::select(mask.1, yes.1, no.1))
    }
    fn power(self, exponent: f64) -> Self {
        Self(self.0.power(exponent), self.1.power(exponent))
    }
    on_both! { sqrt() abs() inverse_cube_root_estimate() max(other) min(other) fused(factor, term) -> Self }
    on_both! { lt(other) le(other) -> Pair<R::Mask> }
}

/// Bytes that come into the cache at once; no register is longer.
pub(crate) const CACHE_LINE: usize = size_of::<CacheLine>();

/// A line of the cache.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
struct CacheLine([u64; 8]);

/// Numbers, one of which begins a line of the cache, and so does every one a whole number of lines away from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Aligned<S> {
    lines: Vec<CacheLine>,
    /// Numbers to spare before the first.
    start: usize,
    length: usize,
    numbers: PhantomData<S>,
}

impl<S: Pod> Aligned<S> {
    /// `length` zeros; the number at `first` begins a line.
    pub fn zeros(length: usize, first: usize) -> Self {
        let line = CACHE_LINE / size_of::<S>();
        let start = (line - first % line) % line;
        // A page of zeros that has only been read is shared until it is written, and then every core has to be told: written here,
        // while one thread runs, and not, as zeros else would be, when a wave comes by.
        let mut lines = Vec::with_capacity((start + length).div_ceil(line));
        lines.resize(lines.capacity(), std::hint::black_box(CacheLine::zeroed()));
        Self { lines, start, length, numbers: PhantomData }
    }
}

impl<S: Pod> Deref for Aligned<S> {
    type Target = [S];

    fn deref(&self) -> &[S] {
        &bytemuck::cast_slice(&self.lines)[self.start..self.start + self.length]
    }
}

impl<S: Pod> DerefMut for Aligned<S> {
    fn deref_mut(&mut self) -> &mut [S] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[self.start..self.start + self.length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begins_a_line<S>(number: &S) -> bool {
        std::ptr::from_ref(number).addr().is_multiple_of(CACHE_LINE)
    }

    #[test]
    fn the_number_asked_for_begins_a_line_in_copies_too() {
        for first in [0, 1, 7, 8, 17] {
            let mut numbers = Aligned::<f64>::zeros(100, first);
            assert!(begins_a_line(&numbers[first]), "{first}");
            numbers[99] = 3.0;
            let copy = numbers.clone();
            assert!(begins_a_line(&copy[first]) && copy == numbers && copy.len() == 100, "{first}");
            let singles = Aligned::<f32>::zeros(40, first);
            assert!(begins_a_line(&singles[first]) && singles.len() == 40);
        }
    }
}
