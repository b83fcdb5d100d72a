//! What of an element's size changes along a row, as the element kernel loads it.

use super::{Grid, Mesh, regularisation};
use crate::number::Scalar;

/// Shapes (node stride,), beyond the last element as of the finest; of an even mesh empty.
#[derive(Clone, Debug)]
pub struct Columns<S> {
    /// Lengths of elements along X over the finest [-].
    pub width: Vec<S>,
    /// 1 over that [-].
    pub per_width: Vec<S>,
    /// Viscosity along X over the stiffness [s].
    along: Vec<S>,
    /// The same along Y of each row, shape (rows,); empty: there is none.
    across: Vec<f64>,
}

impl<S: Scalar> Columns<S> {
    /// `viscosity`: of elements twice the finest along X, along Y, over the stiffness [s].
    pub(super) fn new(mesh: &Mesh, viscosity: [f64; 2]) -> Self {
        let stride = if mesh.is_graded() { Grid::node_stride(mesh.columns) } else { 0 };
        let ones = || vec![S::splat(1.0); stride];
        let mut out = Self { width: ones(), per_width: ones(), along: vec![S::splat(0.0); stride], across: Vec::new() };
        if !mesh.is_graded() {
            return out;
        }
        for column in 0..mesh.columns {
            let [x, _] = mesh.widths(0, column);
            out.width[column] = S::splat(x);
            out.per_width[column] = S::splat(1.0 / x);
            out.along[column] = S::splat(viscosity[0] * regularisation::share(x));
        }
        if viscosity != [0.0; 2] {
            let of_row = |row| viscosity[1] * regularisation::share(mesh.widths(row, 0)[1]);
            out.across = (0..mesh.rows).map(of_row).collect();
        }
        out
    }

    /// Viscosity of the elements of a row along X, and of the row along Y, over the stiffness [s]; `None`: there is none.
    pub fn viscosity(&self, row: usize) -> Option<(&[S], f64)> {
        self.across.get(row).map(|across| (&self.along[..], *across))
    }
}
