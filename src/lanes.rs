//! Several numbers at once: the kernels' fast path on the CPU.
//!
//! Arrays with element-wise operations. The compiler turns them into vector instructions where it can and into
//! independent scalar ones where it cannot, which already hides the latency of the unit cell's divisions and roots.
//! Every lane does exactly what one number alone would do, so results are the same bits for any width.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::number::{Mask, Real, Scalar};

/// `N` numbers.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Lanes<S, const N: usize>([S; N]);

/// `N` truth values.
#[derive(Clone, Copy, Debug)]
pub struct LaneMask<const N: usize>([bool; N]);

macro_rules! arithmetic {
    ($($trait:ident $name:ident),+) => {$(
        impl<S: Scalar, const N: usize> $trait for Lanes<S, N> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(std::array::from_fn(|i| self.0[i].$name(other.0[i])))
            }
        }
    )+};
}

arithmetic!(Add add, Sub sub, Mul mul, Div div);

impl<S: Scalar, const N: usize> Neg for Lanes<S, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<const N: usize> BitAnd for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] & other.0[i]))
    }
}

impl<const N: usize> BitOr for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}

impl<const N: usize> Not for LaneMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|b| !b))
    }
}

impl<const N: usize> Mask for LaneMask<N> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.into_iter().fold(false, |a, b| a | b)
    }
    #[inline(always)]
    fn count(self) -> u32 {
        self.0.into_iter().map(u32::from).sum()
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.0[lane]
    }
}

impl<S: Scalar, const N: usize> Real for Lanes<S, N> {
    type Scalar = S;
    type Mask = LaneMask<N>;
    const LANES: usize = N;
    const EPSILON: f64 = S::EPSILON;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([S::splat(value); N])
    }
    #[inline(always)]
    fn load(source: &[S], index: usize) -> Self {
        let part = &source[index..index + N];
        Self(std::array::from_fn(|i| part[i]))
    }
    #[inline(always)]
    fn store(self, target: &mut [S], index: usize) {
        target[index..index + N].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> S {
        self.0[lane]
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(Real::sqrt))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(Real::abs))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<N> {
        LaneMask(std::array::from_fn(|i| self.0[i] < other.0[i]))
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<N> {
        LaneMask(std::array::from_fn(|i| self.0[i] <= other.0[i]))
    }
    #[inline(always)]
    fn select(mask: LaneMask<N>, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if mask.0[i] { yes.0[i] } else { no.0[i] }))
    }
    #[inline(always)]
    fn cube_root_estimate(self) -> Self {
        Self(self.0.map(Real::cube_root_estimate))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::crossover::{CellConstants, PublishedTension, solve};

    #[test]
    fn lanes_give_the_same_bits_as_one_number_at_a_time() {
        let text = include_str!("../cases/verify/mirror.json");
        let fabric = crate::case::from_str("mirror", text, &[]).map(|c| c.fabric);
        let cell = CellConstants::new(&fabric.expect("a shipped case"));
        let one = CellConstants::<f64>::cast::<PublishedTension>(&cell);
        let four = CellConstants::<Lanes<f64, 4>>::cast::<PublishedTension>(&cell);
        let stretches = |i: usize| [2e-4 * i as f64 - 3e-3, 1.5e-4 * (40 - i) as f64 - 2e-3];
        for first in 0..37 {
            let pick = |yarn: usize| Lanes::<f64, 4>(std::array::from_fn(|i| stretches(first + i)[yarn]));
            let warm = [four.yarn[0].height, four.yarn[1].height];
            let both = solve::<_, PublishedTension>(&four, [pick(0), pick(1)], warm, LaneMask::splat(true));
            for lane in 0..4 {
                let warm = [one.yarn[0].height, one.yarn[1].height];
                let alone = solve::<_, PublishedTension>(&one, stretches(first + lane), warm, true);
                for yarn in 0..2 {
                    assert_eq!(both.tension[yarn].lane(lane).to_bits(), alone.tension[yarn].to_bits());
                    assert_eq!(both.height[yarn].lane(lane).to_bits(), alone.height[yarn].to_bits());
                }
            }
        }
    }
}
