//! Failure judged over a piece of yarn: a length along it, its whole breadth across it.
//!
//! Along each row of elements strains are averaged, for the peak under a rim grows as the mesh is refined. Over the breadth the root mean square
//! counts: the elastic energy of the piece over that of one that breaks. With the mean instead, one side of a yarn carries far more than breaks
//! it, the more the finer the mesh, and results do not converge (docs/decisions/10).

use crate::model::Model;
use crate::model::failure_criterion::{Window, Windows};
use crate::num::scalar::Scalar;
use crate::solver::element_force::MARKED_FOR_FAILURE;
use crate::solver::element_totals::{ElementTotals, field};
use crate::solver::state::State;

/// Marks the yarns of which an element's strain and the strain of the piece around it reached the failure strain in the last step: that piece
/// breaks in this one, over its whole breadth. Where strength varies, each piece has a failure strain of its own. `last`: sums of that step, which
/// say where nothing has to be looked at; `None`: everything is.
///
/// Gives the largest strain of a whole piece over its failure strain.
pub fn evaluate_failure<S: Scalar>(model: &Model<S>, state: &mut State<S>, last: Option<&[ElementTotals]>) -> f64 {
    let mut found = Found::default();
    for ply in 0..model.grid.plies {
        let ply_type = model.ply_type(ply);
        for (yarn, windows) in ply_type.windows.iter().enumerate() {
            let nominal = ply_type.cell.yarn[yarn].failure_strain;
            let yarns = YarnsOfPly { model, state, first: model.grid.first_element_row(ply), yarn, windows, nominal };
            // Almost always nothing has to be looked at.
            let is_near = |row: usize| last.is_none_or(|totals| yarns.may_break(row, totals));
            if yarn == 0 {
                for across in windows.yarns().filter(|across| across.elements().any(|(row, _)| is_near(row))) {
                    (0..ply_type.mesh.columns).for_each(|column| yarns.judge(column, across, &mut found));
                }
            } else {
                for row in (0..ply_type.mesh.rows).filter(|row| is_near(*row)) {
                    windows.yarns().for_each(|across| yarns.judge(row, across, &mut found));
                }
            }
        }
    }
    for [row, yarn, column] in found.breaking {
        state.elements.set(row, field::ALIVE + yarn, column + 1, S::splat(MARKED_FOR_FAILURE));
    }
    found.largest
}

/// Yarns that break, and the largest load.
#[derive(Default)]
struct Found {
    /// Row of the pack, yarn (0 warp, 1 weft), column.
    breaking: Vec<[usize; 3]>,
    /// Strain of a whole piece over its failure strain.
    largest: f64,
}

/// Warp (0) or weft (1) of a ply.
struct YarnsOfPly<'a, S: Scalar> {
    model: &'a Model<S>,
    state: &'a State<S>,
    /// First row of elements of the ply.
    first: usize,
    yarn: usize,
    windows: &'a Windows,
    /// Failure strain of the fabric [-].
    nominal: f64,
}

impl<S: Scalar> YarnsOfPly<'_, S> {
    /// Whether an element of a row reached its failure strain.
    fn may_break(&self, row: usize, last: &[ElementTotals]) -> bool {
        let row = self.first + row;
        let least = self.model.strength.as_ref().map_or(1.0, |strength| strength.least(row, self.yarn));
        last[row].largest_strain[self.yarn] >= self.nominal * least
    }

    fn strain(&self, row: usize, column: usize) -> f64 {
        let elements = &self.state.elements;
        elements.get(self.first + row, elements.fields - field::STRAIN + self.yarn, column + 1).to_f64()
    }

    fn failure_strain(&self, row: usize, column: usize) -> f64 {
        let strength = self.model.strength.as_ref();
        self.nominal * strength.map_or(1.0, |strength| strength.factor(self.first + row, self.yarn, column))
    }

    /// Row and column, by the places along and across the yarn.
    fn place(&self, along: usize, across: usize) -> (usize, usize) {
        if self.yarn == 0 { (across, along) } else { (along, across) }
    }

    /// Judges the piece of a yarn around one of its places.
    fn judge(&self, along: usize, across: &Window, found: &mut Found) {
        let elements = || across.elements().map(|(beside, _)| self.place(along, beside));
        if !elements().any(|(row, column)| self.strain(row, column) >= self.failure_strain(row, column)) {
            return;
        }
        let piece = Piece::over(&self.windows.along[along], across, |along, across| {
            let (row, column) = self.place(along, across);
            self.strain(row, column)
        });
        // Elements side by side share their yarn's strength.
        let (row, column) = self.place(along, across.first);
        let limit = self.failure_strain(row, column);
        if piece.whole {
            found.largest = found.largest.max(piece.strain / limit);
        }
        if piece.strain >= limit {
            let along = self.windows.breaking[along].clone();
            let piece = along.flat_map(|at| across.elements().map(move |(beside, _)| self.place(at, beside)));
            let whole = piece.filter(|(row, column)| self.strain(*row, *column) >= 0.0);
            found.breaking.extend(whole.map(|(row, column)| [self.first + row, self.yarn, column]));
        }
    }
}

/// Strain over the elements of a piece of yarn that are whole, of which there is one at least. A broken one, slack beside its break, says
/// nothing of the others.
struct Piece {
    /// Root mean square over its rows of the means along them.
    strain: f64,
    /// No element of it is broken.
    whole: bool,
}

impl Piece {
    /// `strain`: of an element, by its places along and across the yarn.
    fn over(along: &Window, across: &Window, strain: impl Fn(usize, usize) -> f64) -> Self {
        let (mut squares, mut area, mut whole) = (0.0, 0.0, true);
        for (beside, breadth) in across.elements() {
            let (mut sum, mut total) = (0.0, 0.0);
            for (at, length) in along.elements() {
                let strain = strain(at, beside);
                if strain >= 0.0 {
                    sum += length * strain;
                    total += length;
                } else {
                    whole = false;
                }
            }
            if total > 0.0 {
                squares += breadth * sum * sum / total;
                area += breadth * total;
            }
        }
        Self { strain: (squares / area).sqrt(), whole }
    }
}

#[cfg(test)]
#[path = "failure_tests.rs"]
mod tests;
