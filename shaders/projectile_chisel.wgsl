// projectile_chisel: gap and outward normal near a cylinder whose flat front two slanted flats cut down to a strip.
// Twin: src/kernels/projectile_chisel.rs

/// Newton steps for the nearest point of the ellipse in which a flat meets the wall.
const ELLIPSE_STEPS: u32 = 5u;

/// How far the nose lies behind its foremost plane beside this point, along the axis [m]: 0 but for a chisel.
fn recess(point: vec3<f32>) -> f32 {
    return select(0.0, max((abs(point.y) - scene.chisel_half) * scene.chisel_slope, 0.0), scene.chisel != 0u);
}

/// Outward normal of the face of a flat or chisel nose beside this point.
fn nose_face(point: vec3<f32>) -> vec3<f32> {
    let on_flat = scene.chisel != 0u && scene.chisel_half < abs(point.y);
    let side = select(scene.chisel_sine, -scene.chisel_sine, point.y < 0.0);
    return select(vec3<f32>(0.0, 0.0, 1.0), vec3<f32>(0.0, side, scene.chisel_cosine), on_flat);
}

/// Cosine and sine of the place on the wall that is nearest to a point on the edge between flat and wall.
fn nearest_on_ellipse(radius: f32, point: vec3<f32>) -> vec2<f32> {
    let bend = squared(scene.chisel_slope);
    let size = max(radius, RESOLVED);
    let x = point.x / size;
    let y = (point.y - scene.chisel_slope * (point.z - scene.chisel_half * scene.chisel_slope)) / size;
    var mu = max(max(sqrt(squared(x) + squared(y)) - bend, x), 1.0);
    for (var i = 0u; i < ELLIPSE_STEPS; i++) {
        let c = x / mu;
        let s = y / (mu + bend);
        let square = max(squared(c) + squared(s), 1e-30);
        let change = max(squared(c) / mu + squared(s) / (mu + bend), 1e-30);
        mu = max(mu + square * (sqrt(square) - 1.0) / change, 1.0);
    }
    let at = vec2<f32>(x / mu, y / (mu + bend));
    return at / sqrt(max(dot(at, at), 1e-30));
}

/// The nearest candidate so far.
struct Nearest {
    square: f32,
    offset: vec3<f32>,
}

/// Takes a candidate into account: `start` runs from it to the point.
fn see(best: Nearest, there: bool, start: vec3<f32>) -> Nearest {
    let square = dot(start, start);
    if (there && square < best.square) {
        return Nearest(square, start);
    }
    return best;
}

/// From the nearest point of the body to a point that has passed several of its surfaces [m]; z from the strip.
fn outside_offset(radius: f32, back: f32, point: vec3<f32>, rho: f32, over_flat: f32) -> vec3<f32> {
    var best = Nearest(1e30, vec3<f32>(0.0, 0.0, 1.0));
    // Inwards to the wall, then along it or across the strip or the back.
    let shrink = select(1.0, radius / select(1.0, rho, radius < rho), radius < rho);
    let wall = vec3<f32>(point.xy * shrink, point.z);
    let height = max(min(point.z, -recess(wall)), back);
    best = see(best, true, point - vec3<f32>(wall.xy, height));
    // The edge between strip and flat, with its corner.
    best = see(best, true, point - vec3<f32>(min(point.x, scene.chisel_corner), scene.chisel_half, 0.0));
    // The flat.
    let down = over_flat * vec2<f32>(scene.chisel_sine, scene.chisel_cosine);
    let foot = point.y - down.x;
    let on_flat = scene.chisel_half <= foot && squared(point.x) + squared(foot) <= squared(radius);
    best = see(best, on_flat, vec3<f32>(0.0, down));
    // The edge between flat and wall.
    let rim = radius * nearest_on_ellipse(radius, point);
    let drop = (rim.y - scene.chisel_half) * scene.chisel_slope;
    best = see(best, scene.chisel_half <= rim.y, point - vec3<f32>(rim, -drop));
    return best.offset;
}

/// Gap of a point given in the body's frame [m].
fn chisel_gap(point: vec3<f32>) -> Gap {
    let radius = scene.profile[1].x;
    let front = scene.profile[1].y;
    let back = scene.profile[2].y;
    // z from the strip.
    let at = vec3<f32>(abs(point.xy), point.z - front);
    let rho = axis_distance(point);
    let on_axis = rho <= 1e-30;
    let safe = select(rho, 1.0, on_axis);
    let over_flat = (at.y - scene.chisel_half) * scene.chisel_sine + at.z * scene.chisel_cosine;
    let heights = array<f32, 4>(at.z, over_flat, rho - radius, back - point.z);
    let normals = array<vec3<f32>, 4>(
        vec3<f32>(0.0, 0.0, 1.0),
        vec3<f32>(0.0, scene.chisel_sine, scene.chisel_cosine),
        vec3<f32>(select(at.x / safe, 1.0, on_axis), at.y / safe, 0.0),
        vec3<f32>(0.0, 0.0, -1.0));
    // The two largest heights over the surfaces.
    var deepest = -1e30;
    var second = -1e30;
    var normal = vec3<f32>(0.0, 0.0, 1.0);
    for (var i = 0u; i < 4u; i++) {
        second = max(second, min(deepest, heights[i]));
        if (deepest < heights[i]) {
            deepest = heights[i];
            normal = normals[i];
        }
    }
    var distance = deepest;
    if (0.0 < second) {
        let offset = outside_offset(radius, back - front, at, rho, over_flat);
        distance = sqrt(dot(offset, offset));
        if (RESOLVED < distance) {
            normal = offset / distance;
        }
    }
    let turned = select(normal.xy, -normal.xy, point.xy < vec2<f32>(0.0));
    return Gap(distance - scene.profile_radius, vec3<f32>(turned, normal.z));
}
