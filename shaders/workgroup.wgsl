// workgroup: sums and votes of the invocations of kernels that are a single workgroup.
// Twin: src/kernels/projectile_contact.rs, which has one invocation

/// Invocations: as many as every device has. A card waits for memory most of the time, for all of them together.
const WIDTH: u32 = 256u;
/// Of them, those whose parts of sums lie side by side.
const LANES: u32 = 64u;

var<workgroup> sums: array<f32, 1755>; // 27 sums of 64 parts, in rows of 65
var<workgroup> result: array<f32, 27>;
var<workgroup> scan: array<u32, 256>;
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
    if (local < count) {
        var sum = 0.0;
        for (var i = 0u; i < LANES; i++) {
            sum += sums[local * 65u + i];
        }
        result[local] = sum;
    }
    workgroupBarrier();
}

/// The same answer for every invocation: whether it is yes for any.
fn vote(yes: bool, local: u32) -> bool {
    if (local == 0u) {
        atomicStore(&ballot, 0u);
    }
    workgroupBarrier();
    if (yes) {
        atomicStore(&ballot, 1u);
    }
    workgroupBarrier();
    if (local == 0u) {
        verdict = atomicLoad(&ballot);
    }
    return workgroupUniformLoad(&verdict) != 0u;
}

/// The number of an invocation added to those of all before it; the last has the sum of all. `scan` must not be read by then.
fn sum_up_to(number: u32, local: u32) -> u32 {
    scan[local] = number;
    workgroupBarrier();
    for (var reach = 1u; reach < WIDTH; reach *= 2u) {
        var sum = scan[local];
        if (local >= reach) {
            sum += scan[local - reach];
        }
        workgroupBarrier();
        scan[local] = sum;
        workgroupBarrier();
    }
    return scan[local];
}
