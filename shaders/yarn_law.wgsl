// yarn_law: tension and contact force of one yarn at a stretch and a height, (13)–(19), for every law.
// Twin: src/physics/yarn_law.rs

const SHORTEST: f32 = 1e-9;
const PI: f32 = 3.14159265358979;
const HALF_PI: f32 = 1.5707963267948966;

struct Yarn {
    /// EA [N].
    stiffness: f32,
    /// w0 [m].
    half_span: f32,
    crimp: f32,
    failure_strain: f32,
    /// dF/dε of the continuation to slack yarns [N].
    slack: f32,
    /// 0 warp, 1 weft.
    which: u32,
}

fn yarn(i: u32) -> Yarn {
    if (i == 0u) {
        return Yarn(
            scene.warp_stiffness, scene.warp_half_span, scene.warp_crimp, scene.warp_failure_strain, scene.warp_slack,
            0u);
    }
    return Yarn(
        scene.weft_stiffness, scene.weft_half_span, scene.weft_crimp, scene.weft_failure_strain, scene.weft_slack, 1u);
}

/// Tension at a strain [N] (17): a yarn carries no compression.
fn tension_at(y: Yarn, strain: f32) -> f32 { return y.stiffness * curve_tension(y.which, max(strain, 0.0)); }

/// dT/dε of a taut yarn [N].
fn modulus_at(y: Yarn, strain: f32) -> f32 {
    if (CURVE == 0u) { return y.stiffness; }
    return y.stiffness * curve_slope(y.which, strain);
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

fn sinusoid(y: Yarn, stretch: f32, h: f32) -> Sinusoid {
    let length = max(1.0 + stretch, SHORTEST);
    let dk = HALF_PI / (y.half_span * length);
    let k = h * dk;
    let arc = arc_length(k);
    let per_length = 1.0 / (1.0 + y.crimp);
    let scale = length * per_length;
    let strain = (stretch - y.crimp) * per_length + scale * arc.excess;
    let tension = tension_at(y, strain);
    let dstrain = scale * dk * arc.slope;
    return Sinusoid(arc, k, dk, strain, tension, dstrain);
}

/// Tension, contact force and their derivatives at Λ = 1 + `stretch` and height `h`.
fn yarn_response(y: Yarn, stretch: f32, h: f32) -> YarnResponse {
    let s = sinusoid(y, stretch, h);
    var force: f32;
    var stiffness: f32;
    if (VARIATIONAL) {
        force = PI * s.arc.slope * s.tension;
        let growth = modulus_at(y, s.strain) * s.dstrain;
        stiffness = PI * (s.arc.curvature * s.dk * s.tension + s.arc.slope * growth);
    } else {
        let cosine = s.arc.cosine;
        let twice = 2.0 * cosine;
        let sine = twice * s.k;
        force = s.tension * sine;
        stiffness = modulus_at(y, s.strain) * s.dstrain * sine + s.tension * (twice * squared(cosine) * s.dk);
    }
    let taut = 0.0 < s.strain;
    return YarnResponse(
        s.strain,
        select(y.slack * s.strain, force, taut),
        select(y.slack * s.dstrain, stiffness, taut),
        s.dstrain);
}

/// In-plane force over tension.
fn in_plane_factor(y: Yarn, stretch: f32, h: f32) -> f32 {
    if (!VARIATIONAL) { return 1.0; }
    let s = sinusoid(y, stretch, h);
    return 1.0 + s.arc.excess - s.k * s.arc.slope;
}
