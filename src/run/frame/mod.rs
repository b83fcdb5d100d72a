//! Frames: the whole scene at one time, for whoever draws or writes it.
//!
//! A [`SnapshotTaker`] in the hands of a watcher takes a [`Snapshot`] when one is due, a copy of what has moved. What costs time, tensions
//! and strains of every element and the mirror images of a scene that is computed in part, is left to [`Snapshot::frame`],
//! which may be called on another thread while the solver goes on.
//!
//! N frames lie evenly between the start and the end of a run, both included. When a run ends is not known before: frames
//! are taken more often, and N of them are chosen in the end ([`even`]).

mod collector;
mod element;
mod scene;
mod schedule;
mod snapshot;

use serde::{Deserialize, Serialize};

pub use collector::FrameCollector;
pub use scene::{PlyMesh, Scene};
pub(crate) use schedule::Schedule;
pub use schedule::even;
pub use snapshot::{Snapshot, SnapshotTaker};

/// The whole scene at one time, in the axes of the pack. Nodes and elements run over (ply, row, column); [`Scene`] has
/// their numbers and what does not change.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Frame {
    /// Steps done.
    pub step: u64,
    /// [s]
    pub time: f64,
    /// Of the nodes [m].
    pub displacement: Vec<[f32; 3]>,
    /// Of the nodes, half a time step before (leapfrog) [m/s].
    pub velocity: Vec<[f32; 3]>,
    /// Warp and weft tension of the elements; of broken yarns 0 [N].
    pub tension: [Vec<f32>; 2],
    /// Warp and weft axial strain of the elements; of broken yarns 0 [-].
    pub strain: [Vec<f32>; 2],
    /// Warp and weft crimp height of the elements; 0 where the yarns do not cross any more [m].
    pub height: [Vec<f32>; 2],
    /// Shear angle of the elements; 0 where the yarns do not cross any more [rad].
    pub shear_angle: Vec<f32>,
    /// 1 where the warp, the weft of an element carries load, 0 where it is broken or missing.
    pub alive: [Vec<u8>; 2],
    /// The projectile, where there is one.
    pub projectile: Option<Pose>,
}

impl Frame {
    /// Everything at rest and nothing there.
    pub(crate) fn empty(scene: &Scene) -> Self {
        let (nodes, elements) = (scene.reference.len(), scene.elements);
        let zeros = || std::array::from_fn(|_| vec![0.0; elements]);
        Self {
            step: 0,
            time: 0.0,
            displacement: vec![[0.0; 3]; nodes],
            velocity: vec![[0.0; 3]; nodes],
            tension: zeros(),
            strain: zeros(),
            height: zeros(),
            shear_angle: vec![0.0; elements],
            alive: std::array::from_fn(|_| vec![0; elements]),
            projectile: None,
        }
    }
}

/// A projectile at one time, in the axes of the pack.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Pose {
    /// Centre of mass [m].
    pub position: [f64; 3],
    /// From the body's axes to those of the pack: quaternion w, x, y, z of length one.
    pub rotation: [f64; 4],
    /// Of the centre of mass, half a time step before (leapfrog) [m/s].
    pub velocity: [f64; 3],
    /// [rad/s]
    pub angular_velocity: [f64; 3],
}
