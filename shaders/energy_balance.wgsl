// energy_balance: sums of energy, momentum and counts over the pack at the end of a step, and the state of the projectile.
//   in      nodes     array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in      forces    array<f32>  (9, E)   P1·Ly/2, P2·Lx/2, force on the difference of opposite edges [N]
//   in/out  flags     array<u32>  (E)      evaluations are counted from 0 again
//   in/out  accumulators  array<f32>  (10, E)   since the last sample: work, released by failures, hourglass released [J];
//                                          now: stored, hourglass [J], largest yarn tension [N], deflection [m]; since the last sample:
//                                          dissipated by shock viscosity [J]; made by the unit-cell law since the start [J]; now:
//                                          largest load of a whole piece of yarn [-];
//                             then (4, N)  of contact between plies, since the last sample, see PLY_LOSS
//   in/out  supports  array<f32>  (S, 3)   impulse of the supports, from 0 again [N·s]
//   in/out  bodies    array<Body>          their sums begin at 0 again
//   in      status    array<u32>           counters
//   out     samples   array<u32>  (slots, shots that run, groups·25 + 73)
// Twin: src/solver/energy_balance.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> flags: array<u32>;
@group(1) @binding(3) var<storage, read_write> accumulators: array<f32>;
@group(1) @binding(4) var<storage, read_write> supports: array<f32>;
@group(1) @binding(5) var<storage, read_write> bodies: array<Body>;
@group(1) @binding(6) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(7) var<storage, read_write> samples: array<u32>;

/// Numbers a workgroup adds up.
const SUMS: u32 = 25u;
/// Words of the body.
const BODY_WORDS: u32 = 60u;

// The sums of `samples`.
const WORK: u32 = 0u;
const RELEASED: u32 = 1u;
const RELEASED_HOURGLASS: u32 = 2u;
const STORED: u32 = 3u;
const HOURGLASS_NOW: u32 = 4u;
const TENSION: u32 = 5u;
const DEFLECTION: u32 = 6u;
const EVALUATIONS: u32 = 7u;
const SOLVED: u32 = 8u;
const KINETIC: u32 = 9u;
/// ½ m v⁺·(v⁺ − Δt f/m), at the time of the positions.
const KINETIC_NOW: u32 = 10u;
const FASTEST: u32 = 11u;
const MOMENTUM: u32 = 12u;
const SUPPORT: u32 = 15u;
/// Elements ahead of the projectile with a yarn that runs on.
const COVERED: u32 = 18u;
/// Lost in contact between plies, of it to friction, and the work of moving nodes out of other plies.
const PLY_LOSS: u32 = 19u;
const PLY_FRICTION_WORK: u32 = 20u;
const PLY_SEPARATION_WORK: u32 = 21u;
/// Dissipated by shock viscosity.
const VISCOUS_WORK: u32 = 22u;
/// Made by the unit-cell law itself since the start.
const LAW_MADE: u32 = 23u;
/// Largest strain of a whole piece of yarn over its failure strain.
const LOAD: u32 = 24u;

/// Sums of an invocation.
var<private> part: array<f32, 25>;
var<workgroup> sums: array<f32, 1625>; // 25 sums of 64 parts, in rows of 65

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
/// the ply. Only the yarns' bits of `flags` are read: the energy balance leaves them as they are.
fn runs_on(ply: u32, place: vec2<u32>, yarn: u32) -> bool {
    let warp = yarn == 1u;
    let along = select(place.x, place.y, warp);
    let pieces = within(ply, select(1u, 0u, warp), along);
    for (var at = pieces.x; at < pieces.y; at++) {
        let cell = select(vec2<u32>(at, place.y), vec2<u32>(place.x, at), warp);
        if ((flags[element_at(ply, cell)] & yarn) == 0u) { return false; }
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
    if ((flags[element] & 3u) == 0u || axis_distance(rotate_back(body.orientation, a)) >= far) { return false; }
    let b = arm_to(at.y);
    let c = arm_to(at.z);
    let d = arm_to(at.w);
    return (ahead(a) || ahead(b) || ahead(c) || ahead(d) || ahead(0.25 * ((a + b) + (c + d))))
        && (runs_on(ply, place, 1u) || runs_on(ply, place, 2u));
}

fn put(at: u32, words: vec4<u32>) {
    for (var i = 0u; i < 4u; i++) { samples[at + i] = words[i]; }
}

/// The body and the counters after the sums; the body's own sums begin anew.
fn finish(first: u32) {
    put(first, bitcast<vec4<u32>>(body.coarse));
    put(first + 4u, bitcast<vec4<u32>>(body.fine));
    put(first + 8u, bitcast<vec4<u32>>(body.change));
    put(first + 12u, bitcast<vec4<u32>>(body.orientation));
    put(first + 16u, bitcast<vec4<u32>>(body.angular_momentum));
    put(first + 20u, bitcast<vec4<u32>>(body.velocity));
    put(first + 24u, bitcast<vec4<u32>>(body.turning));
    put(first + 28u, bitcast<vec4<u32>>(body.coarse_before));
    put(first + 32u, bitcast<vec4<u32>>(body.fine_before));
    put(first + 36u, bitcast<vec4<u32>>(body.change_before));
    put(first + 40u, bitcast<vec4<u32>>(body.impulse));
    put(first + 44u, bitcast<vec4<u32>>(body.support));
    put(first + 48u, bitcast<vec4<u32>>(body.energy));
    put(first + 52u, bitcast<vec4<u32>>(body.nose_coarse));
    put(first + 56u, bitcast<vec4<u32>>(body.nose_fine));
    for (var i = 0u; i < STATUS_WORDS; i++) { samples[first + BODY_WORDS + i] = atomicLoad(&status[counter(i)]); }
    bodies[shot.number].impulse = vec4<f32>(0.0);
    bodies[shot.number].support = vec4<f32>(0.0);
    bodies[shot.number].energy = vec4<f32>(0.0, 0.0, 0.0, body.energy.w);
}

/// Adds what an element has; its accumulators begin anew.
fn add_element(ply: u32, element: u32) {
    let e = scene.elements;
    let word = flags[element];
    // Work, released and released hourglass energy lie one after the other here and there.
    for (var i = 0u; i < 3u; i++) {
        part[WORK + i] += accumulators[i * e + element];
        accumulators[i * e + element] = 0.0;
    }
    if (VISCOUS) {
        part[VISCOUS_WORK] += accumulators[7u * e + element];
        accumulators[7u * e + element] = 0.0;
    }
    part[STORED] += accumulators[3u * e + element];
    part[HOURGLASS_NOW] += accumulators[4u * e + element];
    part[TENSION] = max(part[TENSION], accumulators[5u * e + element]);
    part[LAW_MADE] += accumulators[8u * e + element];
    part[LOAD] = max(part[LOAD], accumulators[9u * e + element]);
    part[DEFLECTION] = max(part[DEFLECTION], accumulators[6u * e + element]);
    part[EVALUATIONS] += f32(word >> 8u);
    part[SOLVED] += select(0.0, f32(step.since), (word & 3u) == 3u);
    flags[element] = word & 3u;
    if (PROJECTILE) { part[COVERED] += select(0.0, 1.0, covers(ply, element)); }
}

/// Adds what a node has.
fn add_node(ply: u32, node: u32, place: vec2<u32>) {
    let e = scene.elements;
    let n = scene.nodes;
    let v = node_vector(3u, node);
    let mass = node_mass(ply, place);
    let square = dot(v, v);
    part[KINETIC] += 0.5 * mass * square;
    part[KINETIC_NOW] += 0.5 * mass * dot(v, v - scene.dt * gather(node, place) * inverse_mass(ply, place));
    part[FASTEST] = max(part[FASTEST], square);
    let momentum = mass * to_pack(ply, v);
    for (var a = 0u; a < 3u; a++) { part[MOMENTUM + a] += momentum[a]; }
    if (PLIES) {
        let at = 10u * e + node;
        // Loss, friction and work of moving nodes out of other plies lie one after the other here and there.
        for (var i = 0u; i < 3u; i++) {
            part[PLY_LOSS + i] += accumulators[at + i * n];
            accumulators[at + i * n] = 0.0;
        }
    }
}

/// Adds the impulse of a support at a node, which begins anew.
fn add_support(at: u32) {
    for (var a = 0u; a < 3u; a++) {
        part[SUPPORT + a] += supports[at + a];
        supports[at + a] = 0.0;
    }
}

@compute @workgroup_size(64)
fn energy_balance(id: Invocation) {
    shot = shots[id.group.z];
    body = bodies[shot.number];
    // Each ply has as many workgroups, so that their sums are those of a ply.
    let share = scene.groups / scene.plies;
    let ply = id.group.x / share;
    let begin = (id.group.x % share) * GROUP + id.local;
    let stride = share * GROUP;
    let first = (step.slot * id.groups.z + id.group.z) * (scene.groups * SUMS + BODY_WORDS + STATUS_WORDS);
    let ply_elements = scene.rows * scene.columns;
    for (var i = begin; i < ply_elements; i += stride) {
        let element = ply_number(ply) * ply_elements + i;
        if (!is_element(ply, element_place(element))) { continue; }
        add_element(ply, element);
    }
    let ply_nodes = (scene.rows + 1u) * (scene.columns + 1u);
    for (var i = begin; i < ply_nodes; i += stride) {
        let node = ply_number(ply) * ply_nodes + i;
        let place = node_place(node);
        if (!is_node(ply, place)) { continue; }
        add_node(ply, node, place);
    }
    let rim = 2u * (scene.columns + scene.rows + 2u);
    for (var i = begin; i < rim; i += stride) { add_support(3u * (ply_number(ply) * rim + i)); }
    for (var i = 0u; i < SUMS; i++) { sums[i * 65u + id.local] = part[i]; }
    workgroupBarrier();
    for (var bit = 6u; bit > 0u; bit--) {
        let reach = 1u << (bit - 1u);
        for (var at = id.local; at < SUMS * reach; at += GROUP) {
            let which = at >> (bit - 1u);
            let place = which * 65u + (at & (reach - 1u));
            let x = sums[place + reach];
            let largest = which == TENSION || which == DEFLECTION || which == FASTEST || which == LOAD;
            sums[place] = select(sums[place] + x, max(sums[place], x), largest);
        }
        workgroupBarrier();
    }
    if (id.local < SUMS) { samples[first + id.group.x * SUMS + id.local] = bitcast<u32>(sums[id.local * 65u]); }
    if (id.group.x == 0u && id.local == 0u) { finish(first + scene.groups * SUMS); }
}
