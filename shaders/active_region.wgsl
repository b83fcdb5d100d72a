// active_region: which nodes and elements of a ply may have moved; everything else is at rest, to the last bit.
// Needs `status`.
// Twin: src/solver/state.rs

/// Rows first and end, columns first and end, of the nodes of a ply that may have moved.
fn reach_of(ply: u32) -> vec4<u32> {
    let at = counter(REACH + 4u * ply);
    return vec4<u32>(
        atomicLoad(&status[at]), atomicLoad(&status[at + 1u]), atomicLoad(&status[at + 2u]), atomicLoad(&status[at + 3u]));
}

/// Whether a node lies in a reach grown by one ring.
fn in_reach(reach: vec4<u32>, place: vec2<u32>) -> bool {
    let row = place.x + 1u >= reach.x && place.x <= reach.y;
    let column = place.y + 1u >= reach.z && place.y <= reach.w;
    return row && column && reach.x < reach.y;
}

/// Whether an element has a corner in a reach. The first step computes everything.
fn element_in_reach(reach: vec4<u32>, place: vec2<u32>) -> bool {
    let row = place.x + 1u >= reach.x && place.x < reach.y;
    let column = place.y + 1u >= reach.z && place.y < reach.w;
    return (row && column && reach.x < reach.y) || step.index == 0u;
}

/// Takes a node in.
fn touch(ply: u32, place: vec2<u32>) {
    let at = counter(REACH + 4u * ply);
    atomicMin(&status[at], place.x);
    atomicMax(&status[at + 1u], place.x + 1u);
    atomicMin(&status[at + 2u], place.y);
    atomicMax(&status[at + 3u], place.y + 1u);
}
