//! Numbers: what the kernels are generic over, several at once, sums in fixed order; random numbers, distributions, solids.

pub mod random;
pub mod scalar;
pub mod simd;
pub(crate) mod solid;

/// A range after so many halvings, around the number up to which `is_low` holds.
pub(crate) fn bisect([mut low, mut high]: [f64; 2], halvings: u32, is_low: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if is_low(middle) { low = middle } else { high = middle }
    }
    [low, high]
}
