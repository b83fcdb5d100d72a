// ply_search: which nodes come too close to a cell of a neighbouring ply, and how many contacts each node takes part in.
//   in      nodes     array<f32>      (6, N)   displacement [m], velocity [m/s]
//   in      cells     array<u32>               elements, see `cells`
//   in/out  over      array<u32>      (2, N)   element of the ply in front, of the ply behind, that a node is over, PENETRATING
//   out     contacts  array<Contact>  (2, N)
//   in/out  shares    array<u32>      (N)      contacts of a node, by weight
//   in/out  status    array<u32>               counters
// Twin: `PlySearch` of src/solver/contact/ply_search.rs, `share` of src/solver/contact/ply_impulse.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> over: array<u32>;
@group(1) @binding(3) var<storage, read_write> contacts: array<Contact>;
@group(1) @binding(4) var<storage, read_write> shares: array<atomic<u32>>;
@group(1) @binding(5) var<storage, read_write> status: array<atomic<u32>>;

/// Whether a neighbour's part that may have moved lies within reach of a node, by reference positions.
fn is_within_reach(own: u32, place: vec2<u32>, other: u32) -> bool {
    let reach = reach_of(other);
    if (reach.x >= reach.y) { return false; }
    let lies = to_ply(other, to_pack(own, reference(own, place)));
    // A ring for the growth of this step, and room for what has gone sideways.
    let slack = shot.travel * f32(step.index + 1u) + 3.0 * max(plies[other].longest, plies[own].longest);
    let low = reference(other, vec2<u32>(reach.x, reach.z)).xy - vec2<f32>(slack);
    let high = reference(other, vec2<u32>(reach.y, reach.w)).xy + vec2<f32>(slack);
    return all(lies.xy >= low) && all(lies.xy <= high);
}

/// Touch of a node and a cell of the neighbouring ply, or its distance from that.
struct Touch {
    cell: vec2<u32>,
    place: vec2<f32>,
    /// Unit vector along which the node is driven out.
    normal_impulse: vec3<f32>,
    /// Along it, beyond the distance at which plies touch [m].
    gap: f32,
    /// Whether the node is over the cell.
    over: bool,
}

/// Places of the corners of a cell of a ply.
fn cell_at(ply: u32, cell: vec2<u32>) -> Cell {
    return Cell(
        ply_position(ply, cell),
        ply_position(ply, cell + vec2<u32>(0u, 1u)),
        ply_position(ply, cell + vec2<u32>(1u, 1u)),
        ply_position(ply, cell + vec2<u32>(1u, 0u)),
    );
}

/// Whether a cell of a ply carries load.
fn cell_is_intact(ply: u32, cell: vec2<u32>) -> bool { return yarns_left(element_at(ply, cell)) != 0u; }

/// Position of a point over the cells that meet at the corner of a cell to which its foot points: over the nearest of them, or of
/// their edges.
fn on_ridge(
    other: u32, start: vec2<u32>, foot: vec2<f32>, point: vec3<f32>, direction: f32, touching: f32, slop: f32,
) -> Touch {
    let o = plies[other];
    var nearest = Touch(start, vec2<f32>(0.0), vec3<f32>(0.0), 1e30, false);
    var hole = 1e30;
    // In an order that is its own mirror image; beyond the first row and column a number wraps around.
    let way = vec2<u32>(select(~0u, 1u, foot.y > 0.0), select(~0u, 1u, foot.x > 0.0));
    for (var i = 0u; i < 4u; i++) {
        let cell = start + way * vec2<u32>(i >> 1u, i & 1u);
        if (!is_element(other, cell)) { continue; }
        let corner = cell_at(other, cell);
        let f = closest_on(corner, point, cell_area(other, cell));
        if (!f.sound) { continue; }
        let over = is_over(f.place, cell, o.rows, o.columns, cut_sides(other));
        var edge = EdgePlace(f.place, f.normal * f.height);
        if (!over) { edge = on_edge(corner, point, f.place); }
        let distance = sqrt(dot(edge.arm, edge.arm));
        if (!cell_is_intact(other, cell)) {
            hole = min(hole, distance);
        } else if (distance - touching < nearest.gap) {
            let outside = direction * dot(edge.arm, f.normal) > 0.0;
            nearest = Touch(cell, edge.place, edge.arm / max(distance, 1e-30), distance - touching, outside);
        }
    }
    // No node stands over the rim of a hole, which is as near to the hole as to its neighbour.
    nearest.over = nearest.over && hole - touching > nearest.gap + slop;
    if (!nearest.over) { nearest.cell = start; }
    return nearest;
}

/// Walks from a cell, whose corners are known, to that which a point is over; and how it stands over it. `edge`: mirror planes it lies on.
fn touch_of(
    other: u32, start: vec2<u32>, at_start: Cell, point: vec3<f32>, direction: f32, touching: f32, slop: f32, edge: vec2<u32>,
) -> Touch {
    let o = plies[other];
    var found = Touch(start, vec2<f32>(0.0), vec3<f32>(0.0), 0.0, false);
    var left: array<u32, WALK>;
    var corner = at_start;
    for (var walk = 0u; walk <= WALK; walk++) {
        let cell = found.cell;
        let area = cell_area(other, cell);
        var foot: ClosestPoint;
        if (all(edge == vec2<u32>(0u))) {
            foot = closest_on(corner, point, area);
        } else {
            foot = closest_on_planes(corner, point, area, edge);
        }
        if (!foot.sound) { break; }
        if (is_over(foot.place, cell, o.rows, o.columns, cut_sides(other))) {
            return Touch(cell, foot.place, foot.normal * direction, direction * foot.height - touching, true);
        }
        let next = vec2<u32>(step_over(cell.x, foot.place.y, o.rows), step_over(cell.y, foot.place.x, o.columns));
        for (var i = 0u; i < walk; i++) {
            if (left[i] == element_at(other, next)) {
                // Cells send the point to each other: it is beyond the ridge between them. On a mirror plane the image of the place
                // nearest to it is as near.
                if (any(edge != vec2<u32>(0u))) { return found; }
                return on_ridge(other, cell, foot.place, point, direction, touching, slop);
            }
        }
        if (all(next == cell) || walk == WALK) { break; }
        left[walk] = element_at(other, cell);
        found.cell = next;
        corner = cell_at(other, next);
    }
    return found;
}

/// Search for a contact of a node with one neighbour; true where there is one.
fn search(ply: u32, node: u32, place: vec2<u32>, side: u32) -> bool {
    let other = neighbour(ply, side);
    let at = side * scene.nodes + node;
    let o = plies[other];
    let point = ply_position(ply, place);
    let cell = cell_over(other, over[at]);
    let was_inside = (over[at] & PENETRATING) != 0u;
    let front = plies[min(ply, other)];
    let direction = select(-1.0, 1.0, side == 0u);
    let slop = SLOP * front.thickness;
    let corner = cell_at(other, cell);
    if (is_apart(corner, point, direction, front.touching - slop, cell_area(other, cell))) {
        if (was_inside) { over[at] &= ~PENETRATING; }
        return false;
    }
    let touch = touch_of(other, cell, corner, point, direction, front.touching, slop, planes_at(ply, place, other));
    over[at] = touch.cell.x * o.columns + touch.cell.y;
    if (!touch.over || touch.gap >= -slop) { return false; }
    if (!cell_is_intact(other, touch.cell) || !is_intact(node, place)) { return false; }
    let weights = weights_at(touch.place);
    let around = cell_corners(other, touch.cell);
    var velocity = ply_velocity(ply, node);
    for (var i = 0u; i < 4u; i++) { velocity -= ply_velocity(other, around[i]) * weights[i]; }
    let along = dot(velocity, touch.normal_impulse);
    let gap = touch.gap - along * scene.dt;
    if (!was_inside && gap < -MAX_INITIAL_PENETRATION * front.thickness) { return false; }
    over[at] |= PENETRATING;
    let limit = ply_closing_limit(gap);
    let recovery = recovery_speed(gap, front.thickness, along);
    let depth = bitcast<u32>(max(-gap, 0.0));
    // Torn edges stick into each other: only whole fabric counts.
    let whole = yarns_left(element_at(other, touch.cell)) == o.present && is_whole(node, place);
    if (whole && depth > atomicLoad(&status[counter(PLY_DEPTH)])) { atomicMax(&status[counter(PLY_DEPTH)], depth); }
    if (!(along < limit || recovery > 0.0)) { return false; }
    contacts[at] = Contact(vec4<f32>(touch.normal_impulse, limit), vec4<f32>(touch.place, recovery, 1.0));
    atomicAdd(&shares[node], u32(SHARE_UNIT));
    let part = SHARE_UNIT * part_of(ply, place);
    for (var i = 0u; i < 4u; i++) {
        // Rounded up: a corner that gets any impulse must have a share, or it would not take it. One on a mirror plane has the
        // images of contacts that come from one side of it.
        let share = u32(ceil(weights[i] * part / part_of(other, node_place(around[i]))));
        if (share > 0u) { atomicAdd(&shares[around[i]], share); }
    }
    return true;
}

@compute @workgroup_size(64)
fn ply_search(id: Invocation) {
    shot = shots[id.group.z];
    let number = invocation_number(id);
    if (number >= scene.shot_nodes || step.index > atomicLoad(&status[counter(BAD_STEP)])) { return; }
    let node = first_node() + number;
    let ply = node_ply(node);
    let place = node_place(node);
    if (!is_node(ply, place)) { return; }
    let moving = is_near(reach_of(ply), place, 1u, 1u);
    for (var side = 0u; side < 2u; side++) {
        let other = neighbour(ply, side);
        var found = false;
        if (other != NO_PLY && (moving || is_within_reach(ply, place, other))) { found = search(ply, node, place, side); }
        let at = side * scene.nodes + node;
        if (!found && contacts[at].foot.w != 0.0) { contacts[at].foot.w = 0.0; }
    }
}
