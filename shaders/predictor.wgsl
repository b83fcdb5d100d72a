// predictor: what predicts the heights of a cell from one step to the next.
// Twin: src/kernels/predictor.rs

/// Strain below which a yarn is not followed: F/ε is of two numbers that vanish.
const LEAST_STRAIN: f32 = 1e-6;

/// How the two heights of a cell follow its two stretches, to first order.
struct Predictor {
    /// What a height falls by, per stretch, at constant contact force [m].
    dh_dstretch: vec2<f32>,
    /// 1/S over 1/S₁ + 1/S₂ + c [-].
    force_share: vec2<f32>,
}

/// Of a cell in equilibrium: strains and contact forces of its yarns, their slopes S [N/m], the compliance c of the crossover [m/N],
/// heights [m] and stretches Λ.
fn predictor_of(strain: vec2<f32>, force: vec2<f32>, slope: vec2<f32>, give: f32, height: vec2<f32>, length: vec2<f32>) -> Predictor {
    let below = max(strain, vec2<f32>(LEAST_STRAIN)) * slope * length;
    let per_both = 1.0 / (below.x * below.y);
    let per_sum = 1.0 / (give * (slope.x * slope.y) + (slope.x + slope.y));
    let above = force * (1.0 + strain) - height * slope * strain;
    let fall = above * (below.yx * per_both);
    // No number that is not finite passes either.
    let followed = (vec2<f32>(LEAST_STRAIN) < strain) & (abs(fall) < vec2<f32>(1.0));
    return Predictor(select(vec2<f32>(0.0), fall, followed), slope.yx * per_sum);
}

/// Heights after the stretches have grown by `change`.
fn predicted(predictor: Predictor, height: vec2<f32>, change: vec2<f32>) -> vec2<f32> {
    let push = predictor.dh_dstretch.x * change.x + predictor.dh_dstretch.y * change.y;
    return predictor.force_share * push + height - predictor.dh_dstretch * change;
}
