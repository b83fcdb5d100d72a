// pack: the plies, where a node or an element lies, its mass, and what may have moved.
// Needs `status`: everything outside the reach of a ply is at rest, to the last bit.
// Twin: src/model/mesh.rs, src/model/ply_type.rs, `ActiveRegion` of src/solver/state.rs

/// A ply of the pack.
struct Ply {
    // Its own mesh.
    rows: u32,
    columns: u32,
    /// Number of its ply type.
    ply_type: u32,
    /// Yarns that are there: 1 warp, 2 weft.
    present: u32,
    origin: vec2<f32>,
    /// Lengths of the finest elements [m].
    length: vec2<f32>,
    /// Cosine and sine of the angle from the pack's X axis to the warp.
    cosine: f32,
    sine: f32,
    /// Behind the struck ply [m].
    z: f32,
    /// Thickness of the fabric in front of it, where none is missing [m].
    depth: f32,
    /// Distance of mid-planes at which it touches the ply behind it, and mean thickness of the two [m].
    touching: f32,
    thickness: f32,
    // Mass [kg] of an inner node of the finest elements, and 1/mass.
    mass: f32,
    inverse_mass: f32,
    /// Held directions (1 x, 2 y, 4 z) of the left, right, bottom and top side, three bits each; from bit 12 on, which of
    /// these sides mirror planes cut.
    held: u32,
    /// Finest cells for which a yarn must run on unbroken to cover.
    span: u32,
    /// Longest side of any element [m].
    longest: f32,
    /// Place after the beginning of the lines where the shares of the nodes of its type begin, 0: no ply of the pack is in a frame.
    shares: u32,
    /// Gap to the clay behind it [m], the pressure of that over its areal density [m/s²], 0: there is none, and what this gains with the
    /// depth, over it [1/m].
    clay_gap: f32,
    clay_rate: f32,
    clay_gain: f32,
    pad: u32,
}

// Numbers of a node of a ply with clay behind it, after its vectors.
/// Depth of the crater behind it [m].
const CRATER: u32 = 0u;
/// Velocity that the clay took in this step [m/s].
const TAKEN: u32 = 1u;
/// Energy that it took since the last sample [J].
const INTO_CLAY: u32 = 2u;

/// Set beside the element that a node is over where it is inside it, closer than the two plies touch.
const PENETRATING: u32 = 0x80000000u;

/// Row and column of the cell of a ply that a node is over.
fn cell_over(ply: u32, over: u32) -> vec2<u32> {
    let element = over & ~PENETRATING;
    return vec2<u32>(element / plies[ply].columns, element % plies[ply].columns);
}

/// Ply of a node.
fn node_ply(node: u32) -> u32 { return (node / (scene.columns + 1u)) / (scene.rows + 1u) - ply_number(0u); }

/// Row within its ply and column of a node.
fn node_place(node: u32) -> vec2<u32> {
    let across = scene.columns + 1u;
    return vec2<u32>((node / across) % (scene.rows + 1u), node % across);
}

/// The node at a row and column of a ply.
fn node_at(ply: u32, place: vec2<u32>) -> u32 {
    return (ply_number(ply) * (scene.rows + 1u) + place.x) * (scene.columns + 1u) + place.y;
}

/// The element at a row and column of a ply.
fn element_at(ply: u32, place: vec2<u32>) -> u32 {
    return (ply_number(ply) * scene.rows + place.x) * scene.columns + place.y;
}

/// Ply of an element.
fn element_ply(element: u32) -> u32 { return (element / scene.columns) / scene.rows - ply_number(0u); }

/// Row within its ply and column of an element.
fn element_place(element: u32) -> vec2<u32> {
    return vec2<u32>((element / scene.columns) % scene.rows, element % scene.columns);
}

/// Corners of an element, counter-clockwise.
fn corners(element: u32) -> vec4<u32> {
    let row = element / scene.columns;
    let column = element % scene.columns;
    let across = scene.columns + 1u;
    let first = (row + row / scene.rows) * across + column;
    return vec4<u32>(first, first + 1u, first + 1u + across, first + across);
}

/// Whether the storage at a place of a ply holds a node.
fn is_node(ply: u32, place: vec2<u32>) -> bool { return place.x <= plies[ply].rows && place.y <= plies[ply].columns; }

/// Whether the storage at a place of a ply holds an element.
fn is_element(ply: u32, place: vec2<u32>) -> bool { return place.x < plies[ply].rows && place.y < plies[ply].columns; }

/// Directions in which a node is held.
fn held(ply: u32, place: vec2<u32>) -> u32 {
    let sides = plies[ply].held;
    var bits = 0u;
    bits |= select(0u, sides, place.y == 0u);
    bits |= select(0u, sides >> 3u, place.y == plies[ply].columns);
    bits |= select(0u, sides >> 6u, place.x == 0u);
    bits |= select(0u, sides >> 9u, place.x == plies[ply].rows);
    if (is_framed(ply)) { bits |= select(0u, 7u, in_frame(ply, SHARES, place) <= 0.0); }
    return bits & 7u;
}

/// Mass of a node over that of an inner one of the finest elements: where these are even, a half on each edge it lies on.
fn mass_share(ply: u32, place: vec2<u32>) -> f32 {
    if (is_framed(ply)) { return abs(in_frame(ply, SHARES, place)); }
    if (GRADED) { return line_at(ply, 0u, place.y).share * line_at(ply, 1u, place.x).share; }
    let row = place.x == 0u || place.x == plies[ply].rows;
    let column = place.y == 0u || place.y == plies[ply].columns;
    return select(1.0, 0.5, row) * select(1.0, 0.5, column);
}

fn node_mass(ply: u32, place: vec2<u32>) -> f32 { return plies[ply].mass * mass_share(ply, place); }

/// 1/mass by direction of the ply [1/kg], 0 where held.
fn inverse_mass(ply: u32, place: vec2<u32>) -> vec3<f32> {
    let inverse = plies[ply].inverse_mass / mass_share(ply, place);
    let bits = vec3<u32>(held(ply, place)) & vec3<u32>(1u, 2u, 4u);
    return select(vec3<f32>(inverse), vec3<f32>(0.0), bits != vec3<u32>(0u));
}

/// Sides of a ply that mirror planes cut: 1 left, 2 right, 4 bottom, 8 top.
fn cut_sides(ply: u32) -> u32 { return plies[ply].held >> 12u; }

/// Whether a node lies on a plane that cuts the ply across its X, across its Y.
fn cut_across(ply: u32, place: vec2<u32>) -> vec2<bool> {
    let cut = cut_sides(ply);
    let low = vec2<bool>(place.y == 0u && (cut & 1u) != 0u, place.x == 0u && (cut & 4u) != 0u);
    let high = vec2<bool>(
        place.y == plies[ply].columns && (cut & 2u) != 0u, place.x == plies[ply].rows && (cut & 8u) != 0u);
    return low | high;
}

/// The part of a node that is there: a half where a plane cuts it, a quarter where two do.
fn part_of(ply: u32, place: vec2<u32>) -> f32 {
    let parts = select(vec2<f32>(1.0), vec2<f32>(0.5), cut_across(ply, place));
    return parts.x * parts.y;
}

/// Inverse masses by direction of the pack. Rollers, which tell the directions apart, hold only plies laid along its axes.
fn inverse_in_pack(ply: u32, place: vec2<u32>) -> vec3<f32> {
    let inverse = inverse_mass(ply, place);
    return select(inverse, inverse.yxz, abs(plies[ply].sine) > 0.5 && inverse.x != inverse.y);
}

/// A vector of the ply's axes in those of the pack.
fn to_pack(ply: u32, v: vec3<f32>) -> vec3<f32> {
    let c = plies[ply].cosine;
    let s = plies[ply].sine;
    return vec3<f32>(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

/// A vector of the pack's axes in those of the ply.
fn to_ply(ply: u32, v: vec3<f32>) -> vec3<f32> {
    let c = plies[ply].cosine;
    let s = plies[ply].sine;
    return vec3<f32>(c * v.x + s * v.y, c * v.y - s * v.x, v.z);
}

/// Reference position of a node in the ply's axes, its depth in the pack in z [m].
fn reference(ply: u32, place: vec2<u32>) -> vec3<f32> {
    var lies = plies[ply].origin + plies[ply].length * vec2<f32>(place.yx);
    if (GRADED) { lies = vec2<f32>(line_at(ply, 0u, place.y).place, line_at(ply, 1u, place.x).place); }
    return vec3<f32>(lies, plies[ply].z);
}

/// First element above and to the right of a node, as if the ply went on.
fn element_above(node: u32, place: vec2<u32>) -> u32 { return element_at(node_ply(node), place); }

/// Presence of the elements above right, above left, below left and below right of a node.
fn adjacent_elements(ply: u32, place: vec2<u32>) -> vec4<bool> {
    let above = place.x < plies[ply].rows;
    let below = place.x > 0u;
    let right = place.y < plies[ply].columns;
    let left = place.y > 0u;
    return vec4<bool>(above && right, above && left, below && left, below && right);
}

fn node_word(slot: u32, field: u32, node: u32) -> u32 { return (6u * slot + field) * scene.nodes + node; }

/// Vector of a node in the axes of its ply, from its first field on: 0 displacement [m], 3 velocity [m/s].
fn vector_in(slot: u32, field: u32, node: u32) -> vec3<f32> {
    let at = node_word(slot, field, node);
    return vec3<f32>(nodes[at], nodes[at + scene.nodes], nodes[at + 2u * scene.nodes]);
}

/// Vector of a node in the slot that this step writes.
fn node_vector(field: u32, node: u32) -> vec3<f32> { return vector_in(slot_now(), field, node); }

/// Place of such a number of a node, behind both slots.
fn clay_word(which: u32, node: u32) -> u32 { return node_word(2u, which, node); }

/// Whether a ply has clay behind it.
fn has_clay(ply: u32) -> bool { return BACKING && 0.0 < plies[ply].clay_rate; }

/// Velocity of a node before the forces of this step, less what clay took since, which is no force [m/s].
fn velocity_before(ply: u32, node: u32) -> vec3<f32> {
    let v = vector_in(slot_before(), 3u, node);
    if (!has_clay(ply)) { return v; }
    return v - vec3<f32>(0.0, 0.0, nodes[clay_word(TAKEN, node)]);
}

/// Rows first and end, columns first and end, of the nodes of a ply that may have moved.
fn reach_of(ply: u32) -> vec4<u32> {
    let at = counter(REACH + 4u * ply);
    return vec4<u32>(
        atomicLoad(&status[at]), atomicLoad(&status[at + 1u]), atomicLoad(&status[at + 2u]), atomicLoad(&status[at + 3u]));
}

/// Whether a place lies in a reach with `before` more rows and columns at its beginning and `after` more at its end. Nodes of the reach and
/// of the ring around it: 1, 1. Elements with a corner in the reach: 1, 0; with a corner in the ring: 2, 1.
fn is_near(reach: vec4<u32>, place: vec2<u32>, before: u32, after: u32) -> bool {
    let row = place.x + before >= reach.x && place.x < reach.y + after;
    let column = place.y + before >= reach.z && place.y < reach.w + after;
    return row && column && reach.x < reach.y;
}

/// Takes a node in.
fn touch(ply: u32, place: vec2<u32>) {
    let at = counter(REACH + 4u * ply);
    atomicMin(&status[at], place.x);
    atomicMax(&status[at + 1u], place.x + 1u);
    atomicMin(&status[at + 2u], place.y);
    atomicMax(&status[at + 3u], place.y + 1u);
}
