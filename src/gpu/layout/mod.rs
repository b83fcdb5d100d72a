//! What the shaders see: words of the uniforms, of the projectile and of the ledger, in the order of the WGSL structs.
//!
//! Blocks are lists of named words, so that a test can hold every name and offset against the shaders' own structs.

mod motion;
mod shot;

pub use motion::*;
pub use shot::*;

use super::buffers::Sizes;
use crate::case::{Edge, Edges};
use crate::kernels::element_force::ElementConstants;
use crate::kernels::mirror_planes::Cut;
use crate::kernels::rigid_body::RigidBody;
use crate::model::cover::{shoulder, unbroken_cells};
use crate::model::{Mesh, Model, PlyType};

/// Invocations per workgroup of the kernels over elements and nodes.
pub const GROUP: u32 = 64;
/// A number for none: no step that went bad, no place, no ply.
pub const NONE: u32 = u32::MAX;
/// Fields of a node: displacement, velocity.
pub const NODE_FIELDS: u64 = 6;
/// Fields of an element's forces.
pub const FORCE_FIELDS: u64 = 9;
/// Fields of an element's heights: what predicts them, and the two.
pub const HEIGHT_FIELDS: u64 = 6;
/// Fields of an element's accounts.
pub const ACCOUNT_FIELDS: u64 = 10;
/// Fields of a node's accounts of contact between plies.
pub const PLY_ACCOUNT_FIELDS: u64 = 4;
/// Fields of an element whose yarns have shock viscosity: viscous forces of warp and weft.
pub const VISCOUS_FIELDS: u64 = 2;
/// Fields of an element whose yarns are judged over a length: strains of warp and weft in the last two steps.
pub const STRAIN_FIELDS: u64 = 4;
/// Failure strains of warp and weft over the fabric's, behind those, where strength varies.
pub const STRENGTH_FIELDS: u64 = 2;
/// Words of a contact between plies.
pub const CONTACT_WORDS: u64 = 8;
/// Fields of the impulses of contact between plies.
pub const IMPULSE_FIELDS: u64 = 6;
/// Words of what may have moved of a ply.
pub const REACH_WORDS: u64 = 4;
/// Most plies there are.
pub const PLIES: usize = 64;
/// Words of a ply.
pub const PLY_WORDS: usize = 24;
/// Numbers of a grid line.
pub const LINE_WORDS: usize = 8;
/// Texels of a grid line.
pub const LINE_TEXELS: usize = 2;
/// Grid lines in a row of their texture.
pub const LINES_ACROSS: usize = 1024;
/// Bytes between the constants of two ply types.
pub const SCENE_STRIDE: u64 = 512;
/// Words of a failure event.
pub const EVENT_WORDS: u64 = 4;
/// Words of a contact point, and of one where the rim is sampled too.
pub const POINT_WORDS: [u64; 2] = [20, 32];
/// Words of a place where the projectile may touch, where its rim is sampled too. Before the first of a shot there is one more.
pub const TOUCH_WORDS: u64 = 32;
/// Words of the counters.
pub const STATUS_WORDS: usize = 13;
/// Words of the projectile.
pub const BODY_WORDS: usize = 60;
/// Sums of a workgroup of the ledger.
pub const SUMS: usize = 26;
/// Bytes of a step's uniform.
pub const STEP_BYTES: u64 = 32;
/// Bytes between two steps' uniforms, the alignment every device grants.
pub const STEP_STRIDE: u64 = 256;

/// Words of `status`.
pub mod status {
    /// First step that produced a number that is not finite, or did not settle.
    pub const BAD_STEP: usize = 0;
    /// Failure events so far.
    pub const EVENTS: usize = 1;
    /// Failed warps and wefts.
    pub const FAILED: usize = 2;
    /// Eroded elements.
    pub const ERODED: usize = 4;
    /// Unit cells that did not meet the residual.
    pub const UNCONVERGED: usize = 5;
    /// Bits of the largest residual.
    pub const RESIDUAL: usize = 6;
    /// Nodes that met the projectile when there was no room for them.
    pub const OVERFLOW: usize = 7;
    /// Elements computed so far, low and high word.
    pub const COMPUTED: usize = 8;
    /// Bits of the largest depth of a node in a neighbouring ply.
    pub const PLY_DEPTH: usize = 10;
    /// Points of the rim that met a ply when there was no room for them.
    pub const OVERFLOW_EDGES: usize = 11;
    /// 1 where the set of points that push had not settled at the end of the bad step.
    pub const NOT_CONVERGED: usize = 12;
    /// What may have moved of each ply begins here.
    pub const REACH: usize = 13;
}

/// Sums of the ledger.
pub mod sum {
    /// Work on the elements since the last ledger [J].
    pub const WORK: usize = 0;
    /// Released by failures since then [J].
    pub const RELEASED: usize = 1;
    /// Hourglass energy released since then [J].
    pub const RELEASED_HOURGLASS: usize = 2;
    /// Elastic energy by state functions [J].
    pub const STORED: usize = 3;
    /// Hourglass energy [J].
    pub const HOURGLASS_NOW: usize = 4;
    /// Largest tension [N].
    pub const TENSION: usize = 5;
    /// Largest deflection [m].
    pub const DEFLECTION: usize = 6;
    /// Residual evaluations since then.
    pub const EVALUATIONS: usize = 7;
    /// Unit cells solved since then.
    pub const SOLVED: usize = 8;
    /// ½ m v² [J].
    pub const KINETIC: usize = 9;
    /// Kinetic energy at the time of the positions [J].
    pub const KINETIC_NOW: usize = 10;
    /// Largest squared speed [m²/s²].
    pub const FASTEST: usize = 11;
    /// Momentum [kg·m/s], three components.
    pub const MOMENTUM: usize = 12;
    /// Impulse of the supports since then [N·s], three components.
    pub const SUPPORT: usize = 15;
    /// Whole elements ahead of the projectile.
    pub const COVERED: usize = 18;
    /// Lost in contact between plies since then [J].
    pub const PLY_LOSS: usize = 19;
    /// Of it to friction [J].
    pub const PLY_RUBBED: usize = 20;
    /// Work of moving nodes out of other plies, against membrane and hourglass forces [J].
    pub const PLY_LIFTED: usize = 21;
    /// Dissipated by shock viscosity since the last ledger [J].
    pub const VISCOUS: usize = 23;
    /// Made by the unit-cell law itself since the start [J].
    pub const LAW: usize = 24;
    /// Largest tension over breaking load [-].
    pub const LOAD: usize = 25;
}

/// Named words of a uniform, in order.
#[derive(Clone, Debug, Default)]
pub struct Block(Vec<(&'static str, u32)>);

impl Block {
    fn count(&mut self, name: &'static str, value: usize) {
        self.0.push((name, value as u32));
    }

    fn number(&mut self, name: &'static str, value: f32) {
        self.0.push((name, value.to_bits()));
    }

    fn double(&mut self, name: &'static str, value: f64) {
        self.number(name, value as f32);
    }

    /// Names in order, arrays once per word.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }

    /// The words.
    pub fn words(&self) -> Vec<u32> {
        self.0.iter().map(|(_, word)| *word).collect()
    }
}

/// The constants of the shots of a batch and of one of their ply types, with the room there is in the buffers.
pub fn scene(model: &Model<f32>, ply_type: usize, sizes: &Sizes) -> Block {
    let mut block = Block::default();
    let grid = &model.grid;
    block.count("columns", grid.columns);
    block.count("rows", grid.rows);
    block.count("elements", (sizes.shots * sizes.elements) as usize);
    block.count("nodes", (sizes.shots * sizes.nodes) as usize);
    block.count("shot_elements", sizes.elements as usize);
    block.count("shot_nodes", sizes.nodes as usize);
    block.count("plies", grid.plies);
    block.count("ply_type", ply_type);
    block.double("ply_friction", model.ply_friction);
    let ply_type = &model.ply_types[ply_type];
    element(&mut block, ply_type);
    block.double("dt", model.dt);
    projectile(&mut block, model);
    block.count("points", sizes.points as usize);
    block.count("groups", sizes.groups as usize);
    block.count("body_held", model.projectile.as_ref().map_or(0, body_held));
    block.count("mirror", model.mirror.0.into_iter().enumerate().map(|(axis, plane)| usize::from(plane) << axis).sum());
    block.count("ties", sizes.ties as usize);
    // The array begins at a multiple of sixteen bytes.
    while !block.0.len().is_multiple_of(4) {
        let pads = ["pad0", "pad1", "pad2"];
        let at = block.names().filter(|name| pads.contains(name)).count();
        block.count(pads[at], 0);
    }
    let body = model.projectile.as_ref();
    for i in 0..crate::kernels::projectile_shape::CORNERS {
        let [corner, normal] = body.map_or([[0.0; 2]; 2], |b| [b.body.profile.corner[i], b.body.profile.normal[i]]);
        for value in [corner[0], corner[1] - body.map_or(0.0, nose), normal[0], normal[1]] {
            block.double("profile", value);
        }
    }
    block
}

/// Mass of an inner node of the finest elements [kg].
fn node_mass(ply_type: &PlyType<f32>) -> f64 {
    ply_type.areal_density * ply_type.mesh.length[0] * ply_type.mesh.length[1]
}

/// Bytes between the law tables of two ply types: the table, to the alignment every device grants.
pub const LAW_STRIDE: u64 = 6656;

/// What the unit-cell law of a ply type makes of energy by itself, as the shaders see it: first place and places per stretch of warp and
/// weft, then the table.
pub fn law_energy(ply_type: &PlyType<f32>) -> Vec<u32> {
    let mut words = vec![0.0_f32; LAW_STRIDE as usize / 4];
    if let Some(table) = &ply_type.law_energy {
        let head = table.low.iter().chain(&table.per_stretch);
        for (word, value) in words.iter_mut().zip(head.chain(&table.values)) {
            *word = *value as f32;
        }
    }
    words.into_iter().map(f32::to_bits).collect()
}

/// The plies as the shaders see them.
pub fn plies(model: &Model<f32>) -> Vec<Block> {
    let mut out = Vec::with_capacity(PLIES);
    for (at, ply) in model.plies.iter().enumerate() {
        let ply_type = &model.ply_types[ply.ply_type];
        let mesh = &ply_type.mesh;
        let mass = node_mass(ply_type);
        let behind = model.plies.get(at + 1);
        // Plies that touch at rest do so exactly, whatever their places round to.
        let apart = behind.map_or(0.0, |next| next.z as f32 - ply.z as f32);
        let touching = (ply.touching as f32).min(apart);
        let present = ply_type.present.map(usize::from);
        let mut block = Block::default();
        block.count("rows", mesh.rows);
        block.count("columns", mesh.columns);
        block.count("ply_type", ply.ply_type);
        block.count("present", present[0] + 2 * present[1]);
        block.double("origin_x", mesh.origin[0]);
        block.double("origin_y", mesh.origin[1]);
        block.double("length_x", mesh.length[0]);
        block.double("length_y", mesh.length[1]);
        block.double("cosine", mesh.rotation[0]);
        block.double("sine", mesh.rotation[1]);
        block.double("z", ply.z);
        block.double("depth", ply.depth);
        block.number("touching", touching);
        block.double("thickness", ply.thickness);
        block.double("mass", mass);
        block.double("inverse_inner", 1.0 / mass);
        block.double("inverse_edge", 2.0 / mass);
        block.double("inverse_corner", 4.0 / mass);
        block.count("held", constrained(&ply_type.edges) | cut_sides(mesh) << 12);
        block.count("span", model.projectile.as_ref().map_or(0, |body| unbroken_cells(&ply_type.mesh, body)));
        block.double("longest", mesh.longest());
        for pad in ["pad0", "pad1", "pad2"] {
            block.count(pad, 0);
        }
        out.push(block);
    }
    out
}

/// A grid line across the X (0) or Y (1) of a ply of a ply type, with one more behind the last.
pub fn line(ply_type: &PlyType<f32>, axis: usize, line: usize) -> Block {
    let mesh = &ply_type.mesh;
    let last = [mesh.columns, mesh.rows][axis];
    let element = line.min(last - 1);
    let place = |line: usize| mesh.reference(line * axis, line * (1 - axis))[axis];
    let width = mesh.widths(element * axis, element * (1 - axis))[axis];
    let yarn = ply_type.failure_reach.side_by_side(mesh, axis, element);
    let mut block = Block::default();
    block.double("place", if line > last { place(last) + width * mesh.length[axis] } else { place(line) });
    block.double("width", width);
    block.double("per_width", 1.0 / width);
    block.double("share", if line > last { 0.0 } else { mesh.share(axis, line) });
    block.double("yarn_first", yarn.start as f64);
    block.double("yarn_end", yarn.end as f64);
    for pad in ["pad0", "pad1"] {
        block.double(pad, 0.0);
    }
    block
}

/// The grid lines of graded meshes, or of elements narrower than a yarn, as the shaders see them, shape (ply types, axes, room for the longest
/// axis), in whole rows of the texture; else a line that nobody reads.
pub fn lines(model: &Model<f32>) -> Vec<u32> {
    if !(model.features().graded || model.features().windows) {
        return vec![0; LINE_WORDS];
    }
    let room = model.grid.columns.max(model.grid.rows) + 2;
    let mut out = Vec::new();
    for ply_type in &model.ply_types {
        for (axis, elements) in [ply_type.mesh.columns, ply_type.mesh.rows].into_iter().enumerate() {
            let end = out.len() + room * LINE_WORDS;
            (0..elements + 2).for_each(|at| out.extend(line(ply_type, axis, at).words()));
            out.resize(end, 0);
        }
    }
    out.resize(out.len().next_multiple_of(LINES_ACROSS * LINE_WORDS), 0);
    out
}

/// Held directions of the sides, three bits each: left, right, bottom, top.
fn constrained(edges: &Edges) -> usize {
    let side = |edge: Edge, roller: usize| match edge {
        Edge::Clamped => 7,
        Edge::Roller => roller,
        Edge::Free => 0,
    };
    side(edges.left, 1) | side(edges.right, 1) << 3 | side(edges.bottom, 2) << 6 | side(edges.top, 2) << 9
}

/// Sides that mirror planes cut: left, right, bottom, top, a bit each.
fn cut_sides(mesh: &Mesh) -> usize {
    let [x, y] = mesh.cut.map(|cut| match cut {
        Cut::Nowhere => 0,
        Cut::First => 1,
        Cut::Last => 2,
    });
    x | y << 2
}

fn element(block: &mut Block, ply_type: &PlyType<f32>) {
    let c: ElementConstants<f32> = crate::with_law!(ply_type.law, L => ply_type.constants::<f32, L>());
    let names = [
        ["warp_stiffness", "warp_half_span", "warp_crimp", "warp_failure_strain", "warp_slack"],
        ["weft_stiffness", "weft_half_span", "weft_crimp", "weft_failure_strain", "weft_slack"],
    ];
    for (names, y) in names.into_iter().zip(&c.cell.yarn) {
        let values = [y.stiffness, y.half_span, y.crimp, y.failure_strain, y.slack_slope];
        names.into_iter().zip(values).for_each(|(name, value)| block.number(name, value));
    }
    block.number("height_sum", c.cell.height_sum);
    block.number("compression_a", c.cell.compression[0]);
    block.number("compression_b", c.cell.compression[1]);
    block.number("compression_offset", c.cell.compression[2]);
    block.number("compression_uncompressed", c.cell.uncompressed_limit);
    block.number("compression_per_b", c.cell.per_b);
    block.number("min_stiffness", c.cell.min_stiffness);
    block.number("roundoff_tolerance", c.cell.roundoff_tolerance);
    block.number("tolerance", c.cell.tolerance);
    block.number("shear_g1", c.shear.g1);
    block.number("shear_rise", c.shear.rise);
    block.number("shear_gamma1", c.shear.gamma1);
    block.number("shear_ramp", c.shear.ramp);
    block.number("shear_slope", c.shear.slope);
    block.number("gradient_x", c.gradient[0]);
    block.number("gradient_y", c.gradient[1]);
    block.number("membrane_warp", c.membrane[0]);
    block.number("membrane_weft", c.membrane[1]);
    block.number("half_length_warp", c.half_length[0]);
    block.number("half_length_weft", c.half_length[1]);
    block.number("hourglass_warp", c.hourglass[0]);
    block.number("hourglass_weft", c.hourglass[1]);
    block.number("viscosity_warp", c.viscosity[0]);
    block.number("viscosity_weft", c.viscosity[1]);
    let reach = &ply_type.failure_reach;
    block.double("failure_reach_warp", reach.along[0]);
    block.double("failure_reach_weft", reach.along[1]);
    block.number("cells", c.cells);
    block.number("area", c.area);
}

fn projectile(block: &mut Block, model: &Model<f32>) {
    // Without one the numbers are never read; a mass of one keeps them tame.
    let body = model.projectile.as_ref();
    let number = |pick: fn(&RigidBody) -> f64, none: f64| body.map_or(none, pick);
    let back = |b: &RigidBody| {
        let corners = b.body.profile.corner[..b.body.profile.count].iter().map(|c| c[1]);
        corners.fold(f64::MAX, f64::min) - b.body.profile.radius - nose(b)
    };
    block.double("body_mass", number(|b| b.mass, 1.0));
    block.double("body_inertia_x", number(|b| b.body.inertia[0], 1.0));
    block.double("body_inertia_y", number(|b| b.body.inertia[1], 1.0));
    block.double("body_inertia_z", number(|b| b.body.inertia[2], 1.0));
    block.double("body_radius", number(|b| b.body.radius, 0.0));
    block.double("body_bounding_radius", number(|b| b.body.bounding_radius, 1.0));
    block.double("body_nose", number(nose, 0.0));
    block.double("body_back", body.map_or(0.0, back));
    block.double("body_shoulder", number(|b| shoulder(b) - nose(b), 0.0));
    block.count("body_prescribed", body.map_or(0, |b| usize::from(b.prescribed)));
    block.count("body_bar", body.map_or(0, |b| usize::from(b.body.profile.bar)));
    block.double("friction", model.friction);
    block.double("rim_depth", number(|b| b.rim_depth, 0.0));
    block.double("profile_radius", number(|b| b.body.profile.radius, 0.0));
    block.count("profile_count", body.map_or(1, |b| b.body.profile.count));
    block.count("profile_flat", body.map_or(0, |b| usize::from(b.body.profile.is_flat())));
    block.double("profile_arc", number(|b| b.body.profile.arc, 0.0));
    let chisel = body.and_then(|b| b.body.profile.chisel);
    block.count("chisel", usize::from(chisel.is_some()));
    block.double("chisel_half", chisel.map_or(0.0, |c| c.half));
    block.double("chisel_sine", chisel.map_or(0.0, |c| c.sine));
    block.double("chisel_cosine", chisel.map_or(0.0, |c| c.cosine));
    block.double("chisel_slope", chisel.map_or(0.0, |c| c.slope));
    block.double("chisel_corner", chisel.map_or(0.0, |c| c.corner));
}

/// Directions that mirror planes hold: of velocity, of turning, a bit each.
fn body_held(body: &RigidBody) -> usize {
    let [moves, turns] = body.freedom;
    let free = moves.iter().chain(&turns);
    free.enumerate().filter(|(_, free)| **free == 0.0).map(|(bit, _)| 1 << bit).sum()
}

/// From the centre of mass to the tip of the nose along the axis [m]: what the device measures gaps from.
fn nose(body: &RigidBody) -> f64 {
    let profile = &body.body.profile;
    profile.corner[..profile.count].iter().map(|c| c[1]).fold(f64::MIN, f64::max) + profile.radius
}
