// projectile_motion: sums over the workgroup, and the equations of the body's motion with the touches that push attached. Needs `bodies` and `status`.
// Twin: src/solver/contact/projectile_contact.rs

/// Changes of the set of pushing nodes allowed in one step.
const SET_CHANGES: u32 = 40u;
/// Sweeps of friction after the normal impulses are found.
const FRICTION_SWEEPS: u32 = 3u;
/// Mass of a held node over that of the body, or over its own where that is more.
const HELD: f32 = 1e3;

/// Change of the body's velocity [m/s] and angular velocity [rad/s].
var<workgroup> motion: array<f32, 6>;

/// Relative normal velocity below which a node enters the body within the step: what closes its gap exactly.
fn closing_limit(gap: f32) -> f32 { return -max(gap, 0.0) / scene.dt; }

/// Inertia met along a normal [kg], of what a unit impulse moves at `along` [1/kg].
fn inertia_along(along: f32, mass: f32) -> f32 { return 1.0 / max(along, 1.0 / (HELD * max(scene.body_mass, mass))); }

/// Velocity of the body, or impulse on it, without the directions that mirror planes hold.
fn in_planes(v: vec3<f32>) -> vec3<f32> {
    return select(v, vec3<f32>(0.0), (vec3<u32>(scene.body_held) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

/// Turning without the directions that mirror planes hold.
fn about_planes(v: vec3<f32>) -> vec3<f32> {
    return select(v, vec3<f32>(0.0), (vec3<u32>(scene.body_held) & vec3<u32>(8u, 16u, 32u)) != vec3<u32>(0u));
}

/// Motion that impulse and turn `result[0..6]` give the body: velocity, angular velocity.
fn given_motion() -> array<f32, 6> {
    let linear = in_planes(vec3<f32>(result[0], result[1], result[2])) / scene.body_mass;
    var angular = vec3<f32>(0.0);
    if (may_turn()) {
        angular = angular_velocity(body.orientation, about_planes(vec3<f32>(result[3], result[4], result[5])));
    }
    return array<f32, 6>(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z);
}

/// (n, r × n) of a point with that normal and arm; turns are measured in lengths of `body_bounding_radius`.
fn direction_of(along: vec3<f32>, arm: vec3<f32>) -> array<f32, 6> {
    let normal = in_planes(along);
    var turn = vec3<f32>(0.0);
    if (may_turn()) { turn = about_planes(cross(arm, along) / scene.body_bounding_radius); }
    return array<f32, 6>(normal.x, normal.y, normal.z, turn.x, turn.y, turn.z);
}

/// Inertia of the body over `body_bounding_radius`² [kg], its lower triangle by rows.
fn body_inertia() -> array<f32, 6> {
    let side = rotate(body.orientation, vec3<f32>(1.0, 0.0, 0.0));
    let axis = rotate(body.orientation, vec3<f32>(0.0, 0.0, 1.0));
    let scale = 1.0 / squared(scene.body_bounding_radius);
    // Excess of x and z over y; the rest is the same in every direction.
    let across = scene.body_inertia.y * scale;
    let more_x = (scene.body_inertia.x - scene.body_inertia.y) * scale;
    let more_z = (scene.body_inertia.z - scene.body_inertia.y) * scale;
    return array<f32, 6>(
        across + more_x * side.x * side.x + more_z * axis.x * axis.x,
        more_x * side.y * side.x + more_z * axis.y * axis.x,
        across + more_x * side.y * side.y + more_z * axis.y * axis.y,
        more_x * side.z * side.x + more_z * axis.z * axis.x,
        more_x * side.z * side.y + more_z * axis.z * axis.y,
        across + more_x * side.z * side.z + more_z * axis.z * axis.z);
}

/// Solves (M + Σ κ G Gᵀ) m = right by Cholesky; `result` holds the sums, lower triangle by rows, then the right side.
fn solve_motion() {
    var a: array<f32, 21>;
    var x: array<f32, 6>;
    for (var i = 0u; i < 21u; i++) { a[i] = result[i]; }
    for (var i = 0u; i < 6u; i++) { x[i] = result[21u + i]; }
    for (var i = 0u; i < 3u; i++) { a[i * (i + 1u) / 2u + i] += scene.body_mass; }
    var size = 3u;
    if (may_turn()) {
        size = 6u;
        let inertia = body_inertia();
        a[9] += inertia[0];
        a[13] += inertia[1];
        a[14] += inertia[2];
        a[18] += inertia[3];
        a[19] += inertia[4];
        a[20] += inertia[5];
    }
    var sound = true;
    for (var i = 0u; i < size; i++) {
        let row = i * (i + 1u) / 2u;
        for (var j = 0u; j <= i; j++) {
            let column = j * (j + 1u) / 2u;
            var sum = a[row + j];
            for (var k = 0u; k < j; k++) { sum -= a[row + k] * a[column + k]; }
            if (i == j) {
                sound = sound && sum > 0.0;
                a[row + j] = sqrt(max(sum, 1e-30));
            } else {
                a[row + j] = sum / a[column + j];
            }
        }
    }
    for (var i = 0u; i < size; i++) {
        let row = i * (i + 1u) / 2u;
        for (var k = 0u; k < i; k++) { x[i] -= a[row + k] * x[k]; }
        x[i] /= a[row + i];
    }
    for (var r = 0u; r < size; r++) {
        let i = size - 1u - r;
        for (var k = i + 1u; k < size; k++) { x[i] -= a[k * (k + 1u) / 2u + i] * x[k]; }
        x[i] /= a[i * (i + 1u) / 2u + i];
    }
    for (var i = 0u; i < 6u; i++) {
        motion[i] = select(0.0, x[i], sound && i < size) / select(1.0, scene.body_bounding_radius, i >= 3u);
    }
}

/// The body after impulse and turn `result[0..6]`, losses and work `result[6..9]`, what the supports took `result[9..12]` and
/// work on the elements `result[12]`: moved on by a step. `met`: whether there was anything to meet.
fn moved_body(start: Body, met: bool) -> Body {
    var b = start;
    b.coarse_before = b.coarse;
    b.fine_before = b.fine;
    b.change_before = b.change;
    let impulse = vec3<f32>(result[0], result[1], result[2]);
    if (met) {
        if (scene.body_prescribed == 0u) {
            b.change += vec4<f32>(in_planes(impulse) / scene.body_mass, 0.0);
            if (may_turn()) {
                b.angular_momentum += vec4<f32>(about_planes(vec3<f32>(result[3], result[4], result[5])), 0.0);
            }
        }
        b.impulse += vec4<f32>(impulse, result[12]);
        b.support += vec4<f32>(result[9], result[10], result[11], 0.0);
        b.energy += vec4<f32>(result[6], result[7], result[8], 0.0);
    }
    b.support.w = result[12];
    return advance(b);
}

/// Invocations whose parts of sums lie side by side, and of these as many as one invocation adds up: its square root.
const LANES: u32 = 64u;
const STRIDE: u32 = 8u;
/// Invocations that `sum_up_to` goes through one after another.
const BLOCK: u32 = 16u;

var<workgroup> sums: array<f32, 1755>; // 27 sums of 64 parts, in rows of 65
var<workgroup> result: array<f32, 27>;
var<workgroup> scan: array<u32, 256>;
var<workgroup> block_sums: array<u32, 16>;
var<workgroup> rank_bits: array<atomic<u32>, 24>;
var<workgroup> ballot: atomic<u32>;
var<workgroup> verdict: u32;

/// Adds up `count` sums over the invocations, in fixed order, from what each has.
fn reduce(part: ptr<function, array<f32, 27>>, count: u32, local: u32) {
    workgroupBarrier();
    let lane = local % LANES;
    for (var turn = 0u; turn < WIDTH / LANES; turn++) {
        if (local / LANES == turn) {
            for (var i = 0u; i < count; i++) {
                let before = select(sums[i * 65u + lane], 0.0, turn == 0u);
                sums[i * 65u + lane] = before + (*part)[i];
            }
        }
        workgroupBarrier();
    }
    for (var at = local; at < count * STRIDE; at += WIDTH) {
        let first = at / STRIDE * 65u + at % STRIDE;
        var sum = sums[first];
        for (var i = STRIDE; i < LANES; i += STRIDE) { sum += sums[first + i]; }
        sums[first] = sum;
    }
    workgroupBarrier();
    if (local < count) {
        var sum = sums[local * 65u];
        for (var i = 1u; i < STRIDE; i++) { sum += sums[local * 65u + i]; }
        result[local] = sum;
    }
    workgroupBarrier();
}

/// Takes the shot of a layer of the dispatch, and its body. False if one of its numbers is not finite: nothing happens any more.
fn take_shot(layer: u32, local: u32) -> bool {
    shot = shots[layer];
    body = bodies[shot.number];
    if (local == 0u) { verdict = u32(step.index <= atomicLoad(&status[counter(BAD_STEP)])); }
    return workgroupUniformLoad(&verdict) != 0u;
}

/// Vote of all invocations: whether it is yes for any.
fn vote(yes: bool, local: u32) -> bool {
    if (local == 0u) { atomicStore(&ballot, 0u); }
    workgroupBarrier();
    if (yes) { atomicStore(&ballot, 1u); }
    workgroupBarrier();
    if (local == 0u) { verdict = atomicLoad(&ballot); }
    return workgroupUniformLoad(&verdict) != 0u;
}

/// Marks an invocation or not; gives how many marked ones come before it, and how many there are. `round`: 0 in the first call of a dispatch, then
/// one more in each: three rounds have words of their own, so that what one clears no other reads.
fn rank_of(marked: bool, round: u32, local: u32) -> vec2<u32> {
    if (marked) { atomicOr(&rank_bits[rank_word(round, local)], 1u << (local % 32u)); }
    workgroupBarrier();
    var rank = vec2<u32>(0u);
    for (var word = 0u; word < WIDTH / 32u; word++) {
        let bits = atomicLoad(&rank_bits[rank_word(round, 32u * word)]);
        let before = select(select(0u, bits, word < local / 32u), bits & ((1u << (local % 32u)) - 1u), word == local / 32u);
        rank += vec2<u32>(countOneBits(before), countOneBits(bits));
    }
    if (local < WIDTH / 32u) { atomicStore(&rank_bits[rank_word(round + 2u, 32u * local)], 0u); }
    return rank;
}

/// Place of the word with the mark of an invocation.
fn rank_word(round: u32, local: u32) -> u32 { return (round % 3u) * (WIDTH / 32u) + local / 32u; }

/// Whether an invocation is marked.
fn is_marked(which: u32, round: u32) -> u32 {
    return (atomicLoad(&rank_bits[rank_word(round, which)]) >> (which % 32u)) & 1u;
}

/// The number of an invocation added to those of all before it; `all`: of all invocations, the same for each.
fn sum_up_to(number: u32, all: ptr<function, u32>, local: u32) -> u32 {
    scan[local] = number;
    workgroupBarrier();
    var sum = number;
    for (var i = local - local % BLOCK; i < local; i++) { sum += scan[i]; }
    if (local % BLOCK == BLOCK - 1u) { block_sums[local / BLOCK] = sum; }
    var blocks = workgroupUniformLoad(&block_sums);
    *all = 0u;
    for (var block = 0u; block < WIDTH / BLOCK; block++) {
        if (block == local / BLOCK) { sum += *all; }
        *all += blocks[block];
    }
    return sum;
}
