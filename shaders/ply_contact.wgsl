// ply_contact: the nodes of a ply in the axes of the pack, where a node stands over a cell of the neighbouring ply, and the impulse between
// them. Needs `nodes`.
// Twin: src/physics/ply_contact.rs, `PlyView` of src/solver/contact/ply_search.rs

/// No such ply.
const NO_PLY: u32 = 0xffffffffu;

/// The ply in front (0) or behind (1).
fn neighbour(ply: u32, side: u32) -> u32 {
    if (side == 0u) { return ply - 1u; } // of the first: NO_PLY
    return select(NO_PLY, ply + 1u, ply + 1u < scene.plies);
}

fn ply_velocity(ply: u32, node: u32) -> vec3<f32> { return to_pack(ply, node_vector(3u, node)); }

/// Position at the end of the step [m].
fn ply_position(ply: u32, place: vec2<u32>) -> vec3<f32> {
    return to_pack(ply, reference(ply, place) + node_vector(0u, node_at(ply, place)));
}

/// 1/mass along a direction of the pack [1/kg], in the whole scene: mirror planes hold no node in a single contact, only with
/// its image.
fn inverse_along(ply: u32, place: vec2<u32>, along: vec3<f32>) -> f32 {
    var inverse = inverse_mass(ply, place);
    let across = cut_across(ply, place);
    if (any(across)) {
        let whole = inverse.z * part_of(ply, place);
        inverse = vec3<f32>(select(vec2<f32>(0.0), vec2<f32>(whole), across | (inverse.xy > vec2<f32>(0.0))), whole);
    }
    let own = to_ply(ply, along);
    let mixed = dot(own * own, inverse);
    return select(mixed, inverse.x, inverse.x == inverse.y && inverse.y == inverse.z);
}

/// The mirror planes that a node lies on: by coordinate of a neighbour's cells, 1 or 2 for the one across x or y of the pack.
fn planes_at(ply: u32, place: vec2<u32>, other: u32) -> vec2<u32> {
    if (scene.mirror == 0u) { return vec2<u32>(0u); }
    let near = abs(to_pack(ply, reference(ply, place)).xy) < vec2<f32>(0.25 * min(plies[ply].length.x, plies[ply].length.y));
    let planes = vec2<u32>(scene.mirror) & vec2<u32>(1u, 2u) & select(vec2<u32>(0u), vec2<u32>(3u), near);
    return select(planes, planes.yx, abs(plies[other].sine) > 0.5);
}

/// Nodes at the corners of a cell (row, column) of a ply, counter-clockwise.
fn cell_corners(ply: u32, cell: vec2<u32>) -> vec4<u32> { return corners(element_at(ply, cell)); }

/// Most of a penetration that is driven out in a step.
const POSITION_CORRECTION: f32 = 0.05;
/// Time in which a penetration is driven out, were it left alone [s].
const RECOVERY_TIME: f32 = 3.5e-6;
/// Fraction of what is deeper than `DEEP` that is driven out besides.
const DEEP_RECOVERY: f32 = 0.15;
/// Over the thickness.
const DEEP: f32 = 0.5;
/// Largest speed at which a node is driven out [m/s].
const RECOVERY_SPEED: f32 = 30.0;
/// Multiple of that speed more for every thickness beyond `NEAR_MIDDLE`.
const DEEP_SPEED: f32 = 30.0;
/// A node is about to pass the mid-plane here; over the thickness.
const NEAR_MIDDLE: f32 = 0.8;
/// A node has passed the mid-plane here; over the thickness.
const PASSED: f32 = 1.2;
/// Largest speed at which such a node is driven back [m/s].
const PASSED_SPEED: f32 = 6.0;
/// Depth that is left, over the thickness.
const SLOP: f32 = 1e-4;
/// Steps over neighbouring cells a node may take in one time step.
const WALK: u32 = 4u;
/// Beyond the edge of a cell at which a node walks on to the next, over the cell's length.
const EDGE: f32 = 1e-6;
/// Beyond the edge of a ply up to which its outermost cells carry a node, over the cell's length.
const SEGMENT_EXTENSION: f32 = 0.25;
/// Depth up to which a node that was outside a step ago may be found inside, over the thickness: what appears deeper has come
/// through a hole, past an edge or round a fold, and not through the cell.
const MAX_INITIAL_PENETRATION: f32 = 0.25;
/// Least area of a cell, over its area at rest.
const MIN_AREA_RATIO: f32 = 0.05;

/// Beyond the edge of a cell up to which a node that is apart from it need not walk on, over the cell's length.
const EDGE_TOLERANCE: f32 = 0.05;

/// Most that the corners of a cell may differ along z for the same, over its length at rest.
const FLATNESS_TOLERANCE: f32 = 0.05;

/// A node's contact with one of its neighbouring plies.
struct Contact {
    /// Unit vector along which the node is driven out; in w the least velocity along it [m/s].
    normal_impulse: vec4<f32>,
    /// Coordinates within the cell, ±½ at its edges; speed at which the node is moved out [m/s]; 1 where there is contact.
    foot: vec4<f32>,
}

/// Corners of a cell, counter-clockwise [m].
struct Cell {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    d: vec3<f32>,
}

struct ClosestPoint {
    place: vec2<f32>,
    /// Towards the rear of the pack.
    normal: vec3<f32>,
    /// Height of the point over the cell along the normal [m].
    height: f32,
    /// Whether the cell is a surface.
    sound: bool,
}

/// Twice the area of the triangle over a side, seen along z.
fn beside(a: vec3<f32>, b: vec3<f32>, point: vec3<f32>) -> f32 {
    return (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x);
}

/// Whether a point above a cell, as seen along z, is further from it than `touching` [m], and the cell is almost flat.
/// `direction`: 1 for a point behind the cell, −1 for one in front.
fn is_apart(k: Cell, point: vec3<f32>, direction: f32, touching: f32, area: f32) -> bool {
    let heights = direction * vec4<f32>(k.a.z, k.b.z, k.c.z, k.d.z);
    let low = min(min(heights.x, heights.y), min(heights.z, heights.w));
    let high = max(max(heights.x, heights.y), max(heights.z, heights.w));
    let least = min(
        min(beside(k.a, k.b, point), beside(k.b, k.c, point)), min(beside(k.c, k.d, point), beside(k.d, k.a, point)));
    let flat = squared(high - low) <= FLATNESS_TOLERANCE * FLATNESS_TOLERANCE * area;
    return flat && direction * point.z - high - touching >= high - low && least >= -EDGE_TOLERANCE * area;
}

/// A bilinear cell.
struct Surface {
    centre: vec3<f32>,
    along: vec3<f32>,
    across: vec3<f32>,
    twist: vec3<f32>,
    /// Across the cell at its centre, as long as its area; and that squared.
    normal: vec3<f32>,
    square: f32,
}

fn surface_of(k: Cell) -> Surface {
    let along = ((k.b - k.a) + (k.c - k.d)) * 0.5;
    let across = ((k.d - k.a) + (k.c - k.b)) * 0.5;
    let normal = cross(along, across);
    let centre = ((k.a + k.c) + (k.b + k.d)) * 0.25;
    return Surface(centre, along, across, (k.a - k.b) + (k.c - k.d), normal, dot(normal, normal));
}

/// Coordinates within the cell, were it flat, of what lies `arm` [m] from its centre. `safe`: its area squared, not zero.
fn place_of(s: Surface, arm: vec3<f32>, safe: f32) -> vec2<f32> {
    let aa = dot(s.along, s.along);
    let ac = dot(s.along, s.across);
    let cc = dot(s.across, s.across);
    let p = vec2<f32>(dot(arm, s.along), dot(arm, s.across));
    return vec2<f32>(cc * p.x - ac * p.y, aa * p.y - ac * p.x) / safe;
}

/// Arm from the centre, as seen by a flat cell. The twist of the cell is small: one correction.
fn untwisted(s: Surface, arm: vec3<f32>, place: vec2<f32>) -> vec3<f32> { return arm - s.twist * (place.x * place.y); }

/// The foot of a point on the bilinear cell with these corners. `area`: of the cell at rest [m²].
fn closest_on(k: Cell, point: vec3<f32>, area: f32) -> ClosestPoint {
    let s = surface_of(k);
    let sound = s.square >= squared(MIN_AREA_RATIO * area);
    let safe = select(1.0, s.square, sound);
    let arm = point - s.centre;
    let mended = untwisted(s, arm, place_of(s, arm, safe));
    let unit = s.normal / sqrt(safe);
    return ClosestPoint(place_of(s, mended, safe), unit, dot(mended, unit), sound);
}

/// The foot of a point on mirror planes, which lies on them: along the normal less what of it points across them.
/// `edge`: by coordinate of the cell, 1 or 2 where there is a plane across x or y, on one of the cell's edges then.
fn closest_on_planes(k: Cell, point: vec3<f32>, area: f32, edge: vec2<u32>) -> ClosestPoint {
    let s = surface_of(k);
    let planes = vec3<bool>(any(edge == vec2<u32>(1u)), any(edge == vec2<u32>(2u)), false);
    let left = select(s.normal, vec3<f32>(0.0), planes);
    let size = dot(left, left);
    let sound = s.square >= squared(MIN_AREA_RATIO * area) && size >= squared(MIN_AREA_RATIO * area);
    let safe = select(1.0, s.square, sound);
    let push = left / sqrt(select(1.0, size, sound));
    let slope = select(1.0, dot(push, s.normal), sound);
    let arm = point - s.centre;
    var place = vec2<f32>(0.0);
    var height = 0.0;
    for (var i = 0u; i < 2u; i++) {
        let mended = untwisted(s, arm, place);
        height = dot(mended, s.normal) / slope;
        place = place_of(s, mended - push * height, safe);
        place = select(place, select(vec2<f32>(-0.5), vec2<f32>(0.5), place > vec2<f32>(0.0)), edge != vec2<u32>(0u));
    }
    return ClosestPoint(place, push, height, sound);
}

/// Weights of the corners at a place in a cell; they add up to 1.
fn weights_at(place: vec2<f32>) -> vec4<f32> {
    let x = min(max(place.x, -0.5), 0.5);
    let y = min(max(place.y, -0.5), 0.5);
    return vec4<f32>((0.5 - x) * (0.5 - y), (0.5 + x) * (0.5 - y), (0.5 + x) * (0.5 + y), (0.5 - x) * (0.5 + y));
}

/// The cell a foot lies towards along one direction.
fn step_over(index: u32, x: f32, count: u32) -> u32 {
    return select(select(index, max(index, 1u) - 1u, x < -0.5 - EDGE), min(index + 1u, count - 1u), x > 0.5 + EDGE);
}

/// Range along one direction in which a cell carries a node: beyond the ply's edge a little more.
fn room(outermost: bool) -> f32 { return 0.5 + select(EDGE, SEGMENT_EXTENSION, outermost); }

/// Whether a cell (row, column) of a ply of `rows` and `columns` carries a node with this foot. At sides that mirror
/// planes `cut` (1 left, 2 right, 4 bottom, 8 top) the ply goes on.
fn is_over(place: vec2<f32>, cell: vec2<u32>, rows: u32, columns: u32, cut: u32) -> bool {
    let ends = (vec4<u32>(cut) & vec4<u32>(1u, 2u, 4u, 8u)) == vec4<u32>(0u);
    let along = -room(cell.y == 0u && ends.x) <= place.x && place.x <= room(cell.y + 1u == columns && ends.y);
    return along && -room(cell.x == 0u && ends.z) <= place.y && place.y <= room(cell.x + 1u == rows && ends.w);
}

/// The place on an edge of a cell that is nearest to a point, and from there to the point [m].
struct EdgePlace {
    place: vec2<f32>,
    arm: vec3<f32>,
}

/// The place nearest to a point on the line between two corners.
fn along_edge(first: vec3<f32>, last: vec3<f32>, point: vec3<f32>) -> vec4<f32> {
    let edge = last - first;
    let part = min(max(dot(point - first, edge) / max(dot(edge, edge), 1e-30), 0.0), 1.0);
    return vec4<f32>(point - (first + edge * part), part - 0.5);
}

/// The place on the edges of a cell that is nearest to a point beyond them. `foot`: of the point.
fn on_edge(k: Cell, point: vec3<f32>, foot: vec2<f32>) -> EdgePlace {
    let x = min(max(foot.x, -0.5), 0.5);
    let y = min(max(foot.y, -0.5), 0.5);
    let across = along_edge(k.a + (k.b - k.a) * (x + 0.5), k.d + (k.c - k.d) * (x + 0.5), point);
    let along = along_edge(k.a + (k.d - k.a) * (y + 0.5), k.b + (k.c - k.b) * (y + 0.5), point);
    let nearer = dot(along.xyz, along.xyz) < dot(across.xyz, across.xyz);
    if (abs(foot.y) > 0.5 && (abs(foot.x) <= 0.5 || nearer)) { return EdgePlace(vec2<f32>(along.w, y), along.xyz); }
    return EdgePlace(vec2<f32>(x, across.w), across.xyz);
}

/// Least velocity along the push with which a node may leave the step [m/s].
fn ply_closing_limit(gap: f32) -> f32 { return -max(gap, 0.0) / scene.dt; }

/// Speed at which a node is moved out of a surface, beyond what its own velocity does [m/s]; no part of its velocity.
fn recovery_speed(gap: f32, thickness: f32, along: f32) -> f32 {
    let depth = -gap - SLOP * thickness;
    let deep = max(depth - DEEP * thickness, 0.0);
    let rising = RECOVERY_SPEED * (1.0 + DEEP_SPEED * max(depth / thickness - NEAR_MIDDLE, 0.0));
    let fastest = select(PASSED_SPEED, rising, depth < PASSED * thickness);
    let speed = depth * min(POSITION_CORRECTION / scene.dt, 1.0 / RECOVERY_TIME) + DEEP_RECOVERY * deep / scene.dt;
    return max(min(speed, fastest) - max(along, 0.0), 0.0);
}

/// Impulse of one contact on its node [N·s].
struct Impulse {
    along: f32,
    friction_impulse: vec3<f32>,
}

fn impulse_between(velocity: vec3<f32>, push: vec3<f32>, limit: f32, kappa: f32) -> Impulse {
    let along = dot(velocity, push);
    let normal = max(kappa * (limit - along), 0.0);
    let slide = velocity - push * along;
    let stick = slide * -kappa;
    let most = scene.ply_friction * normal;
    let size = sqrt(dot(stick, stick));
    return Impulse(normal, select(stick, stick * (most / max(size, 1e-30)), size > most));
}
