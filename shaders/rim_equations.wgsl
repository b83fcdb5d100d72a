// rim_equations: the normal impulses of touches that share nodes: K = N M⁻¹ Nᵀ of those that push, its factor L and both substitutions.
// Needs `points`, `touches`, their `extent`, `members` and `matrix`.
// Twin: src/kernels/projectile_rim.rs

/// What is added to the diagonal of K, over itself in the whole scene: two points that ask the same of a node share its impulse.
const SHARED: f32 = 1e-3;
/// Least pivot, over the diagonal of K.
const FLOOR: f32 = 1e-7;

/// Members of each ply: the first, and one past the last.
var<workgroup> begins: array<atomic<u32>, 64>;
var<workgroup> stops: array<atomic<u32>, 64>;
/// Most members of any ply.
var<workgroup> longest: atomic<u32>;

/// Lists the touches that push and share nodes: a node's own, then those of the edges that begin there. Gives their number.
fn gather_members(local: u32) -> u32 {
    atomicStore(&begins[local], NONE);
    atomicStore(&stops[local], 0u);
    if (local == 0u) {
        atomicStore(&longest, 0u);
    }
    let count = workgroupUniformLoad(&extent).x;
    var total = 0u;
    for (var base = 0u; base < count; base += WIDTH) {
        let p = base + local;
        var own = 0u;
        var first = 0u;
        var past = 0u;
        var itself = false;
        if (p < count) {
            first = points[point_number(p)].first;
            past = first + points[point_number(p)].to_right + points[point_number(p)].to_above;
            itself = points[point_number(p)].constrained != 0u && touches[touch_number(p)].state == PUSHING;
            own = u32(itself);
            for (var t = first; t < past; t++) {
                own += u32(touches[touch_number(t)].state == PUSHING);
            }
        }
        var at = total + sum_up_to(own, local) - own;
        if (own > 0u) {
            let ply = node_ply(points[point_number(p)].node);
            atomicMin(&begins[ply], at);
            atomicMax(&stops[ply], at + own);
            if (itself) {
                members[member_number(at)] = p;
                touches[touch_number(p)].member = at;
                at += 1u;
            }
            for (var t = first; t < past; t++) {
                if (touches[touch_number(t)].state == PUSHING) {
                    members[member_number(at)] = t;
                    touches[touch_number(t)].member = at;
                    at += 1u;
                }
            }
        }
        total += scan[WIDTH - 1u];
        workgroupBarrier();
    }
    let first = atomicLoad(&begins[local]);
    if (first != NONE) {
        atomicMax(&longest, atomicLoad(&stops[local]) - first);
    }
    storageBarrier();
    workgroupBarrier();
    return total;
}

/// An entry of K [1/kg].
fn coupling(a: u32, b: u32) -> f32 {
    let of_a = touches[touch_number(a)].ends;
    let of_b = touches[touch_number(b)].ends;
    let weights_a = vec2<f32>(1.0 - touches[touch_number(a)].weight, touches[touch_number(a)].weight);
    let weights_b = vec2<f32>(1.0 - touches[touch_number(b)].weight, touches[touch_number(b)].weight);
    let first = weights_a.x * (weights_b.x * f32(of_a.x == of_b.x) + weights_b.y * f32(of_a.x == of_b.y));
    let second = weights_a.y * (weights_b.x * f32(of_a.y == of_b.x) + weights_b.y * f32(of_a.y == of_b.y));
    if (first + second == 0.0) {
        return 0.0;
    }
    let inverse = first * points[point_number(of_a.x)].inverse.xyz + second * points[point_number(of_a.y)].inverse.xyz;
    return dot(touches[touch_number(a)].normal.xyz, inverse * touches[touch_number(b)].normal.xyz);
}

/// What is added to the entry of a touch on the diagonal of K [1/kg]. A node on a mirror plane adds as much as it would in the whole
/// scene, where the images of the points on its edges push it too.
fn compliance(t: u32) -> f32 {
    let ends = touches[touch_number(t)].ends;
    let normal = touches[touch_number(t)].normal.xyz;
    let weights = vec2<f32>(1.0 - touches[touch_number(t)].weight, touches[touch_number(t)].weight);
    let parts = vec2<f32>(part_at(ends.x), part_at(ends.y)) / part_of_touch(t);
    let shares = weights * weights * parts;
    let inverse = shares.x * points[point_number(ends.x)].inverse.xyz + shares.y * points[point_number(ends.y)].inverse.xyz;
    return SHARED * dot(normal, inverse * normal);
}

/// What a touch that pushes adds to the equations: its row of K, direction and excess. One that shares no node has a row to itself.
fn fill(t: u32) {
    let member = touches[touch_number(t)].member;
    let alone = member == NONE;
    var begin = 0u;
    var own = 0u;
    if (!alone) {
        let ply = node_ply(points[point_number(touches[touch_number(t)].ends.x)].node);
        begin = atomicLoad(&begins[ply]);
        own = member - begin;
        // Every ply has a triangle of its own, with room for as many as there may be.
        let most = 3u * scene.constraints;
        touches[touch_number(t)].begin = begin;
        touches[touch_number(t)].end = atomicLoad(&stops[ply]);
        touches[touch_number(t)].row = ply_number(ply) * (most * (most + 1u) / 2u) + own * (own + 1u) / 2u;
    }
    let row = touches[touch_number(t)].row;
    var diagonal = 0.0;
    for (var j = 0u; j <= own; j++) {
        var other = t;
        if (j < own) {
            other = members[member_number(begin + j)];
        }
        diagonal = coupling(t, other);
        if (j < own) {
            matrix[row + j] = diagonal;
        }
    }
    let normal = touches[touch_number(t)].normal;
    let arm = touches[touch_number(t)].arm;
    let ends = touches[touch_number(t)].ends;
    let pivot = 1.0 / inertia_along(diagonal, arm.w) + select(compliance(t), 0.0, alone);
    touches[touch_number(t)].pivot = pivot;
    touches[touch_number(t)].least = FLOOR * pivot;
    let g = direction_of(normal.xyz, arm.xyz);
    let free = mix(points[point_number(ends.x)].free.xyz, points[point_number(ends.y)].free.xyz, touches[touch_number(t)].weight);
    touches[touch_number(t)].moved = vec4<f32>(g[0], g[1], g[2], 0.0);
    touches[touch_number(t)].turned = vec4<f32>(g[3], g[4], g[5], dot(free, normal.xyz) - closing_limit(normal.w));
}

/// What a row of L has on its diagonal.
fn root_of(t: u32) -> f32 {
    return sqrt(max(touches[touch_number(t)].pivot, touches[touch_number(t)].least));
}

/// L of every ply in the place of its K, column by column, and the substitution that goes with it.
fn factor(count: u32, columns: u32, local: u32) {
    for (var k = 0u; k + 1u < columns; k++) {
        for (var m = local; m < count; m += WIDTH) {
            let t = members[member_number(m)];
            let begin = touches[touch_number(t)].begin;
            if (m - begin > k) {
                let row = touches[touch_number(t)].row;
                let above = members[member_number(begin + k)];
                let other = touches[touch_number(above)].row;
                var sum = matrix[row + k];
                for (var j = 0u; j < k; j++) {
                    sum -= matrix[row + j] * matrix[other + j];
                }
                let root = root_of(above);
                let entry = sum / root;
                matrix[row + k] = entry;
                touches[touch_number(t)].pivot -= entry * entry;
                touches[touch_number(t)].moved -= (entry / root) * touches[touch_number(above)].moved;
                touches[touch_number(t)].turned -= (entry / root) * touches[touch_number(above)].turned;
            }
        }
        storageBarrier();
    }
}

/// Normal impulses for the motion found: the substitution back.
fn push_back(count: u32, columns: u32, local: u32) {
    let linear = vec3<f32>(motion[0], motion[1], motion[2]);
    let angular = vec3<f32>(motion[3], motion[4], motion[5]) * scene.body_bounding_radius;
    for (var t = local; t < extent.y; t += WIDTH) {
        if (touches[touch_number(t)].state == PUSHING) {
            let turned = touches[touch_number(t)].turned;
            let along = dot(touches[touch_number(t)].moved.xyz, linear) + dot(turned.xyz, angular);
            touches[touch_number(t)].normal_impulse = (along - turned.w) / root_of(t);
        }
    }
    storageBarrier();
    for (var left = columns; left > 1u; left--) {
        let k = left - 1u;
        for (var m = local; m < count; m += WIDTH) {
            let t = members[member_number(m)];
            let begin = touches[touch_number(t)].begin;
            if (m < begin + k && begin + k < touches[touch_number(t)].end) {
                let below = members[member_number(begin + k)];
                let entry = matrix[touches[touch_number(below)].row + m - begin];
                touches[touch_number(t)].normal_impulse -= entry * touches[touch_number(below)].normal_impulse / root_of(below);
            }
        }
        storageBarrier();
    }
    for (var t = local; t < extent.y; t += WIDTH) {
        if (touches[touch_number(t)].state == PUSHING) {
            touches[touch_number(t)].friction_impulse.w = touches[touch_number(t)].normal_impulse / root_of(t);
        }
    }
}
