//! Mirror planes of a scene, and what they mean for vectors and bodies.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Mirror planes of a scene: whether x = 0 and whether y = 0 is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MirrorPlanes(pub [bool; 2]);

impl MirrorPlanes {
    /// No plane: the whole scene is computed.
    pub const NONE: Self = Self([false; 2]);

    /// How many parts like the one computed make the whole.
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

/// Where a mirror plane cuts a mesh along one of its own axes.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_is_the_sum_over_the_part_and_its_images() {
        let vector = Vector3::new(2.0, -3.0, 5.0);
        for planes in [[false, false], [true, false], [false, true], [true, true]] {
            let mut images = vec![Vector3::repeat(1.0)];
            for axis in (0..2).filter(|axis| planes[*axis]) {
                let mirrored = images.clone().into_iter().map(|mut image| {
                    image[axis] = -image[axis];
                    image
                });
                images.extend(mirrored);
            }
            let mirror = MirrorPlanes(planes);
            assert_eq!(mirror.copies() as usize, images.len());
            let whole: Vector3<f64> = images.iter().map(|image| image.component_mul(&vector)).sum();
            assert_eq!(mirror.whole(vector), whole, "{planes:?}");
            // What moves or turns alike with every image is free; a turn is a product of two directions.
            let same = |of: &dyn Fn(&Vector3<f64>) -> f64| f64::from(u8::from(images.iter().all(|i| of(i) == 1.0)));
            let moves = Vector3::new(same(&|i| i.x), same(&|i| i.y), same(&|i| i.z));
            let turns = Vector3::new(same(&|i| i.y * i.z), same(&|i| i.z * i.x), same(&|i| i.x * i.y));
            assert_eq!(mirror.freedom(), [moves, turns], "{planes:?}");
            assert_eq!(mirror.names().len(), planes.iter().filter(|plane| **plane).count());
        }
        assert_eq!(MirrorPlanes([false, true]).names(), ["y"]);
    }
}
