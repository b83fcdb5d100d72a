//! Failure judged over a piece of yarn: a length along it, its whole breadth across it.
//!
//! Along each row of elements strains are averaged, for the peak under a rim grows as the mesh is refined. Over the breadth the root mean square
//! counts: the elastic energy of the piece over that of one that breaks. With the mean instead, one side of a yarn carries far more than breaks
//! it, the more the finer the mesh, and results do not converge (docs/decisions/09).

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
        let (strain, is_whole) = self.strain_of_piece(&self.windows.along[along], across);
        // Elements side by side share their yarn's strength.
        let (row, column) = self.place(along, across.first);
        let limit = self.failure_strain(row, column);
        if is_whole {
            found.largest = found.largest.max(strain / limit);
        }
        if strain >= limit {
            let along = self.windows.breaking[along].clone();
            let piece = along.flat_map(|at| across.elements().map(move |(beside, _)| self.place(at, beside)));
            let whole = piece.filter(|(row, column)| self.strain(*row, *column) >= 0.0);
            found.breaking.extend(whole.map(|(row, column)| [self.first + row, self.yarn, column]));
        }
    }
    /// Strain over the elements of a piece of yarn that are whole, of which there is one at least: the root mean square over its rows of the
    /// means along them; and whether no element of it is broken. A broken one, slack beside its break, says nothing of the others.
    fn strain_of_piece(&self, along: &Window, across: &Window) -> (f64, bool) {
        let (mut squares, mut area, mut is_whole) = (0.0, 0.0, true);
        for (beside, breadth) in across.elements() {
            let (mut sum, mut total) = (0.0, 0.0);
            for (at, length) in along.elements() {
                let (row, column) = self.place(at, beside);
                let strain = self.strain(row, column);
                if strain >= 0.0 {
                    sum += length * strain;
                    total += length;
                } else {
                    is_whole = false;
                }
            }
            if total > 0.0 {
                squares += breadth * sum * sum / total;
                area += breadth * total;
            }
        }
        ((squares / area).sqrt(), is_whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::model::failure_criterion::Strength;

    /// A ply type of 9 × 9 elements with these strains of its warp (row, column) over the failure strain, judged: where its warp is marked, and
    /// the largest load. `sets` change the case; elements are as long as a crossover, 1.27 mm, unless they do.
    fn judged(strain: impl Fn(usize, usize) -> f64, sets: &[&str]) -> (Vec<[usize; 2]>, f64) {
        judged_with(strain, sets, |_| None)
    }

    /// Ply type judged with a strength of each element.
    fn judged_with(
        strain: impl Fn(usize, usize) -> f64,
        sets: &[&str],
        strength: impl Fn(&Model<f64>) -> Option<Strength>,
    ) -> (Vec<[usize; 2]>, f64) {
        let size = ["/pack/width_mm=11.43", "/pack/height_mm=11.43", "/solver/numerics=paper", "/expect=[]"];
        let case = case::shipped(&[&size, sets].concat());
        let mut model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        model.strength = strength(&model);
        let mut state = State::new(&case, &model);
        let mesh = &model.ply_type(0).mesh;
        let limit = model.ply_type(0).cell.yarn[0].failure_strain;
        let mut totals = vec![ElementTotals::default(); mesh.rows];
        for (row, totals) in totals.iter_mut().enumerate() {
            for column in 0..mesh.columns {
                let strain = limit * strain(row, column);
                state.elements.set(row, field::COUNT, column + 1, strain);
                totals.largest_strain[0] = totals.largest_strain[0].max(strain);
            }
        }
        let mut again = state.clone();
        let load = evaluate_failure(&model, &mut state, Some(&totals));
        let marked = |state: &State<f64>| {
            let places = (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| [row, column]));
            places
                .filter(|[row, column]| state.elements.get(*row, field::ALIVE, column + 1) == MARKED_FOR_FAILURE)
                .collect::<Vec<_>>()
        };
        // What the last step says only saves looking.
        assert_eq!(evaluate_failure(&model, &mut again, None), load);
        assert_eq!(marked(&again), marked(&state));
        (marked(&state), load)
    }

    /// Three elements.
    const THREE: &str = "/solver/failure_length_mm=3.81";
    const NOTHING: [[usize; 2]; 0] = [];

    #[test]
    fn a_peak_breaks_nothing_that_a_plateau_breaks() {
        let peak = |height: f64| move |row, column| if (row, column) == (4, 4) { height } else { 0.9 };
        assert_eq!(judged(peak(1.19), &[THREE]).0, NOTHING);
        let (marked, load) = judged(peak(1.21), &[THREE]);
        assert_eq!(marked, [[4, 3], [4, 4], [4, 5]]);
        assert!((load - (0.9 + 0.31 / 3.0)).abs() < 1e-12, "{load}");
        assert_eq!(judged(|_, _| 1.001, &[THREE]).0.len(), 81);
        assert_eq!(judged(|_, _| 0.999, &[THREE]), (NOTHING.to_vec(), 0.0));
        // The mean is along the yarn: its neighbours do not help.
        let row: Vec<[usize; 2]> = (0..9).map(|column| [4, column]).collect();
        assert_eq!(judged(|row, _| if row == 4 { 1.001 } else { 0.1 }, &[THREE]).0, row);
    }

    #[test]
    fn a_yarn_whose_elements_are_as_long_as_the_failure_length_is_judged_by_them() {
        // Elements along weft are shorter.
        let peak = |row, column| if (row, column) == (4, 4) { 1.001 } else { 0.1 };
        let sets = ["/solver/failure_length_mm=1.2", "/fabric/weft/count_per_inch=30"];
        assert_eq!(judged(peak, &sets).0, [[4, 4]]);
    }

    #[test]
    fn an_element_breaks_at_its_own_strength() {
        let one = |factor: f64| {
            move |model: &Model<f64>| {
                Some(Strength::of_one(model.grid.element_rows(), model.grid.columns, [4, 4], factor))
            }
        };
        // A weak one among whole ones, far below what breaks the others.
        let even = |height: f64| move |_: usize, _: usize| height;
        assert_eq!(judged_with(even(0.61), &[THREE], one(0.6)).0, [[4, 3], [4, 4], [4, 5]]);
        assert_eq!(judged_with(even(0.59), &[THREE], one(0.6)).0, NOTHING);
        // A strong one holds, unless it lies in a piece that breaks; the load is over its own strength.
        let peak = |height: f64| move |row, column| if (row, column) == (4, 4) { height } else { 0.9 };
        assert_eq!(judged_with(peak(1.79), &[THREE], one(1.2)).0, NOTHING);
        assert_eq!(judged_with(peak(1.81), &[THREE], one(1.2)).0.len(), 3);
        assert_eq!(judged_with(even(1.1), &[THREE], one(1.2)).0.len(), 81);
        let (_, load) = judged_with(even(0.61), &[THREE], one(0.6));
        assert!((load - 0.61 / 0.6).abs() < 1e-12, "{load}");
    }

    #[test]
    fn a_broken_piece_says_nothing_of_the_others() {
        let broken = |beside: f64| {
            move |row: usize, column: usize| match (row, column) {
                (4, 3) => -1.0 / 0.035,
                (4, 4) => 1.2,
                (4, 5) => beside,
                _ => 0.1,
            }
        };
        assert_eq!(judged(broken(0.81), &[THREE]), (vec![[4, 4], [4, 5]], 0.0));
        assert_eq!(judged(broken(0.79), &[THREE]).0, NOTHING);
    }

    #[test]
    fn a_yarn_breaks_by_the_elastic_energy_of_its_breadth() {
        // Four elements across a yarn, four along it within the failure length; rows 18 to 21 are one yarn.
        let fine = ["/solver/failure_length_mm=1.27", "/pack/elements_per_crossover=4"];
        let row = |strain: f64| move |row: usize, _: usize| if row == 19 { strain } else { 0.6 };
        let breaks = (4.0_f64 - 3.0 * 0.6 * 0.6).sqrt();
        let yarn: Vec<[usize; 2]> = (18..22).flat_map(|row| (0..36).map(move |column| [row, column])).collect();
        assert_eq!(judged(row(breaks + 1e-6), &fine).0, yarn);
        let (marked, load) = judged(row(breaks - 1e-6), &fine);
        assert_eq!(marked, NOTHING);
        assert!((load - 1.0).abs() < 1e-6, "{load}");
        // One side alone carries no more than twice what it could bear as a yarn of its own.
        let alone = |strain: f64| move |row: usize, _: usize| if row == 19 { strain } else { 0.0 };
        assert_eq!(judged(alone(1.999), &fine).0, NOTHING);
        assert_eq!(judged(alone(2.001), &fine).0, yarn);
        // Along a row the mean counts, no single element of it.
        let peak = |row: usize, column: usize| if (row, column) == (19, 18) { 6.0 } else { 0.1 };
        assert_eq!(judged(peak, &fine).0, NOTHING);
        // What is broken in a row does not count.
        let torn = |row: usize, column: usize| match (row, column) {
            (19, 17) => -1.0 / 0.035,
            (19, 16..=20) => 2.3,
            _ => 0.1,
        };
        assert!(judged(torn, &fine).0.contains(&[21, 18]));
    }

    #[test]
    fn a_piece_of_the_failure_length_breaks_whatever_the_mesh() {
        // Elements of 1.27, 0.635 and 0.3175 mm, one of which carries the load of a piece of 3.81 mm.
        for (elements, loaded, breaking) in [(1, 4, 3..=5), (2, 9, 7..=11), (4, 18, 13..=23)] {
            let fine = [THREE, &format!("/pack/elements_per_crossover={elements}")];
            let peak = |height: f64| move |_: usize, column: usize| if column == loaded { height } else { 0.0 };
            let columns = |height: f64| {
                let marked = judged(peak(height * 3.0 * f64::from(elements)), &fine).0;
                marked.into_iter().filter(|[row, _]| *row == 0).map(|[_, column]| column).collect::<Vec<_>>()
            };
            assert_eq!(columns(1.001), breaking.collect::<Vec<_>>(), "{elements}");
            assert_eq!(columns(0.999), Vec::<usize>::new(), "{elements}");
        }
    }
}
