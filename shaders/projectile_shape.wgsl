// projectile_shape: gap and outward normal near an analytic body, chisel noses included.
// Twin: src/physics/projectile_shape.rs

struct Gap {
    /// Negative inside [m].
    distance: f32,
    /// Body frame.
    normal: vec3<f32>,
}

/// Distance of a point from the body's axis [m] (from its midplane for a bar).
fn axis_distance(point: vec3<f32>) -> f32 {
    return select(sqrt(squared(point.x) + squared(point.y)), abs(point.x), scene.body_bar != 0u);
}

/// One side of the profile as a point sees it.
struct Side {
    /// From the nearest point of the side to the point [m].
    away: vec2<f32>,
    /// Outward normal there.
    normal: vec2<f32>,
    /// Whether that is no end of the side.
    beside: bool,
    /// Height over the side and what it goes on to beyond its ends [m].
    height: f32,
}

/// Nearer to a corner than this the direction to it is noise [m].
const RESOLVED: f32 = 1e-9;

/// A straight side: `start` and `edge` run from its beginning to the point and to its end.
fn straight_side(normal: vec2<f32>, edge: vec2<f32>, start: vec2<f32>) -> Side {
    let length = max(dot(edge, edge), 1e-30);
    let along = min(max(dot(start, edge) / length, 0.0), 1.0);
    return Side(start - along * edge, normal, 0.0 < along && along < 1.0, dot(start, normal));
}

/// A side that is an arc and begins with normal `normal`.
fn arc_side(normal: vec2<f32>, edge: vec2<f32>, start: vec2<f32>) -> Side {
    let arc = scene.profile_arc;
    // From the arc's centre to the point and to the arc's end.
    let centre = start + arc * normal;
    let end = edge + arc * normal;
    let size = max(sqrt(dot(centre, centre)), 1e-30);
    let out = centre / size;
    // |centre| - arc by its square: an arc is longer than the body, and its radius would drown the gap in rounding.
    let past = 2.0 * arc * dot(normal, start) + dot(start, start);
    let rise = past / (size + arc);
    let begun = normal.x * centre.y - normal.y * centre.x < 0.0;
    let ended = end.x * centre.y - end.y * centre.x < 0.0;
    let away = select(start, select(out * rise, start - edge, ended), begun);
    // Below its centre the arc goes on as the wall that it is tangent to.
    let wall = centre.y < 0.0;
    return Side(away, select(out, vec2<f32>(1.0, 0.0), wall), begun && !ended, select(rise, start.x - edge.x, wall));
}

/// Gap of a point given in the body's frame [m]: x, y across the axis, z along it from the tip of the nose.
fn surface_distance(point: vec3<f32>) -> Gap {
    // What has a round rim is no chisel.
    if (!EDGES && scene.chisel != 0u) { return chisel_gap(point); }
    let rho = axis_distance(point);
    let s = point.z;
    var best = 1e30;
    var normal = vec2<f32>(0.0, 1.0);
    var offset = vec2<f32>(0.0);
    var beside = false;
    var deepest = -1e30;
    var deepest_normal = vec2<f32>(0.0, 1.0);
    let sides = max(scene.profile_count, 2u) - 1u;
    for (var i = 0u; i < sides; i++) {
        let a = scene.profile[i];
        let b = scene.profile[min(i + 1u, scene.profile_count - 1u)];
        let edge = b.xy - a.xy;
        let start = vec2<f32>(rho, s) - a.xy;
        var side = straight_side(a.zw, edge, start);
        if (i == 0u && 0.0 < scene.profile_arc) { side = arc_side(a.zw, edge, start); }
        let square = dot(side.away, side.away);
        if (square < best) {
            best = square;
            normal = side.normal;
            offset = side.away;
            beside = side.beside;
        }
        let height = side.height;
        if (deepest < height) {
            deepest = height;
            deepest_normal = side.normal;
        }
    }
    let inside = scene.profile_count > 1u && deepest <= 0.0;
    let distance = sqrt(best);
    // Near the surface the direction to it is noise: beside a side that side's own normal holds.
    let resolved = !beside && RESOLVED < distance;
    let outside = select(normal, offset / select(1.0, distance, resolved), resolved);
    let n = select(outside, deepest_normal, inside);
    let signed = select(distance, deepest, inside);
    // On the axis no direction across it is nearer than another: the normal lies along it.
    let on_axis = rho <= 1e-30;
    let spread = select(n.x / select(rho, 1.0, on_axis), 0.0, on_axis);
    let ahead = select(1.0, -1.0, n.y < 0.0);
    let y = select(spread * point.y, 0.0, scene.body_bar != 0u);
    return Gap(signed - scene.profile_radius, vec3<f32>(spread * point.x, y, select(n.y, ahead, on_axis)));
}

/// The gap that contact acts on: the surface's, except behind the rim of a flat or chisel nose.
fn contact_distance(point: vec3<f32>) -> Gap {
    var g = surface_distance(point);
    let below = scene.profile[1].y - recess(point) - point.z;
    if (scene.profile_flat != 0u && 0.0 < below && below <= scene.rim_depth) {
        g.distance = select(1e30, g.distance, g.distance < 0.0);
        g.normal = nose_face(point);
    }
    return g;
}

/// Newton steps for the nearest point of the ellipse in which a flat meets the wall.
const ELLIPSE_STEPS: u32 = 5u;

/// Depth of the nose behind its foremost plane beside this point, along the axis [m]: 0 but for a chisel.
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
    if (there && square < best.square) { return Nearest(square, start); }
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
        if (RESOLVED < distance) { normal = offset / distance; }
    }
    let turned = select(normal.xy, -normal.xy, point.xy < vec2<f32>(0.0));
    return Gap(distance - scene.profile_radius, vec3<f32>(turned, normal.z));
}
