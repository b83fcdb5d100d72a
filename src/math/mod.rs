//! Numbers: what the kernels are generic over, several at once, and sums in fixed order.

pub mod aligned;
pub mod counter_random;
pub mod link;
pub mod scalar;
pub mod simd;
pub(crate) mod solid;
pub(crate) mod sum;
pub mod weibull;
