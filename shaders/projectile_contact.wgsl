// projectile_contact: kinematic, perfectly inelastic contact with Coulomb friction, then the motion of the body. One
// workgroup: the nodes near the projectile are few, and all of them meet in one 6 × 6 solve.
//   in/out  nodes       array<f32>    (6, N)   displacement [m], velocity [m/s]
//   in      forces      array<f32>    (9, E)   P1·Ly/2, P2·Lx/2, hourglass per corner [N]
//   in      flags       array<u32>    (E)      bit 0 warp alive, bit 1 weft alive
//   in/out  status      array<u32>             counters
//   in/out  body        Body                   the projectile
//   in/out  candidates  array<u32>             a bit per node, then a bit per word of these; cleared
//   scratch points      array<Point>
//   in      over        array<u32>    (2, N)   element in front of, behind a node
// Twin: src/kernels/projectile_contact.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read> flags: array<u32>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> body: Body;
@group(1) @binding(5) var<storage, read_write> candidates: array<atomic<u32>>;
@group(1) @binding(6) var<storage, read_write> points: array<Point>;
@group(1) @binding(7) var<storage, read> over: array<u32>;

/// A node near the body during one step.
struct Point {
    /// Outward normal, and the gap [m].
    normal: vec4<f32>,
    /// From the centre of mass [m], and the inertia met along the normal, 1/(n·w n) [kg].
    arm: vec4<f32>,
    /// Friction impulse and normal impulse on the node [N·s].
    drag: vec4<f32>,
    /// Velocity relative to the body's material before contact [m/s], and the node's mass [kg].
    relative: vec4<f32>,
    node: u32,
    state: u32,
    /// Coulomb coefficient.
    friction: f32,
    pad0: u32,
}

// States of a point.
const AWAY: u32 = 0u;
const NEAR: u32 = 1u;
const PUSHING: u32 = 2u;

/// Invocations.
const WIDTH: u32 = 64u;
/// Changes of the set of pushing nodes allowed in one step.
const SET_CHANGES: u32 = 40u;
/// Alternations between normal impulses and friction.
const FRICTION_SWEEPS: u32 = 6u;
/// Rounding of relative velocities, over the largest speed of the body.
const NOISE: f32 = 1e-6;

var<workgroup> sums: array<f32, 1755>; // 27 sums of 64 parts, in rows of 65
var<workgroup> result: array<f32, 27>;
/// Change of the body's velocity [m/s] and angular velocity [rad/s].
var<workgroup> motion: array<f32, 6>;
var<workgroup> scan: array<u32, 64>;
var<workgroup> ballot: atomic<u32>;
var<workgroup> verdict: u32;

/// Adds up `count` sums over the invocations, in fixed order.
fn reduce(count: u32, local: u32) {
    workgroupBarrier();
    if (local < count) {
        var sum = 0.0;
        for (var i = 0u; i < WIDTH; i++) {
            sum += sums[local * 65u + i];
        }
        result[local] = sum;
    }
    workgroupBarrier();
}

/// The same answer for every invocation: whether it is yes for any.
fn vote(yes: bool, local: u32) -> bool {
    if (local == 0u) {
        atomicStore(&ballot, 0u);
    }
    workgroupBarrier();
    if (yes) {
        atomicStore(&ballot, 1u);
    }
    workgroupBarrier();
    if (local == 0u) {
        verdict = atomicLoad(&ballot);
    }
    return workgroupUniformLoad(&verdict) != 0u;
}

/// Lists the marked nodes in storage order and clears the marks; gives their number.
fn collect(local: u32) -> u32 {
    let words = (scene.nodes + 31u) >> 5u;
    let summaries = (words + 31u) >> 5u;
    var total = 0u;
    for (var base = 0u; base < summaries; base += WIDTH) {
        let summary = base + local;
        var bits = 0u;
        if (summary < summaries) {
            bits = atomicLoad(&candidates[words + summary]);
        }
        var count = 0u;
        for (var rest = bits; rest != 0u; rest &= rest - 1u) {
            count += countOneBits(atomicLoad(&candidates[summary * 32u + firstTrailingBit(rest)]));
        }
        scan[local] = count;
        workgroupBarrier();
        for (var reach = 1u; reach < WIDTH; reach *= 2u) {
            var sum = scan[local];
            if (local >= reach) {
                sum += scan[local - reach];
            }
            workgroupBarrier();
            scan[local] = sum;
            workgroupBarrier();
        }
        var at = total + scan[local] - count;
        for (var rest = bits; rest != 0u; rest &= rest - 1u) {
            let word = summary * 32u + firstTrailingBit(rest);
            for (var marks = atomicLoad(&candidates[word]); marks != 0u; marks &= marks - 1u) {
                if (at < scene.points) {
                    points[at].node = word * 32u + firstTrailingBit(marks);
                }
                at += 1u;
            }
            atomicStore(&candidates[word], 0u);
        }
        if (bits != 0u) {
            atomicStore(&candidates[words + summary], 0u);
        }
        total += scan[WIDTH - 1u];
        workgroupBarrier();
    }
    if (total > scene.points && local == 0u) {
        atomicStore(&status[CROWDED], total);
    }
    storageBarrier();
    return min(total, scene.points);
}

/// Thickness of the fabric between a node and the struck side [m]: of each ply in front whose element there stands.
fn fabric_between(node: u32) -> f32 {
    if (!PLIES) {
        return 0.0;
    }
    var at = node;
    var thickness = 0.0;
    for (var front = node_ply(node); front > 0u; front--) {
        let ply = front - 1u;
        let element = element_at(ply, cell_over(ply, over[at]));
        let place = element_place(element);
        thickness += select(0.0, plies[ply].touching, (flags[element] & 3u) != 0u);
        // On through the corner nearest to the node by its place in the ply behind.
        let lies = to_ply(ply, to_pack(front, reference(front, node_place(at))));
        let corner = reference(ply, place);
        let further = vec2<u32>(
            u32(lies.y - corner.y > 0.5 * plies[ply].length_y), u32(lies.x - corner.x > 0.5 * plies[ply].length_x));
        at = node_at(ply, place + further);
    }
    return thickness;
}

fn velocity_of(node: u32) -> vec3<f32> {
    let n = scene.nodes;
    return vec3<f32>(nodes[3u * n + node], nodes[4u * n + node], nodes[5u * n + node]);
}

fn displacement_of(node: u32) -> vec3<f32> {
    let n = scene.nodes;
    return vec3<f32>(nodes[node], nodes[n + node], nodes[2u * n + node]);
}

/// Looks at one node closely; gives how deep it is inside the body [m].
fn look(p: u32) -> f32 {
    let node = points[p].node;
    points[p].state = AWAY;
    points[p].drag = vec4<f32>(0.0);
    let ply = node_ply(node);
    let place = node_place(node);
    if (!stands(node, place)) {
        return 0.0;
    }
    let own = velocity_of(node);
    let free = to_pack(ply, own);
    let before = to_pack(ply, displacement_of(node) - scene.dt * own);
    let from_nose = arm_of(body.nose_coarse, body.nose_fine, to_pack(ply, reference(ply, place)), before);
    let between = fabric_between(node);
    let g = holding_gap(rotate_back(body.orientation, from_nose - vec3<f32>(0.0, 0.0, between)));
    let arm = from_nose + nose_of(body.orientation);
    let normal = rotate(body.orientation, g.normal);
    let relative = free - body.velocity.xyz - cross(body.turning.xyz, arm);
    let approach = dot(relative, normal);
    let depth = max(0.0, -g.distance);
    // A body that turns under impulses may reach a little further than its velocity now tells.
    if (g.distance + scene.dt * (approach - 0.1 * body.velocity.w) > 0.0) {
        return depth;
    }
    let along = dot(normal, inverse_in_pack(ply, place) * normal);
    if (scene.body_prescribed != 0u && along <= 0.0) {
        return depth; // both are held: neither can give way
    }
    let mass = node_mass(ply, place);
    points[p].normal = vec4<f32>(normal, g.distance);
    // A held node weighs as much as a thousand bodies: more would drown the body's momentum in the rounding of its speed.
    points[p].arm = vec4<f32>(arm, 1.0 / max(along, 1e-3 / max(scene.body_mass, mass)));
    points[p].relative = vec4<f32>(relative, mass);
    // What the projectile rubs against is the fabric it touches; further plies rub against each other.
    points[p].friction = select(scene.friction, min(scene.friction, scene.ply_friction), between > 0.0);
    points[p].state = select(NEAR, PUSHING, approach < closing_limit(g.distance));
    return depth;
}

/// Relative normal velocity below which a node enters the body within the step: what closes its gap exactly.
fn closing_limit(gap: f32) -> f32 {
    return -max(gap, 0.0) / scene.dt;
}

fn impulse_of(p: u32) -> vec3<f32> {
    return points[p].normal.xyz * points[p].drag.w + points[p].drag.xyz;
}

/// Inverse masses of a point by direction [1/kg].
fn inverse_of(p: u32) -> vec3<f32> {
    let node = points[p].node;
    return inverse_in_pack(node_ply(node), node_place(node));
}

/// Velocity of a node relative to the body's material with the impulses and the motion found so far [m/s].
fn slip_of(p: u32) -> vec3<f32> {
    let inverse = inverse_of(p);
    let linear = vec3<f32>(motion[0], motion[1], motion[2]);
    let angular = vec3<f32>(motion[3], motion[4], motion[5]);
    return (points[p].relative.xyz + inverse * impulse_of(p)) - linear - cross(angular, points[p].arm.xyz);
}

/// Normal speed relative to the body before contact, with friction [m/s].
fn normal_speed(p: u32) -> f32 {
    let inverse = inverse_of(p);
    return dot(points[p].relative.xyz + inverse * points[p].drag.xyz, points[p].normal.xyz);
}

/// What is left of a velocity of the body, or of an impulse on it, where mirror planes hold directions.
fn in_planes(v: vec3<f32>) -> vec3<f32> {
    return select(v, vec3<f32>(0.0), (vec3<u32>(scene.body_held) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

/// The same of turning.
fn about_planes(v: vec3<f32>) -> vec3<f32> {
    return select(v, vec3<f32>(0.0), (vec3<u32>(scene.body_held) & vec3<u32>(8u, 16u, 32u)) != vec3<u32>(0u));
}

/// (n, r × n) of a point; turns are measured in lengths of `body_reach`.
fn direction(p: u32) -> array<f32, 6> {
    let normal = in_planes(points[p].normal.xyz);
    var turn = vec3<f32>(0.0);
    if (ROTATION) {
        turn = about_planes(cross(points[p].arm.xyz, points[p].normal.xyz) / scene.body_reach);
    }
    return array<f32, 6>(normal.x, normal.y, normal.z, turn.x, turn.y, turn.z);
}

/// Inertia of the body over `body_reach`² [kg], its lower triangle by rows.
fn body_inertia() -> array<f32, 6> {
    let side = rotate(body.orientation, vec3<f32>(1.0, 0.0, 0.0));
    let axis = rotate(body.orientation, vec3<f32>(0.0, 0.0, 1.0));
    let scale = 1.0 / squared(scene.body_reach);
    // What x and z have more than y, for which the rest is the same in every direction.
    let across = scene.body_inertia_y * scale;
    let more_x = (scene.body_inertia_x - scene.body_inertia_y) * scale;
    let more_z = (scene.body_inertia_z - scene.body_inertia_y) * scale;
    return array<f32, 6>(
        across + more_x * side.x * side.x + more_z * axis.x * axis.x,
        more_x * side.y * side.x + more_z * axis.y * axis.x,
        across + more_x * side.y * side.y + more_z * axis.y * axis.y,
        more_x * side.z * side.x + more_z * axis.z * axis.x,
        more_x * side.z * side.y + more_z * axis.z * axis.y,
        across + more_x * side.z * side.z + more_z * axis.z * axis.z);
}

/// Solves (M + Σ κ G Gᵀ) m = right by Cholesky; `result` holds the sums, lower triangle by rows, then the right side.
fn solve_motion() {
    var a: array<f32, 21>;
    var x: array<f32, 6>;
    for (var i = 0u; i < 21u; i++) { a[i] = result[i]; }
    for (var i = 0u; i < 6u; i++) { x[i] = result[21u + i]; }
    for (var i = 0u; i < 3u; i++) { a[i * (i + 1u) / 2u + i] += scene.body_mass; }
    var size = 3u;
    if (ROTATION) {
        size = 6u;
        let inertia = body_inertia();
        a[9] += inertia[0];
        a[13] += inertia[1];
        a[14] += inertia[2];
        a[18] += inertia[3];
        a[19] += inertia[4];
        a[20] += inertia[5];
    }
    var sound = true;
    for (var i = 0u; i < size; i++) {
        let row = i * (i + 1u) / 2u;
        for (var j = 0u; j <= i; j++) {
            let column = j * (j + 1u) / 2u;
            var sum = a[row + j];
            for (var k = 0u; k < j; k++) {
                sum -= a[row + k] * a[column + k];
            }
            if (i == j) {
                sound = sound && sum > 0.0;
                a[row + j] = sqrt(max(sum, 1e-30));
            } else {
                a[row + j] = sum / a[column + j];
            }
        }
    }
    for (var i = 0u; i < size; i++) {
        let row = i * (i + 1u) / 2u;
        for (var k = 0u; k < i; k++) { x[i] -= a[row + k] * x[k]; }
        x[i] /= a[row + i];
    }
    for (var r = 0u; r < size; r++) {
        let i = size - 1u - r;
        for (var k = i + 1u; k < size; k++) { x[i] -= a[k * (k + 1u) / 2u + i] * x[k]; }
        x[i] /= a[i * (i + 1u) / 2u + i];
    }
    for (var i = 0u; i < 6u; i++) {
        motion[i] = select(0.0, x[i], sound && i < size) / select(1.0, scene.body_reach, i >= 3u);
    }
}

/// One solve for the body's motion with the pushing nodes attached, and their impulses.
fn common_velocity(count: u32, local: u32) {
    if (scene.body_prescribed == 0u) {
        var part: array<f32, 27>;
        for (var p = local; p < count; p += WIDTH) {
            let drag = in_planes(points[p].drag.xyz);
            let turn = about_planes(cross(points[p].arm.xyz, points[p].drag.xyz) / scene.body_reach);
            part[21] -= drag.x;
            part[22] -= drag.y;
            part[23] -= drag.z;
            part[24] -= turn.x;
            part[25] -= turn.y;
            part[26] -= turn.z;
            if (points[p].state == PUSHING) {
                let g = direction(p);
                let kappa = points[p].arm.w;
                let speed = kappa * (normal_speed(p) - closing_limit(points[p].normal.w));
                for (var i = 0u; i < 6u; i++) {
                    part[21u + i] += g[i] * speed;
                    for (var j = 0u; j <= i; j++) {
                        part[i * (i + 1u) / 2u + j] += kappa * g[i] * g[j];
                    }
                }
            }
        }
        for (var i = 0u; i < 27u; i++) {
            sums[i * 65u + local] = part[i];
        }
    }
    reduce(27u, local);
    if (local == 0u && scene.body_prescribed == 0u) {
        solve_motion();
    }
    workgroupBarrier();
    for (var p = local; p < count; p += WIDTH) {
        if (points[p].state == PUSHING) {
            let g = direction(p);
            var along = 0.0;
            for (var i = 0u; i < 3u; i++) {
                along += g[i] * motion[i] + g[3u + i] * motion[3u + i] * scene.body_reach;
            }
            points[p].drag.w = points[p].arm.w * (along + closing_limit(points[p].normal.w) - normal_speed(p));
        }
    }
}

/// Ends the contact: a node that does not push is not dragged either.
fn release(p: u32) {
    points[p].state = NEAR;
    points[p].drag = vec4<f32>(0.0);
}

/// Normal impulses of the pushing set, with changes of the set until none pulls and none enters.
fn solve_normal(count: u32, local: u32) {
    let tolerance = NOISE * (body.velocity.w + 1e-3);
    for (var change = 0u; change < SET_CHANGES; change++) {
        common_velocity(count, local);
        var changed = false;
        for (var p = local; p < count; p += WIDTH) {
            let state = points[p].state;
            if (state == PUSHING && points[p].drag.w < 0.0) {
                release(p);
                changed = true;
            } else if (state == NEAR && change < SET_CHANGES / 2u) {
                let approach = dot(slip_of(p), points[p].normal.xyz);
                if (approach < closing_limit(points[p].normal.w) - tolerance) {
                    points[p].state = PUSHING;
                    changed = true;
                }
            }
        }
        if (!vote(changed, local)) {
            return;
        }
    }
    common_velocity(count, local);
    for (var p = local; p < count; p += WIDTH) {
        if (points[p].drag.w < 0.0) {
            release(p);
        }
    }
}

/// Friction impulses that stop the sliding, cut to μ times the normal impulse. True if any changed.
fn update_friction(count: u32, local: u32) -> bool {
    var changed = false;
    for (var p = local; p < count; p += WIDTH) {
        let normal = points[p].normal.xyz;
        let push = points[p].drag.w;
        if (push <= 0.0) {
            continue;
        }
        let slip = slip_of(p);
        let slide = slip - normal * dot(slip, normal);
        let wanted = points[p].drag.xyz - slide * points[p].relative.w;
        let limit = points[p].friction * push;
        let size = sqrt(dot(wanted, wanted));
        let drag = select(wanted, wanted * (limit / max(size, 1e-30)), size > limit);
        let moved = drag - points[p].drag.xyz;
        changed = changed || squared(NOISE * limit) < dot(moved, moved);
        points[p].drag = vec4<f32>(drag, push);
    }
    return vote(changed, local);
}

/// Sums of what the impulses did: impulse and turn on the body, dissipation, friction, work of the drive, support.
fn account(count: u32, local: u32) {
    var part: array<f32, 12>;
    for (var p = local; p < count; p += WIDTH) {
        let push = points[p].drag.w;
        if (points[p].state != PUSHING || push <= 0.0) {
            continue;
        }
        let node = points[p].node;
        let ply = node_ply(node);
        let inverse = inverse_of(p);
        let impulse = impulse_of(p);
        let turn = cross(points[p].arm.xyz, impulse);
        let before = points[p].relative.xyz - inverse * to_pack(ply, gather(node, node_place(node))) * step.kick;
        let mean = 0.5 * (before + slip_of(p));
        let prescribed = scene.body_prescribed != 0u;
        let fixed = inverse <= vec3<f32>(0.0);
        // The drive is the support of a driven body; what goes into held nodes never reaches the fabric.
        let support = select(select(vec3<f32>(0.0), -impulse, fixed), select(impulse, vec3<f32>(0.0), fixed), prescribed);
        let surface = body.velocity.xyz + cross(body.turning.xyz, points[p].arm.xyz);
        part[0] -= impulse.x;
        part[1] -= impulse.y;
        part[2] -= impulse.z;
        part[3] -= turn.x;
        part[4] -= turn.y;
        part[5] -= turn.z;
        part[6] -= push * dot(points[p].normal.xyz, mean);
        part[7] -= dot(points[p].drag.xyz, mean);
        part[8] += select(0.0, dot(impulse, surface), prescribed);
        part[9] += support.x;
        part[10] += support.y;
        part[11] += support.z;
    }
    for (var i = 0u; i < 12u; i++) {
        sums[i * 65u + local] = part[i];
    }
    reduce(12u, local);
}

/// Gives the nodes their impulses.
fn correct_nodes(count: u32, local: u32) {
    let n = scene.nodes;
    for (var p = local; p < count; p += WIDTH) {
        if (points[p].state != PUSHING || points[p].drag.w <= 0.0) {
            continue;
        }
        let node = points[p].node;
        let ply = node_ply(node);
        let change = to_ply(ply, inverse_of(p) * impulse_of(p));
        touch(ply, node_place(node));
        let u = displacement_of(node) + scene.dt * change;
        let v = velocity_of(node) + change;
        nodes[node] = u.x;
        nodes[n + node] = u.y;
        nodes[2u * n + node] = u.z;
        nodes[3u * n + node] = v.x;
        nodes[4u * n + node] = v.y;
        nodes[5u * n + node] = v.z;
    }
}

/// Takes note of the elements computed in this step, and lets what may have moved grow by a ring of nodes.
fn spread(local: u32) {
    if (local == 0u) {
        for (var ply = 0u; ply < scene.plies; ply++) {
            let p = plies[ply];
            let reach = reach_of(ply);
            let all = step.index == 0u;
            let none = reach.x >= reach.y;
            // A ring more on each side, cut at the edges of the ply.
            let rows = min(reach.y, p.rows) - (max(reach.x, 1u) - 1u);
            let columns = min(reach.w, p.columns) - (max(reach.z, 1u) - 1u);
            let count = select(select(rows * columns, 0u, none), p.rows * p.columns, all);
            let before = atomicAdd(&status[VISITED], count);
            if (before + count < before) {
                atomicAdd(&status[VISITED + 1u], 1u);
            }
        }
    }
    workgroupBarrier();
    storageBarrier();
    let reach = reach_of(min(local, scene.plies - 1u));
    if (local < scene.plies && reach.x < reach.y) {
        let at = REACH + 4u * local;
        atomicStore(&status[at], max(reach.x, 1u) - 1u);
        atomicStore(&status[at + 1u], min(reach.y + 1u, plies[local].rows + 1u));
        atomicStore(&status[at + 2u], max(reach.z, 1u) - 1u);
        atomicStore(&status[at + 3u], min(reach.w + 1u, plies[local].columns + 1u));
    }
    workgroupBarrier();
    storageBarrier();
}

@compute @workgroup_size(64)
fn projectile_contact(@builtin(local_invocation_index) local: u32) {
    let sound = step.index <= atomicLoad(&status[BAD_STEP]);
    if (!vote(sound, local)) {
        return;
    }
    spread(local);
    let found = collect(local);
    if (local == 0u) {
        verdict = found;
        for (var i = 0u; i < 6u; i++) { motion[i] = 0.0; }
        for (var i = 0u; i < 27u; i++) { result[i] = 0.0; }
    }
    let count = workgroupUniformLoad(&verdict);
    var deepest = 0.0;
    if (count > 0u) {
        for (var p = local; p < count; p += WIDTH) {
            deepest = max(deepest, look(p));
        }
        for (var sweep = 1u; true; sweep++) {
            solve_normal(count, local);
            if (!FRICTION || sweep >= FRICTION_SWEEPS) {
                break;
            }
            if (!update_friction(count, local)) {
                break;
            }
        }
        workgroupBarrier();
        account(count, local);
        correct_nodes(count, local);
    }
    sums[local] = deepest;
    workgroupBarrier();
    if (local == 0u) {
        for (var i = 0u; i < WIDTH; i++) {
            deepest = max(deepest, sums[i]);
        }
        var b = body;
        b.coarse_before = b.coarse;
        b.fine_before = b.fine;
        b.change_before = b.change;
        let impulse = vec3<f32>(result[0], result[1], result[2]);
        if (count > 0u) {
            if (scene.body_prescribed == 0u) {
                b.change += vec4<f32>(in_planes(impulse) / scene.body_mass, 0.0);
                if (ROTATION) {
                    b.spin += vec4<f32>(about_planes(vec3<f32>(result[3], result[4], result[5])), 0.0);
                }
            }
            b.impulse += vec4<f32>(impulse, 0.0);
            b.support += vec4<f32>(result[9], result[10], result[11], 0.0);
            b.energy = vec4<f32>(b.energy.xyz + vec3<f32>(result[6], result[7], result[8]), max(b.energy.w, deepest));
        }
        body = advance(b);
    }
}
