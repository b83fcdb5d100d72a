//! Failure judged over a piece of yarn: a length along it, its whole breadth across it.

use crate::kernels::element_force::{ElementTotals, MARKED_FOR_FAILURE, field};
use crate::math::scalar::Scalar;
use crate::model::Model;
use crate::model::failure_length::{Window, Windows};
use crate::solver::state::State;

/// Marks the yarns of which an element's strain and the mean strain over the piece around it reached the failure strain in the last step: they
/// break in this one, over their whole breadth. Where strength varies, each piece has a failure strain of its own. `last`: sums of that step,
/// which say where nothing has to be looked at; `None`: everything is.
///
/// Gives the largest of those means over the failure strain where all pieces are whole: what a yarn carries over its breaking load.
pub(super) fn evaluate_failure<S: Scalar>(
    model: &Model<S>,
    state: &mut State<S>,
    last: Option<&[ElementTotals]>,
) -> f64 {
    let mut found = Found::default();
    for ply in 0..model.grid.plies {
        let ply_type = model.ply_type(ply);
        for (yarn, windows) in ply_type.windows.iter().flatten().enumerate() {
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

/// What breaks, and the largest load.
#[derive(Default)]
struct Found {
    /// Row of the pack, yarn (0 warp, 1 weft), column.
    breaking: Vec<[usize; 3]>,
    /// Mean strain of a whole piece over its failure strain.
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
        let strains = self.model.element_fields() - field::STRAIN;
        self.state.elements.get(self.first + row, strains + self.yarn, column + 1).to_f64()
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
        let mean = Mean::over(&self.windows.along[along], across, |along, across| {
            let (row, column) = self.place(along, across);
            self.strain(row, column)
        });
        // Elements side by side share their yarn's strength.
        let (row, column) = self.place(along, across.first);
        let limit = self.failure_strain(row, column);
        if mean.whole {
            found.largest = found.largest.max(mean.strain / limit);
        }
        if mean.strain >= limit {
            let whole = elements().filter(|(row, column)| self.strain(*row, *column) >= 0.0);
            found.breaking.extend(whole.map(|(row, column)| [self.first + row, self.yarn, column]));
        }
    }
}

/// Mean strain over the elements of a piece of yarn that are whole, of which there is one at least. A broken one, slack beside its break,
/// says nothing of the others.
struct Mean {
    strain: f64,
    /// No element of it is broken.
    whole: bool,
}

impl Mean {
    /// `strain`: of an element, by its places along and across the yarn.
    fn over(along: &Window, across: &Window, strain: impl Fn(usize, usize) -> f64) -> Self {
        let (mut sum, mut total, mut whole) = (0.0, 0.0, true);
        for (beside, breadth) in across.elements() {
            for (at, length) in along.elements() {
                let (strain, area) = (strain(at, beside), length * breadth);
                if strain >= 0.0 {
                    sum += area * strain;
                    total += area;
                } else {
                    whole = false;
                }
            }
        }
        Self { strain: sum / total, whole }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::model::Strength;

    /// A ply type of 9 × 9 elements with these strains of its warp (row, column) over the failure strain, judged: where its warp is marked, and
    /// the largest load. `sets` change the case; elements are as long as a crossover, 1.27 mm, unless they do.
    fn judged(strain: impl Fn(usize, usize) -> f64, sets: &[&str]) -> (Vec<[usize; 2]>, f64) {
        judged_with(strain, sets, |_| None)
    }

    /// The same with a strength of each element.
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
        assert_eq!(marked, [[4, 4]]);
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
        assert_eq!(judged_with(even(0.61), &[THREE], one(0.6)).0, [[4, 4]]);
        assert_eq!(judged_with(even(0.59), &[THREE], one(0.6)).0, NOTHING);
        // A strong one holds where all others break; the load is over its own strength.
        assert_eq!(judged_with(even(1.1), &[THREE], one(1.2)).0.len(), 80);
        let (_, load) = judged_with(even(0.61), &[THREE], one(0.6));
        assert!((load - 0.61 / 0.6).abs() < 1e-12, "{load}");
    }

    #[test]
    fn half_an_element_more_counts_half() {
        // Four elements: the three in the middle and half of the ones beside them.
        let outer = |height: f64| move |_, column: usize| [0.0, 0.0, height, 0.0, 1.0, 0.0, height, 0.0, 0.0][column];
        let four = "/solver/failure_length_mm=5.08";
        let column: Vec<_> = (0..9).map(|row| [row, 4]).collect();
        assert_eq!(judged(outer(3.01), &[four]).0, column);
        assert_eq!(judged(outer(2.99), &[four]).0, NOTHING);
        // Elements half as long.
        let strip = |height: f64| move |_, column: usize| if column.abs_diff(9) <= 1 { height } else { 0.0 };
        let fine = [four, "/pack/elements_per_crossover=2"];
        assert!(judged(strip(2.68), &fine).0.contains(&[9, 9]));
        assert_eq!(judged(strip(2.65), &fine).0, NOTHING);
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
        assert_eq!(judged(broken(0.81), &[THREE]), (vec![[4, 4]], 0.0));
        assert_eq!(judged(broken(0.79), &[THREE]).0, NOTHING);
    }

    #[test]
    fn a_yarn_of_several_elements_across_breaks_as_one() {
        // Two elements across a yarn; the middle of the ply, after row 8, lies between two. Both break, the one that carries less too.
        let fine = ["/solver/failure_length_mm=1.27", "/pack/elements_per_crossover=2"];
        let rows = |own: f64| move |row: usize, _| if row == 10 { own } else { 0.8 };
        let yarn: Vec<[usize; 2]> = [9, 10].iter().flat_map(|row| (0..18).map(|column| [*row, column])).collect();
        assert_eq!(judged(rows(1.21), &fine).0, yarn);
        assert_eq!(judged(rows(1.19), &fine).0, NOTHING);
        // The yarns beside it do not help.
        let beside = |row: usize, _| if row == 9 || row == 10 { 1.01 } else { 0.1 };
        assert_eq!(judged(beside, &fine).0, yarn);
        // Beside a broken one the other is judged by itself, and the broken one stays as it is.
        let torn = |row: usize, _| if row == 9 { 1.01 } else { -1.0 / 0.035 };
        assert_eq!(judged(torn, &fine).0, yarn[..18]);
    }

    #[test]
    fn a_part_of_a_ply_judges_as_the_whole() {
        let windows = |cut: bool| {
            let case = case::shipped(&["/solver/failure_length_mm=3", "/expect=[]"]);
            let model = if cut { Model::<f64>::part(&case) } else { Model::<f64>::new(&case) };
            model.unwrap_or_else(|error| unreachable!("{error}")).ply_types.swap_remove(0)
        };
        let (whole, part) = (windows(false), windows(true));
        let (Some(all), Some(half)) = (&whole.windows, &part.windows) else { unreachable!("there are windows") };
        for axis in 0..2 {
            let middle = half[axis].along.len();
            assert_eq!(all[axis].along.len(), 2 * middle);
            for (at, window) in half[axis].along.iter().enumerate() {
                // A symmetric field, over the whole and over the half.
                let field = |place: usize| ((place.max(2 * middle - 1 - place) - middle) as f64).sqrt();
                let one = Window { first: 0, length: vec![1.0] };
                let over_whole = Mean::over(&all[axis].along[middle + at], &one, |place, _| field(place)).strain;
                let over_half = Mean::over(window, &one, |place, _| field(middle + place)).strain;
                assert!((over_whole - over_half).abs() < 1e-12, "{axis} {at}");
            }
        }
    }
}
