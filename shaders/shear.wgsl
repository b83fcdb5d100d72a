// shear: trellis shear with locking, (25).
// Twin: src/kernels/shear.rs

/// asin(x)/x as a polynomial in x² on |x| ≤ ½, highest power first.
const ARC_SINE = array<f32, 13>(
    0.03187962140081284,
    -0.016187392271599133,
    0.019513468251252168,
    0.006529302004736569,
    0.012170138592391726,
    0.01388484282640208,
    0.01735977964134998,
    0.022371749733164053,
    0.030381959697685140,
    0.04464285680599894,
    0.07500000000385202,
    0.1666666666666494,
    1.0,
);

/// Arc sine of a number in [−1, 1].
fn arc_sine(x: f32) -> f32 {
    let size = min(abs(x), 1.0);
    let small = size <= 0.5;
    let argument = select(sqrt(0.5 * (1.0 - size)), size, small);
    let s = squared(argument);
    // Horner for the even (x) and for the odd (y) powers of x²: neither waits for the other.
    let fourth = s * s;
    var p = vec2<f32>(ARC_SINE[2], ARC_SINE[1]) + vec2<f32>(ARC_SINE[0] * fourth, 0.0);
    p = p * fourth + vec2<f32>(ARC_SINE[4], ARC_SINE[3]);
    p = p * fourth + vec2<f32>(ARC_SINE[6], ARC_SINE[5]);
    p = p * fourth + vec2<f32>(ARC_SINE[8], ARC_SINE[7]);
    p = p * fourth + vec2<f32>(ARC_SINE[10], ARC_SINE[9]);
    p = p * fourth + vec2<f32>(ARC_SINE[12], ARC_SINE[11]);
    let angle = argument * (p.x + p.y * s);
    let whole = select(HALF_PI - 2.0 * angle, angle, small);
    return select(whole, -whole, x < 0.0);
}

/// Shear resultant q(γ) [N/m] at γ [rad].
fn shear_resultant(gamma: f32) -> f32 {
    let size = abs(gamma);
    let into = min(max(size - scene.shear_gamma1, 0.0), scene.shear_ramp);
    var q: f32;
    if (SECANT) {
        let locked = scene.shear_gamma1 + scene.shear_ramp <= size;
        q = size * (scene.shear_g1 + select(scene.shear_slope * into, scene.shear_rise, locked));
    } else {
        let past = max(size - scene.shear_gamma1 - scene.shear_ramp, 0.0);
        q = scene.shear_g1 * size + 0.5 * scene.shear_slope * squared(into) + scene.shear_rise * past;
    }
    return select(q, -q, gamma < 0.0);
}

/// Shear energy per reference area, ∫q dγ [J/m²].
fn shear_energy(gamma: f32) -> f32 {
    let size = abs(gamma);
    let third = 1.0 / 3.0;
    let into = min(max(size - scene.shear_gamma1, 0.0), scene.shear_ramp);
    let past = max(size - scene.shear_gamma1 - scene.shear_ramp, 0.0);
    let base = 0.5 * scene.shear_g1 * squared(size);
    if (SECANT) {
        let over_ramp = into * into * (third * into + 0.5 * scene.shear_gamma1);
        let locked = scene.shear_gamma1 + scene.shear_ramp;
        let past_ramp = 0.5 * scene.shear_rise * past * (past + 2.0 * locked);
        return base + scene.shear_slope * over_ramp + past_ramp;
    }
    let ramp = 0.5 * third * scene.shear_slope * into * into * into;
    return base + ramp + 0.5 * scene.shear_slope * squared(into) * past + 0.5 * scene.shear_rise * squared(past);
}
