// shot: the shot of a batch that a workgroup computes, what it has of its own, and where its part of storage begins. Fields of nodes and
// elements hold those of all shots, one shot after another: number of a node and of an element say which shot they are of. All else a
// shot has is in one piece.
// Twin: src/gpu/layout/uniforms.rs

/// Constants of a shot.
struct Shot {
    /// Velocity of the projectile at the start [m/s].
    impact_x: f32,
    impact_y: f32,
    impact_z: f32,
    /// An impulse between plies is counted in these [N·s].
    impulse_unit: f32,
    /// Largest distance that any node may go in a step [m].
    travel: f32,
    /// Place in storage.
    number: u32,
    pad0: u32,
    pad1: u32,
}

/// Shots that run, in the order of the layers of a dispatch: one that has ended is not dispatched.
@group(0) @binding(5) var<uniform> shots: array<Shot, 2048>;

/// The one at hand; every kernel takes it from `shots` first.
var<private> shot: Shot;

fn first_node() -> u32 { return shot.number * scene.shot_nodes; }

fn first_element() -> u32 { return shot.number * scene.shot_elements; }

/// A ply of the shot among those of all shots.
fn ply_number(ply: u32) -> u32 { return shot.number * scene.plies + ply; }

/// Place of a word of the shot in `status`.
fn counter(word: u32) -> u32 { return shot.number * (STATUS_WORDS + 4u * scene.plies) + word; }

/// Words of a bit for every node of a shot, and of a bit for every such word.
fn mark_words() -> vec2<u32> {
    let words = (scene.shot_nodes + 31u) >> 5u;
    return vec2<u32>(words, (words + 31u) >> 5u);
}

/// Place of a word of the shot in `candidates`.
fn mark_word(word: u32) -> u32 {
    let words = mark_words();
    return shot.number * (words.x + words.y) + word;
}

/// Place of a point of the shot in `points`.
fn point_number(point: u32) -> u32 { return shot.number * scene.points + point; }

/// Place of a touch of the shot in `touches`.
fn touch_number(at: u32) -> u32 { return shot.number * (scene.points + scene.plies * scene.constraints) + at; }

/// Place of a member of the shot in `members`: three for each point of the rim that a ply has room for.
fn member_number(member: u32) -> u32 { return shot.number * (2u * scene.plies * 3u * scene.constraints) + member; }

/// Entries of a row of `matrix` that there is room for in the mean: rows begin with the first member of their block, and most blocks are short.
const MATRIX_ROW: u32 = 32u;

fn matrix_room() -> u32 { return scene.plies * 3u * scene.constraints * MATRIX_ROW; }

/// Place of an entry of the shot in `matrix`.
fn matrix_number(entry: u32) -> u32 { return shot.number * matrix_room() + entry; }

/// Place of the block of a member there, while members are sorted.
fn block_number(member: u32) -> u32 { return member_number(scene.plies * 3u * scene.constraints + member); }
