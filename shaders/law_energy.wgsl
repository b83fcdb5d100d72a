// law_energy: energy that the published unit-cell law makes or loses by itself.
// Twin: src/model/law_energy.rs

/// Places along each axis of the law's energy.
const LAW_COUNT: u32 = 40u;

/// Share of a cell's energy that the unit-cell law creates, over both stretches.
struct LawEnergy {
    /// Λ − 1 of the first place, warp and weft.
    low: vec2<f32>,
    /// Places per stretch.
    per_stretch: vec2<f32>,
    /// Shape (40 warp, 40 weft).
    values: array<vec4<f32>, 400>,
}

@group(0) @binding(4) var<uniform> law: LawEnergy;

fn law_value(i: u32, j: u32) -> f32 {
    let at = i * LAW_COUNT + j;
    return law.values[at / 4u][at % 4u];
}

/// At the stretches Λ − 1.
fn law_share(stretch: vec2<f32>) -> f32 {
    let place = min(max((stretch - law.low) * law.per_stretch, vec2<f32>(0.0)), vec2<f32>(f32(LAW_COUNT - 1u)));
    let i = min(u32(place.x), LAW_COUNT - 2u);
    let j = min(u32(place.y), LAW_COUNT - 2u);
    let x = place.x - f32(i);
    let y = place.y - f32(j);
    let low = law_value(i, j) + y * (law_value(i, j + 1u) - law_value(i, j));
    let high = law_value(i + 1u, j) + y * (law_value(i + 1u, j + 1u) - law_value(i + 1u, j));
    return low + x * (high - low);
}
