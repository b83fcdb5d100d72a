// projectile_touches: touches of the projectile, of one ply where that is searched, of all where they meet: how to go through them, and how
// impulses pass between edges and nodes. Needs `points`, `touches`, `motion` and `cells`.
// Twin: src/solver/contact/projectile_contact.rs

/// A node near the body during one step.
struct Point {
    /// Inverse mass by direction, 0 where held [1/kg].
    inverse: vec4<f32>,
    /// Velocity relative to the body's material before contact [m/s], and the mass [kg].
    relative: vec4<f32>,
    /// In the body's frame, without the fabric in front of it [m], and the thickness of that [m].
    pressed: vec4<f32>,
    /// Impulse of the points of the rim on its edges [N·s], and the sum of their weights.
    edge_impulse: vec4<f32>,
    /// Relative velocity before the step, where anything may have pushed [m/s].
    before: vec4<f32>,
    /// Relative velocity with all impulses found so far [m/s].
    slip: vec4<f32>,
    node: u32,
    // Where the rim is sampled.
    /// Points of the rim on the edges to the next node of the row, then of the column: the first, and how many of each.
    first: u32,
    to_right: u32,
    to_above: u32,
    /// The points before this one in its row, in its column, where a point of the rim lies between; or `NONE`.
    left: u32,
    below: u32,
    /// Whether a point of the rim lies on an edge that ends here: 1 or 0.
    constrained: u32,
    /// The first of the points that it is tied to by points of the rim, over any number of edges.
    block: u32,
}

/// Point that the body may touch: a node, or a point of the rim on an edge. Those of the nodes come first.
struct Touch {
    /// Outward normal, and the gap [m].
    normal: vec4<f32>,
    /// From the centre of mass [m], and the mass that friction meets [kg].
    arm: vec4<f32>,
    /// Friction impulse and normal impulse [N·s].
    friction_impulse: vec4<f32>,
    /// L⁻¹ [G | n·v − target]: impulse, then turn and excess [m/s].
    moved: vec4<f32>,
    turned: vec4<f32>,
    /// The nodes at the ends of the edge, by their points; a node's own is both.
    ends: vec2<u32>,
    /// Share of the second node in it [-]; the first has the rest.
    weight: f32,
    /// Coulomb coefficient.
    friction: f32,
    state: u32,
    // Of those that push.
    /// On the diagonal of K [1/kg], of L.
    diagonal: f32,
    root: f32,
    /// On the way to the normal impulse.
    normal_impulse: f32,
    /// Place among those that share nodes, or `NONE`; the first of its block; the first that its row has an entry for.
    member: u32,
    begin: u32,
    entry: u32,
    /// First entry of its row of the matrix.
    row: u32,
}

// States of a point.
const AWAY: u32 = 0u;
const NEAR: u32 = 1u;
const PUSHING: u32 = 2u;

/// Touches that a workgroup goes through.
struct Extent {
    /// The first, and one past the last, of the points of nodes.
    first: u32,
    past: u32,
    /// The first ply.
    ply: u32,
    /// Number of edge constraints.
    constraints: u32,
}

var<workgroup> extent: Extent;
/// Edge constraints of the plies up to and with each, from the first ply of `extent` on.
var<workgroup> ends: array<u32, 64>;

/// Where an invocation is on its way through them.
struct Cursor {
    /// Number of a touch in their order.
    number: u32,
    /// Ply of an edge constraint, and how many there are on the plies before it.
    ply: u32,
    before: u32,
}

var<private> cursor: Cursor;

/// Place in `touches` of an edge constraint: room for those of every ply is behind the nodes.
fn constraint_touch(ply: u32, number: u32) -> u32 { return scene.points + ply * scene.constraints + number; }

/// The first touch of an invocation, or `NONE`: nodes first, then edge constraints, ply by ply.
fn first_touch(local: u32) -> u32 {
    cursor = Cursor(local, extent.ply, 0u);
    return touch_at_cursor();
}

/// Its next one.
fn next_touch() -> u32 {
    cursor.number += WIDTH;
    return touch_at_cursor();
}

/// That at its place.
fn touch_at_cursor() -> u32 {
    let nodes = extent.past - extent.first;
    if (cursor.number < nodes) { return extent.first + cursor.number; }
    let at = cursor.number - nodes;
    if (at >= extent.constraints) { return NONE; }
    while (at >= ends[cursor.ply]) {
        cursor.before = ends[cursor.ply];
        cursor.ply += 1u;
    }
    return constraint_touch(cursor.ply, at - cursor.before);
}

/// Sums of the edge contacts at a node.
struct Through {
    /// Their impulses by weight [N·s].
    impulse: vec3<f32>,
    /// Their weights by what is there of them.
    weight: f32,
}

/// The part of the node of a point that is there.
fn part_at(p: u32) -> f32 {
    let node = points[point_number(p)].node;
    return part_of(node_ply(node), node_place(node));
}

/// The part of a touch that is there: a half on an edge in a mirror plane.
fn part_of_touch(t: u32) -> f32 {
    let ends = touches[touch_number(t)].ends;
    return max(part_at(ends.x), part_at(ends.y));
}

/// Whether a point of the rim lies on an edge that ends at the node of a point.
fn is_constrained(p: u32) -> bool { return EDGES && points[point_number(p)].constrained != 0u; }

fn through_edges(p: u32) -> Through {
    var sum: Through;
    // The edges that begin here, the one from the left, the one from below.
    for (var edge = 0u; edge < 3u; edge++) {
        var start = p;
        if (edge == 1u) { start = points[point_number(p)].left; }
        if (edge == 2u) { start = points[point_number(p)].below; }
        if (start == NONE) { continue; }
        let right = points[point_number(start)].to_right;
        let first = points[point_number(start)].first;
        let past = first + right + select(points[point_number(start)].to_above, 0u, edge == 1u);
        for (var t = first + select(0u, right, edge == 2u); t < past; t++) {
            let second = touches[touch_number(t)].weight;
            let weight = select(second, 1.0 - second, edge == 0u);
            let drag = touches[touch_number(t)].friction_impulse;
            sum.impulse += weight * (touches[touch_number(t)].normal.xyz * drag.w + drag.xyz);
            sum.weight += weight * part_of_touch(t);
        }
    }
    return sum;
}

/// Propagates impulses from the edges to the nodes, and how these move.
fn propagate(local: u32) {
    storageBarrier();
    let linear = vec3<f32>(motion[0], motion[1], motion[2]);
    let angular = vec3<f32>(motion[3], motion[4], motion[5]);
    for (var p = extent.first + local; p < extent.past; p += WIDTH) {
        let constrained = is_constrained(p);
        if (constrained || touches[touch_number(p)].state != AWAY) {
            var through: Through;
            if (constrained) { through = through_edges(p); }
            let drag = touches[touch_number(p)].friction_impulse;
            let relative = points[point_number(p)].relative.xyz;
            let inverse = points[point_number(p)].inverse.xyz;
            let impulse = touches[touch_number(p)].normal.xyz * drag.w + drag.xyz + through.impulse;
            points[point_number(p)].edge_impulse = vec4<f32>(through.impulse, through.weight);
            let given = (relative + inverse * impulse) - linear - cross(angular, touches[touch_number(p)].arm.xyz);
            points[point_number(p)].slip = vec4<f32>(given, 0.0);
        }
    }
    storageBarrier();
}

/// Gives a point of the rim its share of the masses of its nodes, by its weight among the points there: what friction meets.
fn share_mass(t: u32) {
    let ends = touches[touch_number(t)].ends;
    let second = touches[touch_number(t)].weight;
    // In the whole scene: a touch has images at a node on a mirror plane.
    let shares = vec2<f32>((1.0 - second) * points[point_number(ends.x)].edge_impulse.w, second * points[point_number(ends.y)].edge_impulse.w) / part_of_touch(t);
    let inverse = shares.x * points[point_number(ends.x)].inverse.xyz + shares.y * points[point_number(ends.y)].inverse.xyz;
    let unheld = shares.x / points[point_number(ends.x)].relative.w + shares.y / points[point_number(ends.y)].relative.w;
    let most = max(max(inverse.x, inverse.y), inverse.z);
    // Between two held nodes it has a mass like they have, though nothing moves it.
    touches[touch_number(t)].arm.w = 1.0 / select(unheld, most, most > 0.0);
}

/// Velocity relative to the body's material with all impulses found so far [m/s].
fn slip_of(t: u32) -> vec3<f32> {
    let ends = touches[touch_number(t)].ends;
    return mix(points[point_number(ends.x)].slip.xyz, points[point_number(ends.y)].slip.xyz, touches[touch_number(t)].weight);
}

