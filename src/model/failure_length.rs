//! The piece of yarn over which failure is judged, and which breaks: the failure length along it, its own spacing across it.
//!
//! The strain of a single element under a sharp rim or a point grows as the mesh is refined; its mean along the yarn over a fixed length
//! converges. Elements narrower than a yarn are no yarns of their own: those side by side in a yarn are judged together, by the root mean
//! square of these means, and break together. Where they broke one by one, a yarn tore from side to side, and a finer mesh took up more
//! energy (benches/NOTES.md).
//!
//! Along the yarn what lies in the piece breaks with it. Where one row of elements broke alone, yarns side by side that broke a row apart stayed
//! tied to each other by the node between them, and held on to a projectile or not by chance (benches/NOTES.md).

use std::ops::Range;

use super::Mesh;
use super::lines::SAME;
use crate::kernels::crossover::UnitCellParameters;

/// What lies in a piece by half does not break with it. Share of half the failure length that rounding does not reach [-].
const HALF_WITHIN: f64 = 1e-4;

/// Elements within a length around the middle of one, or side by side in a yarn.
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
    /// Of those along the yarn the elements that break with the one in the middle: they lie in the piece by more than half.
    pub breaking: Vec<Range<usize>>,
    /// Across the yarn, by row for warp, by column for weft: the whole yarn, the same for each of its elements.
    pub across: Vec<Window>,
}

impl Windows {
    /// The yarns side by side, each once.
    pub fn yarns(&self) -> impl Iterator<Item = &Window> {
        self.across.iter().enumerate().filter(|(at, window)| window.first == *at).map(|(_, window)| window)
    }
}

/// The spacing of warp and of weft yarns, in lengths of the finest element across them; across warp lies the crossovers' spacing along weft.
pub(super) fn breadth(mesh: &Mesh, cell: &UnitCellParameters<f64>) -> [f64; 2] {
    [1, 0].map(|axis| 2.0 * cell.yarn[axis].half_span / mesh.length[axis])
}

/// Half the length and the breadth of the piece, in lengths of the finest element; warp and weft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StencilRadius {
    /// Half of the failure length.
    pub along: [f64; 2],
    /// The yarns' spacing.
    pub breadth: [f64; 2],
}

impl StencilRadius {
    /// The element itself.
    const ELEMENT: Self = Self { along: [0.5; 2], breadth: [1.0; 2] };

    /// The piece of the failure length [m] and the [`breadth`] of a yarn; the element itself where none is smaller than that, or no length
    /// is given.
    pub(super) fn new(mesh: &Mesh, length: f64, breadth: [f64; 2]) -> Self {
        let along = mesh.length.map(|finest| 0.5 * length / finest);
        let smaller = along.iter().any(|half| *half > 0.5) || breadth.iter().any(|breadth| *breadth > 1.0 + SAME);
        if length > 0.0 && smaller { Self { along, breadth } } else { Self::ELEMENT }
    }

    /// The elements that lie side by side with one, along an axis, in the yarn across it.
    pub(crate) fn side_by_side(&self, mesh: &Mesh, axis: usize, element: usize) -> Range<usize> {
        mesh.side_by_side(axis, element, self.breadth[1 - axis])
    }

    /// Windows of warp and weft.
    pub(super) fn windows(&self, mesh: &Mesh) -> [Windows; 2] {
        let width = |axis: usize, at: usize| mesh.widths(at * axis, at * (1 - axis))[axis];
        let along = |axis: usize, reach: f64| {
            let overlaps = mesh.overlaps(axis, reach).into_iter();
            overlaps.map(|(first, length)| Window { first, length }).collect()
        };
        let across = |axis: usize, breadth: f64| {
            let count = [mesh.columns, mesh.rows][axis];
            let yarns = (0..count).map(|element| mesh.side_by_side(axis, element, breadth));
            yarns.map(|yarn| Window { first: yarn.start, length: yarn.map(|at| width(axis, at)).collect() }).collect()
        };
        [0, 1].map(|yarn| {
            let along: Vec<Window> = along(yarn, self.along[yarn]);
            let breaking = |(own, window): (usize, &Window)| {
                let is_within =
                    |at: usize, length: f64| length - 0.5 * width(yarn, at) > HALF_WITHIN * self.along[yarn];
                let within = window.elements().filter(|&(at, length)| is_within(at, length)).map(|(at, _)| at);
                let (first, last) = within.fold((own, own), |(first, last), at| (first.min(at), last.max(at)));
                first..last + 1
            };
            let breaking = along.iter().enumerate().map(breaking).collect();
            Windows { along, breaking, across: across(1 - yarn, self.breadth[yarn]) }
        })
    }
}

#[cfg(test)]
#[path = "failure_length_tests.rs"]
mod tests;
