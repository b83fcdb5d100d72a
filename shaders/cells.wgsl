// cells: what an element keeps from step to step, in two slots by turns.
//   cells  array<u32>  (2, 7, E)   three words: bit 0 warp alive, bit 1 weft alive, from bit 2 on the heights of warp and weft over their sum
//                                  in 24 bits each, `dh_dstretch` over that sum as floats of 14 bits, `force_share` in 9 bits each; of warp
//                                  and weft: viscous forces [N], strains that failure is judged by [-]
//                then  (2, E)      failure strains over the fabric's [-], where strength varies
// Needs `cells`.
// Twin: `cell` of src/gpu/layout/mod.rs

/// Fields of an element in a slot.
const CELL_FIELDS: u32 = 7u;
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
