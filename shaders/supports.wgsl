// supports: impulse of the held nodes: those on the sides of each ply, in a frame any, as of those that clay resists. Needs `supports`.
// Twin: the `support` sums of src/solver/node_update.rs

/// Number of a node of a ply's rim; in a frame, or with clay behind it, of a node of the pack.
fn rim_index(ply: u32, place: vec2<u32>) -> u32 {
    if (supports_every_node()) { return node_at(ply, place); }
    let across = scene.columns + 1u;
    let along = scene.rows + 1u;
    let first = ply_number(ply) * 2u * (across + along);
    if (place.x == 0u) { return first + place.y; }
    if (place.x == plies[ply].rows) { return first + across + place.y; }
    return first + 2u * across + select(along, 0u, place.y == 0u) + place.x;
}

/// Adds to the impulse of the supports [N·s], in the axes of the ply.
fn add_support(ply: u32, place: vec2<u32>, impulse: vec3<f32>) {
    let at = 3u * rim_index(ply, place);
    let turned = to_pack(ply, impulse);
    for (var a = 0u; a < 3u; a++) { supports[at + a] += turned[a]; }
}
