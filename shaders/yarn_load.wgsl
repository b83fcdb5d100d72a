// yarn_load: tension of the yarns, and their load as failure judges it, in steps with a sample.
//   in      nodes  array<f32>            read by what it shares with others
//   in      cells  array<u32>            elements, see `cells`
//   in/out  tiles  array<u32>  (T, 14)   bits of largest tension and load, in the first tile of a ply
//   in      status  array<u32>           counters
// Twin: src/solver/failure.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read> cells: array<u32>;
@group(1) @binding(2) var<storage, read_write> tiles: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

/// Strains of this step.
fn strain_slot() -> u32 { return slot_now(); }

/// Mean tension over stiffness of the elements side by side in a yarn with one: what is broken carries nothing.
fn yarn_strain(ply: u32, place: vec2<u32>, which: u32) -> f32 {
    let across = side_by_side(ply, place, which);
    var sum = 0.0;
    var total = 0.0;
    for (var at = across.x; at < across.y; at++) {
        let breadth = width_along(ply, 1u - which, at);
        let strain = max(strain_of(element_at(ply, place_across(place, which, at)), which), 0.0);
        sum += breadth * curve_tension(which, strain);
        total += breadth;
    }
    return sum / total;
}

@compute @workgroup_size(64)
fn yarn_load(id: Invocation) {
    shot = shots[id.group.z];
    let number = invocation_number(id);
    if (number >= scene.shot_elements || step.index > atomicLoad(&status[counter(BAD_STEP)])) { return; }
    let element = first_element() + number;
    let ply = element_ply(element);
    let place = element_place(element);
    if (!is_element(ply, place) || plies[ply].ply_type != scene.ply_type) { return; }
    let strain = vec2<f32>(yarn_strain(ply, place, 0u), yarn_strain(ply, place, 1u));
    let tension = strain * scene.stiffness;
    let warp = piece_of(element, 0u, 0.0);
    let weft = piece_of(element, 1u, 0.0);
    let load = vec2<f32>(warp.x * warp.y, weft.x * weft.y) / failure_strain(element);
    // Numbers above zero are in the order of their bits.
    let at = tile_sum(ply, 0u, TENSION);
    atomicMax(&tiles[at], bitcast<u32>(max(tension.x, tension.y)));
    atomicMax(&tiles[at + LOAD - TENSION], bitcast<u32>(max(load.x, load.y)));
}
