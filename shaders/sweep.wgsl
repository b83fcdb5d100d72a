// sweep: a step of the fabric, tile by tile: forces of the elements, then kick and drift of the nodes between them. A tile also computes the
// elements along its lower left sides, which other tiles own, so that no force leaves it.
//   in/out  nodes       array<f32>  (2, 6, N)   displacement [m], velocity [m/s], by slots
//   in/out  cells       array<u32>              elements, by slots, see `cells`
//   in/out  tiles       array<f32>  (T, 14)     sums of the owned elements and nodes
//   in/out  status      array<u32>              counters
//   out     events      array<Event>            yarn failures
//   in/out  supports    array<f32>  (3, N)      impulse of the supports since the last sample [N·s]
//   in      bodies      array<Body>             the projectiles
//   out     candidates  array<u32>              a bit per node
// Twin: src/solver/sweep.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read_write> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> tiles: array<f32>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> events: array<Event>;
@group(1) @binding(5) var<storage, read_write> supports: array<f32>;
@group(1) @binding(6) var<storage, read> bodies: array<Body>;
@group(1) @binding(7) var<storage, read_write> candidates: array<atomic<u32>>;

/// Elements and nodes along a row of a tile, and all of its nodes.
fn side() -> u32 { return INVOCATIONS / TILE_ROWS; }
fn across() -> u32 { return side() + 1u; }
fn all_nodes() -> u32 { return (TILE_ROWS + 1u) * across(); }
/// First steps, which compute everything: after them the words of an element at rest no longer change in either slot.
const SETTLED: u32 = 4u;

/// Displacements and velocities of the nodes of the tile, shape (2, `all_nodes`); then forces of its elements, shape (3, 256); then sums, the same.
var<workgroup> tile: array<vec4<f32>, 768>;
/// Nodes of the ply that may have moved; `NONE` after a bad step.
var<workgroup> tile_reach: vec4<u32>;
/// Bits of the largest residual, and cells that did not meet it.
var<workgroup> worst: atomic<u32>;
var<workgroup> open_cells: atomic<u32>;

/// Displacements (0) or velocities (1) of a node of the tile and the three that close its element.
fn tile_differences(field: u32, node: u32) -> Differences {
    let at = field * all_nodes() + node;
    return differences(tile[at].xyz, tile[at + 1u].xyz, tile[at + across() + 1u].xyz, tile[at + across()].xyz);
}

/// Loads the nodes of the tile; `corner`: place of the first, which may lie beyond the edge.
fn load_nodes(ply: u32, corner: vec2<u32>, local: u32) {
    for (var at = local; at < all_nodes(); at += INVOCATIONS) {
        let place = corner + vec2<u32>(at / across(), at % across());
        var u = vec3<f32>(0.0);
        var v = vec3<f32>(0.0);
        if (is_node(ply, place)) {
            u = vector_in(slot_before(), 0u, node_at(ply, place));
            v = vector_in(slot_before(), 3u, node_at(ply, place));
        }
        tile[at] = vec4<f32>(u, 0.0);
        tile[all_nodes() + at] = vec4<f32>(v, 0.0);
    }
}

/// Internal force on the node at the lower left corner of an element of the tile [N], in fixed order.
fn gather(local: u32) -> vec3<f32> {
    let first = corner_force(local, 1.0, 1.0, -1.0);
    let second = corner_force(local - 1u, -1.0, 1.0, 1.0);
    let third = corner_force(local - side() - 1u, 1.0, 1.0, 1.0);
    let fourth = corner_force(local - side(), 1.0, -1.0, 1.0);
    return (first + second) + (fourth - third);
}

/// Force of one element [N] with the signs of the corner it has at a node.
fn corner_force(at: u32, warp: f32, weft: f32, mode: f32) -> vec3<f32> {
    return warp * tile[at].xyz + weft * tile[INVOCATIONS + at].xyz + mode * tile[2u * INVOCATIONS + at].xyz;
}

/// Four numbers of an invocation or a tile added to four others; of deflections the larger.
fn joined_four(which: u32, a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(a.xyz + b.xyz, joined(4u * which + 3u, a.w, b.w));
}

/// Adds the sums of all invocations to those of the tile, in fixed order.
fn add_up(first_sum: u32, local: u32) {
    let count = select(2u, 3u, is_sampled());
    workgroupBarrier();
    for (var i = 0u; i < count; i++) {
        tile[i * INVOCATIONS + local] = vec4<f32>(part[4u * i], part[4u * i + 1u], part[4u * i + 2u], part[4u * i + 3u]);
    }
    workgroupBarrier();
    let which = local / side();
    if (which < count) {
        let first = which * INVOCATIONS + local % side();
        var sum = tile[first];
        for (var i = side(); i < INVOCATIONS; i += side()) { sum = joined_four(which, sum, tile[first + i]); }
        tile[first] = sum;
    }
    workgroupBarrier();
    if (local < count) {
        var sum = tile[local * INVOCATIONS];
        for (var i = 1u; i < side(); i++) { sum = joined_four(local, sum, tile[local * INVOCATIONS + i]); }
        for (var i = 0u; i < 4u; i++) {
            let at = first_sum + 4u * local + i;
            tiles[at] = joined(4u * local + i, tiles[at], sum[i]);
        }
    }
    if (local == 0u) {
        let most = atomicLoad(&worst);
        if (most > atomicLoad(&status[counter(RESIDUAL)])) { atomicMax(&status[counter(RESIDUAL)], most); }
        let count = atomicLoad(&open_cells);
        if (count > 0u) { atomicAdd(&status[counter(UNCONVERGED)], count); }
    }
}

@compute @workgroup_size(256)
fn sweep(
    @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>, @builtin(local_invocation_index) local: u32,
) {
    // No `Invocation`: one that has `local` in it does not count as the same for all invocations, and a barrier must.
    shot = shots[group.z];
    body = bodies[shot.number];
    let number = group.y * groups.x + group.x;
    let counts = tile_counts();
    let ply = number / (counts.x * counts.y);
    if (ply >= scene.plies || plies[ply].ply_type != scene.ply_type) { return; }
    let at_tile = vec2<u32>((number / counts.y) % counts.x, number % counts.y);
    if (local == 0u) {
        let sound = step.index <= atomicLoad(&status[counter(BAD_STEP)]);
        tile_reach = select(vec4<u32>(NONE), reach_of(ply), sound);
    }
    let reach = workgroupUniformLoad(&tile_reach);
    if (reach.w == NONE) { return; }
    // Elements of the first row and column belong to other tiles; at the edge of a ply there are none, and their numbers wrap around.
    let low = owned_sides() * at_tile;
    let corner = low - vec2<u32>(1u);
    let place = corner + vec2<u32>(local / side(), local % side());
    let own = local >= side() && local % side() > 0u;
    let own_node = own && is_node(ply, place);
    let moves = own_node && is_near(reach, place, 1u, 1u);
    let rests = reach.x >= reach.y || low.x > reach.y || low.x + TILE_ROWS < reach.x || low.y > reach.w || low.y + side() < reach.z;
    if (rests && step.index >= SETTLED) {
        if (has_projectile() && own_node) { mark(ply, place, vec3<f32>(0.0), 0.0); }
        return;
    }
    load_nodes(ply, corner, local);
    workgroupBarrier();
    let at = (local / side()) * across() + local % side();
    var forces = ElementForces();
    if (is_element(ply, place) && (step.index < SETTLED || is_near(reach, place, 2u, 1u))) {
        let counted = own && (step.index == 0u || is_near(reach, place, 1u, 0u));
        forces = element_step(ply, place, tile_differences(0u, at), tile_differences(1u, at), own, counted);
        if (is_sampled() && own && forces.stood) {
            let z = vec4<f32>(tile[at].z, tile[at + 1u].z, tile[at + across()].z, tile[at + across() + 1u].z);
            part[DEFLECTION] = max(max(abs(z.x), abs(z.y)), max(abs(z.z), abs(z.w)));
        }
    }
    let u = tile[at].xyz;
    let v = tile[all_nodes() + at].xyz;
    workgroupBarrier();
    tile[local] = vec4<f32>(forces.warp, 0.0);
    tile[INVOCATIONS + local] = vec4<f32>(forces.weft, 0.0);
    tile[2u * INVOCATIONS + local] = vec4<f32>(forces.mode, 0.0);
    workgroupBarrier();
    if (moves) {
        move_node(ply, place, u, v, gather(local));
    } else if (has_projectile() && own_node) {
        mark(ply, place, vec3<f32>(0.0), 0.0);
    }
    add_up(tile_sum(ply, at_tile.x * counts.y + at_tile.y, 0u), local);
}
