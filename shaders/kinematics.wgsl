// kinematics: size, gradients, stretches and directions of an element.
// Twin: src/physics/kinematics.rs

/// Keeps quotients finite where an element has shrunk to nothing: least stretch, its square or its change.
const TINY: f32 = 1e-12;

/// The constants of an element's own size; otherwise as in `Scene`.
struct ElementGeometry {
    gradient_x: f32,
    gradient_y: f32,
    membrane_warp: f32,
    membrane_weft: f32,
    half_length_warp: f32,
    half_length_weft: f32,
    /// Hourglass stiffness of both yarns [N/m].
    hourglass: f32,
    viscosity_warp: f32,
    viscosity_weft: f32,
    /// In proportion to the whole length, at steep fronts.
    steep_viscosity_warp: f32,
    steep_viscosity_weft: f32,
    cells: f32,
    area: f32,
}

fn geometry_of(ply: u32, place: vec2<u32>) -> ElementGeometry {
    // Width and its inverse along x and y, over the finest.
    var x = vec2<f32>(1.0);
    var y = vec2<f32>(1.0);
    var limited = vec2<f32>(1.0);
    if (GRADED) {
        let across_x = line_at(ply, 0u, place.y);
        let across_y = line_at(ply, 1u, place.x);
        x = vec2<f32>(across_x.width, across_x.per_width);
        y = vec2<f32>(across_y.width, across_y.per_width);
        limited = min(vec2<f32>(x.x, y.x), vec2<f32>(scene.viscous_length_x, scene.viscous_length_y));
    }
    return ElementGeometry(
        scene.gradient_x * x.y,
        scene.gradient_y * y.y,
        scene.membrane_warp * y.x,
        scene.membrane_weft * x.x,
        scene.half_length_warp * y.x,
        scene.half_length_weft * x.x,
        scene.hourglass_warp * x.y * x.y + scene.hourglass_weft * y.y * y.y,
        scene.viscosity_warp * limited.x,
        scene.viscosity_weft * limited.y,
        scene.viscosity_warp * x.x,
        scene.viscosity_weft * y.x,
        scene.cells * y.x * x.x,
        scene.area * y.x * x.x);
}

struct Kinematics {
    /// Λ − 1.
    stretch: vec2<f32>,
    warp: vec3<f32>,
    weft: vec3<f32>,
    /// Difference of opposite edges [m].
    mode: vec3<f32>,
    /// Slope of the stretch over that difference, over q: share/(2·L·Λ) [1/m].
    per_mode: vec2<f32>,
    /// 1/Λ.
    per_stretch: vec2<f32>,
    sine: f32,
}

/// Corner values (columns of four) to twice the edge differences along X and Y and the hourglass combination.
struct Differences {
    x: vec3<f32>,
    y: vec3<f32>,
    mode: vec3<f32>,
}

fn differences(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> Differences {
    let bottom = b - a;
    let top = c - d;
    return Differences(bottom + top, (d - a) + (c - b), top - bottom);
}

fn kinematics(size: ElementGeometry, u: Differences) -> Kinematics {
    let g1 = u.x * size.gradient_x;
    let g2 = u.y * size.gradient_y;
    let f1 = vec3<f32>(1.0 + g1.x, g1.y, g1.z);
    let f2 = vec3<f32>(g2.x, 1.0 + g2.y, g2.z);
    let q = vec2<f32>(size.gradient_x * size.gradient_x, size.gradient_y * size.gradient_y) * (scene.mode_share * dot(u.mode, u.mode));
    let l1 = max(sqrt(dot(f1, f1) + q.x), TINY);
    let l2 = max(sqrt(dot(f2, f2) + q.y), TINY);
    // Λ − 1 from the displacement gradient: no cancellation at small strain.
    let s1 = (2.0 * g1.x + (dot(g1, g1) + q.x)) / (1.0 + l1);
    let s2 = (2.0 * g2.y + (dot(g2, g2) + q.y)) / (1.0 + l2);
    let i1 = 1.0 / l1;
    let i2 = 1.0 / l2;
    let sine = (g2.x + g1.y + dot(g1, g2)) * i1 * i2;
    let per_mode = scene.mode_share * vec2<f32>(size.gradient_x * i1, size.gradient_y * i2);
    return Kinematics(
        vec2<f32>(s1, s2), f1 * i1, f2 * i2, u.mode, per_mode, vec2<f32>(i1, i2), min(max(sine, -1.0), 1.0));
}

/// Growth along warp and weft in a step.
struct Growth {
    /// Growth of the gradient at the centre, along the yarn, and its square.
    along: vec2<f32>,
    square: vec2<f32>,
    /// Growth with q, the part of the hourglass mode.
    whole: vec2<f32>,
    whole_square: vec2<f32>,
}

/// Since the last forces. `v`: differences of velocities.
fn growth(size: ElementGeometry, k: Kinematics, v: Differences) -> Growth {
    let warp = v.x * (step.span * size.gradient_x);
    let weft = v.y * (step.span * size.gradient_y);
    let per_length = step.span * vec2<f32>(size.gradient_x, size.gradient_y);
    let along = vec2<f32>(dot(k.warp, warp), dot(k.weft, weft));
    let square = vec2<f32>(dot(warp, warp), dot(weft, weft));
    return Growth(
        along,
        square,
        along + k.per_mode * per_length * dot(k.mode, v.mode),
        square + per_length * per_length * (scene.mode_share * dot(v.mode, v.mode)));
}

/// Growth of the stretches in a step, to second order.
fn stretching(k: Kinematics, grown: Growth) -> vec2<f32> {
    return grown.whole - 0.5 * k.per_stretch * (grown.whole_square - grown.whole * grown.whole);
}
