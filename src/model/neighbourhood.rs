//! What lies around every element: nonlocal failure judges a yarn by its mean strain there.

use super::Mesh;
use super::regularisation::NEIGHBOURHOOD;

/// Elements around one, along one axis.
#[derive(Clone, Debug)]
pub struct Span {
    /// The first of them.
    pub first: usize,
    /// How much of each counts, in lengths of the finest element.
    pub weight: Vec<f64>,
}

/// What lies around the elements of a mesh: spans of columns times spans of rows.
#[derive(Clone, Debug)]
pub struct Neighbourhood {
    /// From the middle of the element to either side, in lengths of the finest element.
    pub reach: f64,
    /// By column.
    pub columns: Vec<Span>,
    /// By row.
    pub rows: Vec<Span>,
}

impl Neighbourhood {
    /// Of a mesh whose finest elements have `crossovers` along a side.
    pub(super) fn of(mesh: &Mesh, crossovers: f64) -> Self {
        let reach = 0.5 * NEIGHBOURHOOD / crossovers;
        let [columns, rows] = [0, 1].map(|axis| {
            let spans = mesh.overlaps(axis, reach);
            spans.into_iter().map(|(first, weight)| Span { first, weight }).collect()
        });
        Self { reach, columns, rows }
    }
}
