// intact: what still carries load. Needs `cells`.
// Twin: `node_stands` of src/solver/state.rs, `edge_stands` of src/solver/contact/projectile_points.rs

/// Yarns (1 warp, 2 weft) that any, and that all of the elements around a node have.
fn yarns_around(node: u32, place: vec2<u32>) -> vec2<u32> {
    let there = adjacent_elements(node_ply(node), place);
    let e = element_above(node, place);
    let around = vec4<u32>(e, e - 1u, e - scene.columns - 1u, e - scene.columns);
    var bits = vec2<u32>(0u, 3u);
    for (var i = 0u; i < 4u; i++) {
        if (there[i]) { bits = vec2<u32>(bits.x | yarns_left(around[i]), bits.y & yarns_left(around[i])); }
    }
    return bits;
}

/// Whether any element around a node still carries load; debris no longer touches anything.
fn is_intact(node: u32, place: vec2<u32>) -> bool { return yarns_around(node, place).x != 0u; }

/// Whether nothing has failed around a node.
fn is_whole(node: u32, place: vec2<u32>) -> bool { return yarns_around(node, place).y == plies[node_ply(node)].present; }

/// Whether a yarn still runs along the edge from a node to the next of its row, or `up` its column, in an element beside it.
fn edge_is_intact(node: u32, place: vec2<u32>, up: bool) -> bool {
    let there = adjacent_elements(node_ply(node), place);
    let e = element_above(node, place);
    var bits = 0u;
    if (there.x) { bits |= yarns_left(e); }
    if (up && there.y) { bits |= yarns_left(e - 1u); }
    if (!up && there.w) { bits |= yarns_left(e - scene.columns); }
    return (bits & select(1u, 2u, up)) != 0u;
}
