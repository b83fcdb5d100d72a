// sums: numbers of the energy balance, of an invocation, a tile or a sample.
// Twin: `sum` of src/gpu/layout/mod.rs

// Those of a tile come first. Since the last sample:
/// Work on the elements, up to half a step after the positions [J].
const WORK: u32 = 0u;
/// Dissipated by shock viscosity [J].
const VISCOUS_WORK: u32 = 1u;
const EVALUATIONS: u32 = 2u;
/// Released by failures: by all but the hourglass stiffness, by that [J].
const RELEASED: u32 = 3u;
const RELEASED_HOURGLASS: u32 = 4u;
/// Made by the unit-cell law in cells that failed [J].
const LAW_RELEASED: u32 = 5u;
// Of the sampled step:
/// Work in the half step after the positions [J].
const HALF_STEP: u32 = 6u;
const STORED: u32 = 7u;
const HOURGLASS_NOW: u32 = 8u;
/// Made by the unit-cell law in whole cells since the start [J].
const LAW_MADE: u32 = 9u;
/// Cells solved, once for every step since the last sample.
const SOLVED: u32 = 10u;
const DEFLECTION: u32 = 11u;
const TENSION: u32 = 12u;
/// Largest strain of a whole piece of yarn over its failure strain.
const LOAD: u32 = 13u;
/// Numbers of a tile.
const TILE_SUMS: u32 = 14u;
const KINETIC: u32 = 14u;
const FASTEST: u32 = 15u;
const MOMENTUM: u32 = 16u;
const SUPPORT: u32 = 19u;
/// Elements ahead of the projectile with a yarn that runs on.
const COVERED: u32 = 22u;
/// Lost in contact between plies, of it to friction, and the work of moving nodes out of other plies [J].
const PLY_LOSS: u32 = 23u;
const PLY_FRICTION_WORK: u32 = 24u;
const PLY_SEPARATION_WORK: u32 = 25u;
/// Taken by clay behind the pack [J], and its deepest crater [m].
const CLAY_WORK: u32 = 26u;
const CLAY_DEPTH: u32 = 27u;
const SUMS: u32 = 28u;

/// Elements of a tile that `sweep` computes, one an invocation.
const INVOCATIONS: u32 = 256u;

/// Rows and columns of the elements that a tile owns.
fn owned_sides() -> vec2<u32> { return vec2<u32>(TILE_ROWS, INVOCATIONS / TILE_ROWS) - 1u; }

/// Tiles of a ply along its rows and columns: a node more than elements.
fn tile_counts() -> vec2<u32> { return (vec2<u32>(scene.rows, scene.columns) + owned_sides()) / owned_sides(); }

/// Place in `tiles` of a number of a tile of a ply.
fn tile_sum(ply: u32, tile: u32, which: u32) -> u32 { return (ply_number(ply) * tile_counts().x * tile_counts().y + tile) * TILE_SUMS + which; }

/// Sums of an invocation.
var<private> part: array<f32, 28>;

/// A number added to another, or the larger of both.
fn joined(which: u32, a: f32, b: f32) -> f32 {
    return select(a + b, max(a, b), which == DEFLECTION || which == TENSION || which == LOAD || which == FASTEST || which == CLAY_DEPTH);
}
