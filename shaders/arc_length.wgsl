// arc_length: length of a sinusoidal yarn over its span, (13) in closed form, by the Gauss–Kummer series.
// Twin: src/physics/arc_length.rs

/// s − 1, ds/dk, d²s/dk² and cos α = 1/√(1 + k²) at end slope k.
struct ArcLength {
    excess: f32,
    slope: f32,
    curvature: f32,
    cosine: f32,
}

/// Squares of the binomial coefficients C(1/2, n), n = 1…12.
const SERIES = array<f32, 12>(
    0.25,
    0.015625,
    0.00390625,
    0.00152587890625,
    0.0007476806640625,
    0.00042057037353515625,
    0.00025963783264160156,
    0.0001714015379548073,
    0.000119028845801949501,
    0.0000859983410919085145,
    0.0000641433907730970532,
    0.0000491097835606524313,
);

/// One term of Horner's scheme for p (x) and its derivative (y).
fn term(sum: vec2<f32>, x: f32, coefficient: f32) -> vec2<f32> {
    return vec2<f32>(sum.x * x + coefficient, sum.y * x + sum.x);
}

fn arc_length(k: f32) -> ArcLength {
    let square = k * k;
    let secant = sqrt(1.0 + square);
    let a2 = secant + 1.0;
    // One division for 1/√(1 + k²) and 1/(√(1 + k²) + 1).
    let both = 1.0 / (secant * a2);
    let inverse_secant = a2 * both;
    let a1 = secant * both;
    let a_minus_1 = square * a1;
    let lambda = a_minus_1 * a1;
    let x = lambda * lambda;
    // Unrolled, so that the terms a fabric does not need are gone.
    var sum = vec2<f32>(0.0);
    if (TERMS > 11u) { sum = term(sum, x, SERIES[11]); }
    if (TERMS > 10u) { sum = term(sum, x, SERIES[10]); }
    if (TERMS > 9u) { sum = term(sum, x, SERIES[9]); }
    if (TERMS > 8u) { sum = term(sum, x, SERIES[8]); }
    if (TERMS > 7u) { sum = term(sum, x, SERIES[7]); }
    if (TERMS > 6u) { sum = term(sum, x, SERIES[6]); }
    if (TERMS > 5u) { sum = term(sum, x, SERIES[5]); }
    if (TERMS > 4u) { sum = term(sum, x, SERIES[4]); }
    if (TERMS > 3u) { sum = term(sum, x, SERIES[3]); }
    if (TERMS > 2u) { sum = term(sum, x, SERIES[2]); }
    if (TERMS > 1u) { sum = term(sum, x, SERIES[1]); }
    sum = term(sum, x, SERIES[0]);
    let g_minus_1 = x * sum.x;
    let dg = sum.x + x * sum.y;
    let excess = 0.5 * a_minus_1 + 0.5 * a2 * g_minus_1;
    let b = 0.5 * (1.0 + g_minus_1) + 2.0 * lambda * dg * a1;
    let slope = k * inverse_secant * b;
    let curvature = (1.0 + excess) * inverse_secant * inverse_secant - b * inverse_secant;
    return ArcLength(excess, slope, curvature, inverse_secant);
}
