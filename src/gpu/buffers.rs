//! Buffers of a run: what each holds, how large it is, and whether a device can hold it.

use super::DeviceError;
use super::layout::{
    ACCOUNT_FIELDS, BODY_WORDS, CONTACT_WORDS, EVENT_WORDS, FORCE_FIELDS, HEIGHT_FIELDS, IMPULSE_FIELDS, NODE_FIELDS,
    PLY_ACCOUNT_FIELDS, POINT_WORDS, REACH_WORDS, SHOTS, STATUS_WORDS, STRAIN_FIELDS, STRENGTH_FIELDS, SUMS,
    TOUCH_WORDS, VISCOUS_FIELDS,
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
/// Points of the rim on a ply there is room for: over those of a flat ply, and more for small ones. Crumpled fabric has more edges
/// under a rim.
const CONSTRAINTS: [f64; 2] = [4.0, 64.0];
/// Nodes and points of the rim that may push together, per point of the rim: it and the two ends of its edge.
const MEMBERS: u64 = 3;
/// Elements a workgroup of the ledger adds up before another one helps.
const LEDGER_SHARE: usize = 1024;
/// Workgroups of the ledger at most.
const LEDGER_GROUPS: usize = 256;

/// A storage buffer, by the name of its variable in the shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BufferId {
    /// Displacement and velocity, shape (6, nodes).
    Nodes,
    /// Forces, shape (9, elements).
    Forces,
    /// What predicts yarn heights, and these, shape (6, elements).
    Heights,
    /// Life of the yarns and evaluations, shape (elements,).
    Flags,
    /// Work and energies, shape (7, elements).
    Accounts,
    /// Counters, shape (8,).
    Status,
    /// Failures, shape (2·elements, 4): every yarn breaks once, so the list cannot overflow.
    Events,
    /// Impulse of the supports, shape (rim nodes, 3).
    Supports,
    /// The projectiles.
    Body,
    /// Nodes near the projectile, a bit each.
    Candidates,
    /// Nodes near the projectile.
    Points,
    /// Samples of the ledger, shape (slots, words of a sample).
    Samples,
    /// Element in front of a node, behind it, shape (2, nodes).
    Over,
    /// Contacts of a node with the ply in front, with the one behind, shape (2, nodes, 8).
    Contacts,
    /// Contacts of a node by weight, shape (nodes,).
    Shares,
    /// Counted impulses, shape (nodes, 6).
    Impulses,
    /// Places where the projectile may touch: those nodes, and points of its rim where it is sampled.
    Touches,
    /// Those that push and share nodes, shape (plies, most of a ply).
    Members,
    /// Their equations, a triangle for each ply.
    Matrix,
    /// Where yarns have shock viscosity or are judged over a length: viscous forces of warp and weft, shape (2, elements); where they are
    /// judged over a length, then their strains in the last two steps, shape (2 steps, 2, elements).
    Yarns,
}

impl BufferId {
    /// Every buffer.
    pub const ALL: [Self; 20] = [
        Self::Nodes,
        Self::Forces,
        Self::Heights,
        Self::Flags,
        Self::Accounts,
        Self::Status,
        Self::Events,
        Self::Supports,
        Self::Body,
        Self::Candidates,
        Self::Points,
        Self::Samples,
        Self::Over,
        Self::Contacts,
        Self::Shares,
        Self::Impulses,
        Self::Touches,
        Self::Members,
        Self::Matrix,
        Self::Yarns,
    ];

    /// Its variable in the shaders.
    pub fn variable(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Forces => "forces",
            Self::Heights => "heights",
            Self::Flags => "flags",
            Self::Accounts => "accounts",
            Self::Status => "status",
            Self::Events => "events",
            Self::Supports => "supports",
            Self::Body => "bodies",
            Self::Candidates => "candidates",
            Self::Points => "points",
            Self::Samples => "samples",
            Self::Over => "over",
            Self::Contacts => "contacts",
            Self::Shares => "shares",
            Self::Impulses => "impulses",
            Self::Touches => "touches",
            Self::Members => "members",
            Self::Matrix => "matrix",
            Self::Yarns => "yarns",
        }
    }
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
    /// Fields of the yarns of an element; see [`BufferId::Yarns`].
    pub yarn_fields: u64,
    /// Places for nodes.
    pub nodes: u64,
    /// Nodes on the rims of the plies.
    pub rim: u64,
    /// Room for nodes near the projectile, none without one.
    pub points: u64,
    /// Room for points of the projectile's rim on each ply, none where it is not sampled.
    pub constraints: u64,
    /// Workgroups of the ledger, as many for each ply.
    pub groups: u64,
}

impl Sizes {
    /// Sizes for one shot of a model.
    pub fn new(model: &Model<f32>) -> Self {
        let grid = &model.grid;
        let nodes = (model.plies.len() * model.nodes_per_ply()) as u64;
        let per_ply = grid.rows * grid.columns;
        let most = (LEDGER_GROUPS / grid.plies).max(1);
        let elements = (grid.plies * per_ply) as u64;
        Self {
            shots: 1,
            plies: grid.plies as u64,
            elements,
            yarn_fields: VISCOUS_FIELDS + STRAIN_FIELDS + if model.strength.is_some() { STRENGTH_FIELDS } else { 0 },
            nodes,
            rim: (grid.plies * 2 * (grid.columns + grid.rows + 2)) as u64,
            points: if model.projectile.is_some() { nodes.min(POINTS) } else { 0 },
            constraints: if model.edges { constraints(model) } else { 0 },
            groups: (grid.plies * per_ply.div_ceil(LEDGER_SHARE).clamp(1, most)) as u64,
        }
    }

    /// Points that may push and share nodes on each ply.
    fn members(&self) -> u64 {
        MEMBERS * self.constraints
    }

    /// Nodes for which there is contact between plies.
    fn meeting(&self) -> u64 {
        if self.plies > 1 { self.nodes } else { 1 }
    }

    /// Words of one sample.
    pub fn sample_words(&self) -> usize {
        self.groups as usize * SUMS + BODY_WORDS + STATUS_WORDS
    }

    /// The same for so many shots.
    #[must_use]
    pub fn with_shots(self, shots: u64) -> Self {
        Self { shots, ..self }
    }

    /// Size of a buffer [bytes].
    pub fn bytes(&self, name: BufferId) -> u64 {
        self.shots * self.bytes_of_shot(name)
    }

    /// A shot's part of a buffer [bytes].
    pub(crate) fn bytes_of_shot(&self, name: BufferId) -> u64 {
        let mask_words = self.nodes.div_ceil(32);
        4 * match name {
            BufferId::Accounts => ACCOUNT_FIELDS * self.elements + PLY_ACCOUNT_FIELDS * self.meeting(),
            BufferId::Events => 2 * EVENT_WORDS * self.elements,
            BufferId::Supports => 3 * self.rim,
            BufferId::Candidates => mask_words + mask_words.div_ceil(32),
            BufferId::Points => (POINT_WORDS * self.points).max(1),
            BufferId::Samples => u64::from(SLOTS) * self.sample_words() as u64,
            BufferId::Touches => TOUCH_WORDS * (self.points + self.plies * self.constraints + 1),
            BufferId::Members => (2 * self.plies * self.members()).max(1),
            BufferId::Matrix => (self.plies * self.members() * (self.members() + 1) / 2).max(1),
            _ => {
                let [fields, count] = self.shape(name);
                fields * count
            }
        }
    }

    /// Fields of a buffer, and words that a shot has of each; a field holds one shot after another. Of buffers that the host never
    /// reads or writes shot by shot it tells nothing.
    pub(crate) fn shape(&self, name: BufferId) -> [u64; 2] {
        match name {
            BufferId::Nodes => [NODE_FIELDS, self.nodes],
            BufferId::Forces => [FORCE_FIELDS, self.elements],
            BufferId::Heights => [HEIGHT_FIELDS, self.elements],
            BufferId::Flags => [1, self.elements],
            BufferId::Status => [1, STATUS_WORDS as u64 + REACH_WORDS * self.plies],
            BufferId::Body => [1, BODY_WORDS as u64],
            BufferId::Over => [2, self.meeting()],
            BufferId::Contacts => [2 * CONTACT_WORDS, self.meeting()],
            BufferId::Shares => [1, self.meeting()],
            BufferId::Impulses => [IMPULSE_FIELDS, self.meeting()],
            BufferId::Yarns if self.yarn_fields > 0 => [self.yarn_fields, self.elements],
            _ => [1, 1],
        }
    }

    /// All buffers together [bytes].
    pub fn total(&self) -> u64 {
        BufferId::ALL.into_iter().map(|name| self.bytes(name)).sum()
    }

    /// What a batch takes on the device, with the buffers that results are fetched through [bytes].
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
        let largest = BufferId::ALL.into_iter().map(|name| one.bytes(name)).max().unwrap_or(1);
        let fit = (largest_binding(limits) / largest).min(memory / one.planned()).min(SHOTS);
        fit.max(1)
    }

    /// Whether a device with these limits can hold them.
    ///
    /// # Errors
    /// [`DeviceError::TooLarge`] with the buffer that does not fit and the memory needed.
    pub fn check(&self, limits: &wgpu::Limits, adapter: &str) -> Result<(), DeviceError> {
        let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        for name in BufferId::ALL {
            let needed = self.bytes(name);
            if needed > largest_binding(limits) {
                return Err(DeviceError::TooLarge {
                    adapter: adapter.to_owned(),
                    buffer: name.variable(),
                    needed,
                    limit: binding,
                    total: self.total(),
                });
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

/// Room for points of the rim on a ply: no more than every edge meets it twice.
fn constraints(model: &Model<f32>) -> u64 {
    let radius = model.projectile.as_ref().map_or(0.0, |projectile| projectile.body.radius);
    let shortest = model.ply_types.iter().map(|ply_type| ply_type.mesh.shortest()).fold(f64::INFINITY, f64::min);
    // As many lines of each direction as the face is wide, and twice each.
    let flat = 8.0 * radius / shortest;
    ((CONSTRAINTS[0] * flat + CONSTRAINTS[1]).ceil() as u64).min(4 * model.nodes_per_ply() as u64)
}

/// Workgroups of `count` invocations as a two-dimensional dispatch within `most` per dimension.
pub fn spread(count: u64, group: u32, most: u32) -> [u32; 2] {
    let groups = count.div_ceil(u64::from(group)).max(1);
    let rows = groups.div_ceil(u64::from(most));
    [groups.div_ceil(rows) as u32, rows as u32]
}

#[cfg(test)]
#[path = "buffers_tests.rs"]
mod tests;
