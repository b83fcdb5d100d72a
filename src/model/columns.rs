//! What changes along a row of a mesh, as kernels load it.

use super::{Grid, Mesh};
use crate::num::scalar::Scalar;

/// Shapes (node stride,), beyond the last element as of the finest; all but the places are empty for an even mesh.
#[derive(Clone, Debug)]
pub struct Columns<S> {
    /// Reference places of the nodes along X of the ply [m]; zero beyond the last. And rounded to the precision of the state.
    pub place: Vec<f64>,
    /// See `place`.
    pub rounded: Vec<S>,
    /// Lengths of elements along X over the finest [-].
    pub width: Vec<S>,
    /// 1 over that [-].
    pub per_width: Vec<S>,
}

impl<S: Scalar> Columns<S> {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut place: Vec<f64> = (0..=mesh.columns).map(|column| mesh.reference(0, column)[0]).collect();
        place.resize(Grid::node_stride(mesh.columns), 0.0);
        let rounded = place.iter().map(|x| S::splat(*x)).collect();
        let sizes = if mesh.is_graded() { place.len() } else { 0 };
        let ones = || vec![S::splat(1.0); sizes];
        let mut out = Self { place, rounded, width: ones(), per_width: ones() };
        if !mesh.is_graded() {
            return out;
        }
        for column in 0..mesh.columns {
            let [x, _] = mesh.widths(0, column);
            out.width[column] = S::splat(x);
            out.per_width[column] = S::splat(1.0 / x);
        }
        out
    }
}
