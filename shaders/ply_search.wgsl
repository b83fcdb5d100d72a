// ply_search: which nodes come too close to a cell of a neighbouring ply, and how many contacts each node takes part in.
//   in      nodes     array<f32>      (6, N)   displacement [m], velocity [m/s]
//   in      flags     array<u32>      (E)      bit 0 warp alive, bit 1 weft alive
//   in/out  over      array<u32>      (2, N)   element of the ply in front, of the ply behind, that a node is over
//   out     contacts  array<Contact>  (2, N)
//   in/out  shares    array<u32>      (N)      contacts of a node, by weight
//   in/out  status    array<u32>               counters
// Twin: `Look` of src/step/plies/look.rs, `share` of src/step/plies/mod.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> flags: array<u32>;
@group(1) @binding(2) var<storage, read_write> over: array<u32>;
@group(1) @binding(3) var<storage, read_write> contacts: array<Contact>;
@group(1) @binding(4) var<storage, read_write> shares: array<atomic<u32>>;
@group(1) @binding(5) var<storage, read_write> status: array<atomic<u32>>;

/// Whether a neighbour's part that may have moved lies within reach of a node, by reference positions.
fn sees(own: u32, place: vec2<u32>, other: u32) -> bool {
    let reach = reach_of(other);
    if (reach.x >= reach.y) {
        return false;
    }
    let lies = to_ply(other, to_pack(own, reference(own, place)));
    let o = plies[other];
    let longest = max(max(o.length_x, o.length_y), max(plies[own].length_x, plies[own].length_y));
    // A ring for the growth of this step, and room for what has gone sideways.
    let slack = step.travel + 3.0 * longest;
    let low = vec2<f32>(
        o.origin_x + o.length_x * f32(reach.z), o.origin_y + o.length_y * f32(reach.x)) - vec2<f32>(slack);
    let high = vec2<f32>(o.origin_x + o.length_x * f32(reach.w), o.origin_y + o.length_y * f32(reach.y)) + vec2<f32>(slack);
    return all(lies.xy >= low) && all(lies.xy <= high);
}

/// Looks at a node against one neighbour; true where it is a contact.
fn look(ply: u32, node: u32, place: vec2<u32>, side: u32) -> bool {
    let other = neighbour(ply, side);
    let at = side * scene.nodes + node;
    let o = plies[other];
    let point = ply_position(ply, place);
    let area = o.length_x * o.length_y;
    var cell = vec2<u32>(over[at] / o.columns, over[at] % o.columns);
    let front = plies[min(ply, other)];
    let direction = select(-1.0, 1.0, side == 0u);
    let touching = front.touching - SLOP * front.thickness;
    let edge = planes_at(ply, place, other);
    var foot: Foot;
    for (var walk = 0u; walk <= WALK; walk++) {
        let a = ply_position(other, cell);
        let b = ply_position(other, cell + vec2<u32>(0u, 1u));
        let c = ply_position(other, cell + vec2<u32>(1u, 1u));
        let d = ply_position(other, cell + vec2<u32>(1u, 0u));
        if (walk == 0u && is_apart(a, b, c, d, point, direction, touching, area)) {
            return false;
        }
        if (all(edge == vec2<u32>(0u))) {
            foot = foot_on(a, b, c, d, point, area);
        } else {
            foot = foot_on_planes(a, b, c, d, point, area, edge);
        }
        if (!foot.sound) {
            break;
        }
        let next = vec2<u32>(step_over(cell.x, foot.place.y, o.rows), step_over(cell.y, foot.place.x, o.columns));
        if (all(next == cell)) {
            break;
        }
        cell = next;
    }
    over[at] = cell.x * o.columns + cell.y;
    if (!foot.sound || !is_over(foot.place, cell, o.rows, o.columns, cut_sides(other))) {
        return false;
    }
    let end = direction * foot.height - front.touching;
    if (end >= -SLOP * front.thickness || end < -PASSED * front.thickness) {
        return false;
    }
    let element = element_at(other, cell);
    if ((flags[element] & 3u) == 0u || !stands(node, place)) {
        return false;
    }
    let push = foot.normal * direction;
    let weights = weights_at(foot.place);
    let around = cell_corners(other, cell);
    var velocity = ply_velocity(ply, node);
    for (var i = 0u; i < 4u; i++) {
        velocity -= ply_velocity(other, around[i]) * weights[i];
    }
    let along = dot(velocity, push);
    let gap = end - along * scene.dt;
    let limit = ply_closing_limit(gap);
    let recovery = recovery_speed(gap, SLOP * front.thickness, along);
    let depth = bitcast<u32>(max(-gap, 0.0));
    // Torn edges stick into each other: only whole fabric counts.
    let whole = (flags[element] & 3u) == o.present && is_whole(node, place);
    if (whole && depth > atomicLoad(&status[PLY_DEPTH])) {
        atomicMax(&status[PLY_DEPTH], depth);
    }
    if (!(along < limit || recovery > 0.0)) {
        return false;
    }
    contacts[at] = Contact(vec4<f32>(push, limit), vec4<f32>(foot.place, recovery, 1.0));
    atomicAdd(&shares[node], u32(SHARE_UNIT));
    let part = SHARE_UNIT * part_of(ply, place);
    for (var i = 0u; i < 4u; i++) {
        // Rounded up: a corner that gets any impulse must have a share, or it would not take it. One on a mirror plane has the
        // images of contacts that come from one side of it.
        let share = u32(ceil(weights[i] * part / part_of(other, node_place(around[i]))));
        if (share > 0u) {
            atomicAdd(&shares[around[i]], share);
        }
    }
    return true;
}

@compute @workgroup_size(64)
fn ply_search(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = invocation(group, groups, local);
    if (node >= scene.nodes || step.index > atomicLoad(&status[BAD_STEP])) {
        return;
    }
    let ply = node_ply(node);
    let place = node_place(node);
    if (!is_node(ply, place)) {
        return;
    }
    let moving = in_reach(reach_of(ply), place);
    for (var side = 0u; side < 2u; side++) {
        let other = neighbour(ply, side);
        var found = false;
        if (other != NO_PLY && (moving || sees(ply, place, other))) {
            found = look(ply, node, place, side);
        }
        let at = side * scene.nodes + node;
        if (!found && contacts[at].foot.w != 0.0) {
            contacts[at].foot.w = 0.0;
        }
    }
}
