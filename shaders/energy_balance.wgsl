// energy_balance: sums of energy, momentum and counts over the pack at the end of a step, and the state of the projectile.
//   in/out  nodes     array<f32>           displacement [m], velocity [m/s], by slots; what clay took, from 0 again
//   in      cells     array<u32>           elements, see `cells`
//   in/out  tiles     array<f32>  (T, 14)  sums of the tiles, from 0 again
//   in/out  contact_work  array<f32>  (5, N)   of contact between plies, since the last sample: lost, lost to friction, work of moving nodes
//                                          out of other plies, work on the elements; that in the half step after the positions, of this
//                                          step; from 0 again [J]
//   in/out  supports  array<f32>  (3, N)   impulse of the supports, from 0 again [N·s]
//   in/out  bodies    array<Body>          their sums begin at 0 again
//   in      status    array<u32>           counters
//   out     samples   array<u32>  (slots, shots that run, groups·28 + 73)
// Twin: src/solver/energy_balance.rs

@group(1) @binding(0) var<storage, read_write> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> tiles: array<f32>;
@group(1) @binding(3) var<storage, read_write> contact_work: array<f32>;
@group(1) @binding(4) var<storage, read_write> supports: array<f32>;
@group(1) @binding(5) var<storage, read_write> bodies: array<array<vec4<u32>, 15>>;
@group(1) @binding(6) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(7) var<storage, read_write> samples: array<u32>;

/// Words of the body; fours of them: orientation, impulse, support and energy, place of the nose.
const BODY_WORDS: u32 = 60u;
const BODY_ORIENTATION: u32 = 3u;
const BODY_SUMS: u32 = 10u;
const BODY_NOSE: u32 = 13u;

var<workgroup> sums: array<f32, 1820>; // 28 sums of 64 parts, in rows of 65

/// Whether a point lies ahead of the body's widest section, or of the faces of its chisel nose, and within its shadow.
fn ahead(arm: vec3<f32>) -> bool {
    let local = rotate_back(body.orientation, arm);
    return axis_distance(local) < scene.body_radius && scene.body_shoulder < local.z + recess(local);
}

fn arm_to(node: u32) -> vec3<f32> {
    let ply = node_ply(node);
    let lies = to_pack(ply, reference(ply, node_place(node)));
    return arm_of(body.nose_coarse, body.nose_fine, lies, to_pack(ply, node_vector(0u, node)));
}

/// The first, and one past the last, of the elements of a ply along X (0) or Y (1) that lie within `span` finest cells of one.
fn within(ply: u32, axis: u32, along: u32) -> vec2<u32> {
    let span = plies[ply].span;
    let count = select(plies[ply].rows, plies[ply].columns, axis == 0u);
    if (!GRADED) { return vec2<u32>(along - min(along, span), min(along + span + 1u, count)); }
    // A part of an element counts.
    var first = along;
    for (var left = f32(span); left > WITHIN && first > 0u; left -= line_at(ply, axis, first).width) { first -= 1u; }
    var end = along + 1u;
    for (var left = f32(span); left > WITHIN && end < count; left -= line_at(ply, axis, end - 1u).width) { end += 1u; }
    return vec2<u32>(first, end);
}

/// Whether a yarn (1 warp, 2 weft) of an element is unbroken there and for `span` cells on either side, or to the edge of
/// the ply.
fn runs_on(ply: u32, place: vec2<u32>, yarn: u32) -> bool {
    let warp = yarn == 1u;
    let along = select(place.x, place.y, warp);
    let pieces = within(ply, select(1u, 0u, warp), along);
    for (var at = pieces.x; at < pieces.y; at++) {
        let cell = select(vec2<u32>(at, place.y), vec2<u32>(place.x, at), warp);
        if ((yarns_left(element_at(ply, cell)) & yarn) == 0u && is_present(ply, cell)) { return false; }
    }
    return true;
}

/// Whether an element lies ahead of the body and has a yarn that runs on unbroken on both sides.
fn covers(ply: u32, element: u32) -> bool {
    let at = corners(element);
    let a = arm_to(at.x);
    // An element with a corner further away is not looked at any closer.
    let place = element_place(element);
    let size = cell_size(ply, place);
    let far = scene.body_radius + 2.0 * (size.x + size.y);
    if (yarns_left(element) == 0u || axis_distance(rotate_back(body.orientation, a)) >= far) { return false; }
    let b = arm_to(at.y);
    let c = arm_to(at.z);
    let d = arm_to(at.w);
    return (ahead(a) || ahead(b) || ahead(c) || ahead(d) || ahead(0.25 * ((a + b) + (c + d))))
        && (runs_on(ply, place, 1u) || runs_on(ply, place, 2u));
}

/// The body and the counters after the sums; the body's own sums begin anew.
fn finish(first: u32) {
    let n = shot.number;
    for (var i = 0u; i < BODY_WORDS; i++) { samples[first + i] = bodies[n][i / 4u][i % 4u]; }
    for (var i = 0u; i < STATUS_WORDS; i++) { samples[first + BODY_WORDS + i] = atomicLoad(&status[counter(i)]); }
    for (var i = BODY_SUMS; i < BODY_SUMS + 2u; i++) { bodies[n][i] = vec4<u32>(0u); }
    bodies[n][BODY_SUMS + 2u] = vec4<u32>(0u, 0u, 0u, bodies[n][BODY_SUMS + 2u].w);
}

/// Adds what a tile has, which begins anew.
fn add_tile(first: u32) {
    for (var which = 0u; which < TILE_SUMS; which++) {
        part[which] = joined(which, part[which], tiles[first + which]);
        tiles[first + which] = 0.0;
    }
}

/// Adds what a node has.
fn add_node(ply: u32, node: u32, place: vec2<u32>) {
    let n = scene.nodes;
    let v = node_vector(3u, node);
    let mass = node_mass(ply, place);
    let square = dot(v, v);
    part[KINETIC] += 0.5 * mass * square;
    part[FASTEST] = max(part[FASTEST], square);
    let momentum = mass * to_pack(ply, v);
    for (var a = 0u; a < 3u; a++) { part[MOMENTUM + a] += momentum[a]; }
    if (held(ply, place) != 0u || has_clay(ply)) {
        for (var a = 0u; a < 3u; a++) {
            part[SUPPORT + a] += supports[a * n + node];
            supports[a * n + node] = 0.0;
        }
    }
    if (has_clay(ply)) {
        part[CLAY_DEPTH] = max(part[CLAY_DEPTH], nodes[clay_word(CRATER, node)]);
        part[CLAY_WORK] += nodes[clay_word(INTO_CLAY, node)];
        nodes[clay_word(INTO_CLAY, node)] = 0.0;
    }
    if (scene.plies > 1u) {
        for (var i = 0u; i < 3u; i++) { part[PLY_LOSS + i] += contact_work[i * n + node]; }
        part[WORK] += contact_work[3u * n + node];
        part[HALF_STEP] += contact_work[4u * n + node];
        for (var i = 0u; i < 5u; i++) { contact_work[i * n + node] = 0.0; }
    }
}

@compute @workgroup_size(64)
fn energy_balance(id: Invocation) {
    shot = shots[id.group.z];
    body.orientation = bitcast<vec4<f32>>(bodies[shot.number][BODY_ORIENTATION]);
    body.nose_coarse = bitcast<vec4<i32>>(bodies[shot.number][BODY_NOSE]);
    body.nose_fine = bitcast<vec4<i32>>(bodies[shot.number][BODY_NOSE + 1u]);
    // Each ply has as many workgroups, so that their sums are those of a ply.
    let share = scene.groups / scene.plies;
    let ply = id.group.x / share;
    let begin = (id.group.x % share) * GROUP + id.local;
    let stride = share * GROUP;
    let first = (step.slot * id.groups.z + id.group.z) * (scene.groups * SUMS + BODY_WORDS + STATUS_WORDS);
    let ply_elements = scene.rows * scene.columns;
    for (var i = begin; i < ply_elements; i += stride) {
        let element = ply_number(ply) * ply_elements + i;
        if (has_projectile() && is_element(ply, element_place(element))) { part[COVERED] += select(0.0, 1.0, covers(ply, element)); }
    }
    for (var tile = begin; tile < tile_counts().x * tile_counts().y; tile += stride) { add_tile(tile_sum(ply, tile, 0u)); }
    let ply_nodes = (scene.rows + 1u) * (scene.columns + 1u);
    for (var i = begin; i < ply_nodes; i += stride) {
        let node = ply_number(ply) * ply_nodes + i;
        let place = node_place(node);
        if (!is_node(ply, place)) { continue; }
        add_node(ply, node, place);
    }
    for (var i = 0u; i < SUMS; i++) { sums[i * 65u + id.local] = part[i]; }
    workgroupBarrier();
    for (var bit = 6u; bit > 0u; bit--) {
        let reach = 1u << (bit - 1u);
        for (var at = id.local; at < SUMS * reach; at += GROUP) {
            let which = at >> (bit - 1u);
            let place = which * 65u + (at & (reach - 1u));
            sums[place] = joined(which, sums[place], sums[place + reach]);
        }
        workgroupBarrier();
    }
    if (id.local < SUMS) { samples[first + id.group.x * SUMS + id.local] = bitcast<u32>(sums[id.local * 65u]); }
    if (id.group.x == 0u && id.local == 0u) { finish(first + scene.groups * SUMS); }
}
