// projectile_rim: contact with a projectile the rim of whose face is sampled too, after `projectile_points`: kinematic, perfectly inelastic,
// with Coulomb friction, then the motion of the body. One workgroup. Touches that share nodes depend on each other: with K = N M⁻¹ Nᵀ of
// those that push, K p = G V′ + target − n·v takes the place of p = κ(…), ply by ply. With K = L Lᵀ the body's equations need L⁻¹G alone.
//   in/out  nodes    array<f32>    (6, N)       displacement [m], velocity [m/s]
//   in      forces   array<f32>    (9, E)       P1·Ly/2, P2·Lx/2, hourglass per corner [N]
//   in/out  status   array<u32>                 counters
//   in/out  bodies   array<Body>                the projectiles
//   in/out  points   array<Point>               nodes near it
//   in/out  touches  array<Touch>               how many, in the first; where it may touch
//   scratch members  array<u32>                 touches that push and share nodes, ply by ply
//   scratch matrix   array<f32>    (plies, …)   K, then L: lower triangles by rows [1/kg]
// Twin: src/kernels/projectile_rim.rs and src/kernels/projectile_contact.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> bodies: array<Body>;
@group(1) @binding(4) var<storage, read_write> points: array<Point>;
@group(1) @binding(5) var<storage, read_write> touches: array<Touch>;
@group(1) @binding(6) var<storage, read_write> members: array<u32>;
@group(1) @binding(7) var<storage, read_write> matrix: array<f32>;

/// What is added to the diagonal of K, over itself in the whole scene: two points that ask the same of a node share its impulse.
const SHARED: f32 = 1e-3;
/// Least pivot, over the diagonal of K.
const FLOOR: f32 = 1e-7;

/// Points, and touches.
var<workgroup> extent: vec2<u32>;
/// Members of each ply: the first, and one past the last.
var<workgroup> begins: array<atomic<u32>, 64>;
var<workgroup> stops: array<atomic<u32>, 64>;
/// Most members of any ply.
var<workgroup> longest: atomic<u32>;
var<workgroup> height: u32;

/// What the points of the rim on its edges add up to at a node.
struct Through {
    /// Their impulses and friction impulses by weight [N·s].
    impulse: vec3<f32>,
    friction_impulse: vec3<f32>,
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

fn through_edges(p: u32) -> Through {
    var sum: Through;
    // The edges that begin here, the one from the left, the one from below.
    for (var edge = 0u; edge < 3u; edge++) {
        var start = p;
        if (edge == 1u) { start = points[point_number(p)].left; }
        if (edge == 2u) { start = points[point_number(p)].below; }
        if (start == NONE) {
            continue;
        }
        let right = points[point_number(start)].to_right;
        let first = points[point_number(start)].first;
        let past = first + right + select(points[point_number(start)].to_above, 0u, edge == 1u);
        for (var t = first + select(0u, right, edge == 2u); t < past; t++) {
            let second = touches[touch_number(t)].weight;
            let weight = select(second, 1.0 - second, edge == 0u);
            let drag = touches[touch_number(t)].friction_impulse;
            sum.impulse += weight * (touches[touch_number(t)].normal.xyz * drag.w + drag.xyz);
            sum.friction_impulse += weight * drag.xyz;
            sum.weight += weight * part_of_touch(t);
        }
    }
    return sum;
}

/// Tells nodes what the rim gives them, and how they move.
fn propagate(local: u32) {
    storageBarrier();
    let linear = vec3<f32>(motion[0], motion[1], motion[2]);
    let angular = vec3<f32>(motion[3], motion[4], motion[5]);
    for (var p = local; p < extent.x; p += WIDTH) {
        let tied = points[point_number(p)].tied != 0u;
        if (tied || touches[touch_number(p)].state != AWAY) {
            var through: Through;
            if (tied) {
                through = through_edges(p);
            }
            let drag = touches[touch_number(p)].friction_impulse;
            let relative = points[point_number(p)].relative.xyz;
            let inverse = points[point_number(p)].inverse.xyz;
            let impulse = touches[touch_number(p)].normal.xyz * drag.w + drag.xyz + through.impulse;
            points[point_number(p)].edge_impulse = vec4<f32>(through.impulse, through.weight);
            points[point_number(p)].free = vec4<f32>(relative + inverse * (drag.xyz + through.friction_impulse), 0.0);
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
            itself = points[point_number(p)].tied != 0u && touches[touch_number(p)].state == PUSHING;
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
        let most = 3u * scene.ties;
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

/// One solve for the body's motion with what pushes attached, and the impulses.
fn common_velocity(local: u32) {
    let count = gather_members(local);
    for (var t = local; t < extent.y; t += WIDTH) {
        if (touches[touch_number(t)].state == PUSHING) {
            fill(t);
        }
    }
    if (local == 0u) {
        height = atomicLoad(&longest);
    }
    storageBarrier();
    let columns = workgroupUniformLoad(&height);
    factor(count, columns, local);
    var part: array<f32, 27>;
    for (var t = local; t < extent.y; t += WIDTH) {
        let drag = in_planes(touches[touch_number(t)].friction_impulse.xyz);
        let turn = about_planes(cross(touches[touch_number(t)].arm.xyz, touches[touch_number(t)].friction_impulse.xyz) / scene.body_bounding_radius);
        part[21] -= drag.x;
        part[22] -= drag.y;
        part[23] -= drag.z;
        part[24] -= turn.x;
        part[25] -= turn.y;
        part[26] -= turn.z;
        if (touches[touch_number(t)].state == PUSHING) {
            let weight = 1.0 / squared(root_of(t));
            let moved = touches[touch_number(t)].moved;
            let turned = touches[touch_number(t)].turned;
            let g = array<f32, 6>(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z);
            for (var i = 0u; i < 6u; i++) {
                part[21u + i] += weight * g[i] * turned.w;
                for (var j = 0u; j <= i; j++) {
                    part[i * (i + 1u) / 2u + j] += weight * g[i] * g[j];
                }
            }
        }
    }
    for (var i = 0u; i < 27u; i++) {
        sums[i * 65u + local] = part[i];
    }
    reduce(27u, local);
    if (local == 0u && scene.body_prescribed == 0u) {
        solve_motion();
    }
    workgroupBarrier();
    push_back(count, columns, local);
}

/// Ends the contact of what pulls, which is not dragged either, and lets push what would enter. True if anything changed.
fn change_set(joining: bool, local: u32) -> bool {
    let tolerance = ROUNDOFF_TOLERANCE * (body.velocity.w + 1e-3);
    var changed = false;
    for (var t = local; t < extent.y; t += WIDTH) {
        let state = touches[touch_number(t)].state;
        if (state == PUSHING && touches[touch_number(t)].friction_impulse.w < 0.0) {
            touches[touch_number(t)].state = NEAR;
            touches[touch_number(t)].friction_impulse = vec4<f32>(0.0);
            changed = true;
        } else if (state == NEAR && joining) {
            let normal = touches[touch_number(t)].normal;
            if (dot(slip_of(t), normal.xyz) < closing_limit(normal.w) - tolerance) {
                touches[touch_number(t)].state = PUSHING;
                changed = true;
            }
        }
    }
    return vote(changed, local);
}

/// Friction impulses that stop the sliding, cut to μ times the normal impulse. True if any changed.
fn update_friction(local: u32) -> bool {
    var changed = false;
    for (var t = local; t < extent.y; t += WIDTH) {
        let old = touches[touch_number(t)].friction_impulse;
        if (touches[touch_number(t)].state != PUSHING || old.w <= 0.0) {
            continue;
        }
        let normal = touches[touch_number(t)].normal.xyz;
        let slip = slip_of(t);
        let slide = slip - normal * dot(slip, normal);
        let wanted = old.xyz - slide * touches[touch_number(t)].arm.w;
        let limit = touches[touch_number(t)].friction * old.w;
        let size = sqrt(dot(wanted, wanted));
        let drag = select(wanted, wanted * (limit / max(size, 1e-30)), size > limit);
        let moved = drag - old.xyz;
        changed = changed || squared(ROUNDOFF_TOLERANCE * limit) < dot(moved, moved);
        touches[touch_number(t)].friction_impulse = vec4<f32>(drag, old.w);
    }
    return vote(changed, local);
}

/// Impulses of all touches, with changes of the set of those that push until none pulls and none enters.
fn solve(local: u32) {
    var change = 0u;
    var sweep = 1u;
    var solved = false;
    var shared_out = false;
    loop {
        propagate(local);
        if (!solved) {
            if (!shared_out) {
                for (var t = extent.x + local; t < extent.y; t += WIDTH) {
                    share_mass(t);
                }
            }
            common_velocity(local);
            solved = true;
            shared_out = true;
        } else if (change_set(change < SET_CHANGES / 2u, local)) {
            if (change == SET_CHANGES && local == 0u) {
                atomicStore(&status[counter(NOT_CONVERGED)], 1u);
                atomicMin(&status[counter(BAD_STEP)], step.index);
            }
            solved = change >= SET_CHANGES;
            change++;
        } else {
            if (!FRICTION || sweep >= FRICTION_SWEEPS) {
                break;
            }
            if (!update_friction(local)) {
                break;
            }
            sweep++;
            change = 0u;
            solved = false;
        }
    }
}

/// Gives the nodes their impulses, and sums up what the impulses did: impulse and turn on the body, dissipation, friction, work of the drive,
/// support.
fn account(local: u32) {
    let n = scene.nodes;
    let prescribed = scene.body_prescribed != 0u;
    var part: array<f32, 12>;
    for (var p = local; p < extent.x; p += WIDTH) {
        let drag = touches[touch_number(p)].friction_impulse;
        let carried = points[point_number(p)].edge_impulse.xyz;
        if (drag.w <= 0.0 && points[point_number(p)].tied == 0u) {
            continue;
        }
        let node = points[point_number(p)].node;
        let ply = node_ply(node);
        let place = node_place(node);
        let inverse = points[point_number(p)].inverse.xyz;
        let force = to_pack(ply, gather(node, place));
        points[point_number(p)].free = vec4<f32>(points[point_number(p)].relative.xyz - inverse * force * step.kick, 0.0);
        if (drag.w <= 0.0 && all(carried == vec3<f32>(0.0))) {
            continue;
        }
        let impulse = touches[touch_number(p)].normal.xyz * drag.w + drag.xyz + carried;
        let fixed = inverse <= vec3<f32>(0.0);
        // The drive is the support of a driven body; what goes into held nodes never reaches the fabric.
        let support = select(select(vec3<f32>(0.0), -impulse, fixed), select(impulse, vec3<f32>(0.0), fixed), prescribed);
        part[9] += support.x;
        part[10] += support.y;
        part[11] += support.z;
        let change = to_ply(ply, inverse * impulse);
        touch(ply, place);
        for (var a = 0u; a < 3u; a++) {
            nodes[a * n + node] += scene.dt * change[a];
            nodes[(3u + a) * n + node] += change[a];
        }
    }
    storageBarrier();
    for (var t = local; t < extent.y; t += WIDTH) {
        let drag = touches[touch_number(t)].friction_impulse;
        if (drag.w <= 0.0) {
            continue;
        }
        let ends = touches[touch_number(t)].ends;
        let normal = touches[touch_number(t)].normal.xyz;
        let arm = touches[touch_number(t)].arm.xyz;
        let before = mix(points[point_number(ends.x)].free.xyz, points[point_number(ends.y)].free.xyz, touches[touch_number(t)].weight);
        let mean = 0.5 * (before + slip_of(t));
        let impulse = normal * drag.w + drag.xyz;
        let turn = cross(arm, impulse);
        let surface = body.velocity.xyz + cross(body.turning.xyz, arm);
        part[0] -= impulse.x;
        part[1] -= impulse.y;
        part[2] -= impulse.z;
        part[3] -= turn.x;
        part[4] -= turn.y;
        part[5] -= turn.z;
        part[6] -= drag.w * dot(normal, mean);
        part[7] -= dot(drag.xyz, mean);
        part[8] += select(0.0, dot(impulse, surface), prescribed);
    }
    for (var i = 0u; i < 12u; i++) {
        sums[i * 65u + local] = part[i];
    }
    reduce(12u, local);
}

@compute @workgroup_size(64)
fn projectile_rim(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    shot = shots[group.z];
    body = bodies[shot.number];
    if (local == 0u) {
        extent = touches[touch_head()].ends;
        verdict = u32(step.index <= atomicLoad(&status[counter(BAD_STEP)]));
        for (var i = 0u; i < 6u; i++) { motion[i] = 0.0; }
        for (var i = 0u; i < 27u; i++) { result[i] = 0.0; }
    }
    if (workgroupUniformLoad(&verdict) == 0u) {
        return;
    }
    let met = workgroupUniformLoad(&extent).x > 0u;
    if (met) {
        solve(local);
        account(local);
    }
    if (local == 0u) {
        bodies[shot.number] = moved_body(body, met);
    }
}
