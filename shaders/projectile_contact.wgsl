// projectile_contact: kinematic, perfectly inelastic contact with Coulomb friction where the body may touch, then the motion of the body.
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
// In packs `projectile_search` has found where, ply by ply; a single ply is searched here, and a dispatch saved.
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

/// Ends the contact of what pulls, which is not dragged either, and lets push what would enter. True if anything changed.
fn change_set(joining: bool, local: u32) -> bool {
    let tolerance = ROUNDOFF_TOLERANCE * (body.velocity.w + 1e-3);
    var changed = false;
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
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
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
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
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
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
    for (var change = 0u;; change++) {
        if (!PACK || change > 0u) { assemble(local); }
        if (local == 0u && scene.body_prescribed == 0u) { solve_motion(); }
        workgroupBarrier();
        push_back(local);
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
    for (var p = extent.first + local; p < extent.past; p += WIDTH) {
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
    for (var p = extent.first + local; p < extent.past; p += WIDTH) {
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
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
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

/// Takes in what `projectile_search` found on every ply. True if anything.
fn join_plies(local: u32) -> bool {
    var part: array<f32, 27>;
    var number = 0u;
    if (local < scene.plies) {
        for (var i = 0u; i < 27u; i++) { part[i] = bitcast<f32>(members[found_number(local, i)]); }
        number = members[found_number(local, FOUND_CONSTRAINTS)];
        atomicMax(&penetration, members[found_number(local, FOUND_PENETRATION)]);
    }
    var all = 0u;
    let end = sum_up_to(number, &all, local);
    if (local < scene.plies) { ends[local] = end; }
    if (local == 0u) { extent = Extent(0u, members[found_number(scene.plies - 1u, FOUND_POINTS)], 0u, all); }
    reduce(&part, 27u, local);
    return workgroupUniformLoad(&extent).past > 0u;
}

@compute @workgroup_size(WIDTH)
fn projectile_contact(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    if (!take_shot(group.z, local)) { return; }
    var met = false;
    if (PACK) { met = join_plies(local); } else { met = search(0u, local); }
    clear_marks(local);
    body.energy.w = max(body.energy.w, bitcast<f32>(atomicLoad(&penetration)));
    if (met) {
        solve(local);
        note_idle(local);
        account(local);
    }
    if (local == 0u) { bodies[shot.number] = moved_body(body, met); }
}
