// yarn_law: tension over strain of a yarn, linear or not; the length of a sinusoidal yarn over its span, (13) in closed form, by the
// Gauss–Kummer series; tension and contact force at a stretch and a height, (13)–(19), for every law. Yarns by `which`: 0 warp, 1 weft.
// Twin: src/physics/yarn_law.rs

const SHORTEST: f32 = 1e-9;
const PI: f32 = 3.14159265358979;
const HALF_PI: f32 = 1.5707963267948966;

const RAMPS: u32 = 15u;

/// Tables of a ply type: share of a cell's energy that the unit-cell law creates, over both stretches, and curves of the yarns.
struct Tables {
    /// Λ − 1 of the first place, warp and weft.
    low: vec2<f32>,
    /// Places per stretch.
    per_stretch: vec2<f32>,
    /// Shape (40 warp, 40 weft).
    values: array<vec4<f32>, 400>,
    /// Ramps: start and rise of the warp, start and rise of the weft.
    curve: array<vec4<f32>, RAMPS>,
}

@group(0) @binding(3) var<uniform> law: Tables;

/// Ramp of a yarn (0 warp, 1 weft): start and rise.
fn ramp_of(which: u32, index: u32) -> vec2<f32> {
    let ramp = law.curve[index];
    return select(ramp.zw, ramp.xy, which == 0u);
}

/// Tension over stiffness at a strain, at least 0.
fn curve_tension(which: u32, strain: f32) -> f32 {
    if (CURVE == 0u) { return strain; }
    var sum = 0.0;
    for (var i = 0u; i < CURVE; i++) {
        let ramp = ramp_of(which, i);
        sum += ramp.y * max(strain - ramp.x, 0.0);
    }
    return sum;
}

/// Slope of that at a strain above 0.
fn curve_slope(which: u32, strain: f32) -> f32 {
    if (CURVE == 0u) { return 1.0; }
    var sum = 0.0;
    for (var i = 0u; i < CURVE; i++) {
        let ramp = ramp_of(which, i);
        sum += select(0.0, ramp.y, ramp.x < strain);
    }
    return sum;
}

/// Tension over its slope at a strain above 0.
fn secant_strain(which: u32, strain: f32) -> f32 {
    if (CURVE == 0u) { return strain; }
    return curve_tension(which, strain) / curve_slope(which, strain);
}

/// Twice the energy per rest length of a yarn at a tension and its strain [N]; nothing where the tension is none.
fn twice_energy(which: u32, tension: f32, strain: f32) -> f32 {
    if (CURVE == 0u) { return tension * strain; }
    var sum = 0.0;
    for (var i = 0u; i < CURVE; i++) {
        let ramp = ramp_of(which, i);
        sum += ramp.y * squared(max(strain - ramp.x, 0.0));
    }
    return select(0.0, scene.stiffness[which] * sum, 0.0 < tension);
}

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

/// Tension at a strain [N] (17): a yarn carries no compression.
fn tension_at(which: u32, strain: f32) -> f32 { return scene.stiffness[which] * curve_tension(which, max(strain, 0.0)); }

/// dT/dε of a taut yarn [N].
fn modulus_at(which: u32, strain: f32) -> f32 {
    if (CURVE == 0u) { return scene.stiffness[which]; }
    return scene.stiffness[which] * curve_slope(which, strain);
}

struct YarnResponse {
    strain: f32,
    /// F [N]; negative and growing with h where the yarn is slack.
    force: f32,
    /// dF/dh [N/m].
    stiffness: f32,
    /// dε/dh [1/m].
    growth: f32,
}

/// The response of a taut yarn after a rise of its height too small to bend the curve.
fn raised(r: YarnResponse, rise: f32) -> YarnResponse {
    let strain = r.strain + r.growth * rise;
    return YarnResponse(strain, r.force + r.stiffness * rise, r.stiffness, r.growth);
}

/// The contact force without its continuation.
fn real_force(r: YarnResponse) -> f32 { return select(0.0, r.force, 0.0 < r.strain); }

struct Sinusoid {
    arc: ArcLength,
    k: f32,
    dk: f32,
    strain: f32,
    tension: f32,
    dstrain: f32,
}

fn sinusoid(which: u32, stretch: f32, h: f32) -> Sinusoid {
    let length = max(1.0 + stretch, SHORTEST);
    let dk = HALF_PI / (scene.half_span[which] * length);
    let k = h * dk;
    let arc = arc_length(k);
    let per_length = 1.0 / (1.0 + scene.crimp[which]);
    let scale = length * per_length;
    let strain = (stretch - scene.crimp[which]) * per_length + scale * arc.excess;
    let tension = tension_at(which, strain);
    let dstrain = scale * dk * arc.slope;
    return Sinusoid(arc, k, dk, strain, tension, dstrain);
}

/// Tension, contact force and their derivatives at Λ = 1 + `stretch` and height `h`.
fn yarn_response(which: u32, stretch: f32, h: f32) -> YarnResponse {
    let s = sinusoid(which, stretch, h);
    var force: f32;
    var stiffness: f32;
    if (VARIATIONAL) {
        force = PI * s.arc.slope * s.tension;
        let growth = modulus_at(which, s.strain) * s.dstrain;
        stiffness = PI * (s.arc.curvature * s.dk * s.tension + s.arc.slope * growth);
    } else {
        let cosine = s.arc.cosine;
        let twice = 2.0 * cosine;
        let sine = twice * s.k;
        force = s.tension * sine;
        stiffness = modulus_at(which, s.strain) * s.dstrain * sine + s.tension * (twice * squared(cosine) * s.dk);
    }
    let taut = 0.0 < s.strain;
    return YarnResponse(
        s.strain,
        select(scene.slack[which] * s.strain, force, taut),
        select(scene.slack[which] * s.dstrain, stiffness, taut),
        s.dstrain);
}

/// In-plane force over tension.
fn in_plane_factor(which: u32, stretch: f32, h: f32) -> f32 {
    if (!VARIATIONAL) { return 1.0; }
    let s = sinusoid(which, stretch, h);
    return 1.0 + s.arc.excess - s.k * s.arc.slope;
}
