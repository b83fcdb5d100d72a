//! Mirror planes of a scene, and what they mean for vectors and bodies.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Mirror planes of a scene: whether x = 0 and whether y = 0 is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MirrorPlanes(pub [bool; 2]);

impl MirrorPlanes {
    /// No plane: the whole scene is computed.
    pub const NONE: Self = Self([false; 2]);

    /// Number of parts like the one computed that make the whole.
    pub fn copies(self) -> u64 {
        self.0.iter().map(|plane| if *plane { 2 } else { 1 }).product()
    }

    /// The planes, in words.
    pub fn names(self) -> Vec<&'static str> {
        ["x", "y"].into_iter().zip(self.0).filter(|(_, plane)| *plane).map(|(name, _)| name).collect()
    }

    /// Sum of a vector over the part and its images: what points across a plane cancels.
    pub fn whole(self, vector: Vector3<f64>) -> Vector3<f64> {
        let copies = self.copies() as f64;
        let [x, y] = self.0.map(|plane| if plane { 0.0 } else { copies });
        vector.component_mul(&Vector3::new(x, y, copies))
    }

    /// 1 for directions of velocity and of turning that a body on the planes has, 0 for the others.
    pub fn freedom(self) -> [Vector3<f64>; 2] {
        let [x, y] = self.0.map(|plane| if plane { 0.0 } else { 1.0 });
        // A turn is its own mirror image where its axis is across the plane.
        [Vector3::new(x, y, 1.0), Vector3::new(y, x, x * y)]
    }
}

/// Cut of a mirror plane through a mesh along one of its own axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cut {
    /// Nowhere: the mesh goes from edge to edge.
    #[default]
    Nowhere,
    /// At its first nodes: their images lie before them.
    First,
    /// At its last nodes: their images lie behind them.
    Last,
}
