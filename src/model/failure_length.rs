//! The length along a yarn over which its failure is judged.
//!
//! The strain of a single element under a sharp rim or a point grows as the mesh is refined; its mean along the yarn over a fixed length
//! converges.

use super::Mesh;

/// Pieces of a yarn within the failure length around one of its elements.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The first of them: a column for warp, a row for weft.
    pub first: usize,
    /// Length of each within the window, in lengths of the finest element.
    pub length: Vec<f64>,
}

/// Windows of the elements of a mesh by column for warp, by row for weft; empty where no element is shorter than the failure length.
pub type Windows = [Vec<Window>; 2];

/// Half of `length` [m] along warp and weft, in lengths of the finest element.
pub(super) fn reach(mesh: &Mesh, length: f64) -> [f64; 2] {
    mesh.length.map(|finest| 0.5 * length / finest)
}

/// `length` [m]; `None`: every element is judged by its own strain.
pub(super) fn windows(mesh: &Mesh, length: f64) -> Option<Windows> {
    let of_axis = |axis: usize| {
        let reach = reach(mesh, length)[axis];
        let windows = mesh.overlaps(axis, reach).into_iter().map(|(first, length)| Window { first, length });
        if reach > 0.5 { windows.collect() } else { Vec::new() }
    };
    let windows = [of_axis(0), of_axis(1)];
    windows.iter().any(|windows| !windows.is_empty()).then_some(windows)
}
