// membrane: in-plane forces of an element: yarns, and trellis shear with locking, (25), that fades where a yarn is folded.
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

/// Stretch of a yarn below which it counts as folded: its element's trellis energy fades with the stretch.
const FOLDED_STRETCH: f32 = 0.5;

/// Trellis shear as the membrane feels it: the energy per reference area is fade(Λ1) fade(Λ2) W(sin γ).
struct Shear {
    /// Slope of that energy over Λ1 and Λ2, and over sin γ [N/m].
    along: vec2<f32>,
    slope: f32,
    /// The energy [J/m²].
    energy: f32,
}

fn trellis_shear(k: Kinematics) -> Shear {
    let trellis = trellis_at(k.sine);
    let part = min((1.0 + k.stretch) * (1.0 / FOLDED_STRETCH), vec2<f32>(1.0));
    let fade = part * part * (3.0 - 2.0 * part);
    let rise = (6.0 / FOLDED_STRETCH) * part * (1.0 - part);
    let both = fade.x * fade.y;
    return Shear(trellis.energy * (rise * fade.yx), trellis.slope * both, trellis.energy * both);
}

/// Shear where it acts, nothing elsewhere.
fn shear_where(acts: bool, trellis: Shear) -> Shear {
    if (acts) { return trellis; }
    return Shear();
}

struct Membrane {
    warp: vec3<f32>,
    weft: vec3<f32>,
}

/// P1·Ly/2 and P2·Lx/2 [N] from in-plane yarn forces and trellis shear.
fn membrane(size: ElementGeometry, k: Kinematics, pull: vec2<f32>, shear: Shear) -> Membrane {
    let yarns = pull * size.membrane;
    if (!SHEAR) { return Membrane(yarns.x * k.warp, yarns.y * k.weft); }
    let along = yarns + shear.along * size.half_length;
    let across = shear.slope * size.half_length * k.per_stretch;
    return Membrane(
        along.x * k.warp + across.x * (k.weft - k.sine * k.warp),
        along.y * k.weft + across.y * (k.warp - k.sine * k.weft));
}

/// Force on the difference of opposite edges [N]. `pull`: without shock viscosity, which acts along the yarn at the centre alone.
fn mode_force(size: ElementGeometry, k: Kinematics, pull: vec2<f32>, shear: Shear) -> vec3<f32> {
    var along = pull * size.membrane;
    if (SHEAR) {
        // The sine of the shear angle falls as the stretch grows.
        along += size.half_length * (shear.along - shear.slope * k.sine * k.per_stretch);
    }
    return dot(along, k.per_mode) * k.mode;
}
