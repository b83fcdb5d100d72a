// supports: impulse of the held nodes, and of those that clay resists. Needs `supports`.
// Twin: the `support` sums of src/solver/node_update.rs

/// Adds to the impulse of the supports on a node [N·s], in the axes of the ply.
fn add_support(ply: u32, place: vec2<u32>, impulse: vec3<f32>) {
    let node = node_at(ply, place);
    let turned = to_pack(ply, impulse);
    for (var a = 0u; a < 3u; a++) { supports[a * scene.nodes + node] += turned[a]; }
}
