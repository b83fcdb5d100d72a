//! What the shaders see: words of the uniforms, of the projectile and of the ledger, in the order of the WGSL structs.
//!
//! Blocks are lists of named words, so that a test can hold every name and offset against the shaders' own structs.

mod grid_lines;
mod motion;
mod pack;
mod projectile;
mod scene;
mod shot;

pub use grid_lines::*;
pub use motion::*;
pub use pack::*;
pub use scene::*;
pub use shot::*;

/// Invocations per workgroup of the kernels over elements and nodes.
pub const GROUP: u32 = 64;
/// Invocations of the kernels of contact with the projectile, which are a single workgroup.
pub const CONTACT_GROUP: u32 = 256;
/// Parts of their sums that lie side by side in the memory of the workgroup: for all at once there is no room.
pub const CONTACT_LANES: u32 = 64;
/// A number for none: no step that went bad, no place, no ply.
pub const NONE: u32 = u32::MAX;
/// Fields of a node: displacement, velocity.
pub(crate) const NODE_FIELDS: u64 = 6;
/// Fields of an element's forces.
pub(crate) const FORCE_FIELDS: u64 = 9;
/// Fields of an element's heights: what predicts them, and the two.
pub(crate) const HEIGHT_FIELDS: u64 = 6;
/// Fields of an element's accounts.
pub const ACCOUNT_FIELDS: u64 = 10;
/// Fields of a node's accounts of contact between plies.
pub(crate) const PLY_ACCOUNT_FIELDS: u64 = 3;
/// Fields of an element whose yarns have shock viscosity: viscous forces of warp and weft.
pub(crate) const VISCOUS_FIELDS: u64 = 2;
/// Fields of an element whose yarns are judged over a length: strains of warp and weft in the last two steps.
pub(crate) const STRAIN_FIELDS: u64 = 4;
/// Failure strains of warp and weft over the fabric's, behind those, where strength varies.
pub(crate) const STRENGTH_FIELDS: u64 = 2;
/// Words of a contact between plies.
pub const CONTACT_WORDS: u64 = 8;
/// Fields of the impulses of contact between plies.
pub const IMPULSE_FIELDS: u64 = 6;
/// Words of what may have moved of a ply.
pub(crate) const REACH_WORDS: u64 = 4;
/// Words of a failure event.
pub const EVENT_WORDS: u64 = 4;
/// Words of a node near the projectile.
pub const POINT_WORDS: u64 = 32;
/// Words of a place where the projectile may touch. Before the first of a shot there is one more.
pub const TOUCH_WORDS: u64 = 32;
/// Words of the counters.
pub const STATUS_WORDS: usize = 12;
/// Words of the projectile.
pub const BODY_WORDS: usize = 60;
/// Sums of a workgroup of the ledger.
pub const SUMS: usize = 25;
/// Bytes of a step's uniform.
pub(crate) const STEP_BYTES: u64 = 32;
/// Bytes between two steps' uniforms, the alignment every device grants.
pub(crate) const STEP_STRIDE: u64 = 256;

/// Words of `status`.
pub mod status {
    /// First step that produced a number that is not finite.
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
    /// What may have moved of each ply begins here.
    pub const REACH: usize = 12;
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
    /// Work of moving nodes out of other plies [J].
    pub const PLY_SEPARATION_WORK: usize = 21;
    /// Dissipated by shock viscosity since the last ledger [J].
    pub const VISCOUS: usize = 22;
    /// Made by the unit-cell law itself since the start [J].
    pub const LAW: usize = 23;
    /// Largest tension over breaking load [-].
    pub const LOAD: usize = 24;
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
