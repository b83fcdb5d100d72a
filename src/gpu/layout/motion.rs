//! Words of a step, of the projectile, and of the sums of a sample.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::projectile::nose;
use super::{BODY_WORDS, Block, SUMS};
use crate::kernels::rigid_body::RigidBody;

/// One step as the kernels see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInfo {
    /// Counted from 0.
    pub index: u64,
    /// Where the ledger writes, if it runs.
    pub slot: Option<u32>,
    /// Steps since the last ledger.
    pub since: u32,
    /// Time step [s].
    pub dt: f64,
}

/// The uniform of a step.
pub fn step(info: &StepInfo) -> Block {
    let first = info.index == 0;
    let mut block = Block::default();
    block.count("index", info.index as usize);
    block.count("slot", info.slot.unwrap_or(0) as usize);
    block.count("since", info.since as usize);
    block.double("kick", if first { 0.5 * info.dt } else { info.dt });
    block.double("span", if first { 0.0 } else { info.dt });
    for pad in ["pad0", "pad1", "pad2"] {
        block.count(pad, 0);
    }
    block
}

/// Fine steps of a position per metre.
pub const FIXED_POINT_SCALE: f64 = (1_u64 << 34) as f64;

fn fixed(position: f64) -> [i32; 2] {
    let steps = (position * FIXED_POINT_SCALE).round() as i64;
    [(steps >> 24) as i32, (steps & 0xff_ffff) as i32]
}

fn metres(coarse: u32, fine: u32) -> f64 {
    ((i64::from(coarse as i32) << 24) + i64::from(fine as i32)) as f64 / FIXED_POINT_SCALE
}

/// The projectile as the shaders hold it. `impact`: its velocity at the start [m/s]; `from`: where the device counts places from [m].
pub fn body(body: &RigidBody, impact: &Vector3<f64>, from: &Vector3<f64>) -> [u32; BODY_WORDS] {
    let mut words = [0; BODY_WORDS];
    let mut put = |at: usize, values: [f64; 4]| {
        for (i, value) in values.into_iter().enumerate() {
            words[at + i] = (value as f32).to_bits();
        }
    };
    let vector = |v: &Vector3<f64>, w: f64| [v.x, v.y, v.z, w];
    let change = body.velocity - impact;
    let q = body.orientation;
    put(8, vector(&change, 0.0));
    put(12, [q.i, q.j, q.k, q.w]);
    put(16, vector(&body.angular_momentum, 0.0));
    put(20, vector(&body.velocity, body.speed_bound()));
    put(24, vector(&body.angular_velocity(), 0.0));
    put(36, vector(&change, 0.0));
    let place = body.position - from;
    let tip = place + body.orientation.transform_vector(&Vector3::new(0.0, 0.0, nose(body)));
    for a in 0..3 {
        let [coarse, fine] = fixed(place[a]).map(|x| x as u32);
        (words[a], words[4 + a], words[28 + a], words[32 + a]) = (coarse, fine, coarse, fine);
        [words[52 + a], words[56 + a]] = fixed(tip[a]).map(|x| x as u32);
    }
    words
}

/// What the shaders say of the projectile after a step.
#[derive(Clone, Debug)]
pub struct BodyRecord {
    /// After the step.
    pub body: RigidBody,
    /// Velocity and position before.
    pub before: (Vector3<f64>, Vector3<f64>),
    /// Impulse on it since the last ledger [N·s].
    pub impulse: [f64; 3],
    /// Impulse of supports and drive through contact since then [N·s].
    pub support: [f64; 3],
    /// Lost to contact, to friction, work of the drive since then [J].
    pub energy: [f64; 3],
    /// Deepest node so far [m].
    pub penetration: f64,
}

/// Reads the projectile back; what never changes comes from `start`, the projectile before its first step. `from`: where the device counts
/// places from [m].
pub fn read_body(words: &[u32], start: &RigidBody, from: &Vector3<f64>) -> BodyRecord {
    let float = |at: usize| f64::from(f32::from_bits(words[at]));
    let vector = |at: usize| Vector3::new(float(at), float(at + 1), float(at + 2));
    let position = |coarse: usize, fine: usize| {
        from + Vector3::from(std::array::from_fn::<f64, 3, _>(|a| metres(words[coarse + a], words[fine + a])))
    };
    let mut body = start.clone();
    body.position = position(0, 4);
    body.velocity = start.velocity + vector(8);
    body.orientation = UnitQuaternion::from_quaternion(Quaternion::new(float(15), float(12), float(13), float(14)));
    body.angular_momentum = vector(16);
    BodyRecord {
        body,
        before: (start.velocity + vector(36), position(28, 32)),
        impulse: vector(40).into(),
        support: vector(44).into(),
        energy: vector(48).into(),
        penetration: float(51),
    }
}

/// Sums of the workgroups of one sample, shape (plies, groups of a ply, [`SUMS`]).
#[derive(Clone, Copy)]
pub(crate) struct WorkgroupSums<'a>(&'a [u32]);

impl<'a> WorkgroupSums<'a> {
    /// Of the words of a sample before the projectile's.
    pub(crate) fn new(words: &'a [u32]) -> Self {
        Self(words)
    }

    /// Those of one ply of so many.
    pub(crate) fn ply(&self, ply: usize, plies: usize) -> Self {
        let words = self.0.len() / plies;
        Self(&self.0[ply * words..(ply + 1) * words])
    }

    fn parts(&self, which: usize) -> impl Iterator<Item = f64> {
        self.0.chunks_exact(SUMS).map(move |group| f64::from(f32::from_bits(group[which])))
    }

    /// The sum over the workgroups, in order.
    pub(crate) fn add(&self, which: usize) -> f64 {
        self.parts(which).sum()
    }

    /// The largest over the workgroups.
    pub(crate) fn largest(&self, which: usize) -> f64 {
        self.parts(which).fold(0.0, f64::max)
    }
}

#[cfg(test)]
#[path = "motion_tests.rs"]
mod tests;
