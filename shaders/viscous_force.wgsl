// viscous_force: forces of yarns that depend on rates: shock viscosity, and what the rate of strain adds to a stress.
// Twin: src/physics/viscous_force.rs

/// Forces of an element's yarns that depend on rates.
struct Viscous {
    /// Of shock viscosity and of the rate of strain, now [N].
    force: vec2<f32>,
    /// Overstress of the rate of strain over the tension.
    rate: vec2<f32>,
    /// Work since the last step over ½ of the element's length times its yarns [N].
    work: vec2<f32>,
}

const RATE_ITERATIONS: u32 = 3u;

/// Overstress of the rate of strain over the tensions T of the yarns: dx/dt = k/T (de/dt - C x^P), implicitly. `growth` of the stretches
/// in this step; `before`: at the last step.
fn overstress(tension: vec2<f32>, growth: vec2<f32>, before: vec2<f32>) -> vec2<f32> {
    let zero = vec2<f32>(0.0);
    let per_rest = 1.0 / (1.0 + scene.crimp);
    // An absent yarn has no stiffness either.
    let stiffness = scene.rate_most * scene.stiffness / max(tension, max(scene.stiffness * LEAST_STRAIN, vec2<f32>(TINY)));
    let trial = max(before + stiffness * per_rest * growth, zero);
    let yielding = stiffness * (step.span * scene.rate_c);
    var x = min(before, trial);
    for (var round = 0u; round < RATE_ITERATIONS; round++) {
        // A power of 0 is not defined on every device.
        let slope = yielding * pow(max(x, vec2<f32>(1e-30)), vec2<f32>(scene.rate_power - 1.0));
        x = max(x + (trial - x - slope * x) / (1.0 + scene.rate_power * slope), zero);
    }
    return select(zero, min(x, vec2<f32>(scene.rate_most)), zero < tension);
}

/// Viscous forces of warp and weft: stiffness times viscosity times the rate of stretch, so large at a shock and small elsewhere. In coarse
/// elements the viscosity grows with the steepness of the front. With them what the rate of strain adds. A slack yarn has none, and a yarn
/// never pushes. `elastic`: in-plane forces of the yarns; `before`: viscous forces at the last step, `rate_before`: what the rate of strain
/// added then.
fn viscous_forces(
    size: ElementGeometry, k: Kinematics, v: Differences, grown: Growth, elastic: vec2<f32>, before: vec2<f32>, rate_before: vec2<f32>,
) -> Viscous {
    let rate = vec2<f32>(dot(k.warp, v.x), dot(k.weft, v.y)) * size.gradient;
    let steepness = min(abs(rate) * size.steep_viscosity * scene.per_steep, vec2<f32>(1.0));
    let viscosity = size.viscosity + (size.steep_viscosity - size.viscosity) * steepness;
    let zero = vec2<f32>(0.0);
    var added = zero;
    if (RATE) { added = overstress(elastic, grown.along, rate_before); }
    let force = select(max(scene.stiffness * viscosity * rate + added * elastic, -elastic), zero, elastic <= zero);
    // The same rate along the directions of the last step, from Λ² - 1 there.
    let now = 1.0 + k.stretch;
    let more = k.stretch * (now + 1.0) - 2.0 * now * grown.whole + grown.whole_square;
    let last = sqrt(max(1.0 + more, vec2<f32>(TINY)));
    // A yarn that went slack since dissipates on its way to slack, and no further: more than it stored would be booked.
    let stretch = more / (1.0 + last);
    let share = min(stretch / max(stretch - k.stretch, vec2<f32>(TINY)), vec2<f32>(1.0));
    let taut = select(vec2<f32>(1.0), share, (elastic <= zero) & (stretch > zero));
    return Viscous(force, added, force * grown.along + taut * before * ((now * grown.along - grown.square) / last));
}
