// intact: what still carries load. Needs `flags`.
// Twin: `node_stands` of src/solver/state.rs, `edge_stands` of src/solver/contact/projectile_points.rs

/// Whether any element around a node still carries load; debris no longer touches anything.
fn is_intact(node: u32, place: vec2<u32>) -> bool {
    let there = adjacent_elements(node_ply(node), place);
    let e = element_above(node, place);
    var bits = 0u;
    if (there.x) { bits |= flags[e]; }
    if (there.y) { bits |= flags[e - 1u]; }
    if (there.z) { bits |= flags[e - scene.columns - 1u]; }
    if (there.w) { bits |= flags[e - scene.columns]; }
    return (bits & 3u) != 0u;
}

/// Whether nothing has failed around a node.
fn is_whole(node: u32, place: vec2<u32>) -> bool {
    let ply = node_ply(node);
    let there = adjacent_elements(ply, place);
    let e = element_above(node, place);
    var bits = 3u;
    if (there.x) { bits &= flags[e]; }
    if (there.y) { bits &= flags[e - 1u]; }
    if (there.z) { bits &= flags[e - scene.columns - 1u]; }
    if (there.w) { bits &= flags[e - scene.columns]; }
    return (bits & 3u) == plies[ply].present;
}

/// Whether a yarn still runs along the edge from a node to the next of its row, or `up` its column, in an element beside it.
fn edge_is_intact(node: u32, place: vec2<u32>, up: bool) -> bool {
    let there = adjacent_elements(node_ply(node), place);
    let e = element_above(node, place);
    var bits = 0u;
    if (there.x) { bits |= flags[e]; }
    if (up && there.y) { bits |= flags[e - 1u]; }
    if (!up && there.w) { bits |= flags[e - scene.columns]; }
    return (bits & select(1u, 2u, up)) != 0u;
}
