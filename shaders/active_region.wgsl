// active_region: which nodes and elements of a ply may have moved; everything else is at rest, to the last bit.
// Needs `status`.
// Twin: src/solver/state.rs

/// Rows first and end, columns first and end, of the nodes of a ply that may have moved.
fn reach_of(ply: u32) -> vec4<u32> {
    let at = counter(REACH + 4u * ply);
    return vec4<u32>(
        atomicLoad(&status[at]), atomicLoad(&status[at + 1u]), atomicLoad(&status[at + 2u]), atomicLoad(&status[at + 3u]));
}

/// Whether a place lies in a reach with `before` more rows and columns at its beginning and `after` more at its end. Nodes of the reach and
/// of the ring around it: 1, 1. Elements with a corner in the reach: 1, 0; with a corner in the ring: 2, 1.
fn is_near(reach: vec4<u32>, place: vec2<u32>, before: u32, after: u32) -> bool {
    let row = place.x + before >= reach.x && place.x < reach.y + after;
    let column = place.y + before >= reach.z && place.y < reach.w + after;
    return row && column && reach.x < reach.y;
}

/// Takes a node in.
fn touch(ply: u32, place: vec2<u32>) {
    let at = counter(REACH + 4u * ply);
    atomicMin(&status[at], place.x);
    atomicMax(&status[at + 1u], place.x + 1u);
    atomicMin(&status[at + 2u], place.y);
    atomicMax(&status[at + 3u], place.y + 1u);
}
