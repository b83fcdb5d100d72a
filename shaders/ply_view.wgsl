// ply_view: the nodes of a ply in the axes of the pack, and its neighbours. Needs `nodes`.
// Twin: src/solver/contact/ply_search.rs

/// No such ply.
const NO_PLY: u32 = 0xffffffffu;

/// The ply in front (0) or behind (1).
fn neighbour(ply: u32, side: u32) -> u32 {
    if (side == 0u) { return ply - 1u; } // of the first: NO_PLY
    return select(NO_PLY, ply + 1u, ply + 1u < scene.plies);
}

fn ply_velocity(ply: u32, node: u32) -> vec3<f32> { return to_pack(ply, node_vector(3u, node)); }

/// Position at the end of the step [m].
fn ply_position(ply: u32, place: vec2<u32>) -> vec3<f32> {
    return to_pack(ply, reference(ply, place) + node_vector(0u, node_at(ply, place)));
}

/// 1/mass along a direction of the pack [1/kg], in the whole scene: mirror planes hold no node in a single contact, only with
/// its image.
fn inverse_along(ply: u32, place: vec2<u32>, along: vec3<f32>) -> f32 {
    var inverse = inverse_mass(ply, place);
    let across = cut_across(ply, place);
    if (any(across)) {
        let whole = inverse.z * part_of(ply, place);
        inverse = vec3<f32>(select(vec2<f32>(0.0), vec2<f32>(whole), across | (inverse.xy > vec2<f32>(0.0))), whole);
    }
    let own = to_ply(ply, along);
    let mixed = dot(own * own, inverse);
    return select(mixed, inverse.x, inverse.x == inverse.y && inverse.y == inverse.z);
}

/// The mirror planes that a node lies on: by coordinate of a neighbour's cells, 1 or 2 for the one across x or y of the pack.
fn planes_at(ply: u32, place: vec2<u32>, other: u32) -> vec2<u32> {
    if (scene.mirror == 0u) { return vec2<u32>(0u); }
    let near = abs(to_pack(ply, reference(ply, place)).xy) < vec2<f32>(0.25 * min(plies[ply].length_x, plies[ply].length_y));
    let planes = vec2<u32>(scene.mirror) & vec2<u32>(1u, 2u) & select(vec2<u32>(0u), vec2<u32>(3u), near);
    return select(planes, planes.yx, abs(plies[other].sine) > 0.5);
}

/// Nodes at the corners of a cell (row, column) of a ply, counter-clockwise.
fn cell_corners(ply: u32, cell: vec2<u32>) -> vec4<u32> { return corners(element_at(ply, cell)); }
