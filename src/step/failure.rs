//! Nonlocal failure: yarns judged by their mean strain over what lies around an element.
//!
//! The strain of a single element at a projectile's rim is that of the mesh: it depends on where in an element the rim is. Its mean
//! over four by four crossovers does not (see `model/regularisation.rs`). A yarn that bears a load alone, others beside it slack,
//! breaks at its own mean along those four crossovers.

use crate::kernels::element_force::{BREAKING, ElementTotals, field};
use crate::model::{Model, Span, regularisation::MEAN_OVER_PEAK};
use crate::number::Scalar;
use crate::state::State;

/// Marks the yarns whose own strain and mean strain have both reached the failure strain: they fail in the next step.
pub(super) fn judge<S: Scalar>(model: &Model<S>, state: &mut State<S>, totals: &[ElementTotals]) {
    let grid = &model.grid;
    for ply in 0..grid.plies {
        let sheet = model.sheet(ply);
        let Some(around) = &sheet.neighbourhood else { continue };
        let first = grid.first_element_row(ply);
        for (row, rows) in around.rows.iter().enumerate() {
            for (yarn, constants) in sheet.cell.yarn.iter().enumerate() {
                let limit = constants.failure_strain;
                // Almost always nothing has to be looked at.
                if totals[first + row].largest_strain[yarn] < limit {
                    continue;
                }
                let yarns = Yarns { state, first, yarn };
                let breaking: Vec<usize> = (0..sheet.mesh.columns)
                    .filter(|column| yarns.breaks([row, *column], [rows, &around.columns[*column]], limit))
                    .collect();
                for column in breaking {
                    state.elements.set(first + row, field::ALIVE + yarn, column + 1, S::splat(BREAKING));
                }
            }
        }
    }
}

/// The yarns of one direction of a ply.
struct Yarns<'a, S> {
    state: &'a State<S>,
    /// First row of the ply.
    first: usize,
    yarn: usize,
}

impl<S: Scalar> Yarns<'_, S> {
    fn stands(&self, [row, column]: [usize; 2]) -> bool {
        self.state.alive(self.first + row, column, self.yarn)
    }

    fn strain(&self, [row, column]: [usize; 2]) -> f64 {
        self.state.elements.get(self.first + row, field::COUNT + self.yarn, column + 1).to_f64()
    }

    /// `around`: rows and columns of the element's neighbourhood.
    fn breaks(&self, element: [usize; 2], around: [&Span; 2], limit: f64) -> bool {
        let own = self.strain(element);
        own >= limit
            && self.stands(element)
            && (self.mean(around).unwrap_or(own) >= limit || self.own_mean(element, around) >= limit / MEAN_OVER_PEAK)
    }

    /// Mean strain over the pieces of the element's own yarn around it that are whole. A mean over its neighbours would let a
    /// yarn that is alone in bearing a load bear as many times its limit as there are slack ones beside it.
    fn own_mean(&self, [row, column]: [usize; 2], [rows, columns]: [&Span; 2]) -> f64 {
        let (mut sum, mut length) = (0.0, 0.0);
        for (place, part) in places(if self.yarn == 0 { columns } else { rows }) {
            let at = if self.yarn == 0 { [row, place] } else { [place, column] };
            if self.stands(at) {
                sum += part * self.strain(at);
                length += part;
            }
        }
        sum / length
    }

    /// Mean strain over the pieces of yarn around that are whole, if any is: a broken one, slack beside its break, says nothing of
    /// those beside it.
    fn mean(&self, [rows, columns]: [&Span; 2]) -> Option<f64> {
        let (along, across) = if self.yarn == 0 { (columns, rows) } else { (rows, columns) };
        let (mut sum, mut weights) = (0.0, 0.0);
        for (line, width) in places(across) {
            let at = |place: usize| if self.yarn == 0 { [line, place] } else { [place, line] };
            if places(along).all(|(place, _)| self.stands(at(place))) {
                for (place, length) in places(along) {
                    sum += width * length * self.strain(at(place));
                    weights += width * length;
                }
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

/// Elements of a span, and how much of each counts.
fn places(span: &Span) -> impl Iterator<Item = (usize, f64)> {
    (span.first..).zip(span.weight.iter().copied())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::case;

    /// A sheet of 9 × 9 crossovers with these strains of its warp (row, column), judged; where its warp is marked.
    fn marked(strain: impl Fn(usize, usize) -> f64, broken: &[[usize; 2]], sets: &[&str]) -> Vec<[usize; 2]> {
        let size = ["/pack/width_mm=11.43", "/pack/height_mm=11.43", "/pack/failure=nonlocal", "/expect=[]"];
        let sets: Vec<String> = size.iter().chain(sets).map(|set| (*set).to_owned()).collect();
        let case = case::read(Path::new("cases/s720-1ply-155.json"), &sets);
        let case = case.unwrap_or_else(|error| unreachable!("{error}"));
        let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        let mut state = State::new(&case, &model);
        let mesh = &model.sheet(0).mesh;
        let limit = model.sheet(0).cell.yarn[0].failure_strain;
        let mut totals = vec![ElementTotals::default(); mesh.rows];
        for row in 0..mesh.rows {
            for column in 0..mesh.columns {
                let strain = limit * strain(row, column);
                state.elements.set(row, field::COUNT, column + 1, strain);
                totals[row].largest_strain[0] = totals[row].largest_strain[0].max(strain);
            }
        }
        for [row, column] in broken {
            state.elements.set(*row, field::ALIVE, column + 1, 0.0);
        }
        judge(&model, &mut state, &totals);
        let places = (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| [row, column]));
        places.filter(|[row, column]| state.elements.get(*row, field::ALIVE, column + 1) == BREAKING).collect()
    }

    #[test]
    fn a_peak_breaks_nothing_that_a_plateau_breaks() {
        let peak = |row, column| if (row, column) == (4, 4) { 2.0 } else { 0.9 };
        assert_eq!(marked(peak, &[], &[]), [[0; 2]; 0]);
        // Over four by four crossovers the mean of that peak is 0.9 + 1.1/16.
        let higher = |row, column| if (row, column) == (4, 4) { 2.0 } else { 0.94 };
        assert_eq!(marked(higher, &[], &[]), [[4, 4]]);
        assert_eq!(marked(|_, _| 1.001, &[], &[]).len(), 81);
        assert_eq!(marked(|_, _| 0.999, &[], &[]), [[0; 2]; 0]);
    }

    #[test]
    fn a_yarn_that_bears_alone_breaks_at_its_published_strain() {
        let alone = |height: f64| move |row: usize, _| if row == 4 { height } else { 0.1 };
        let row: Vec<[usize; 2]> = (0..9).map(|column| [4, column]).collect();
        let published = 1.0 / MEAN_OVER_PEAK;
        assert_eq!(marked(alone(1.001 * published), &[], &[]), row);
        assert_eq!(marked(alone(0.999 * published), &[], &[]), [[0; 2]; 0]);
        // It is a mean along the yarn, over its whole pieces: slack ones before column 4 spare it, broken ones do not count.
        let step = |row: usize, column: usize| if row == 4 && column >= 4 { 1.2 * published } else { 0.1 };
        let beside = marked(step, &[[4, 3]], &[]);
        assert_eq!(beside, (4..9).map(|column| [4, column]).collect::<Vec<_>>());
        assert_eq!(marked(step, &[], &[]), (5..9).map(|column| [4, column]).collect::<Vec<_>>());
    }

    #[test]
    fn half_an_element_more_counts_half() {
        // Around column 4 are three whole columns and half of the ones beside them.
        let outer = |height: f64| move |_, column: usize| [0.0, 0.0, height, 0.0, 1.0, 0.0, height, 0.0, 0.0][column];
        let column = |column: usize| (0..9).map(|row| [row, column]).collect::<Vec<_>>();
        assert_eq!(marked(outer(3.01), &[], &[]), column(4));
        assert_eq!(marked(outer(2.99), &[], &[]), [[0; 2]; 0]);
    }

    #[test]
    fn broken_pieces_of_yarn_do_not_spare_the_ones_beside_them() {
        // Row 3 is broken in column 4 and slack there; row 4 beside it carries more than its limit.
        let beside = |row: usize, column: usize| match row {
            3 if (2..=6).contains(&column) => 0.0,
            _ => 1.001,
        };
        let with_break = marked(beside, &[[3, 4]], &[]);
        assert!(
            with_break.contains(&[4, 4])
                && !with_break.iter().any(|[row, column]| *row == 3 && (2..=6).contains(column))
        );
        assert!(!marked(beside, &[], &[]).contains(&[4, 4]));
    }

    #[test]
    fn the_mean_is_over_crossovers_whatever_the_mesh() {
        // Elements half as long: the middle one of a strained strip one crossover wide, in a mean over four.
        let strip = |height: f64| move |_, column: usize| if column.abs_diff(9) <= 1 { height } else { 0.0 };
        let fine = ["/pack/elements_per_crossover=2"];
        // Three of eight half crossovers around column 9.
        assert!(marked(strip(2.68), &[], &fine).contains(&[9, 9]));
        assert!(!marked(strip(2.65), &[], &fine).contains(&[9, 9]));
    }
}
