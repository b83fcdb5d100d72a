// scene: constants of a run, the step at hand, the shot of a batch that a workgroup computes, what that has of its own, and where its part of
// storage begins. Fields of nodes and elements hold those of all shots, one shot after another: number of a node and of an element say which
// shot they are of. All else a shot has is in one piece.
// Twin: src/gpu/layout/scene.rs and `status` of src/gpu/layout/mod.rs

// What only the device rounds or counts.
/// Rounding of relative velocities, over the largest speed of the body.
const ROUNDOFF_TOLERANCE: f32 = 1e-6;
/// Part of a finest cell by which a yarn may run on too short: what a sum of widths rounds to.
const WITHIN: f32 = 1e-3;
/// Contacts between plies are counted by weight in these: counts that make a whole share of a node's mass.
const SHARE_UNIT: f32 = 1048576.0;

// What a scene lacks is compiled out where it is much. A branch that all invocations take alike costs next to nothing, and
// a kernel more to compile one to six seconds on software Vulkan.
/// Whether the unit-cell law is the variational one; else it is the published one.
override VARIATIONAL: bool = false;
/// The yarn whose height is the unknown: 0 warp, 1 weft.
override PIVOT: u32 = 0u;
/// Terms of the arc length series.
override TERMS: u32 = 12u;
/// Whether yarns flatten where they cross.
override COMPRESSION: bool = true;
/// Ramps of the curves of yarns that are not linear; 0: all are linear.
override CURVE: u32 = 0u;
/// Whether the fabric resists trellis shear.
override SHEAR: bool = true;
/// Yarns have forces that depend on rates: of shock viscosity or of the rate of strain.
override VISCOUS: bool = true;
/// Stress of the yarns depends on the rate of strain.
override RATE: bool = false;
/// Whether pieces of yarn differ in strength.
override STRENGTH: bool = true;
/// Whether the rim of its face is sampled where it crosses the edges of elements.
override EDGES: bool = true;
/// There are several plies, which another kernel has searched.
override PACK: bool = true;
// Kernels over all elements or nodes in every step are compiled with and without what follows. Others ask for it, or read the lines of even meshes, too.
/// Whether elements of a ply differ in size.
override GRADED: bool = true;
/// A frame cuts or holds a ply elsewhere than at the sides of its mesh; clay stands behind the last ply.
override FRAME: bool = true;
override BACKING: bool = true;

/// Invocations of the workgroup of contact with the projectile: more where more may touch. A card waits for memory most of the time, for
/// all of them together; where few have work, every barrier waits for the others.
override WIDTH: u32 = 256u;

/// Rows of elements of a tile that `sweep` computes: few where a ply is a strip.
override TILE_ROWS: u32 = 16u;

/// Invocations per workgroup of the kernels over elements and nodes.
const GROUP: u32 = 64u;

/// Constants of a run and of one of its ply types, that is of alike plies.
struct Scene {
    // Storage: room of every ply for elements along weft and warp.
    columns: u32,
    rows: u32,
    /// Elements and nodes of all shots of the batch together: the length of a field.
    elements: u32,
    nodes: u32,
    /// Elements and nodes of one shot.
    shot_elements: u32,
    shot_nodes: u32,
    plies: u32,
    /// Ply type of the constants below.
    ply_type: u32,
    // Of warp and weft: EA [N], w0 [m], crimp, failure strain, and dF/dε of the continuation to slack yarns [N].
    stiffness: vec2<f32>,
    half_span: vec2<f32>,
    crimp: vec2<f32>,
    failure_strain: vec2<f32>,
    slack: vec2<f32>,
    // Element.
    gradient: vec2<f32>,
    membrane: vec2<f32>,
    half_length: vec2<f32>,
    hourglass: vec2<f32>,
    /// Shock viscosity over the stiffness [s].
    viscosity: vec2<f32>,
    /// Length of an element above which the shock viscosity of smooth waves grows no more, over that of the finest.
    viscous_length: vec2<f32>,
    /// Half the failure length along warp and weft, in lengths of the finest element.
    failure_reach: vec2<f32>,
    // Unit cell; forces [N], lengths [m].
    height_sum: f32,
    compression_a: f32,
    compression_b: f32,
    compression_offset: f32,
    /// a/b, and 1/b.
    compression_uncompressed: f32,
    compression_per_b: f32,
    /// Least stiffness of a contact force that Newton's steps reckon with [N/m].
    min_stiffness: f32,
    /// Rounding of a contact force [N].
    roundoff_tolerance: f32,
    tolerance: f32,
    // Trellis shear, times thickness [N/m].
    shear_g1: f32,
    shear_rise: f32,
    shear_gamma1: f32,
    shear_ramp: f32,
    shear_slope: f32,
    /// 1 over the stretch that a front adds while it crosses an element, and from which the viscosity of the whole length acts, over
    /// the coefficient of the viscosity.
    per_steep: f32,
    /// Law of Cowper and Symonds: C [1/s], P; the most that the rate of strain adds to a stress, over that.
    rate_c: f32,
    rate_power: f32,
    rate_most: f32,
    /// Share of the square of half the difference of opposite edges in the square of a stretch.
    mode_share: f32,
    cells: f32,
    area: f32,
    dt: f32,
    // Projectile.
    body_radius: f32,
    body_bounding_radius: f32,
    /// From the centre of mass to the tip of the nose along the axis [m].
    body_nose: f32,
    /// From the tip of the nose, as are all places along the axis: the end, the foremost widest section [m].
    body_back: f32,
    body_shoulder: f32,
    body_prescribed: u32,
    body_bar: u32,
    friction: f32,
    ply_friction: f32,
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
    /// Room for contact points, none without a projectile.
    points: u32,
    /// Workgroups of the energy balance.
    groups: u32,
    /// Directions that mirror planes hold: velocity x, y, z, turning about x, y, z, a bit each; every turning of a locked body.
    body_held: u32,
    /// Mirror planes that the scene has, cut there or not: 1 x = 0, 2 y = 0.
    mirror: u32,
    /// Room for points of the rim on each ply.
    constraints: u32,
    /// Place in `nodes` where the grid lines begin.
    lines: u32,
    /// About the body's own axes [kg·m²].
    body_inertia: vec3<f32>,
    body_mass: f32,
    /// Corner (ρ, s) and outward normal (ρ, s) of the side that begins there.
    profile: array<vec4<f32>, 5>,
}

struct Step {
    /// Counted from 0.
    index: u32,
    /// Place where the energy balance writes this step, or `NONE`.
    slot: u32,
    /// Steps since the last sample.
    since: u32,
    /// Δt of the velocity update [s]: half a step at the start.
    kick: f32,
    /// Time since the last forces [s]: 0 at the start.
    span: f32,
}

// Words of `status`, shot by shot.
/// First step that produced a number that is not finite; nothing happens after it.
const BAD_STEP: u32 = 0u;
const EVENTS: u32 = 1u;
const FAILED: u32 = 2u; // warp, weft
const ERODED: u32 = 4u;
const UNCONVERGED: u32 = 5u;
/// Bits of the largest residual.
const RESIDUAL: u32 = 6u;
/// Set when more nodes meet the projectile than there is room for.
const OVERFLOW: u32 = 7u;
/// Elements computed so far, low and high word.
const COMPUTED: u32 = 8u;
/// Bits of the largest depth of a node in a neighbouring ply [m].
const PLY_DEPTH: u32 = 10u;
/// Set when more points of the rim meet a ply than there is room for.
const OVERFLOW_EDGES: u32 = 11u;
/// The step after the last one in which an element reached its failure strain.
const AT_LIMIT: u32 = 12u;
/// Elements without a yarn that carried load when the run began.
const HOLES: u32 = 13u;
/// Nodes that may have moved: first and one past the last row, then column, of each ply.
const REACH: u32 = 14u;
/// Words before that.
const STATUS_WORDS: u32 = 14u;

/// No step, place, ply.
const NONE: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var<uniform> step: Step;
@group(0) @binding(2) var<uniform> plies: array<Ply, 64>;

/// Place of an invocation in a dispatch, which may spread over two dimensions; the third counts shots.
struct Invocation {
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
}

/// Whether the step fills in the energies of the state. No constant: a kernel of its own would take as long to compile again.
fn is_sampled() -> bool { return step.slot != NONE; }

/// There is a projectile.
fn has_projectile() -> bool { return scene.points > 0u; }

/// Nodes and elements lie in two slots by turns: a step reads what the last one left, and writes the other slot.
fn slot_before() -> u32 { return (step.index + 1u) & 1u; }

fn slot_now() -> u32 { return step.index & 1u; }

/// Number of an invocation among those of its shot.
fn invocation_number(id: Invocation) -> u32 { return (id.group.y * id.groups.x + id.group.x) * GROUP + id.local; }

/// Constants of a shot.
struct Shot {
    /// Velocity of the projectile at the start [m/s].
    impact: vec3<f32>,
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
@group(0) @binding(4) var<uniform> shots: array<Shot, 2048>;

/// The one at hand; every kernel takes it from `shots` first.
var<private> shot: Shot;

fn first_node() -> u32 { return shot.number * scene.shot_nodes; }

fn first_element() -> u32 { return shot.number * scene.shot_elements; }

/// A ply of the shot among those of all shots.
fn ply_number(ply: u32) -> u32 { return shot.number * scene.plies + ply; }

/// Place of a word of the shot in `status`.
fn counter(word: u32) -> u32 { return shot.number * (STATUS_WORDS + 4u * scene.plies) + word; }

/// Numbers of every 32 nodes there: a bit for each node near the projectile, how many such nodes come before, and a bit for each node, each edge on
/// along its row and along its column that might have touched in the last step and did not push.
const MARKS: u32 = 5u;
const BEFORE: u32 = 1u;
const IDLE: u32 = 2u;

/// Words of a bit for every node of a shot.
fn mark_words() -> u32 { return (scene.shot_nodes + 31u) >> 5u; }

/// Place of a word of the shot in `candidates`.
fn mark_word(word: u32) -> u32 { return shot.number * MARKS * mark_words() + word; }

/// Place of a number of the 32 nodes that a node is one of, and its bit there.
fn mark_at(what: u32, node: u32) -> u32 { return mark_word(what * mark_words() + ((node - first_node()) >> 5u)); }

fn mark_bit(node: u32) -> u32 { return 1u << ((node - first_node()) & 31u); }

/// Place of a point of the shot in `points`.
fn point_number(point: u32) -> u32 { return shot.number * scene.points + point; }

/// Place of a touch of the shot in `touches`.
fn touch_number(at: u32) -> u32 { return shot.number * (scene.points + scene.plies * scene.constraints) + at; }

/// Room for members of a ply: three for each point of the rim, and `NONE` behind the last.
fn member_room() -> u32 { return 3u * scene.constraints + 1u; }

/// Place of a member of the shot in `members`.
fn member_number(member: u32) -> u32 { return shot.number * scene.plies * (2u * member_room() + FOUND_WORDS) + member; }

/// Entries of a row of `matrix` that there is room for in the mean: rows begin with the first member of their block, and most blocks are short.
const MATRIX_ROW: u32 = 32u;

/// Room for entries of a ply.
fn matrix_room() -> u32 { return 3u * scene.constraints * MATRIX_ROW; }

/// Place of an entry of the shot in `matrix`.
fn matrix_number(entry: u32) -> u32 { return shot.number * scene.plies * matrix_room() + entry; }

/// Place of the block of a member there, while members are sorted.
fn block_number(member: u32) -> u32 { return member_number(scene.plies * member_room() + member); }

/// What the search found on a ply, behind members and blocks: sums of `assemble`, points up to its last, edge constraints, bits of `penetration`.
const FOUND_WORDS: u32 = 30u;
const FOUND_POINTS: u32 = 27u;
const FOUND_CONSTRAINTS: u32 = 28u;
const FOUND_PENETRATION: u32 = 29u;

/// Place of a word of that.
fn found_number(ply: u32, word: u32) -> u32 { return member_number(2u * scene.plies * member_room() + ply * FOUND_WORDS + word); }
