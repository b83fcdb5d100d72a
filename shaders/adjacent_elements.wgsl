// adjacent_elements: the up to four elements of a node.
// Twin: `neighbours` of src/solver/mod.rs

/// First element above and to the right of a node, as if the ply went on.
fn element_above(node: u32, place: vec2<u32>) -> u32 {
    return element_at(node_ply(node), place);
}

/// Which of the elements above right, above left, below left and below right of a node there are.
fn adjacent_elements(ply: u32, place: vec2<u32>) -> vec4<bool> {
    let above = place.x < plies[ply].rows;
    let below = place.x > 0u;
    let right = place.y < plies[ply].columns;
    let left = place.y > 0u;
    return vec4<bool>(above && right, above && left, below && left, below && right);
}
