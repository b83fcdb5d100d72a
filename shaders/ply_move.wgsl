// ply_move: gives the nodes the impulses of contact between plies.
//   in/out  nodes     array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in      forces    array<f32>  (9, E)   P1·Ly/2, P2·Lx/2, force on the difference of opposite edges [N]
//   in/out  shares    array<u32>  (N)      contacts of a node, by weight; from 0 again
//   in/out  impulses  array<i32>  (N, 6)   counted impulses; from 0 again
//   in/out  accumulators  array<f32>           see `energy_balance`
//   in/out  supports  array<f32>  (S, 3)   impulse of the supports since the last sample [N·s], nodes of the rim
//   in/out  status    array<u32>           counters
//   in      yarns     array<f32>           viscous forces of warp and weft [N], see `element_force`
// Twin: src/solver/contact/ply_impulse.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> shares: array<u32>;
@group(1) @binding(3) var<storage, read_write> impulses: array<i32>;
@group(1) @binding(4) var<storage, read_write> accumulators: array<f32>;
@group(1) @binding(5) var<storage, read_write> supports: array<f32>;
@group(1) @binding(6) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(7) var<storage, read> yarns: array<f32>;

/// A node's sum in the axes of its ply [N·s], and 0 in its place.
fn take(ply: u32, at: u32, unit: f32) -> vec3<f32> {
    let count = vec3<f32>(f32(impulses[at]), f32(impulses[at + 1u]), f32(impulses[at + 2u]));
    for (var a = 0u; a < 3u; a++) { impulses[at + a] = 0; }
    return to_ply(ply, count * unit);
}

/// Shock viscosity's part of the force of a yarn (0 warp, 1 weft) of an element [N]. It is taken along the whole force, which trellis
/// shear turns a little away from the yarn.
fn viscous_part(element: u32, yarn: u32, size: f32) -> vec3<f32> {
    let force = element_forces(3u * yarn, element);
    let whole = sqrt(dot(force, force));
    return force * (yarns[yarn * scene.elements + element] * size / max(whole, 1e-30));
}

/// Shock viscosity's part of the force of one element [N], with the signs of the corner it has at this node; `there` is false beyond the edge.
fn corner_viscous(element: u32, there: bool, warp: f32, weft: f32) -> vec3<f32> {
    if (!there) { return vec3<f32>(0.0); }
    let size = geometry_of(element);
    return warp * viscous_part(element, 0u, size.membrane_warp) + weft * viscous_part(element, 1u, size.membrane_weft);
}

/// Shock viscosity's part of the internal force on a node [N].
fn viscous_force(node: u32, place: vec2<u32>) -> vec3<f32> {
    if (!VISCOUS) { return vec3<f32>(0.0); }
    let there = adjacent_elements(node_ply(node), place);
    let e = element_above(node, place);
    let above = corner_viscous(e, there.x, 1.0, 1.0) + corner_viscous(e - 1u, there.y, -1.0, 1.0);
    let below = corner_viscous(e - scene.columns - 1u, there.z, 1.0, 1.0) + corner_viscous(e - scene.columns, there.w, -1.0, 1.0);
    return above - below;
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
    let force = gather(node, place);
    let pull = step.kick * force * inverse;
    let u = node_vector(0u, node);
    let free = node_vector(3u, node);
    let change = inverse * impulse;
    let now = free + change;
    let way = scene.dt * inverse * shift;
    let moved = u + (scene.dt * change + way);
    for (var a = 0u; a < 3u; a++) {
        nodes[a * n + node] = moved[a];
        nodes[(3u + a) * n + node] = now[a];
    }
    let at = 10u * scene.elements + node;
    accumulators[at] -= 0.5 * dot(impulse, (free - pull) + now);
    if (any(way != vec3<f32>(0.0))) {
        // Viscosity sees velocities alone: against it nothing is stored, and nothing dissipated.
        accumulators[at + 2u * n] -= dot(force - viscous_force(node, place), way);
    }
    if (held(ply, place) != 0u) { add_support(ply, place, -select(vec3<f32>(0.0), impulse, inverse <= vec3<f32>(0.0))); }
}
