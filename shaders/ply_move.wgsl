// ply_move: gives the nodes the impulses of contact between plies.
//   in/out  nodes     array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in      cells     array<u32>           elements, see `cells`
//   in/out  shares    array<u32>  (N)      contacts of a node, by weight; from 0 again
//   in/out  impulses  array<i32>  (N, 6)   counted impulses; from 0 again
//   in/out  contact_work  array<f32>  (5, N)   see `energy_balance`
//   in/out  supports  array<f32>  (3, N)   impulse of the supports since the last sample [N·s]
//   in/out  status    array<u32>           counters
// Twin: src/solver/contact/ply_move.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> shares: array<u32>;
@group(1) @binding(3) var<storage, read_write> impulses: array<i32>;
@group(1) @binding(4) var<storage, read_write> contact_work: array<f32>;
@group(1) @binding(5) var<storage, read_write> supports: array<f32>;
@group(1) @binding(6) var<storage, read_write> status: array<atomic<u32>>;

/// A node's sum in the axes of its ply [N·s], and 0 in its place.
fn take(ply: u32, at: u32, unit: f32) -> vec3<f32> {
    let count = vec3<f32>(f32(impulses[at]), f32(impulses[at + 1u]), f32(impulses[at + 2u]));
    for (var a = 0u; a < 3u; a++) { impulses[at + a] = 0; }
    return to_ply(ply, count * unit);
}

/// Forces of shock viscosity on the node at a place from an element [N], with the signs of the corner it has there.
fn corner_viscous(ply: u32, place: vec2<u32>, there: bool, warp: f32, weft: f32) -> vec3<f32> {
    if (!there) { return vec3<f32>(0.0); }
    let size = geometry_of(ply, place);
    let at = corners(element_at(ply, place));
    let slot = slot_before();
    let k = kinematics(size, differences(
        vector_in(slot, 0u, at.x), vector_in(slot, 0u, at.y), vector_in(slot, 0u, at.z), vector_in(slot, 0u, at.w)));
    let drag = yarn_pair(slot_now(), DRAG, element_at(ply, place));
    return (warp * drag.x * size.membrane.x) * k.warp + (weft * drag.y * size.membrane.y) * k.weft;
}

/// Shock viscosity's part of the internal force on a node [N].
fn viscous_force(ply: u32, place: vec2<u32>) -> vec3<f32> {
    if (!VISCOUS) { return vec3<f32>(0.0); }
    let there = adjacent_elements(ply, place);
    let left = place - vec2<u32>(0u, 1u);
    let below = place - vec2<u32>(1u, 0u);
    return (corner_viscous(ply, place, there.x, 1.0, 1.0) + corner_viscous(ply, left, there.y, -1.0, 1.0))
        - (corner_viscous(ply, left - vec2<u32>(1u, 0u), there.z, 1.0, 1.0) + corner_viscous(ply, below, there.w, -1.0, 1.0));
}

@compute @workgroup_size(64)
fn ply_move(id: Invocation) {
    shot = shots[id.group.z];
    let number = invocation_number(id);
    if (number >= scene.shot_nodes || step.index > atomicLoad(&status[counter(BAD_STEP)])) { return; }
    let node = first_node() + number;
    if (shares[node] == 0u) { return; }
    shares[node] = 0u;
    let n = scene.nodes;
    let ply = node_ply(node);
    let place = node_place(node);
    let unit = shot.impulse_unit * f32(1u << count_shift(ply, place));
    let impulse = take(ply, 6u * node, unit);
    let shift = take(ply, 6u * node + 3u, unit);
    if (all(impulse == vec3<f32>(0.0)) && all(shift == vec3<f32>(0.0))) { return; }
    touch(ply, place);
    let inverse = inverse_mass(ply, place);
    let u = node_vector(0u, node);
    let free = node_vector(3u, node);
    let before = velocity_before(ply, node);
    let change = inverse * impulse;
    let now = free + change;
    let way = scene.dt * inverse * shift;
    let moved = u + (scene.dt * change + way);
    for (var a = 0u; a < 3u; a++) {
        nodes[node_word(slot_now(), a, node)] = moved[a];
        nodes[node_word(slot_now(), 3u + a, node)] = now[a];
    }
    contact_work[node] -= 0.5 * dot(impulse, before + now);
    let force = node_mass(ply, place) / step.kick * (free - before);
    if (any(way != vec3<f32>(0.0))) {
        // Viscosity sees velocities alone: against it nothing is stored, and nothing dissipated.
        contact_work[2u * n + node] -= dot(force - viscous_force(ply, place), way);
    }
    let half = -0.5 * scene.dt * dot(force, change);
    contact_work[3u * n + node] += half;
    if (is_sampled()) { contact_work[4u * n + node] = half; }
    if (held(ply, place) != 0u) { add_support(ply, place, -select(vec3<f32>(0.0), impulse, inverse <= vec3<f32>(0.0))); }
}
