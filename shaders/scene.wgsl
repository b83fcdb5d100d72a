// scene: constants of a run, the step at hand, and where a node or an element lies.
// Twin: src/gpu/layout.rs

// What a scene lacks is compiled out.
/// 0 published with T in the plane, 1 published with T cos α, 2 variational, 3 Kawabata.
override LAW: u32 = 0u;
/// The yarn whose height is the unknown: 0 warp, 1 weft.
override PIVOT: u32 = 0u;
/// Terms of the arc length series.
override TERMS: u32 = 12u;
/// Whether yarns flatten where they cross.
override COMPRESSION: bool = true;
override SHEAR: bool = true;
/// Whether the shear modulus is a secant one.
override SECANT: bool = true;
override HOURGLASS: bool = true;
override FAILURE: bool = true;
override PROJECTILE: bool = true;
override FRICTION: bool = true;
/// Whether the projectile may turn.
override ROTATION: bool = true;
/// Whether the step fills in the energies of the state.
override LEDGER: bool = true;

/// Invocations per workgroup of the kernels over elements and nodes.
const GROUP: u32 = 64u;

struct Scene {
    // Mesh.
    columns: u32,
    rows: u32,
    elements: u32,
    nodes: u32,
    origin_x: f32,
    origin_y: f32,
    length_x: f32,
    length_y: f32,
    // Unit cell; forces [N], lengths [m].
    warp_stiffness: f32,
    warp_half_span: f32,
    warp_crimp: f32,
    warp_failure_strain: f32,
    warp_slack: f32,
    weft_stiffness: f32,
    weft_half_span: f32,
    weft_crimp: f32,
    weft_failure_strain: f32,
    weft_slack: f32,
    height_sum: f32,
    compression_a: f32,
    compression_b: f32,
    compression_offset: f32,
    tolerance: f32,
    // Trellis shear, times thickness [N/m].
    shear_g1: f32,
    shear_rise: f32,
    shear_gamma1: f32,
    shear_ramp: f32,
    shear_slope: f32,
    // Element.
    gradient_x: f32,
    gradient_y: f32,
    membrane_warp: f32,
    membrane_weft: f32,
    half_length_warp: f32,
    half_length_weft: f32,
    hourglass: f32,
    cells: f32,
    area: f32,
    /// Yarns that are there: 1 warp, 2 weft.
    present: u32,
    // Nodes: mass [kg] of an inner one, 1/mass of an inner, edge and corner node, held directions (1 x, 2 y, 4 z).
    mass: f32,
    inverse_inner: f32,
    inverse_edge: f32,
    inverse_corner: f32,
    held_left: u32,
    held_right: u32,
    held_bottom: u32,
    held_top: u32,
    dt: f32,
    // Projectile.
    body_mass: f32,
    /// About the body's own axes [kg·m²].
    body_inertia_x: f32,
    body_inertia_y: f32,
    body_inertia_z: f32,
    body_radius: f32,
    body_reach: f32,
    /// From the centre of mass to the tip of the nose along the axis [m].
    body_nose: f32,
    /// From the tip of the nose, as are all places along the axis: the end, the foremost widest section [m].
    body_back: f32,
    body_shoulder: f32,
    body_prescribed: u32,
    body_bar: u32,
    impact_x: f32,
    impact_y: f32,
    impact_z: f32,
    friction: f32,
    rim_depth: f32,
    profile_radius: f32,
    profile_count: u32,
    profile_flat: u32,
    /// Radius of the first side where that is an arc, or 0 [m].
    profile_arc: f32,
    /// Whether flats cut the nose to a chisel; half width of the strip they leave and half length of its sides [m].
    chisel: u32,
    chisel_half: f32,
    chisel_sine: f32,
    chisel_cosine: f32,
    chisel_slope: f32,
    chisel_corner: f32,
    /// Room for contact points.
    points: u32,
    /// Workgroups of the ledger.
    groups: u32,
    pad0: u32,
    /// Corner (ρ, s) and outward normal (ρ, s) of the side that begins there.
    profile: array<vec4<f32>, 5>,
}

struct Step {
    /// Counted from 0.
    index: u32,
    /// Where the ledger writes this step.
    slot: u32,
    /// Steps since the last ledger.
    since: u32,
    /// Δt of the velocity update [s]: half a step at the start.
    kick: f32,
    /// Time since the last forces [s]: 0 at the start.
    span: f32,
    /// What may have moved; the rest is at rest and left alone.
    first_element: u32,
    end_element: u32,
    first_node: u32,
    end_node: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

// Words of `status`.
/// First step that produced a number that is not finite; nothing happens after it.
const BAD_STEP: u32 = 0u;
const EVENTS: u32 = 1u;
const FAILED: u32 = 2u; // warp, weft
const ERODED: u32 = 4u;
const UNCONVERGED: u32 = 5u;
/// Bits of the largest residual.
const RESIDUAL: u32 = 6u;
/// Set when more nodes meet the projectile than there is room for.
const CROWDED: u32 = 7u;

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<uniform> step: Step;

/// Number of an invocation in a dispatch that may spread over two dimensions.
fn invocation(group: vec3<u32>, groups: vec3<u32>, local: u32) -> u32 {
    return (group.y * groups.x + group.x) * GROUP + local;
}

/// Row within its ply and column of a node.
fn node_place(node: u32) -> vec2<u32> {
    let across = scene.columns + 1u;
    return vec2<u32>((node / across) % (scene.rows + 1u), node % across);
}

/// Corners of an element, counter-clockwise.
fn corners(element: u32) -> vec4<u32> {
    let row = element / scene.columns;
    let column = element % scene.columns;
    let across = scene.columns + 1u;
    let first = (row + row / scene.rows) * across + column;
    return vec4<u32>(first, first + 1u, first + 1u + across, first + across);
}

/// Directions in which a node is held.
fn held(place: vec2<u32>) -> u32 {
    var bits = 0u;
    bits |= select(0u, scene.held_bottom, place.x == 0u);
    bits |= select(0u, scene.held_top, place.x == scene.rows);
    bits |= select(0u, scene.held_left, place.y == 0u);
    bits |= select(0u, scene.held_right, place.y == scene.columns);
    return bits;
}

/// Edges a node lies on: 0, 1 or 2.
fn edges(place: vec2<u32>) -> u32 {
    let row = place.x == 0u || place.x == scene.rows;
    let column = place.y == 0u || place.y == scene.columns;
    return u32(row) + u32(column);
}

fn node_mass(place: vec2<u32>) -> f32 {
    return scene.mass * select(select(1.0, 0.5, edges(place) == 1u), 0.25, edges(place) == 2u);
}

/// 1/mass by direction [1/kg], 0 where held.
fn inverse_mass(place: vec2<u32>) -> vec3<f32> {
    let count = edges(place);
    let inverse = select(select(scene.inverse_inner, scene.inverse_edge, count == 1u), scene.inverse_corner, count == 2u);
    let bits = held(place);
    return select(vec3<f32>(inverse), vec3<f32>(0.0), (vec3<u32>(bits) & vec3<u32>(1u, 2u, 4u)) != vec3<u32>(0u));
}

/// Reference position of a node [m].
fn reference(place: vec2<u32>) -> vec3<f32> {
    let x = scene.origin_x + scene.length_x * f32(place.y);
    let y = scene.origin_y + scene.length_y * f32(place.x);
    return vec3<f32>(x, y, 0.0);
}
