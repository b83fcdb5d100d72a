//! Numbers: what the kernels are generic over, several at once, sums in fixed order; random numbers, distributions, solids.

pub mod random;
pub mod scalar;
pub mod simd;
pub(crate) mod solid;
