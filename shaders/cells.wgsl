// cells: what an element keeps from step to step, in two slots by turns, and what of it still carries load.
//   cells  array<u32>  (2, 7, E)   three words: bit 0 warp alive, bit 1 weft alive, from bit 2 on the heights of warp and weft over their sum
//                                  in 24 bits each, `dh_dstretch` over that sum as floats of 14 bits, `force_share` in 9 bits each; of warp
//                                  and weft: viscous forces [N], strains that failure is judged by [-]
//                then  (2, E)      failure strains over the fabric's [-], where strength varies
//                then  (2, 2, E)   overstress of the rate of strain over the tensions [-], in two slots, where there is one
// Needs `cells`.
// Twin: `cell` of src/gpu/layout/mod.rs, `node_stands` of src/solver/state.rs, `edge_stands` of src/solver/contact/candidate_edges.rs

/// Fields of an element in a slot.
const CELL_FIELDS: u32 = 7u;
/// Fields of the rate of strain in a slot, after the strengths.
const RATE_FIELDS: u32 = 2u;
const YARNS: u32 = 0u;
const DRAG: u32 = 3u;
const STRAIN: u32 = 5u;
/// Steps of a height to the sum of both.
const HEIGHT_STEPS: u32 = 0xffffffu;

fn cell_word(slot: u32, field: u32, element: u32) -> u32 { return (slot * CELL_FIELDS + field) * scene.elements + element; }

/// Numbers of warp and weft.
fn yarn_pair(slot: u32, field: u32, element: u32) -> vec2<f32> {
    let at = cell_word(slot, field, element);
    return bitcast<vec2<f32>>(vec2<u32>(cells[at], cells[at + scene.elements]));
}

/// Yarns that stand, at the end of a step: 1 warp, 2 weft.
fn yarns_left(element: u32) -> u32 { return cells[cell_word(slot_now(), YARNS, element)] & 3u; }

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
