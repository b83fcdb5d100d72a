// shear: trellis shear with locking, (25).
// Twin: src/physics/membrane.rs

/// asin(x)/x as a polynomial in x² on |x| ≤ ½, highest power first.
const ARC_SINE_SINGLE = array<f32, 7>(
    0.03767713930990015,
    0.014295255316288355,
    0.031857189096626805,
    0.04450870947221119,
    0.07500571381184176,
    0.16666657639572235,
    1.0000000002307785,
);

/// Arc sine of a number in [−1, 1].
fn arc_sine(x: f32) -> f32 {
    let size = min(abs(x), 1.0);
    let small = size <= 0.5;
    let argument = select(sqrt(0.5 * (1.0 - size)), size, small);
    let s = squared(argument);
    // Horner for the even (x) and for the odd (y) powers of x²: neither waits for the other.
    let fourth = s * s;
    var p = vec2<f32>(ARC_SINE_SINGLE[2], ARC_SINE_SINGLE[1]) + vec2<f32>(ARC_SINE_SINGLE[0] * fourth, 0.0);
    p = p * fourth + vec2<f32>(ARC_SINE_SINGLE[4], ARC_SINE_SINGLE[3]);
    p = p * fourth + vec2<f32>(ARC_SINE_SINGLE[6], ARC_SINE_SINGLE[5]);
    let angle = argument * (p.x + p.y * s);
    let whole = select(HALF_PI - 2.0 * angle, angle, small);
    return select(whole, -whole, x < 0.0);
}

/// Shear resultant q(γ) [N/m] at γ [rad], and shear energy per reference area, ∫q dγ [J/m²].
fn shear_of(gamma: f32) -> vec2<f32> {
    let size = abs(gamma);
    let third = 1.0 / 3.0;
    let into = min(max(size - scene.shear_gamma1, 0.0), scene.shear_ramp);
    let past = max(size - scene.shear_gamma1 - scene.shear_ramp, 0.0);
    let q = scene.shear_g1 * size + 0.5 * scene.shear_slope * squared(into) + scene.shear_rise * past;
    let base = 0.5 * scene.shear_g1 * squared(size);
    let ramp = 0.5 * third * scene.shear_slope * into * into * into;
    let energy = base + ramp + 0.5 * scene.shear_slope * squared(into) * past + 0.5 * scene.shear_rise * squared(past);
    return vec2<f32>(select(q, -q, gamma < 0.0), energy);
}

/// Sine of the shear angle up to which (25) is followed; beyond it the energy goes on at a constant slope over the sine.
const STEEPEST: f32 = 0.98;

/// Trellis shear of an element at one time.
struct Trellis {
    /// dW/d(sin γ) [N/m].
    slope: f32,
    /// W [J/m²].
    energy: f32,
}

/// Trellis shear at the sine of an angle.
fn trellis_at(sine: f32) -> Trellis {
    let followed = min(max(sine, -STEEPEST), STEEPEST);
    let shear = shear_of(arc_sine(followed));
    let slope = shear.x / sqrt(1.0 - squared(followed));
    return Trellis(slope, shear.y + abs(slope) * abs(sine - followed));
}
