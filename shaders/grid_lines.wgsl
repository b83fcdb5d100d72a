// grid_lines: the lines of nodes of graded meshes, or of elements narrower than a yarn, ply type by ply type: those along X, then those along Y.
// They lie behind what `nodes` has of the shots. Needs `nodes`.
// Twin: src/model/grid_lines.rs, src/model/ply_type.rs

/// Numbers of a line.
const LINE_NUMBERS: u32 = 8u;

/// A line of nodes. The table has one more line after the last of a mesh.
struct Line {
    /// Reference place along the axis [m].
    place: f32,
    /// Length of the element behind it over the finest, and 1 over that [-].
    width: f32,
    per_width: f32,
    /// Half of each element beside it, over the finest [-].
    share: f32,
    /// The elements along the axis that lie side by side in a yarn with the one behind the line: the first, and one past the last.
    yarn_first: f32,
    yarn_end: f32,
    /// Elements along the axis that break with the one behind the line, in a yarn along it: the first, and one past the last.
    breaking_first: f32,
    breaking_end: f32,
}

/// A line of nodes across X (0) or Y (1) of a ply.
fn line_at(ply: u32, axis: u32, line: u32) -> Line {
    let number = (2u * plies[ply].ply_type + axis) * (max(scene.columns, scene.rows) + 2u) + line;
    let at = scene.lines + LINE_NUMBERS * number;
    return Line(
        nodes[at], nodes[at + 1u], nodes[at + 2u], nodes[at + 3u], nodes[at + 4u], nodes[at + 5u], nodes[at + 6u], nodes[at + 7u]);
}

/// Lengths along X and Y of a cell (row, column) of a ply [m].
fn cell_size(ply: u32, cell: vec2<u32>) -> vec2<f32> {
    let finest = plies[ply].length;
    if (!GRADED) { return finest; }
    return finest * vec2<f32>(line_at(ply, 0u, cell.y).width, line_at(ply, 1u, cell.x).width);
}

/// Area of a cell of a ply [m²].
fn cell_area(ply: u32, cell: vec2<u32>) -> f32 {
    let size = cell_size(ply, cell);
    return size.x * size.y;
}

/// Numbers of a node in a frame: its share of the mass of an inner node of the finest elements, not above 0 where it is held; and 1 where the
/// element above and to the right of it is there. They lie behind the lines.
const SHARES: u32 = 0u;
const PRESENCE: u32 = 1u;

fn in_frame(ply: u32, field: u32, place: vec2<u32>) -> f32 {
    return nodes[scene.lines + plies[ply].shares + (field * (scene.rows + 1u) + place.x) * (scene.columns + 1u) + place.y];
}

/// A frame cuts or holds plies elsewhere than at the sides of their meshes: the same for all plies of a pack.
fn is_framed(ply: u32) -> bool { return FRAME && plies[ply].shares > 0u; }

/// Whether an element is there: a frame leaves none outside its opening.
fn is_present(ply: u32, place: vec2<u32>) -> bool { return !is_framed(ply) || in_frame(ply, PRESENCE, place) > 0.0; }

/// Impulses between plies are counted at a node in units of 2 to the power of this: heavier nodes take larger ones. With `ceil` of a
/// single product it is the same in every kernel.
fn count_shift(ply: u32, place: vec2<u32>) -> u32 {
    if (!GRADED) { return 0u; }
    return 32u - countLeadingZeros(max(u32(ceil(mass_share(ply, place))), 1u) - 1u);
}
