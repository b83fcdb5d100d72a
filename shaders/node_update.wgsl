// node_update: gather of element forces, kick and drift of every node; marks the nodes that may meet the projectile.
//   in/out  nodes       array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in      forces      array<f32>  (9, E)   P1·Ly/2, P2·Lx/2, force on the difference of opposite edges [N]
//   in/out  supports    array<f32>  (S, 3)   impulse of the supports since the last sample [N·s], nodes of the rim
//   in/out  status      array<u32>           counters
//   in      bodies      array<Body>          the projectiles
//   out     candidates  array<u32>           a bit per node, then a bit per word of these
// Twin: src/solver/node_update.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> supports: array<f32>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read> bodies: array<Body>;
@group(1) @binding(5) var<storage, read_write> candidates: array<atomic<u32>>;

fn mark_node(node: u32) {
    let number = node - first_node();
    let word = number >> 5u;
    atomicOr(&candidates[mark_word(word)], 1u << (number & 31u));
    atomicOr(&candidates[mark_word(mark_words().x + (word >> 5u))], 1u << (word & 31u));
}

/// Marks a node that may touch the body within the step: its path without contact comes closer to the box around the body than both
/// can move. Where the rim is sampled, the distance grows by the length of an element's edge, and the nodes at the other ends of its
/// edges are marked too. Vectors are in the axes of the pack.
fn mark(node: u32, reference: vec3<f32>, displacement: vec3<f32>, speed: f32, depth: f32) {
    var room = 1.01 * scene.dt * (speed + 1.1 * body.velocity.w) + 1e-6 * scene.body_bounding_radius;
    if (EDGES) { room += scene.rim_depth; }
    let local = rotate_back(body.orientation, arm_of(body.nose_coarse, body.nose_fine, reference, displacement));
    let moved = rotate_back(body.orientation, vec3<f32>(0.0, 0.0, -depth));
    let pressed = local + moved;
    let across = min(axis_distance(local), axis_distance(pressed)) - 0.5 * sqrt(dot(moved.xy, moved.xy));
    let along = max(min(local.z, pressed.z), scene.body_back - max(local.z, pressed.z));
    let gap = max(across - scene.body_radius, along);
    if (gap > room) { return; }
    mark_node(node);
    if (EDGES) {
        let ply = node_ply(node);
        let place = node_place(node);
        if (place.y > 0u) { mark_node(node - 1u); }
        if (place.y < plies[ply].columns) { mark_node(node + 1u); }
        if (place.x > 0u) { mark_node(node - scene.columns - 1u); }
        if (place.x < plies[ply].rows) { mark_node(node + scene.columns + 1u); }
    }
}

@compute @workgroup_size(64)
fn node_update(id: Invocation) {
    shot = shots[id.group.z];
    let number = invocation_number(id);
    if (number >= scene.shot_nodes || step.index > atomicLoad(&status[counter(BAD_STEP)])) { return; }
    body = bodies[shot.number];
    let node = first_node() + number;
    let n = scene.nodes;
    let ply = node_ply(node);
    let place = node_place(node);
    if (!is_node(ply, place)) { return; }
    let lies = reference(ply, place);
    let in_pack = to_pack(ply, lies);
    if (!in_reach(reach_of(ply), place)) {
        if (PROJECTILE) { mark(node, in_pack, vec3<f32>(0.0), 0.0, plies[ply].depth); }
        return;
    }
    let force = gather(node, place);
    let inverse = inverse_mass(ply, place);
    let u = node_vector(0u, node);
    let v = node_vector(3u, node) + step.kick * force * inverse;
    let moved = u + scene.dt * v;
    for (var a = 0u; a < 3u; a++) {
        nodes[a * n + node] = moved[a];
        nodes[(3u + a) * n + node] = v[a];
    }
    let square = dot(v, v);
    if (!finite(square)) { atomicMin(&status[counter(BAD_STEP)], step.index); }
    if (held(ply, place) != 0u) { add_support(ply, place, select(vec3<f32>(0.0), -step.kick * force, inverse <= vec3<f32>(0.0))); }
    if (PROJECTILE) { mark(node, in_pack, to_pack(ply, u), sqrt(square), plies[ply].depth); }
}
