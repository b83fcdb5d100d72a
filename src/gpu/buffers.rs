//! Storage buffers of a run: content and size of each, and the check that a device can hold them.

use super::DeviceError;
use super::layout::{
    BODY_WORDS, CONTACT_GROUPS, CONTACT_WORDS, CONTACT_WORK_FIELDS, EVENT_WORDS, FOUND_WORDS, IMPULSE_FIELDS,
    INVOCATIONS, MARKS, MATRIX_ROW, NODE_FIELDS, POINT_WORDS, REACH_WORDS, SHOTS, STATE_SLOTS, STATUS_WORDS,
    STRENGTH_FIELDS, TOUCH_WORDS, cell, clay, line_numbers, sum,
};
use crate::model::Model;

/// Samples of a submission at most.
pub(crate) const SLOTS: u32 = 64;
/// Submissions on their way at once: one computes while the next is recorded.
pub(crate) const IN_FLIGHT: usize = 2;
/// Failure events of a shot fetched with every submission; more are fetched when there are more.
pub(crate) const EVENT_WINDOW: u64 = 256;
/// Most nodes near the projectile there is room for.
const POINTS: u64 = 1 << 16;
/// Room for points of the projectile's edge on a ply: over those of a flat ply, and more for small ones. Crumpled fabric has more elements
/// under an edge.
const CONSTRAINTS: [f64; 2] = [4.0, 64.0];
/// Nodes and points of the projectile's edge that may push together, per point: it and the two ends of its side of an element.
const MEMBERS: u64 = 3;
/// Elements that a workgroup of the energy balance adds up before another one helps.
const BALANCE_ELEMENTS: usize = 256;
/// Workgroups of the energy balance at most.
const BALANCE_GROUPS: usize = 256;

/// Storage buffers: an identifier each, and the name of its variable in the shaders.
macro_rules! buffers {
    ($($(#[$doc:meta])* $id:ident = $variable:literal,)*) => {
        /// A storage buffer.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum BufferId {
            $($(#[$doc])* $id,)*
        }

        impl BufferId {
            /// Every buffer.
            pub const ALL: [Self; [$($variable),*].len()] = [$(Self::$id),*];

            /// Variable in the shaders.
            pub fn variable(self) -> &'static str {
                match self {
                    $(Self::$id => $variable,)*
                }
            }
        }
    };
}

buffers! {
    /// Displacement and velocity, shape (slots, 6, nodes); then, with clay behind the pack, what that has of a node, shape (3, nodes). Behind
    /// those of all shots the grid lines; see [`lines`](super::layout::lines).
    Nodes = "nodes",
    /// What elements keep from step to step, shape (slots, 7, elements); then strengths, shape (2, elements), where those vary; then, where stress
    /// depends on the rate of strain, its overstress, shape (slots, 2, elements).
    Cells = "cells",
    /// Sums of tiles, shape (tiles, 14).
    Tiles = "tiles",
    /// Energies of contact between plies, shape (5, nodes).
    ContactWork = "contact_work",
    /// Counters, shape (14,), and active regions, shape (plies, 4).
    Status = "status",
    /// Failures, shape (2·elements, 4): every yarn breaks once, so the list cannot overflow.
    Events = "events",
    /// Impulse of the supports, shape (3, nodes).
    Supports = "supports",
    /// The projectiles.
    Body = "bodies",
    /// Nodes near the projectile, a bit each; what else 32 nodes have there, see `MARKS` of shaders/scene.wgsl.
    Candidates = "candidates",
    /// Nodes near the projectile.
    Points = "points",
    /// Samples of the energy balance, shape (slots, words of a sample).
    Samples = "samples",
    /// Facing element in front of a node, behind it, shape (2, nodes).
    Over = "over",
    /// Contacts of a node with the ply in front, with the one behind, shape (2, nodes, 8).
    Contacts = "contacts",
    /// Contacts of a node by weight, shape (nodes,).
    Shares = "shares",
    /// Counted impulses, shape (nodes, 6).
    Impulses = "impulses",
    /// Places where the projectile may touch: those nodes, and points of its edge where it is sampled.
    Touches = "touches",
    /// Touching places that share nodes, ply by ply, and their blocks; then what the search found on each ply, shape (plies, 30).
    Members = "members",
    /// Equations of those, block by block.
    Matrix = "matrix",
}

/// Sizes of the buffers of a model, shot by shot but for the number of shots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Shots there is room for.
    pub shots: u64,
    /// Plies.
    pub plies: u64,
    /// Places for elements.
    pub elements: u64,
    /// Fields of an element; see [`BufferId::Cells`].
    pub cell_fields: u64,
    /// Rows of elements of a tile that are computed: few where a ply is a strip.
    pub tile_rows: u32,
    /// Tiles of a ply along its rows and columns.
    pub tiles: [u64; 2],
    /// Places for nodes.
    pub nodes: u64,
    /// Numbers of a node; see [`BufferId::Nodes`].
    pub node_fields: u64,
    /// Numbers of the grid lines, which all shots share.
    pub line_numbers: u64,
    /// Room for nodes near the projectile, none without one.
    pub points: u64,
    /// Room for points of the projectile's edge on each ply, none where it is not sampled.
    pub constraints: u64,
    /// Workgroups of the energy balance, as many for each ply.
    pub groups: u64,
    /// Invocations of the workgroup of contact with the projectile, and of those that search a ply each: more where more nodes may touch it.
    pub contact_groups: [u32; 2],
}

impl Sizes {
    /// Sizes for one shot of a model.
    pub fn new(model: &Model<f32>) -> Self {
        let (grid, features) = (&model.grid, model.features());
        let nodes = (model.plies.len() * model.nodes_per_ply()) as u64;
        let per_ply = grid.rows * grid.columns;
        let most = (BALANCE_GROUPS / grid.plies).max(1);
        let elements = (grid.plies * per_ply) as u64;
        let radius = model.projectile.as_ref().map_or(0.0, |projectile| projectile.body.radius);
        let shortest = model.ply_types.iter().map(|ply_type| ply_type.mesh.shortest()).fold(f64::INFINITY, f64::min);
        let side = |elements: usize| if elements <= 2 { 4 } else { 16 };
        let tile_rows = match [grid.rows, grid.columns].map(side) {
            [rows, 16] => rows,
            [_, columns] => INVOCATIONS / columns,
        };
        let tiles = |elements: usize, computed: u32| (elements as u64 + 1).div_ceil(u64::from(computed - 1));
        let touching = (2.0 * radius / shortest).powi(2) / model.mirror.copies() as f64;
        let group =
            |plies: usize| CONTACT_GROUPS[usize::from(touching * plies as f64 > f64::from(2 * CONTACT_GROUPS[0]))];
        Self {
            shots: 1,
            contact_groups: [grid.plies, 1].map(group),
            plies: grid.plies as u64,
            elements,
            cell_fields: STATE_SLOTS * cell::CELL_FIELDS as u64
                + model.strength.as_ref().map_or(0, |_| STRENGTH_FIELDS)
                + if features.rate { STATE_SLOTS * cell::RATE_FIELDS as u64 } else { 0 },
            tile_rows,
            tiles: [tiles(grid.rows, tile_rows), tiles(grid.columns, INVOCATIONS / tile_rows)],
            nodes,
            node_fields: STATE_SLOTS * NODE_FIELDS + if features.backing { clay::CLAY_FIELDS as u64 } else { 0 },
            line_numbers: line_numbers(model) as u64,
            points: if model.projectile.is_some() { nodes.min(POINTS) } else { 0 },
            constraints: if model.edges { constraints(model, radius / shortest) } else { 0 },
            groups: (grid.plies * per_ply.div_ceil(BALANCE_ELEMENTS).clamp(1, most)) as u64,
        }
    }

    /// Words of one sample.
    pub fn sample_words(&self) -> usize {
        self.groups as usize * sum::SUMS + BODY_WORDS + STATUS_WORDS
    }

    /// Sizes for `shots` shots.
    #[must_use]
    pub fn with_shots(self, shots: u64) -> Self {
        Self { shots, ..self }
    }

    /// Size of a buffer [bytes].
    pub fn bytes(&self, name: BufferId) -> u64 {
        let lines = if name == BufferId::Nodes { 4 * self.line_numbers } else { 0 };
        self.shots * self.bytes_of_shot(name) + lines
    }

    /// Place of the first number of the grid lines in their buffer.
    pub(crate) fn lines_at(&self) -> u64 {
        self.shots * self.bytes_of_shot(BufferId::Nodes) / 4
    }

    /// A shot's part of a buffer [bytes].
    pub(crate) fn bytes_of_shot(&self, name: BufferId) -> u64 {
        let [fields, count] = self.shape(name);
        4 * fields * count
    }

    /// Fields of a buffer, and words that a shot has of each; a field holds one shot after another.
    pub(crate) fn shape(&self, name: BufferId) -> [u64; 2] {
        // Nodes for which there is contact between plies.
        let meeting = if self.plies > 1 { self.nodes } else { 1 };
        let members = MEMBERS * self.constraints;
        match name {
            BufferId::Nodes => [self.node_fields, self.nodes],
            BufferId::Cells => [self.cell_fields, self.elements],
            BufferId::Tiles => [1, sum::TILE_SUMS as u64 * self.plies * self.tiles[0] * self.tiles[1]],
            BufferId::ContactWork => [CONTACT_WORK_FIELDS, meeting],
            BufferId::Status => [1, STATUS_WORDS as u64 + REACH_WORDS * self.plies],
            BufferId::Events => [1, 2 * EVENT_WORDS * self.elements],
            BufferId::Supports => [3, self.nodes],
            BufferId::Body => [1, BODY_WORDS as u64],
            BufferId::Candidates => [1, u64::from(MARKS) * self.nodes.div_ceil(32)],
            BufferId::Points => [1, (POINT_WORDS * self.points).max(1)],
            BufferId::Samples => [1, u64::from(SLOTS) * self.sample_words() as u64],
            BufferId::Over => [2, meeting],
            BufferId::Contacts => [2 * CONTACT_WORDS, meeting],
            BufferId::Shares => [1, meeting],
            BufferId::Impulses => [IMPULSE_FIELDS, meeting],
            BufferId::Touches => [1, (TOUCH_WORDS * (self.points + self.plies * self.constraints)).max(1)],
            BufferId::Members => [1, self.plies * (2 * (members + 1) + u64::from(FOUND_WORDS))],
            BufferId::Matrix => [1, (self.plies * members * u64::from(MATRIX_ROW)).max(1)],
        }
    }

    /// All buffers together [bytes].
    pub fn total(&self) -> u64 {
        BufferId::ALL.iter().map(|name| self.bytes(*name)).sum()
    }

    /// Memory of a batch on the device, with the buffers that results are fetched through [bytes].
    pub fn planned(&self) -> u64 {
        self.total() + IN_FLIGHT as u64 * self.staging()
    }

    /// Size of a buffer that results are fetched through, but for the time that was taken [bytes].
    pub(crate) fn staging(&self) -> u64 {
        self.bytes(BufferId::Samples) + self.bytes(BufferId::Status) + self.shots * 4 * EVENT_WORDS * EVENT_WINDOW
    }

    /// The largest batch of such shots, of at most `memory` bytes in all, that a device with these limits can hold; at least one shot.
    pub fn most_shots(&self, limits: &wgpu::Limits, memory: u64) -> u64 {
        let one = self.with_shots(1);
        let largest = BufferId::ALL.iter().map(|name| one.bytes(*name)).max().unwrap_or(1);
        let fit = (largest_binding(limits) / largest).min(memory / one.planned()).min(SHOTS);
        fit.max(1)
    }

    /// Whether a device with these limits can hold them.
    ///
    /// # Errors
    /// [`DeviceError::TooLarge`] with the buffer that does not fit and the memory needed.
    pub fn check(&self, limits: &wgpu::Limits, adapter: &str) -> Result<(), DeviceError> {
        let limit = largest_binding(limits);
        for (buffer, needed) in BufferId::ALL.map(|name| (name.variable(), self.bytes(name))) {
            if needed > limit {
                let (adapter, total) = (adapter.to_owned(), self.total());
                return Err(DeviceError::TooLarge { adapter, buffer, needed, limit, total });
            }
        }
        Ok(())
    }
}

/// The largest buffer that shaders can use [bytes].
fn largest_binding(limits: &wgpu::Limits) -> u64 {
    // Places in storage are 32-bit numbers of words in the shaders.
    let words = 4 * u64::from(u32::MAX);
    limits.max_storage_buffer_binding_size.min(limits.max_buffer_size).min(words)
}

/// Room for points of the projectile's edge on a ply: no more than every side of an element meets it twice. `elements`: the shortest
/// along its radius.
fn constraints(model: &Model<f32>, elements: f64) -> u64 {
    // As many lines of each direction as the face is wide, and twice each.
    let flat = 8.0 * elements;
    ((CONSTRAINTS[0] * flat + CONSTRAINTS[1]).ceil() as u64).min(4 * model.nodes_per_ply() as u64)
}
