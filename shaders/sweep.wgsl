// sweep: a step of the fabric, tile by tile: forces of the elements, then kick and drift of the nodes between them. A tile also computes the
// elements along its lower left sides, which other tiles own, so that no force leaves it.
//   in/out  nodes       array<f32>  (2, 6, N)   displacement [m], velocity [m/s], by slots
//   in/out  cells       array<u32>              elements, by slots, see `cells`
//   in/out  tiles       array<f32>  (T, 14)     sums of the owned elements and nodes
//   in/out  status      array<u32>              counters
//   out     events      array<Event>            yarn failures
//   in/out  supports    array<f32>  (S, 3)      impulse of the supports since the last sample [N·s], nodes of the rim
//   in      bodies      array<Body>             the projectiles
//   out     candidates  array<u32>              a bit per node, then a bit per word of these
// Twin: src/solver/sweep.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read_write> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> tiles: array<f32>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> events: array<Event>;
@group(1) @binding(5) var<storage, read_write> supports: array<f32>;
@group(1) @binding(6) var<storage, read> bodies: array<Body>;
@group(1) @binding(7) var<storage, read_write> candidates: array<atomic<u32>>;

/// Elements along a side of a tile, nodes, and invocations.
const SIDE: u32 = 16u;
const NODES: u32 = 17u;
const INVOCATIONS: u32 = 256u;
/// First steps, which compute everything: after them an element at rest has the same words in each slot for ever.
const SETTLED: u32 = 4u;

/// Nodes of the tile, shape (6, 17, 17); then forces of its elements, shape (9, 16, 16); then sums, shape (12, 16, 16).
var<workgroup> tile: array<f32, 3072>;
/// Nodes of the ply that may have moved; `NONE` after a bad step.
var<workgroup> tile_reach: vec4<u32>;
/// Bits of the largest residual, and cells that did not meet it.
var<workgroup> worst: atomic<u32>;
var<workgroup> open_cells: atomic<u32>;

/// Vector of a node of the tile, from its first field on.
fn tile_vector(field: u32, at: u32) -> vec3<f32> {
    let first = field * NODES * NODES + at;
    return vec3<f32>(tile[first], tile[first + NODES * NODES], tile[first + 2u * NODES * NODES]);
}

/// Values of a node of the tile and the three that close its element.
fn tile_differences(field: u32, at: u32) -> Differences {
    return differences(
        tile_vector(field, at), tile_vector(field, at + 1u), tile_vector(field, at + NODES + 1u), tile_vector(field, at + NODES));
}

/// Loads the nodes of the tile; `corner`: place of the first, which may lie beyond the edge.
fn load_nodes(ply: u32, corner: vec2<u32>, local: u32) {
    for (var at = local; at < NODES * NODES; at += INVOCATIONS) {
        let place = corner + vec2<u32>(at / NODES, at % NODES);
        let there = is_node(ply, place);
        let node = node_at(ply, place);
        for (var field = 0u; field < 6u; field++) {
            var value = 0.0;
            if (there) { value = nodes[node_word(slot_before(), field, node)]; }
            tile[field * NODES * NODES + at] = value;
        }
    }
}

/// Whether an element has a corner that moves.
fn is_computed(ply: u32, place: vec2<u32>, reach: vec4<u32>) -> bool {
    let moves = in_reach(reach, place) || in_reach(reach, place + vec2<u32>(0u, 1u))
        || in_reach(reach, place + vec2<u32>(1u, 0u)) || in_reach(reach, place + vec2<u32>(1u, 1u));
    return is_element(ply, place) && (step.index < SETTLED || moves);
}

/// Internal force on the node at the lower left corner of an element of the tile [N], in fixed order.
fn gather(local: u32) -> vec3<f32> {
    let first = corner_force(local, 1.0, 1.0, -1.0);
    let second = corner_force(local - 1u, -1.0, 1.0, 1.0);
    let third = corner_force(local - SIDE - 1u, 1.0, 1.0, 1.0);
    let fourth = corner_force(local - SIDE, 1.0, -1.0, 1.0);
    return (first + second) + (fourth - third);
}

fn tile_force(field: u32, at: u32) -> vec3<f32> {
    let first = field * INVOCATIONS + at;
    return vec3<f32>(tile[first], tile[first + INVOCATIONS], tile[first + 2u * INVOCATIONS]);
}

/// Force of one element [N] with the signs of the corner it has at a node.
fn corner_force(at: u32, warp: f32, weft: f32, mode: f32) -> vec3<f32> {
    let membrane = warp * tile_force(0u, at) + weft * tile_force(3u, at);
    if (!HOURGLASS) { return membrane; }
    return membrane + mode * tile_force(6u, at);
}

/// Adds the sums of all invocations to those of the tile, in fixed order.
fn add_up(first_sum: u32, local: u32) {
    let count = select(ALWAYS, TENSION, SAMPLED);
    workgroupBarrier();
    for (var i = 0u; i < count; i++) { tile[i * INVOCATIONS + local] = part[i]; }
    workgroupBarrier();
    let which = local / SIDE;
    let first = which * INVOCATIONS + local % SIDE;
    if (which < count) {
        var sum = tile[first];
        for (var i = SIDE; i < INVOCATIONS; i += SIDE) {
            sum = joined(which, sum, tile[first + i]);
        }
        tile[first] = sum;
    }
    workgroupBarrier();
    if (local < count) {
        var sum = tiles[first_sum + local];
        for (var i = 0u; i < SIDE; i++) { sum = joined(local, sum, tile[local * INVOCATIONS + i]); }
        tiles[first_sum + local] = sum;
    }
    if (local == 0u) {
        let most = atomicLoad(&worst);
        if (most > atomicLoad(&status[counter(RESIDUAL)])) { atomicMax(&status[counter(RESIDUAL)], most); }
        let count = atomicLoad(&open_cells);
        if (count > 0u) { atomicAdd(&status[counter(UNCONVERGED)], count); }
    }
}

@compute @workgroup_size(256)
fn sweep(id: Invocation) {
    shot = shots[id.group.z];
    body = bodies[shot.number];
    let local = id.local;
    let number = id.group.y * id.groups.x + id.group.x;
    let ply = number / (scene.tile_rows * scene.tile_columns);
    if (ply >= scene.plies || plies[min(ply, scene.plies - 1u)].ply_type != scene.ply_type) { return; }
    let row = (number / scene.tile_columns) % scene.tile_rows;
    let column = number % scene.tile_columns;
    if (local == 0u) {
        let sound = step.index <= atomicLoad(&status[counter(BAD_STEP)]);
        tile_reach = select(vec4<u32>(NONE), reach_of(ply), sound);
    }
    let reach = workgroupUniformLoad(&tile_reach);
    if (reach.w == NONE) { return; }
    // Elements of the first row and column belong to other tiles; at the edge of a ply there are none, and their numbers wrap around.
    let corner = (SIDE - 1u) * vec2<u32>(row, column) - vec2<u32>(1u);
    let place = corner + vec2<u32>(local / SIDE, local % SIDE);
    let own = local >= SIDE && local % SIDE > 0u;
    let own_node = own && is_node(ply, place);
    let moves = own_node && in_reach(reach, place);
    let low = corner + vec2<u32>(1u);
    let rests = reach.x >= reach.y || low.x > reach.y || low.x + SIDE < reach.x || low.y > reach.w || low.y + SIDE < reach.z;
    if (rests && step.index >= SETTLED) {
        if (PROJECTILE && own_node) { mark(ply, place, vec3<f32>(0.0), 0.0); }
        return;
    }
    load_nodes(ply, corner, local);
    workgroupBarrier();
    let at = (local / SIDE) * NODES + local % SIDE;
    var forces = ElementForces();
    if (is_computed(ply, place, reach)) {
        let counted = own && element_in_reach(reach, place);
        forces = element_step(ply, place, tile_differences(0u, at), tile_differences(3u, at), own, counted);
        if (SAMPLED && own && forces.stood) {
            let z = 2u * NODES * NODES + at;
            part[DEFLECTION] = max(
                max(abs(tile[z]), abs(tile[z + 1u])), max(abs(tile[z + NODES]), abs(tile[z + NODES + 1u])));
        }
    }
    let u = tile_vector(0u, at);
    let v = tile_vector(3u, at);
    workgroupBarrier();
    for (var a = 0u; a < 3u; a++) {
        tile[a * INVOCATIONS + local] = forces.warp[a];
        tile[(3u + a) * INVOCATIONS + local] = forces.weft[a];
        tile[(6u + a) * INVOCATIONS + local] = forces.mode[a];
    }
    workgroupBarrier();
    if (moves) {
        move_node(ply, place, u, v, gather(local));
    } else if (PROJECTILE && own_node) {
        mark(ply, place, vec3<f32>(0.0), 0.0);
    }
    add_up(tile_sum(ply, row * scene.tile_columns + column, 0u), local);
}
