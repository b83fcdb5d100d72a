// projectile_search: where the projectile may touch a ply of a pack, and its part in the equations of contact with what is guessed to push. A
// workgroup a ply: plies share no node, so that all but the motion of the body is known of each by itself.
//   in      nodes       array<f32>    (6, N)       displacement [m], velocity [m/s]
//   in      cells       array<u32>                 elements, see `cells`
//   in/out  status      array<u32>                 counters
//   in      bodies      array<Body>                the projectiles
//   in/out  candidates  array<u32>                 near nodes, a bit each; what did not push in the last step
//   out     points      array<Point>               nodes near it, in storage order
//   in      over        array<u32>    (2, N)       element in front of, behind a node
//   out     touches     array<Touch>               where it may touch: at those nodes, then at points of the rim
//   out     members     array<u32>                 touches that share nodes, block by block; what was found of the ply
//   out     matrix      array<f32>                 L: lower triangles of blocks by rows [√(1/kg)]
// Twin: src/solver/contact/projectile_points.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read> bodies: array<Body>;
@group(1) @binding(4) var<storage, read_write> candidates: array<atomic<u32>>;
@group(1) @binding(5) var<storage, read_write> points: array<Point>;
@group(1) @binding(6) var<storage, read> over: array<u32>;
@group(1) @binding(7) var<storage, read_write> touches: array<Touch>;
@group(1) @binding(8) var<storage, read_write> members: array<u32>;
@group(1) @binding(9) var<storage, read_write> matrix: array<f32>;

@compute @workgroup_size(WIDTH)
fn projectile_search(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    if (!take_shot(group.z, local)) { return; }
    let ply = group.x;
    if (search(ply, local)) { assemble(local); }
    if (local < 27u) { members[found_number(ply, local)] = bitcast<u32>(result[local]); }
    if (local == 0u) {
        members[found_number(ply, FOUND_POINTS)] = extent.past;
        members[found_number(ply, FOUND_CONSTRAINTS)] = extent.constraints;
        members[found_number(ply, FOUND_PENETRATION)] = atomicLoad(&penetration);
    }
}
