// ply_impulse: the impulse of every contact between plies, each node's mass shared out among its contacts.
//   in      nodes     array<f32>      (6, N)   displacement [m], velocity [m/s]
//   in      over      array<u32>      (2, N)   element of the ply in front, of the ply behind, that a node is over, PENETRATING
//   in      contacts  array<Contact>  (2, N)
//   in      shares    array<u32>      (N)      contacts of a node, by weight
//   in/out  impulses  array<i32>      (N, 6)   impulse on a node, then what moves it without a velocity left, counted
//   in/out  contact_work  array<f32>      (5, N)   see `energy_balance`
//   in      status    array<u32>               counters
// Twin: `solve` of src/solver/contact/ply_impulse.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> over: array<u32>;
@group(1) @binding(2) var<storage, read> contacts: array<Contact>;
@group(1) @binding(3) var<storage, read> shares: array<u32>;
@group(1) @binding(4) var<storage, read_write> impulses: array<atomic<i32>>;
@group(1) @binding(5) var<storage, read_write> contact_work: array<f32>;
@group(1) @binding(6) var<storage, read_write> status: array<atomic<u32>>;

/// Contacts of a node by weight. Below one a light touch of a corner would throw it away.
fn share_of(node: u32) -> f32 { return max(f32(shares[node]) * (1.0 / SHARE_UNIT), 1.0); }

/// Adds to a node's sums. Whole numbers add up the same in any order.
fn add(node: u32, impulse: vec3<i32>, shift: vec3<i32>) {
    for (var a = 0u; a < 3u; a++) {
        if (impulse[a] != 0) { atomicAdd(&impulses[6u * node + a], impulse[a]); }
        if (shift[a] != 0) { atomicAdd(&impulses[6u * node + 3u + a], shift[a]); }
    }
}

/// The impulse of one contact, given to its node and taken from the corners of its cell in whole counts, so that what one
/// gets the others lose.
fn press(ply: u32, node: u32, side: u32) {
    let other = neighbour(ply, side);
    let at = side * scene.nodes + node;
    let contact = contacts[at];
    let push = contact.normal_impulse.xyz;
    let around = cell_corners(other, cell_over(other, over[at]));
    let weights = weights_at(contact.foot.xy);
    var velocity = ply_velocity(ply, node);
    var compliance = share_of(node) * inverse_along(ply, node_place(node), push);
    for (var i = 0u; i < 4u; i++) {
        velocity -= ply_velocity(other, around[i]) * weights[i];
        compliance += weights[i] * share_of(around[i]) * inverse_along(other, node_place(around[i]), push);
    }
    if (compliance <= 0.0) { return; }
    let kappa = 1.0 / compliance;
    let found = impulse_between(velocity, push, contact.normal_impulse.w, kappa);
    let slide = velocity - push * dot(velocity, push);
    let part = part_of(ply, node_place(node));
    contact_work[scene.nodes + node] -= part * dot(found.friction_impulse, slide + found.friction_impulse * (0.5 * compliance));
    // In the largest unit of any of the nodes, which is a whole number of every other one's.
    let own = count_shift(ply, node_place(node));
    var theirs: vec4<u32>;
    for (var i = 0u; i < 4u; i++) { theirs[i] = count_shift(other, node_place(around[i])); }
    let largest = max(max(own, max(theirs.x, theirs.y)), max(theirs.z, theirs.w));
    let unit = shot.impulse_unit * f32(1u << largest);
    let counts = (push * found.along + found.friction_impulse) * (part / unit);
    let shifts = push * (kappa * contact.foot.z) * (part / unit);
    var given = vec3<i32>(0);
    var moved = vec3<i32>(0);
    for (var i = 0u; i < 4u; i++) {
        let part = vec3<i32>(round(counts * weights[i]));
        let way = vec3<i32>(round(shifts * weights[i]));
        let each = 1 << (largest - theirs[i]);
        add(around[i], -part * each, -way * each);
        given += part;
        moved += way;
    }
    let each = 1 << (largest - own);
    add(node, given * each, moved * each);
}

@compute @workgroup_size(64)
fn ply_impulse(id: Invocation) {
    shot = shots[id.group.z];
    let number = invocation_number(id);
    if (number >= scene.shot_nodes || step.index > atomicLoad(&status[counter(BAD_STEP)])) { return; }
    let node = first_node() + number;
    if (shares[node] == 0u) { return; } // a node in contact has a share
    for (var side = 0u; side < 2u; side++) {
        if (contacts[side * scene.nodes + node].foot.w != 0.0) { press(node_ply(node), node, side); }
    }
}
