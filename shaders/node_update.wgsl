// node_update: kick and drift of a node; marks the nodes that may meet the projectile. Needs `nodes`, `supports`, `status`, `body` and
// `candidates`.
// Twin: src/solver/node_update.rs

fn mark_node(node: u32) { atomicOr(&candidates[mark_at(0u, node)], mark_bit(node)); }

/// Marks a node that may touch the body within the step: its path without contact comes closer to the box around the body than both
/// can move. Where the rim is sampled, the distance grows by the length of an element's edge, and the nodes at the other ends of its
/// edges are marked too. Vectors are in the axes of the pack.
fn mark(ply: u32, place: vec2<u32>, displacement: vec3<f32>, speed: f32) {
    let node = node_at(ply, place);
    var room = 1.01 * scene.dt * (speed + 1.1 * body.velocity.w) + 1e-6 * scene.body_bounding_radius;
    if (EDGES) { room += scene.rim_depth; }
    let local = rotate_back(body.orientation, arm_of(body.nose_coarse, body.nose_fine, to_pack(ply, reference(ply, place)), displacement));
    let moved = rotate_back(body.orientation, vec3<f32>(0.0, 0.0, -plies[ply].depth));
    let pressed = local + moved;
    let across = min(axis_distance(local), axis_distance(pressed)) - 0.5 * sqrt(dot(moved.xy, moved.xy));
    let along = max(min(local.z, pressed.z), scene.body_back - max(local.z, pressed.z));
    let gap = max(across - scene.body_radius, along);
    if (gap > room) { return; }
    mark_node(node);
    if (EDGES) {
        if (place.y > 0u) { mark_node(node - 1u); }
        if (place.y < plies[ply].columns) { mark_node(node + 1u); }
        if (place.x > 0u) { mark_node(node - scene.columns - 1u); }
        if (place.x < plies[ply].rows) { mark_node(node + scene.columns + 1u); }
    }
}

/// Velocity that clay takes of a node of displacement `u` [m], velocity `v` and, after its forces, `free`, all along the normal [m/s]. Plastic:
/// for the part of the step that is deeper than the crater, it stops what goes there at most, and throws nothing back.
fn taken_by_clay(ply: u32, place: vec2<u32>, u: f32, v: f32, free: f32) -> f32 {
    let node = node_at(ply, place);
    let depth = u - plies[ply].clay_gap;
    let crater = max(nodes[clay_word(CRATER, node)], depth);
    let most = step.kick * plies[ply].clay_rate * (1.0 + plies[ply].clay_gain * crater);
    let into = max((depth - crater) * (1.0 / scene.dt) + free, 0.0);
    let taken = into * most / max(free, most);
    nodes[clay_word(CRATER, node)] = crater;
    nodes[clay_word(TAKEN, node)] = taken;
    if (0.0 < taken) {
        let impulse = node_mass(ply, place) * taken;
        nodes[clay_word(INTO_CLAY, node)] += 0.5 * impulse * (v + (free - taken));
        add_support(ply, place, vec3<f32>(0.0, 0.0, -impulse));
    }
    return taken;
}

/// Moves a node of displacement `u` [m] and velocity `v` [m/s] by its internal force [N], and books the work that the force does in half a
/// step before and after.
fn move_node(ply: u32, place: vec2<u32>, u: vec3<f32>, v: vec3<f32>, force: vec3<f32>) {
    let node = node_at(ply, place);
    let inverse = inverse_mass(ply, place);
    var after = v + step.kick * force * inverse;
    if (has_clay(ply)) { after.z -= taken_by_clay(ply, place, u.z, v.z, after.z); }
    let moved = u + scene.dt * after;
    for (var a = 0u; a < 3u; a++) {
        nodes[node_word(slot_now(), a, node)] = moved[a];
        nodes[node_word(slot_now(), 3u + a, node)] = after[a];
    }
    let half = -0.5 * scene.dt * dot(force, after);
    part[WORK] += half - 0.5 * step.span * dot(force, v);
    if (is_sampled()) { part[HALF_STEP] += half; }
    let square = dot(after, after);
    if (!finite(square)) { atomicMin(&status[counter(BAD_STEP)], step.index); }
    if (held(ply, place) != 0u) { add_support(ply, place, select(vec3<f32>(0.0), -step.kick * force, inverse <= vec3<f32>(0.0))); }
    if (has_projectile()) { mark(ply, place, to_pack(ply, u), sqrt(square)); }
}
