// yarn_curve: tension over stiffness of yarns that are not linear, and the table that goes with a ply type.
// Twin: src/physics/yarn_law.rs

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

@group(0) @binding(4) var<uniform> law: Tables;

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

/// Twice the energy per rest length of a yarn of this stiffness at a tension and its strain [N]; nothing where the tension is none.
fn twice_energy(which: u32, stiffness: f32, tension: f32, strain: f32) -> f32 {
    if (CURVE == 0u) { return tension * strain; }
    var sum = 0.0;
    for (var i = 0u; i < CURVE; i++) {
        let ramp = ramp_of(which, i);
        sum += ramp.y * squared(max(strain - ramp.x, 0.0));
    }
    return select(0.0, stiffness * sum, 0.0 < tension);
}
