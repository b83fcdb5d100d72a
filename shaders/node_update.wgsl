// node_update: gather of element forces, kick and drift of every node; marks the nodes that may meet the projectile.
//   in/out  nodes       array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in      forces      array<f32>  (9, E)   P1·Ly/2, P2·Lx/2, hourglass per corner [N]
//   in/out  supports    array<f32>  (S, 3)   impulse of the supports since the last ledger [N·s], nodes of the rim
//   in/out  status      array<u32>           counters
//   in      body        Body                 the projectile
//   out     candidates  array<u32>           a bit per node, then a bit per word of these
// Twin: src/kernels/node_update.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> supports: array<f32>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read> body: Body;
@group(1) @binding(5) var<storage, read_write> candidates: array<atomic<u32>>;

/// Number of a node of a ply's rim.
fn rim_index(node: u32, place: vec2<u32>) -> u32 {
    let across = scene.columns + 1u;
    let along = scene.rows + 1u;
    let first = (node / across) / along * 2u * (across + along);
    if (place.x == 0u) {
        return first + place.y;
    }
    if (place.x == scene.rows) {
        return first + across + place.y;
    }
    return first + 2u * across + select(along, 0u, place.y == 0u) + place.x;
}

/// Marks a node that may touch the body within the step: no further from the box around it than both can go.
fn mark(node: u32, reference: vec3<f32>, displacement: vec3<f32>, speed: f32) {
    let room = 1.01 * scene.dt * (speed + 1.1 * body.velocity.w) + 1e-6 * scene.body_reach;
    let local = rotate_back(body.orientation, arm_of(body.nose_coarse, body.nose_fine, reference, displacement));
    let gap = max(axis_distance(local) - scene.body_radius, max(local.z, scene.body_back - local.z));
    if (gap > room) {
        return;
    }
    let word = node >> 5u;
    let words = (scene.nodes + 31u) >> 5u;
    atomicOr(&candidates[word], 1u << (node & 31u));
    atomicOr(&candidates[words + (word >> 5u)], 1u << (word & 31u));
}

@compute @workgroup_size(64)
fn node_update(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let node = step.first_node + invocation(group, groups, local);
    if (node >= step.end_node || step.index > atomicLoad(&status[BAD_STEP])) {
        return;
    }
    let n = scene.nodes;
    let place = node_place(node);
    let force = gather(node, place);
    let inverse = inverse_mass(place);
    let u = vec3<f32>(nodes[node], nodes[n + node], nodes[2u * n + node]);
    let v = vec3<f32>(nodes[3u * n + node], nodes[4u * n + node], nodes[5u * n + node]) + step.kick * force * inverse;
    let moved = u + scene.dt * v;
    nodes[node] = moved.x;
    nodes[n + node] = moved.y;
    nodes[2u * n + node] = moved.z;
    nodes[3u * n + node] = v.x;
    nodes[4u * n + node] = v.y;
    nodes[5u * n + node] = v.z;
    let square = dot(v, v);
    if (!finite(square)) {
        atomicMin(&status[BAD_STEP], step.index);
    }
    if (held(place) != 0u) {
        let impulse = select(vec3<f32>(0.0), -step.kick * force, inverse <= vec3<f32>(0.0));
        let at = 3u * rim_index(node, place);
        supports[at] += impulse.x;
        supports[at + 1u] += impulse.y;
        supports[at + 2u] += impulse.z;
    }
    if (PROJECTILE) {
        mark(node, reference(place), u, sqrt(square));
    }
}
