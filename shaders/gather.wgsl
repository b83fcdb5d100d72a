// gather: internal force on a node from its up to four elements, in fixed order.
// Twin: src/solver/node_update.rs

fn element_forces(field: u32, element: u32) -> vec3<f32> {
    let e = scene.elements;
    return vec3<f32>(forces[field * e + element], forces[(field + 1u) * e + element], forces[(field + 2u) * e + element]);
}

/// Force of one element [N] with the signs of the corner it has at this node; `there` is false beyond the edge.
fn corner_force(element: u32, there: bool, warp: f32, weft: f32, mode: f32) -> vec3<f32> {
    if (!there) { return vec3<f32>(0.0); }
    let membrane = warp * element_forces(0u, element) + weft * element_forces(3u, element);
    if (!HOURGLASS) { return membrane; }
    return membrane + mode * element_forces(6u, element);
}

/// Internal force on a node [N].
fn gather(node: u32, place: vec2<u32>) -> vec3<f32> {
    let there = adjacent_elements(node_ply(node), place);
    let e = element_above(node, place);
    let first = corner_force(e, there.x, 1.0, 1.0, -1.0);
    let second = corner_force(e - 1u, there.y, -1.0, 1.0, 1.0);
    let third = corner_force(e - scene.columns - 1u, there.z, 1.0, 1.0, 1.0);
    let fourth = corner_force(e - scene.columns, there.w, 1.0, -1.0, 1.0);
    return (first + second) + (fourth - third);
}
