// projectile_contact: kinematic, perfectly inelastic contact with Coulomb friction, then the motion of the body. One
// workgroup: the nodes near the projectile are few, and all of them meet in one 6 × 6 solve.
//   in/out  nodes       array<f32>    (6, N)   displacement [m], velocity [m/s]
//   in      forces      array<f32>    (9, E)   P1·Ly/2, P2·Lx/2, hourglass per corner [N]
//   in      flags       array<u32>    (E)      bit 0 warp alive, bit 1 weft alive
//   in/out  status      array<u32>             counters
//   in/out  bodies      array<Body>            the projectiles
//   in/out  candidates  array<u32>             a bit per node, then a bit per word of these; cleared
//   scratch points      array<Point>
//   in      over        array<u32>    (2, N)   element in front of, behind a node
// Twin: src/kernels/projectile_contact.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read> flags: array<u32>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> bodies: array<Body>;
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
    friction_impulse: vec4<f32>,
    /// Velocity relative to the body's material before contact [m/s], and the node's mass [kg].
    relative: vec4<f32>,
    node: u32,
    state: u32,
    /// Coulomb coefficient.
    friction: f32,
    pad0: u32,
}

/// Takes a node in; gives how deep it is inside the body [m].
fn take_in(p: u32) -> f32 {
    let node = points[point_number(p)].node;
    let seen = look(node);
    points[point_number(p)].state = seen.state;
    points[point_number(p)].friction_impulse = vec4<f32>(0.0);
    if (seen.state != AWAY) {
        let mass = node_mass(node_ply(node), node_place(node));
        points[point_number(p)].normal = vec4<f32>(seen.normal, seen.gap);
        points[point_number(p)].arm = vec4<f32>(seen.arm, inertia_along(seen.along, mass));
        points[point_number(p)].relative = vec4<f32>(seen.relative, mass);
        points[point_number(p)].friction = friction_through(seen.between);
    }
    return seen.depth;
}

fn impulse_of(p: u32) -> vec3<f32> {
    return points[point_number(p)].normal.xyz * points[point_number(p)].friction_impulse.w + points[point_number(p)].friction_impulse.xyz;
}

/// Inverse masses of a point by direction [1/kg].
fn inverse_of(p: u32) -> vec3<f32> {
    let node = points[point_number(p)].node;
    return inverse_in_pack(node_ply(node), node_place(node));
}

/// Velocity of a node relative to the body's material with the impulses and the motion found so far [m/s].
fn slip_of(p: u32) -> vec3<f32> {
    let inverse = inverse_of(p);
    let linear = vec3<f32>(motion[0], motion[1], motion[2]);
    let angular = vec3<f32>(motion[3], motion[4], motion[5]);
    return (points[point_number(p)].relative.xyz + inverse * impulse_of(p)) - linear - cross(angular, points[point_number(p)].arm.xyz);
}

/// Normal speed relative to the body before contact, with friction [m/s].
fn normal_speed(p: u32) -> f32 {
    let inverse = inverse_of(p);
    return dot(points[point_number(p)].relative.xyz + inverse * points[point_number(p)].friction_impulse.xyz, points[point_number(p)].normal.xyz);
}

/// (n, r × n) of a point.
fn direction(p: u32) -> array<f32, 6> {
    return direction_of(points[point_number(p)].normal.xyz, points[point_number(p)].arm.xyz);
}

/// One solve for the body's motion with the pushing nodes attached, and their impulses.
fn common_velocity(count: u32, local: u32) {
    if (scene.body_prescribed == 0u) {
        var part: array<f32, 27>;
        for (var p = local; p < count; p += WIDTH) {
            let drag = in_planes(points[point_number(p)].friction_impulse.xyz);
            let turn = about_planes(cross(points[point_number(p)].arm.xyz, points[point_number(p)].friction_impulse.xyz) / scene.body_bounding_radius);
            part[21] -= drag.x;
            part[22] -= drag.y;
            part[23] -= drag.z;
            part[24] -= turn.x;
            part[25] -= turn.y;
            part[26] -= turn.z;
            if (points[point_number(p)].state == PUSHING) {
                let g = direction(p);
                let kappa = points[point_number(p)].arm.w;
                let speed = kappa * (normal_speed(p) - closing_limit(points[point_number(p)].normal.w));
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
        if (points[point_number(p)].state == PUSHING) {
            let along = motion_along(direction(p));
            points[point_number(p)].friction_impulse.w = points[point_number(p)].arm.w * (along + closing_limit(points[point_number(p)].normal.w) - normal_speed(p));
        }
    }
}

/// Ends the contact: a node that does not push is not dragged either.
fn release(p: u32) {
    points[point_number(p)].state = NEAR;
    points[point_number(p)].friction_impulse = vec4<f32>(0.0);
}

/// Normal impulses of the pushing set, with changes of the set until none pulls and none enters.
fn solve_normal(count: u32, local: u32) {
    let tolerance = ROUNDOFF_TOLERANCE * (body.velocity.w + 1e-3);
    for (var change = 0u; change < SET_CHANGES; change++) {
        common_velocity(count, local);
        var changed = false;
        for (var p = local; p < count; p += WIDTH) {
            let state = points[point_number(p)].state;
            if (state == PUSHING && points[point_number(p)].friction_impulse.w < 0.0) {
                release(p);
                changed = true;
            } else if (state == NEAR && change < SET_CHANGES / 2u) {
                let approach = dot(slip_of(p), points[point_number(p)].normal.xyz);
                if (approach < closing_limit(points[point_number(p)].normal.w) - tolerance) {
                    points[point_number(p)].state = PUSHING;
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
        if (points[point_number(p)].friction_impulse.w < 0.0) {
            release(p);
        }
    }
}

/// Friction impulses that stop the sliding, cut to μ times the normal impulse. True if any changed.
fn update_friction(count: u32, local: u32) -> bool {
    var changed = false;
    for (var p = local; p < count; p += WIDTH) {
        let normal = points[point_number(p)].normal.xyz;
        let push = points[point_number(p)].friction_impulse.w;
        if (push <= 0.0) {
            continue;
        }
        let slip = slip_of(p);
        let slide = slip - normal * dot(slip, normal);
        let wanted = points[point_number(p)].friction_impulse.xyz - slide * points[point_number(p)].relative.w;
        let limit = points[point_number(p)].friction * push;
        let size = sqrt(dot(wanted, wanted));
        let drag = select(wanted, wanted * (limit / max(size, 1e-30)), size > limit);
        let moved = drag - points[point_number(p)].friction_impulse.xyz;
        changed = changed || squared(ROUNDOFF_TOLERANCE * limit) < dot(moved, moved);
        points[point_number(p)].friction_impulse = vec4<f32>(drag, push);
    }
    return vote(changed, local);
}

/// Sums of what the impulses did: impulse and turn on the body, dissipation, friction, work of the drive, support.
fn account(count: u32, local: u32) {
    var part: array<f32, 12>;
    for (var p = local; p < count; p += WIDTH) {
        let push = points[point_number(p)].friction_impulse.w;
        if (points[point_number(p)].state != PUSHING || push <= 0.0) {
            continue;
        }
        let node = points[point_number(p)].node;
        let ply = node_ply(node);
        let inverse = inverse_of(p);
        let impulse = impulse_of(p);
        let turn = cross(points[point_number(p)].arm.xyz, impulse);
        let before = points[point_number(p)].relative.xyz - inverse * to_pack(ply, gather(node, node_place(node))) * step.kick;
        let mean = 0.5 * (before + slip_of(p));
        let prescribed = scene.body_prescribed != 0u;
        let fixed = inverse <= vec3<f32>(0.0);
        // The drive is the support of a driven body; what goes into held nodes never reaches the fabric.
        let support = select(select(vec3<f32>(0.0), -impulse, fixed), select(impulse, vec3<f32>(0.0), fixed), prescribed);
        let surface = body.velocity.xyz + cross(body.turning.xyz, points[point_number(p)].arm.xyz);
        part[0] -= impulse.x;
        part[1] -= impulse.y;
        part[2] -= impulse.z;
        part[3] -= turn.x;
        part[4] -= turn.y;
        part[5] -= turn.z;
        part[6] -= push * dot(points[point_number(p)].normal.xyz, mean);
        part[7] -= dot(points[point_number(p)].friction_impulse.xyz, mean);
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
        if (points[point_number(p)].state != PUSHING || points[point_number(p)].friction_impulse.w <= 0.0) {
            continue;
        }
        let node = points[point_number(p)].node;
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

@compute @workgroup_size(64)
fn projectile_contact(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    shot = shots[group.z];
    body = bodies[shot.number];
    let sound = step.index <= atomicLoad(&status[counter(BAD_STEP)]);
    if (!vote(sound, local)) {
        return;
    }
    grow_active_region(local);
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
            deepest = max(deepest, take_in(p));
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
        b.energy.w = max(b.energy.w, select(0.0, deepest, count > 0u));
        bodies[shot.number] = moved_body(b, count > 0u);
    }
}
