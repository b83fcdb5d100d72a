// scalar: what every kernel may do with a number.
// Twin: src/num/scalar.rs

/// Distance from 1 to the next larger number.
const EPSILON: f32 = 1.1920929e-7;

fn squared(x: f32) -> f32 { return x * x; }

/// 1/∛x of a positive number: two rounds of fourth order from the exponent's estimate.
fn inverse_cube_root(x: f32) -> f32 {
    var y = bitcast<f32>(0x54a2fa8cu - (bitcast<u32>(x) >> 16u) * 0x5556u);
    for (var i = 0; i < 2; i++) {
        let r = 1.0 - x * (y * y * y);
        y = y + y * (r * (1.0 / 3.0 + r * (2.0 / 9.0 + r * (14.0 / 81.0))));
    }
    return y;
}

/// Whether a number is finite, by its exponent bits: comparisons with NaN may be folded away.
fn finite(x: f32) -> bool { return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u; }
