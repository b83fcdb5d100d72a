//! Sobol's points: they fill a box evenly, however many are taken. Direction numbers of Joe & Kuo (2008), in Gray code order; the first
//! point, the origin, is left out.

/// Dimensions that there are direction numbers of.
pub const MAX_DIMENSIONS: usize = 16;
/// Bits of a coordinate.
const BITS: usize = 32;

/// Degree and coefficients of the primitive polynomials of the second dimension on, and the first direction numbers.
const DIRECTIONS: [(u32, &[u32]); MAX_DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
];

/// Direction numbers of a dimension.
fn directions(dimension: usize) -> [u32; BITS] {
    let mut v: [u32; BITS] = std::array::from_fn(|bit| 1 << (BITS - 1 - bit));
    let Some((a, m)) = dimension.checked_sub(1).and_then(|at| DIRECTIONS.get(at)) else { return v };
    let degree = m.len();
    for (bit, m) in m.iter().enumerate() {
        v[bit] = m << (BITS - 1 - bit);
    }
    for bit in degree..BITS {
        v[bit] = v[bit - degree] ^ (v[bit - degree] >> degree);
        for k in 1..degree {
            if (a >> (degree - 1 - k)) & 1 == 1 {
                v[bit] ^= v[bit - k];
            }
        }
    }
    v
}

/// So many points between 0 and 1; at most [`MAX_DIMENSIONS`] coordinates each.
pub fn sobol(dimensions: usize, count: usize) -> Vec<Vec<f64>> {
    let v: Vec<[u32; BITS]> = (0..dimensions.min(MAX_DIMENSIONS)).map(directions).collect();
    let mut x = vec![0_u32; v.len()];
    let next = |n: usize| {
        let bit = (n as u32).trailing_ones() as usize;
        x.iter_mut().zip(&v).for_each(|(x, v)| *x ^= v[bit.min(BITS - 1)]);
        x.iter().map(|x| f64::from(*x) / 2.0_f64.powi(BITS as i32)).collect()
    };
    (0..count).map(next).collect()
}

#[cfg(test)]
#[path = "sobol_tests.rs"]
mod tests;
