// kinematics: size, gradients, stretches and directions of an element.
// Twin: src/physics/kinematics.rs

/// Keeps quotients finite where an element has shrunk to nothing: least stretch, its square or its change.
const TINY: f32 = 1e-12;

/// The constants of an element's own size; otherwise as in `Scene`.
struct ElementGeometry {
    gradient: vec2<f32>,
    membrane: vec2<f32>,
    half_length: vec2<f32>,
    /// Hourglass stiffness of both yarns [N/m].
    hourglass: f32,
    viscosity: vec2<f32>,
    /// In proportion to the whole length, at steep fronts.
    steep_viscosity: vec2<f32>,
    cells: f32,
    area: f32,
}

fn geometry_of(ply: u32, place: vec2<u32>) -> ElementGeometry {
    // Along x and y, over the finest.
    var width = vec2<f32>(1.0);
    var per_width = vec2<f32>(1.0);
    var limited = vec2<f32>(1.0);
    if (GRADED) {
        let across_x = line_at(ply, 0u, place.y);
        let across_y = line_at(ply, 1u, place.x);
        width = vec2<f32>(across_x.width, across_y.width);
        per_width = vec2<f32>(across_x.per_width, across_y.per_width);
        limited = min(width, scene.viscous_length);
    }
    let hourglass = scene.hourglass * per_width * per_width;
    return ElementGeometry(
        scene.gradient * per_width,
        scene.membrane * width.yx,
        scene.half_length * width.yx,
        hourglass.x + hourglass.y,
        scene.viscosity * limited,
        scene.viscosity * width,
        scene.cells * width.y * width.x,
        scene.area * width.y * width.x);
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
    let g1 = u.x * size.gradient.x;
    let g2 = u.y * size.gradient.y;
    let f1 = vec3<f32>(1.0 + g1.x, g1.y, g1.z);
    let f2 = vec3<f32>(g2.x, 1.0 + g2.y, g2.z);
    let q = size.gradient * size.gradient * (scene.mode_share * dot(u.mode, u.mode));
    let length = max(sqrt(vec2<f32>(dot(f1, f1), dot(f2, f2)) + q), vec2<f32>(TINY));
    // Λ − 1 from the displacement gradient: no cancellation at small strain.
    let stretch = (2.0 * vec2<f32>(g1.x, g2.y) + (vec2<f32>(dot(g1, g1), dot(g2, g2)) + q)) / (1.0 + length);
    let per_length = 1.0 / length;
    let sine = (g2.x + g1.y + dot(g1, g2)) * per_length.x * per_length.y;
    let per_mode = scene.mode_share * (size.gradient * per_length);
    return Kinematics(
        stretch, f1 * per_length.x, f2 * per_length.y, u.mode, per_mode, per_length, min(max(sine, -1.0), 1.0));
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
    let per_length = step.span * size.gradient;
    let warp = v.x * per_length.x;
    let weft = v.y * per_length.y;
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
