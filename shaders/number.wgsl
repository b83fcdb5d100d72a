// number: what every kernel may do with a number.
// Twin: src/number.rs

/// Distance from 1 to the next larger number.
const EPSILON: f32 = 1.1920929e-7;

fn squared(x: f32) -> f32 {
    return x * x;
}

/// Cube root of a positive number: Halley's iteration from the exponent's estimate.
fn cube_root(x: f32) -> f32 {
    var y = bitcast<f32>(bitcast<u32>(x) / 3u + 0x2a512ce3u);
    for (var i = 0; i < 2; i++) {
        let cube = y * y * y;
        y = y * (cube + 2.0 * x) / (2.0 * cube + x);
    }
    return y;
}

/// Whether a number is finite, by its exponent bits: comparisons with NaN may be folded away.
fn finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}
