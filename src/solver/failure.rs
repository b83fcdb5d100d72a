//! Failure judged over a piece of yarn: a length along it, its whole breadth across it.
//!
//! Along each row of elements strains are averaged, for the peak under a rim grows as the mesh is refined. Over the breadth the root mean square
//! counts: the elastic energy of the piece over that of one that breaks. With the mean instead, one side of a yarn carries far more than breaks
//! it, the more the finer the mesh, and results do not converge (docs/decisions/09).

use std::cell::Cell;

use crate::model::Model;
use crate::model::failure_criterion::{Window, Windows};
use crate::num::scalar::Scalar;
use crate::physics::yarn_law::{Curve, YarnConstants};
use crate::solver::element_force::MARKED_FOR_FAILURE;
use crate::solver::element_totals::{ElementTotals, field};
use crate::solver::state::State;

/// Marks the yarns of which an element's strain and the strain of the piece around it reached the failure strain in the last step: that piece
/// breaks in this one, over its whole breadth. Where strength varies, each piece has a failure strain of its own. `last`: sums of that step, which
/// say where nothing has to be looked at; `None`: everything is.
pub fn evaluate_failure<S: Scalar>(model: &Model<S>, state: &mut State<S>, last: Option<&[ElementTotals]>) {
    let mut breaking = Vec::new();
    for yarns in &yarns_of(model, state) {
        // Almost always nothing has to be looked at.
        let is_near = |row: usize| last.is_none_or(|last| yarns.largest_load(row, last) >= 1.0);
        yarns.sections(is_near, |along, across| {
            if yarns.own_load(along, across) >= 1.0 && yarns.load(along, across).0 >= 1.0 {
                let along = yarns.windows.breaking[along].clone();
                let piece = along.flat_map(|at| across.elements().map(move |(beside, _)| yarns.place(at, beside)));
                let whole = piece.filter(|(row, column)| yarns.strain(*row, *column) >= 0.0);
                breaking.extend(whole.map(|(row, column)| [yarns.first + row, yarns.yarn, column]));
            }
        });
    }
    for [row, yarn, column] in breaking {
        state.elements.set(row, field::ALIVE + yarn, column + 1, S::splat(MARKED_FOR_FAILURE));
    }
}

/// Largest tension of a yarn [N], and largest strain of a whole piece of yarn over its failure strain, after a step: 1 where it breaks in the
/// next one, not before. `last`: sums of the step, as for [`evaluate_failure`].
pub fn yarn_loads<S: Scalar>(model: &Model<S>, state: &State<S>, last: Option<&[ElementTotals]>) -> [f64; 2] {
    let (tension, load) = (Cell::new(0.0_f64), Cell::new(0.0_f64));
    for yarns in &yarns_of(model, state) {
        // What is no more than was found already needs no closer look.
        let is_near = |row: usize| {
            let may_be_more = |last: &[ElementTotals]| {
                yarns.stiffness * yarns.curve.tension(last[yarns.first + row].largest_strain[yarns.yarn])
                    > tension.get()
                    || yarns.largest_load(row, last) > load.get()
            };
            last.is_none_or(may_be_more)
        };
        yarns.sections(is_near, |along, across| {
            tension.set(tension.get().max(yarns.tension(along, across.first)));
            let own = yarns.own_load(along, across);
            if own > load.get()
                && let (of_piece, true) = yarns.load(along, across)
            {
                load.set(load.get().max(own.min(of_piece)));
            }
        });
    }
    [tension.get(), load.get()]
}

/// Tension of a yarn (0 warp, 1 weft) in an element of a ply after the last step [N]: what all elements side by side in the yarn carry.
pub fn yarn_tension<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    ply: usize,
    yarn: usize,
    (row, column): (usize, usize),
) -> f64 {
    let yarns = YarnsOfPly::new(model, state, ply, yarn);
    let (across, along) = yarns.place(column, row);
    yarns.tension(along, across)
}

fn yarns_of<'a, S: Scalar>(model: &'a Model<S>, state: &'a State<S>) -> Vec<YarnsOfPly<'a, S>> {
    let all = (0..model.grid.plies).flat_map(|ply| [(ply, 0), (ply, 1)]);
    all.map(|(ply, yarn)| YarnsOfPly::new(model, state, ply, yarn)).collect()
}

/// Warp (0) or weft (1) of a ply.
struct YarnsOfPly<'a, S: Scalar> {
    model: &'a Model<S>,
    state: &'a State<S>,
    ply: usize,
    /// First row of elements of the ply.
    first: usize,
    yarn: usize,
    windows: &'a Windows,
    /// Failure strain of the fabric [-].
    nominal: f64,
    /// [N]
    stiffness: f64,
    curve: Curve,
}

impl<'a, S: Scalar> YarnsOfPly<'a, S> {
    fn new(model: &'a Model<S>, state: &'a State<S>, ply: usize, yarn: usize) -> Self {
        let (ply_type, first) = (model.ply_type(ply), model.grid.first_element_row(ply));
        let YarnConstants { failure_strain: nominal, stiffness, curve, .. } = ply_type.cell.yarn[yarn];
        Self { model, state, ply, first, yarn, windows: &ply_type.windows[yarn], nominal, stiffness, curve }
    }

    /// Visits the places along every yarn by its elements side by side, in rows that may matter.
    fn sections(&self, is_near: impl Fn(usize) -> bool, mut visit: impl FnMut(usize, &'a Window)) {
        let mesh = &self.model.ply_type(self.ply).mesh;
        if self.yarn == 0 {
            for across in self.windows.yarns().filter(|across| across.elements().any(|(row, _)| is_near(row))) {
                (0..mesh.columns).for_each(|column| visit(column, across));
            }
        } else {
            for row in (0..mesh.rows).filter(|row| is_near(*row)) {
                self.windows.yarns().for_each(|across| visit(row, across));
            }
        }
    }

    /// Largest strain of an element of a row over the least failure strain there, in the last step.
    fn largest_load(&self, row: usize, last: &[ElementTotals]) -> f64 {
        let row = self.first + row;
        let least = self.model.strength.as_ref().map_or(1.0, |strength| strength.least(row, self.yarn));
        last[row].largest_strain[self.yarn] / (self.nominal * least)
    }

    fn strain(&self, row: usize, column: usize) -> f64 {
        let elements = &self.state.elements;
        elements.get(self.first + row, elements.fields - field::STRAIN + self.yarn, column + 1).to_f64()
    }

    fn failure_strain(&self, row: usize, column: usize) -> f64 {
        let strength = self.model.strength.as_ref();
        self.nominal * strength.map_or(1.0, |strength| strength.factor(self.first + row, self.yarn, column))
    }

    /// Row and column, by the places along and across the yarn; and the other way round.
    fn place(&self, along: usize, across: usize) -> (usize, usize) {
        if self.yarn == 0 { (across, along) } else { (along, across) }
    }

    /// Tension of the yarn at an element by the places along and across it [N]; what is broken carries nothing.
    fn tension(&self, along: usize, across: usize) -> f64 {
        let strain = |beside: usize| {
            let (row, column) = self.place(along, beside);
            self.curve.tension(self.strain(row, column).max(0.0))
        };
        self.stiffness * self.windows.of_yarn(across, strain)
    }

    /// Largest strain over failure strain of the elements side by side.
    fn own_load(&self, along: usize, across: &Window) -> f64 {
        let load = |(beside, _)| {
            let (row, column) = self.place(along, beside);
            self.strain(row, column) / self.failure_strain(row, column)
        };
        across.elements().map(load).fold(0.0, f64::max)
    }

    /// Strain over failure strain of the piece of yarn around a place: over its elements that are whole, of which there is one at least, the root
    /// mean square over its rows of the means along them; and whether no element of it is broken. A broken one, slack beside its break, says
    /// nothing of the others.
    fn load(&self, along: usize, across: &Window) -> (f64, bool) {
        let (mut squares, mut area, mut is_whole) = (0.0, 0.0, true);
        for (beside, breadth) in across.elements() {
            let (mut sum, mut total) = (0.0, 0.0);
            for (at, length) in self.windows.along[along].elements() {
                let (row, column) = self.place(at, beside);
                let strain = self.strain(row, column);
                if strain >= 0.0 {
                    sum += length * strain;
                    total += length;
                } else {
                    is_whole &= !self.model.ply_type(self.ply).mesh.is_present(row, column);
                }
            }
            if total > 0.0 {
                squares += breadth * sum * sum / total;
                area += breadth * total;
            }
        }
        // Elements side by side share their yarn's strength.
        let (row, column) = self.place(along, across.first);
        ((squares / area).sqrt() / self.failure_strain(row, column), is_whole)
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
        let [tension, load] = yarn_loads(&model, &state, Some(&totals));
        assert_eq!(yarn_loads(&model, &state, None), [tension, load]);
        evaluate_failure(&model, &mut state, Some(&totals));
        let marked = |state: &State<f64>| {
            let places = (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| [row, column]));
            places
                .filter(|[row, column]| state.elements.get(*row, field::ALIVE, column + 1) == MARKED_FOR_FAILURE)
                .collect::<Vec<_>>()
        };
        // What the last step says only saves looking.
        evaluate_failure(&model, &mut again, None);
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
        let (marked, load) = judged(|_, _| 0.999, &[THREE]);
        assert!(marked == NOTHING && (load - 0.999).abs() < 1e-12, "{load}");
        // An element close to its failure strain says no more of the piece than one beyond it.
        let (marked, load) = judged(|row, column| if (row, column) == (4, 4) { 0.999 } else { 0.7 }, &[THREE]);
        assert!(marked == NOTHING && (load - 2.399 / 3.0).abs() < 1e-12, "{load}");
        // The mean is along the yarn: its neighbours do not help.
        let row: Vec<[usize; 2]> = (0..9).map(|column| [4, column]).collect();
        assert_eq!(judged(|row, _| if row == 4 { 1.001 } else { 0.1 }, &[THREE]).0, row);
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
        let (marked, load) = judged(broken(0.81), &[THREE]);
        assert_eq!(marked, [[4, 4], [4, 5]]);
        assert!((load - (1.2 + 0.81 + 0.1) / 3.0).abs() < 1e-12, "{load}");
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
