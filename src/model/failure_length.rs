//! The piece of yarn over which failure is judged: the failure length along it, its own spacing across it.
//!
//! The strain of a single element under a sharp rim or a point grows as the mesh is refined; its mean along the yarn over a fixed length
//! converges. Elements narrower than a yarn are no yarns of their own: which of them carries most depends on where the rim lies in the mesh,
//! what the yarn carries does not.

use super::Mesh;

/// Elements within a length around the middle of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The first of them: a column or a row.
    pub first: usize,
    /// Length of each within the window, in lengths of the finest element.
    pub length: Vec<f64>,
}

impl Window {
    /// Column or row of each element, with its length within the window.
    pub fn elements(&self) -> impl Iterator<Item = (usize, f64)> {
        (self.first..).zip(self.length.iter().copied())
    }
}

/// Windows of a yarn direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Windows {
    /// Along the yarn, by column for warp, by row for weft.
    pub along: Vec<Window>,
    /// Across the yarn, by row for warp, by column for weft.
    pub across: Vec<Window>,
}

/// Half the length and half the breadth of the piece, in lengths of the finest element; warp and weft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StencilRadius {
    /// Half of the failure length.
    pub along: [f64; 2],
    /// Half of the yarns' spacing.
    pub across: [f64; 2],
}

impl StencilRadius {
    /// The element itself: a strength of its own is judged where those over a length are.
    pub(super) const ELEMENT: Self = Self { along: [0.5; 2], across: [0.5; 2] };

    /// `length`: the failure length [m]. `spacing`: of the crossovers along warp and weft [m]; across warp lies that along weft.
    pub(super) fn new(mesh: &Mesh, length: f64, spacing: [f64; 2]) -> Self {
        let over = |axis: usize, length: f64| 0.5 * length / mesh.length[axis];
        Self { along: [over(0, length), over(1, length)], across: [over(1, spacing[1]), over(0, spacing[0])] }
    }

    /// Windows of warp and weft; `None`: no element is smaller than the piece, or no length is given, so that each is judged by its own
    /// strain.
    pub(super) fn windows(&self, mesh: &Mesh) -> Option<[Windows; 2]> {
        let lengths = self.along.iter().chain(&self.across);
        if self.along == [0.0; 2] || lengths.copied().fold(0.0, f64::max) <= 0.5 {
            return None;
        }
        Some(self.overlaps(mesh))
    }

    /// Windows of warp and weft, whatever their size.
    pub(super) fn overlaps(&self, mesh: &Mesh) -> [Windows; 2] {
        let windows = |axis: usize, reach: f64| {
            let overlaps = mesh.overlaps(axis, reach).into_iter();
            overlaps.map(|(first, length)| Window { first, length }).collect()
        };
        [0, 1].map(|yarn| Windows {
            along: windows(yarn, self.along[yarn]),
            across: windows(1 - yarn, self.across[yarn]),
        })
    }
}
