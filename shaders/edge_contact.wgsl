// edge_contact: the normal impulses of touches that share nodes: K = N M⁻¹ Nᵀ of those that push, its factor L and both substitutions.
// K falls into blocks that share no node.
// Needs `points`, `touches`, `members` and `matrix`.
// Twin: src/solver/contact/edge_contact.rs

/// Compliance added to the diagonal of K, over itself in the whole scene: two points that ask the same of a node share its impulse.
const SHARED: f32 = 1e-3;
/// Least pivot, over the diagonal of K.
const FLOOR: f32 = 1e-7;

/// Lists the touches of a ply that share nodes, block by block, those of a block in storage order: a node's own, then those of the edges that
/// begin there.
fn list_members(ply: u32, local: u32) {
    let start = ply * member_room();
    let nodes = workgroupUniformLoad(&extent);
    var total = 0u;
    for (var base = nodes.first; base < nodes.past; base += WIDTH) {
        let p = base + local;
        var own = 0u;
        if (p < nodes.past) {
            own = points[point_number(p)].constrained + points[point_number(p)].to_right + points[point_number(p)].to_above;
        }
        var all = 0u;
        let at = start + total + sum_up_to(own, &all, local) - own;
        if (own > 0u) {
            let itself = points[point_number(p)].constrained;
            for (var i = 0u; i < own; i++) {
                members[member_number(at + i)] = select(points[point_number(p)].first + i - itself, p, i < itself);
                members[block_number(at + i)] = points[point_number(p)].block;
            }
        }
        total += all;
    }
    storageBarrier();
    for (var m = start + local; m < start + total; m += WIDTH) {
        let t = members[member_number(m)];
        let block = members[block_number(m)];
        var before = 0u;
        var own = 0u;
        for (var i = start; i < start + total; i++) {
            let other = members[block_number(i)];
            before += u32(other < block);
            own += u32(other == block && i < m);
        }
        touches[touch_number(t)].begin = start + before;
        touches[touch_number(t)].member = start + before + own;
    }
    storageBarrier();
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
        let member = touches[touch_number(t)].member;
        if (member != NONE) { members[member_number(member)] = t; }
    }
    if (local == 0u) { members[member_number(start + total)] = NONE; }
    storageBarrier();
    // Rows of the matrix one after another, each from the first member of its block on.
    var entries = 0u;
    for (var base = start; base < start + total; base += WIDTH) {
        let m = base + local;
        var row = 0u;
        if (m < start + total) { row = m + 1u - touches[touch_number(members[member_number(m)])].begin; }
        var all = 0u;
        let at = entries + sum_up_to(row, &all, local) - row;
        if (m < start + total) { touches[touch_number(members[member_number(m)])].row = matrix_number(ply * matrix_room() + at); }
        entries += all;
    }
    storageBarrier();
    if (entries <= matrix_room()) { return; }
    // Where there is no room for them each stands alone: the run ends by its counter.
    if (local == 0u) { atomicMax(&status[counter(OVERFLOW_EDGES)], entries / MATRIX_ROW); }
    for (var t = first_touch(local); t != NONE; t = next_touch()) { touches[touch_number(t)].member = NONE; }
}

/// An entry of K [1/kg].
fn coupling(a: u32, b: u32) -> f32 {
    let of_a = touches[touch_number(a)].ends;
    let of_b = touches[touch_number(b)].ends;
    let weights_a = vec2<f32>(1.0 - touches[touch_number(a)].weight, touches[touch_number(a)].weight);
    let weights_b = vec2<f32>(1.0 - touches[touch_number(b)].weight, touches[touch_number(b)].weight);
    let first = weights_a.x * (weights_b.x * f32(of_a.x == of_b.x) + weights_b.y * f32(of_a.x == of_b.y));
    let second = weights_a.y * (weights_b.x * f32(of_a.y == of_b.x) + weights_b.y * f32(of_a.y == of_b.y));
    if (first + second == 0.0) { return 0.0; }
    let inverse = first * points[point_number(of_a.x)].inverse.xyz + second * points[point_number(of_a.y)].inverse.xyz;
    return dot(touches[touch_number(a)].normal.xyz, inverse * touches[touch_number(b)].normal.xyz);
}

/// Compliance added to the entry of a touch on the diagonal of K [1/kg]. A node on a mirror plane adds as much as it would in the whole
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

/// Part of a touch that pushes in the equations: its row of K, its direction, and its excess velocity over the one allowed. One that
/// shares no node has a row to itself.
fn fill(t: u32) {
    let member = touches[touch_number(t)].member;
    let alone = member == NONE;
    if (!alone) {
        let begin = touches[touch_number(t)].begin;
        let row = touches[touch_number(t)].row;
        var entry = member;
        for (var m = begin; m < member; m++) {
            let other = members[member_number(m)];
            let pushes = touches[touch_number(other)].state == PUSHING;
            let value = select(0.0, coupling(t, other), pushes);
            matrix[row + m - begin] = value;
            entry = select(entry, min(entry, m), value != 0.0);
        }
        touches[touch_number(t)].entry = entry;
    }
    let normal = touches[touch_number(t)].normal.xyz;
    let arm = touches[touch_number(t)].arm;
    let diagonal = 1.0 / inertia_along(coupling(t, t), arm.w) + select(compliance(t), 0.0, alone);
    touches[touch_number(t)].diagonal = diagonal;
    // Of one that shares no node: others have theirs from their row of L.
    touches[touch_number(t)].root = sqrt(diagonal);
    let g = direction_of(normal, arm.xyz);
    touches[touch_number(t)].moved = vec4<f32>(g[0], g[1], g[2], 0.0);
    let ends = touches[touch_number(t)].ends;
    let free = mix(points[point_number(ends.x)].relative.xyz, points[point_number(ends.y)].relative.xyz, touches[touch_number(t)].weight);
    let excess = dot(free, normal) - closing_limit(touches[touch_number(t)].normal.w);
    touches[touch_number(t)].turned = vec4<f32>(g[3], g[4], g[5], excess);
}

/// Whether a touch is the first member of a block. An invocation solves a block: most are short.
fn leads(t: u32) -> bool {
    let member = touches[touch_number(t)].member;
    return member != NONE && touches[touch_number(t)].begin == member;
}

/// One past the last member of a block.
fn end_of(begin: u32) -> u32 {
    var end = begin;
    loop {
        end += 1u;
        let t = members[member_number(end)];
        if (t == NONE || touches[touch_number(t)].begin != begin) { break; }
    }
    return end;
}

/// L of a block in the place of its K, row by row, and its substitution. `first`: its first touch.
fn eliminate(first: u32) {
    let begin = touches[touch_number(first)].member;
    let end = end_of(begin);
    for (var m = begin; m < end; m++) {
        let t = touch_number(members[member_number(m)]);
        if (touches[t].state != PUSHING) { continue; }
        let row = touches[t].row - begin;
        let entry = touches[t].entry;
        let diagonal = touches[t].diagonal;
        var pivot = diagonal;
        var moved = touches[t].moved;
        var turned = touches[t].turned;
        for (var k = entry; k < m; k++) {
            let above = touch_number(members[member_number(k)]);
            if (touches[above].state != PUSHING) { continue; }
            var value = matrix[row + k];
            let other = touches[above].row - begin;
            for (var j = max(entry, touches[above].entry); j < k; j++) {
                value -= matrix[row + j] * matrix[other + j];
            }
            let root = touches[above].root;
            value /= root;
            matrix[row + k] = value;
            pivot -= value * value;
            moved -= (value / root) * touches[above].moved;
            turned -= (value / root) * touches[above].turned;
        }
        touches[t].root = sqrt(max(pivot, FLOOR * diagonal));
        touches[t].moved = moved;
        touches[t].turned = turned;
    }
}

/// Normal impulses of a block for the motion found: the substitution back. `first`: its first touch.
fn substitute_back(first: u32) {
    let begin = touches[touch_number(first)].member;
    for (var left = end_of(begin); left > begin; left--) {
        let m = left - 1u;
        let b = touch_number(members[member_number(m)]);
        if (touches[b].state != PUSHING) { continue; }
        let row = touches[b].row - begin;
        let share = touches[b].normal_impulse / touches[b].root;
        for (var k = touches[b].entry; k < m; k++) {
            touches[touch_number(members[member_number(k)])].normal_impulse -= matrix[row + k] * share;
        }
    }
}

/// Normal impulses for the motion found.
fn push_back(local: u32) {
    let linear = vec3<f32>(motion[0], motion[1], motion[2]);
    let angular = vec3<f32>(motion[3], motion[4], motion[5]) * scene.body_bounding_radius;
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
        if (touches[touch_number(t)].state == PUSHING) {
            let turned = touches[touch_number(t)].turned;
            let along = dot(touches[touch_number(t)].moved.xyz, linear) + dot(turned.xyz, angular);
            touches[touch_number(t)].normal_impulse = (along - turned.w) / touches[touch_number(t)].root;
        }
    }
    if (EDGES) {
        storageBarrier();
        for (var t = first_touch(local); t != NONE; t = next_touch()) {
            if (leads(t)) { substitute_back(t); }
        }
        storageBarrier();
    }
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
        if (touches[touch_number(t)].state == PUSHING) {
            touches[touch_number(t)].friction_impulse.w = touches[touch_number(t)].normal_impulse / touches[touch_number(t)].root;
        }
    }
}

/// Equations of the touches that push, and their sums in those of the body: `result` holds these, lower triangle by rows, then the right side.
fn assemble(local: u32) {
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
        if (touches[touch_number(t)].state == PUSHING) { fill(t); }
    }
    if (EDGES) {
        storageBarrier();
        for (var t = first_touch(local); t != NONE; t = next_touch()) {
            if (leads(t)) { eliminate(t); }
        }
        storageBarrier();
    }
    var part: array<f32, 27>;
    for (var t = first_touch(local); t != NONE; t = next_touch()) {
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
}
