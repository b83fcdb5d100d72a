// projectile_points: where the projectile may touch in this step: nodes, and where the rim of its face is sampled the points at which it
// crosses edges of elements, by the first of their nodes. Needs `body`, `points`, `touches`, `candidates` and `status`.
// Twin: src/solver/contact/projectile_points.rs

/// Bits of the depth of the deepest node inside the body, 0: none is [m]. Numbers above zero are in the order of their bits.
var<workgroup> penetration: atomic<u32>;

/// Point of a node that is marked, else `NONE`.
fn point_of(node: u32) -> u32 {
    let bit = mark_bit(node);
    let marks = atomicLoad(&candidates[mark_at(0u, node)]);
    let point = atomicLoad(&candidates[mark_at(BEFORE, node)]) + countOneBits(marks & (bit - 1u));
    return select(NONE, point, (marks & bit) != 0u && point < scene.points);
}

/// Crossings of a straight line and the cylinder through the rim of the face, as fractions of the way, ascending; -1 where it does not.
fn rim_crossings(start: vec2<f32>, end: vec2<f32>) -> vec2<f32> {
    let way = end - start;
    let square = dot(way, way);
    let half = dot(start, way);
    let radius = scene.profile[1].x;
    let size = sqrt(dot(start, start));
    let under = half * half - square * ((size - radius) * (size + radius));
    if (under < 0.0 || square <= 0.0) { return vec2<f32>(-1.0); }
    let root = sqrt(under);
    return vec2<f32>(-half - root, -half + root) / square;
}

/// Whether a node can move along a normal at all.
fn is_free(p: u32, normal: vec3<f32>) -> bool {
    return dot(normal, points[point_number(p)].inverse.xyz * normal) > 0.0;
}

/// One of the two points of the rim on an edge that begins at a node: 0 and 1 along the row, 2 and 3 along the column. `AWAY` where there
/// is none that may touch.
fn constraint_at(p: u32, slot: u32) -> Touch {
    var constraint: Touch;
    let node = points[point_number(p)].node;
    let ply = node_ply(node);
    let place = node_place(node);
    let up = slot >= 2u;
    let next = place + select(vec2<u32>(0u, 1u), vec2<u32>(1u, 0u), up);
    if (!is_node(ply, next) || !edge_is_intact(node, place, up)) { return constraint; }
    let q = point_of(node_at(ply, next));
    if (q == NONE) { return constraint; }
    let crossings = rim_crossings(points[point_number(p)].pressed.xy, points[point_number(q)].pressed.xy);
    let at = select(crossings.x, crossings.y, (slot & 1u) != 0u);
    if (!(0.0 < at && at < 1.0)) { return constraint; }
    let height = mix(points[point_number(p)].pressed.z, points[point_number(q)].pressed.z, at);
    let gap = height - (scene.profile[1].y + scene.profile_radius);
    let normal = rotate(body.orientation, vec3<f32>(0.0, 0.0, 1.0));
    let approach = dot(mix(points[point_number(p)].relative.xyz, points[point_number(q)].relative.xyz, at), normal);
    if (gap < -scene.rim_depth || stays_away(gap, approach)) { return constraint; }
    if (scene.body_prescribed != 0u && !is_free(p, normal) && !is_free(q, normal)) {
        return constraint; // both are held: neither can give way
    }
    constraint.normal = vec4<f32>(normal, gap);
    constraint.arm = vec4<f32>(mix(touches[touch_number(p)].arm.xyz, touches[touch_number(q)].arm.xyz, at), 0.0);
    constraint.ends = vec2<u32>(p, q);
    constraint.weight = at;
    constraint.friction = friction_through(max(points[point_number(p)].pressed.w, points[point_number(q)].pressed.w));
    constraint.member = NONE;
    constraint.state = first_state(select(1u, 2u, up), node, approach < closing_limit(gap));
    return constraint;
}

/// Lists the points of the rim of a ply, by the first of their nodes; gives their number.
fn find_constraints(ply: u32, nodes: Extent, local: u32) -> u32 {
    var total = 0u;
    for (var base = 0u; base < 4u * (nodes.past - nodes.first); base += WIDTH) {
        let p = nodes.first + (base + local) / 4u;
        var constraint: Touch;
        if (p < nodes.past) { constraint = constraint_at(p, local & 3u); }
        let there = constraint.state != AWAY;
        let round = base / WIDTH;
        let rank = rank_of(there, round, local);
        let at = total + rank.x;
        if (there && at < scene.constraints) { touches[touch_number(constraint_touch(ply, at))] = constraint; }
        if (p < nodes.past && (local & 3u) == 0u) {
            points[point_number(p)].first = constraint_touch(ply, at);
            points[point_number(p)].to_right = u32(there) + is_marked(local + 1u, round);
            points[point_number(p)].to_above = is_marked(local + 2u, round) + is_marked(local + 3u, round);
        }
        total += rank.y;
    }
    if (total <= scene.constraints) { return total; }
    // Where there is no room for them none is heeded: the run ends by its counter.
    if (local == 0u) { atomicMax(&status[counter(OVERFLOW_EDGES)], total); }
    for (var p = nodes.first + local; p < nodes.past; p += WIDTH) {
        points[point_number(p)].to_right = 0u;
        points[point_number(p)].to_above = 0u;
    }
    return 0u;
}

/// Marks at every node which edges with a point of the rim end at it.
fn link(p: u32) {
    let node = points[point_number(p)].node;
    let place = node_place(node);
    var left = NONE;
    var below = NONE;
    if (place.y > 0u && p > 0u) { left = select(NONE, p - 1u, points[point_number(p - 1u)].node == node - 1u); }
    if (place.x > 0u) { below = point_of(node - scene.columns - 1u); }
    if (left != NONE) { left = select(NONE, left, points[point_number(left)].to_right > 0u); }
    if (below != NONE) { below = select(NONE, below, points[point_number(below)].to_above > 0u); }
    points[point_number(p)].left = left;
    points[point_number(p)].below = below;
    points[point_number(p)].constrained = u32(points[point_number(p)].to_right + points[point_number(p)].to_above > 0u || left != NONE || below != NONE);
}

/// Marks at every node the first of those that it is tied to.
fn find_blocks(nodes: Extent, local: u32) {
    for (var p = nodes.first + local; p < nodes.past; p += WIDTH) { points[point_number(p)].block = p; }
    storageBarrier();
    loop {
        for (var p = nodes.first + local; p < nodes.past; p += WIDTH) {
            // From one block known so far to the next: chains are twice as long each time.
            var first = points[point_number(points[point_number(p)].block)].block;
            let left = points[point_number(p)].left;
            let below = points[point_number(p)].below;
            let right = points[point_number(p)].first;
            let above = right + points[point_number(p)].to_right;
            if (left != NONE) { first = min(first, points[point_number(left)].block); }
            if (below != NONE) { first = min(first, points[point_number(below)].block); }
            if (points[point_number(p)].to_right > 0u) {
                first = min(first, points[point_number(touches[touch_number(right)].ends.y)].block);
            }
            if (points[point_number(p)].to_above > 0u) {
                first = min(first, points[point_number(touches[touch_number(above)].ends.y)].block);
            }
            touches[touch_number(p)].row = first;
        }
        storageBarrier();
        var changed = false;
        for (var p = nodes.first + local; p < nodes.past; p += WIDTH) {
            changed = changed || touches[touch_number(p)].row != points[point_number(p)].block;
            points[point_number(p)].block = touches[touch_number(p)].row;
        }
        storageBarrier();
        if (!vote(changed, local)) { break; }
    }
}

/// Finds where the body may touch a ply, noted in `extent`, `ends` and `penetration`. True if anywhere.
fn search(ply: u32, local: u32) -> bool {
    grow_active_region(ply, local);
    collect(ply, local);
    let nodes = workgroupUniformLoad(&extent);
    if (nodes.first == nodes.past) { return false; }
    for (var p = nodes.first + local; p < nodes.past; p += WIDTH) {
        let depth = take_in(p);
        if (depth > 0.0) { atomicMax(&penetration, bitcast<u32>(depth)); }
    }
    if (EDGES) {
        storageBarrier();
        let number = find_constraints(ply, nodes, local);
        if (local == 0u) {
            ends[ply] = number;
            extent.constraints = number;
        }
        storageBarrier();
        for (var p = nodes.first + local; p < nodes.past; p += WIDTH) { link(p); }
        storageBarrier();
        find_blocks(nodes, local);
        list_members(ply, local);
    }
    propagate(local);
    // By the invocation that reads it first, in `fill`.
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
        if (t >= scene.points) { share_mass(t); }
    }
    return true;
}
