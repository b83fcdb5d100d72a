// membrane: in-plane forces of an element: yarns, trellis shear that fades where a yarn is folded.
// Twin: src/physics/membrane.rs

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
    let n1 = pull.x * size.membrane_warp;
    let n2 = pull.y * size.membrane_weft;
    if (!SHEAR) { return Membrane(n1 * k.warp, n2 * k.weft); }
    let m1 = n1 + shear.along.x * size.half_length_warp;
    let m2 = n2 + shear.along.y * size.half_length_weft;
    let q1 = shear.slope * size.half_length_warp * k.per_stretch.x;
    let q2 = shear.slope * size.half_length_weft * k.per_stretch.y;
    return Membrane(
        m1 * k.warp + q1 * (k.weft - k.sine * k.warp),
        m2 * k.weft + q2 * (k.warp - k.sine * k.weft));
}

/// Force on the difference of opposite edges [N]. `pull`: without shock viscosity, which acts along the yarn at the centre alone.
fn mode_force(size: ElementGeometry, k: Kinematics, pull: vec2<f32>, shear: Shear) -> vec3<f32> {
    var along = pull * vec2<f32>(size.membrane_warp, size.membrane_weft);
    if (SHEAR) {
        // The sine of the shear angle falls as the stretch grows.
        along += vec2<f32>(size.half_length_warp, size.half_length_weft) * (shear.along - shear.slope * k.sine * k.per_stretch);
    }
    return dot(along, k.per_mode) * k.mode;
}
