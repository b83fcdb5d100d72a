// projectile_contact: kinematic, perfectly inelastic contact with Coulomb friction where `projectile_points` finds that the body may touch,
// then the motion of the body.
// One workgroup: touches are few, and all of them meet in one 6 × 6 solve. Touches of the rim share nodes and depend on each other: with
// K = N M⁻¹ Nᵀ of those that push, K p = G V′ + target − n·v takes the place of p = κ(…), block by block. With K = L Lᵀ the body's
// equations need L⁻¹G alone. Without a rim no touch shares a node, and nothing of K is computed.
//   in/out  nodes       array<f32>    (6, N)       displacement [m], velocity [m/s]
//   in      cells       array<u32>                 elements, see `cells`
//   in/out  status      array<u32>                 counters
//   in/out  bodies      array<Body>                the projectiles
//   in/out  candidates  array<u32>                 near nodes, a bit each, cleared; what did not push in the last step
//   scratch points      array<Point>               nodes near it, in storage order
//   in      over        array<u32>    (2, N)       element in front of, behind a node
//   scratch touches     array<Touch>               where it may touch: at those nodes, then at points of the rim
//   scratch members     array<u32>                 touches that share nodes, block by block
//   scratch matrix      array<f32>                 K, then L: lower triangles of blocks by rows [1/kg]
// Twin: src/solver/contact/projectile_contact.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> bodies: array<Body>;
@group(1) @binding(4) var<storage, read_write> candidates: array<atomic<u32>>;
@group(1) @binding(5) var<storage, read_write> points: array<Point>;
@group(1) @binding(6) var<storage, read> over: array<u32>;
@group(1) @binding(7) var<storage, read_write> touches: array<Touch>;
@group(1) @binding(8) var<storage, read_write> members: array<u32>;
@group(1) @binding(9) var<storage, read_write> matrix: array<f32>;

/// Points, and touches.
var<workgroup> extent: vec2<u32>;

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
    for (var p = local; p < extent.x; p += WIDTH) {
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

/// One solve for the body's motion with what pushes attached, and the normal impulses. `count`: touches that share nodes.
fn common_velocity(count: u32, local: u32) {
    for (var t = local; t < extent.y; t += WIDTH) {
        if (touches[touch_number(t)].state == PUSHING) { fill(t); }
    }
    if (EDGES) {
        storageBarrier();
        for (var m = local; m < count; m += WIDTH) {
            if (leads(m)) { eliminate(m, end_of(m, count)); }
        }
        storageBarrier();
    }
    var part: array<f32, 27>;
    for (var t = local; t < extent.y; t += WIDTH) {
        if (touches[touch_number(t)].state == PUSHING) {
            let weight = 1.0 / squared(touches[touch_number(t)].root);
            let moved = touches[touch_number(t)].moved;
            let turned = touches[touch_number(t)].turned;
            let g = array<f32, 6>(moved.x, moved.y, moved.z, turned.x, turned.y, turned.z);
            for (var i = 0u; i < 6u; i++) {
                part[21u + i] += weight * g[i] * turned.w;
                for (var j = 0u; j <= i; j++) { part[i * (i + 1u) / 2u + j] += weight * g[i] * g[j]; }
            }
        }
    }
    reduce(&part, 27u, local);
    if (local == 0u && scene.body_prescribed == 0u) { solve_motion(); }
    workgroupBarrier();
    push_back(count, local);
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

/// Share of what would stop each sliding touch alone. All are stopped at once: where they are heavier than the body at their places,
/// the body would be thrown beyond rest, the more so the more it turns, and gain energy.
fn friction_share(local: u32) -> f32 {
    let axis = rotate(body.orientation, vec3<f32>(0.0, 0.0, 1.0));
    var part: array<f32, 27>;
    for (var t = local; t < extent.y; t += WIDTH) {
        if (touches[touch_number(t)].state == PUSHING && touches[touch_number(t)].friction_impulse.w > 0.0) {
            let arm = touches[touch_number(t)].arm;
            let square = dot(arm.xyz, arm.xyz);
            // At most, in any direction across the normal.
            let turned = square / min(scene.body_inertia.x, scene.body_inertia.y)
                + (square - squared(dot(arm.xyz, axis))) / scene.body_inertia.z;
            part[0] += arm.w * (1.0 / scene.body_mass + select(0.0, turned, may_turn()));
        }
    }
    reduce(&part, 1u, local);
    return select(1.0 / max(result[0], 1.0), 1.0, scene.body_prescribed != 0u);
}

/// Friction impulses that stop the sliding, cut to μ times the normal impulse, and the motion of the body with them.
fn update_friction(share: f32, local: u32) {
    var part: array<f32, 27>;
    for (var t = local; t < extent.y; t += WIDTH) {
        let old = touches[touch_number(t)].friction_impulse;
        if (touches[touch_number(t)].state != PUSHING || old.w <= 0.0) { continue; }
        let normal = touches[touch_number(t)].normal.xyz;
        let arm = touches[touch_number(t)].arm;
        let slip = slip_of(t);
        let slide = slip - normal * dot(slip, normal);
        let wanted = old.xyz - slide * (arm.w * share);
        let limit = touches[touch_number(t)].friction * old.w;
        let size = sqrt(dot(wanted, wanted));
        let drag = select(wanted, wanted * (limit / max(size, 1e-30)), size > limit);
        let more = drag - old.xyz;
        let turn = cross(arm.xyz, more);
        for (var a = 0u; a < 3u; a++) {
            part[a] -= more[a];
            part[3u + a] -= turn[a];
        }
        touches[touch_number(t)].friction_impulse = vec4<f32>(drag, old.w);
    }
    reduce(&part, 6u, local);
    if (local == 0u && scene.body_prescribed == 0u) {
        let given = given_motion();
        for (var i = 0u; i < 6u; i++) { motion[i] += given[i]; }
    }
    workgroupBarrier();
}

/// Normal impulses of all touches, with changes of the set of those that push until none pulls and none enters; then friction.
fn solve(local: u32) {
    var count = 0u;
    if (EDGES) { count = list_members(local); }
    propagate(local);
    for (var t = extent.x + local; t < extent.y; t += WIDTH) { share_mass(t); }
    for (var change = 0u;; change++) {
        common_velocity(count, local);
        propagate(local);
        if (!change_set(change < SET_CHANGES / 2u, local)) { break; }
        if (EDGES) { storageBarrier(); }
        if (change >= SET_CHANGES) {
            // What still pulled is let go: the next step finds what enters.
            propagate(local);
            break;
        }
    }
    if (scene.friction > 0.0) {
        let share = friction_share(local);
        for (var sweep = 0u; sweep < FRICTION_SWEEPS; sweep++) {
            update_friction(share, local);
            propagate(local);
        }
    }
}

/// Notes which nodes and edges might have touched and did not push.
fn note_idle(local: u32) {
    for (var p = local; p < extent.x; p += WIDTH) {
        let node = points[point_number(p)].node;
        if (touches[touch_number(p)].state == NEAR) { atomicOr(&candidates[mark_at(IDLE, node)], mark_bit(node)); }
        if (!EDGES) { continue; }
        var t = points[point_number(p)].first;
        for (var way = 1u; way < 3u; way++) {
            let past = t + select(points[point_number(p)].to_right, points[point_number(p)].to_above, way == 2u);
            var idle = t < past;
            for (; t < past; t++) { idle = idle && touches[touch_number(t)].state == NEAR; }
            if (idle) { atomicOr(&candidates[mark_at(IDLE + way, node)], mark_bit(node)); }
        }
    }
}

/// Gives the nodes their impulses, and sums up what the impulses did: impulse and turn on the body, dissipation, friction, work of the drive,
/// support, work on the elements in the half step after the positions.
fn account(local: u32) {
    let prescribed = scene.body_prescribed != 0u;
    var part: array<f32, 27>;
    for (var p = local; p < extent.x; p += WIDTH) {
        let drag = touches[touch_number(p)].friction_impulse;
        let carried = points[point_number(p)].edge_impulse.xyz;
        if (drag.w <= 0.0 && !is_constrained(p)) { continue; }
        let node = points[point_number(p)].node;
        let ply = node_ply(node);
        let place = node_place(node);
        let inverse = points[point_number(p)].inverse.xyz;
        let pull = node_vector(3u, node) - velocity_before(ply, node);
        points[point_number(p)].before = vec4<f32>(points[point_number(p)].relative.xyz - to_pack(ply, pull), 0.0);
        if (drag.w <= 0.0 && all(carried == vec3<f32>(0.0))) { continue; }
        let impulse = touches[touch_number(p)].normal.xyz * drag.w + drag.xyz + carried;
        let fixed = inverse <= vec3<f32>(0.0);
        // The drive is the support of a driven body; what goes into held nodes never reaches the fabric.
        let support = select(select(vec3<f32>(0.0), -impulse, fixed), select(impulse, vec3<f32>(0.0), fixed), prescribed);
        for (var a = 0u; a < 3u; a++) { part[9u + a] += support[a]; }
        let change = to_ply(ply, inverse * impulse);
        touch(ply, place);
        part[12] -= 0.5 * (scene.dt / step.kick) * node_mass(ply, place) * dot(pull, change);
        for (var a = 0u; a < 3u; a++) {
            nodes[node_word(slot_now(), a, node)] += scene.dt * change[a];
            nodes[node_word(slot_now(), 3u + a, node)] += change[a];
        }
    }
    storageBarrier();
    for (var t = local; t < extent.y; t += WIDTH) {
        let drag = touches[touch_number(t)].friction_impulse;
        if (drag.w <= 0.0) { continue; }
        let ends = touches[touch_number(t)].ends;
        let normal = touches[touch_number(t)].normal.xyz;
        let arm = touches[touch_number(t)].arm.xyz;
        let before = mix(points[point_number(ends.x)].before.xyz, points[point_number(ends.y)].before.xyz, touches[touch_number(t)].weight);
        let mean = 0.5 * (before + slip_of(t));
        let impulse = normal * drag.w + drag.xyz;
        let turn = cross(arm, impulse);
        let surface = body.velocity.xyz + cross(body.turning.xyz, arm);
        for (var a = 0u; a < 3u; a++) {
            part[a] -= impulse[a];
            part[3u + a] -= turn[a];
        }
        part[6] -= drag.w * dot(normal, mean);
        part[7] -= dot(drag.xyz, mean);
        part[8] += select(0.0, dot(impulse, surface), prescribed);
    }
    reduce(&part, 13u, local);
    // Where the body meets held nodes the equations lose four digits of the motion in single precision. It moves as the impulses make it move, and
    // loses what they take.
    if (local == 0u && !prescribed) {
        let given = given_motion();
        for (var i = 0u; i < 6u; i++) { result[6] += 0.5 * (motion[i] - given[i]) * result[i]; }
    }
}

@compute @workgroup_size(WIDTH)
fn projectile_contact(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    shot = shots[group.z];
    body = bodies[shot.number];
    if (local == 0u) { verdict = u32(step.index <= atomicLoad(&status[counter(BAD_STEP)])); }
    if (workgroupUniformLoad(&verdict) == 0u) { return; }
    grow_active_region(local);
    let found = find_places(local);
    if (local == 0u) {
        extent = found;
        for (var i = 0u; i < 6u; i++) { motion[i] = 0.0; }
        for (var i = 0u; i < 27u; i++) { result[i] = 0.0; }
    }
    let met = workgroupUniformLoad(&extent).x > 0u;
    if (met) {
        solve(local);
        note_idle(local);
        account(local);
    }
    if (local == 0u) { bodies[shot.number] = moved_body(body, met); }
}
