// grid_lines: the lines of nodes of graded meshes, or of elements narrower than a yarn, ply type by ply type: those along X, then those along Y.
// Twin: src/model/grid_lines.rs, src/model/ply_type.rs

/// Lines in a row of the table.
const LINES_ACROSS: u32 = 1024u;
/// Texels per line.
const LINE_TEXELS: u32 = 2u;

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
    let at = (2u * plies[ply].ply_type + axis) * (max(scene.columns, scene.rows) + 2u) + line;
    let texel = vec2<u32>(LINE_TEXELS * (at % LINES_ACROSS), at / LINES_ACROSS);
    let own = textureLoad(grid_lines, texel, 0);
    let yarn = textureLoad(grid_lines, texel + vec2<u32>(1u, 0u), 0);
    return Line(own.x, own.y, own.z, own.w, yarn.x, yarn.y, yarn.z, yarn.w);
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
/// element above and to the right of it is there. Four in a texel, after the lines.
const SHARES: u32 = 0u;
const PRESENCE: u32 = 1u;

fn in_frame(ply: u32, field: u32, place: vec2<u32>) -> f32 {
    let at = (field * (scene.rows + 1u) + place.x) * (scene.columns + 1u) + place.y;
    let across = LINE_TEXELS * LINES_ACROSS;
    let texel = vec2<u32>((at / 4u) % across, plies[ply].shares_row + at / 4u / across);
    return textureLoad(grid_lines, texel, 0)[at % 4u];
}

/// A frame cuts or holds plies elsewhere than at the sides of their meshes: the same for all plies of a pack.
fn is_framed(ply: u32) -> bool { return FRAME && plies[ply].shares_row > 0u; }

/// Whether an element is there: a frame leaves none outside its opening.
fn is_present(ply: u32, place: vec2<u32>) -> bool { return !is_framed(ply) || in_frame(ply, PRESENCE, place) > 0.0; }

/// Impulses between plies are counted at a node in units of 2 to the power of this: heavier nodes take larger ones. With `ceil` of a
/// single product it is the same in every kernel.
fn count_shift(ply: u32, place: vec2<u32>) -> u32 {
    if (!GRADED) { return 0u; }
    return 32u - countLeadingZeros(max(u32(ceil(mass_share(ply, place))), 1u) - 1u);
}
