//! Energy that the published unit-cell law makes by itself, along the way that every element takes.
//!
//! The ledger tells it along a straight way from rest, from a table. Where the way is another one, as that of a stretched ply let go, it may be
//! off by a third of itself. Here W is the integral of the in-plane forces over the stretches of each step, by Simpson's rule: a step that
//! is too long for a kink, or a force that is not the law's, still shows as energy gained.

use crate::kernels::crossover::{Equilibrium, LawKernel, UnitCellParameters, cell_energy, solve};
use crate::kernels::element_geometry::ElementGeometry;
use crate::kernels::kinematics::{differences, kinematics};
use crate::kernels::node_update::field as node;
use crate::math::scalar::Scalar;
use crate::model::{Model, PlyType};
use crate::solver;
use crate::solver::state::State;
use crate::with_law;

/// Follows every element of a run.
pub(super) struct LawPath {
    /// In order of ply, row, column.
    cells: Vec<Option<Cell>>,
}

/// The unit cell of an element.
#[derive(Clone)]
struct Cell {
    /// Λ − 1 of warp and weft [-].
    stretch: [f64; 2],
    now: Equilibrium<f64>,
    /// Energy held at the start [J].
    start: f64,
    /// Energy held now [J].
    held: f64,
    /// What the in-plane forces have taken up since the start [J].
    work: f64,
}

impl LawPath {
    /// At the start of a run.
    pub(super) fn new<S: Scalar>(model: &Model<S>, state: &State<S>) -> Self {
        let cell = |[ply, row, column]: [usize; 3]| {
            let ply_type = model.ply_type(ply);
            ply_type.law_energy.as_ref()?;
            let stretch = stretch(model, state, [ply, row, column]);
            let (now, held) = with_law!(ply_type.law, L => {
                let cell = UnitCellParameters::<f64>::cast::<L>(&ply_type.cell);
                let rest = cell.yarn.map(|yarn| yarn.height);
                solved::<L>(&cell, stretch, rest)
            });
            Some(Cell { stretch, now, start: held, held, work: 0.0 })
        };
        Self { cells: solver::elements(model).map(cell).collect() }
    }

    /// Follows the elements that have both yarns to where they are now. What the law has made since the start [J].
    pub(super) fn follow<S: Scalar>(&mut self, model: &Model<S>, state: &State<S>) -> f64 {
        let mut made = 0.0;
        for ([ply, row, column], cell) in solver::elements(model).zip(&mut self.cells) {
            let Some(cell) = cell else { continue };
            let ply_type = model.ply_type(ply);
            let at = model.grid.first_element_row(ply) + row;
            if state.is_undamaged(ply_type, at, column) {
                let to = stretch(model, state, [ply, row, column]);
                with_law!(ply_type.law, L => cell.go::<L>(&UnitCellParameters::<f64>::cast::<L>(&ply_type.cell), to));
            }
            made += crossovers(ply_type, row, column) * (cell.held - cell.start - cell.work);
        }
        made
    }
}

impl Cell {
    /// Goes straight to another stretch.
    fn go<L: LawKernel>(&mut self, cell: &UnitCellParameters<f64>, to: [f64; 2]) {
        let from = self.stretch;
        if from == to {
            return;
        }
        let half = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
        let (middle, _) = solved::<L>(cell, half, self.now.height);
        let (end, held) = solved::<L>(cell, to, middle.height);
        for i in 0..2 {
            let mean = (self.now.in_plane[i] + 4.0 * middle.in_plane[i] + end.in_plane[i]) / 6.0;
            self.work += mean * 2.0 * cell.yarn[i].half_span * (to[i] - from[i]);
        }
        (self.stretch, self.now, self.held) = (to, end, held);
    }
}

/// Equilibrium and energy of a cell whose yarns are whole.
fn solved<L: LawKernel>(cell: &UnitCellParameters<f64>, stretch: [f64; 2], warm: [f64; 2]) -> (Equilibrium<f64>, f64) {
    let found = solve::<f64, L>(cell, stretch, warm, true);
    let held = cell_energy(cell, &found.tension, &found.strain, found.force);
    (found, held)
}

/// Crossovers of an element.
fn crossovers<S: Scalar>(ply_type: &PlyType<S>, row: usize, column: usize) -> f64 {
    let [warp, weft] = ply_type.cell.yarn.each_ref().map(|yarn| 2.0 * yarn.half_span);
    ply_type.mesh.area(row, column) / (warp * weft)
}

/// Λ − 1 of warp and weft of an element, as its forces see it.
fn stretch<S: Scalar>(model: &Model<S>, state: &State<S>, [ply, row, column]: [usize; 3]) -> [f64; 2] {
    let at = model.grid.first_node_row(ply) + row;
    let u = [0, 1, 2].map(|a: usize| {
        let moved = |up: usize, right: usize| state.nodes.get(at + up, node::DISPLACEMENT + a, column + right).to_f64();
        differences(&[moved(0, 0), moved(0, 1), moved(1, 1), moved(1, 0)])
    });
    let ply_type = model.ply_type(ply);
    let [width, height] = ply_type.mesh.widths(row, column);
    let size = ElementGeometry::of_row(&ply_type.element, height).of_columns(width, 1.0 / width);
    kinematics(&size, u.each_ref()).extension
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::case;

    const PATCH: &str = r#"{
        "title": "patch",
        "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 3.81, "height_mm": 2.54, "edges": "free", "crossovers_per_element": 1},
        "solver": {"end_time_us": 1}
    }"#;

    /// Stretches a patch evenly.
    fn stretch_to(model: &Model<f64>, state: &mut State<f64>, excess: [f64; 2]) {
        for [ply, row, column] in solver::nodes(model) {
            let x = model.ply_type(ply).mesh.reference(row, column);
            for a in 0..2 {
                state.nodes.set(row, node::DISPLACEMENT + a, column, excess[a] * x[a]);
            }
        }
    }

    #[test]
    fn a_straight_way_makes_what_the_table_says_and_the_way_back_takes_it() {
        let case = case::from_str("patch", PATCH, &[]).unwrap();
        let model = Model::<f64>::new(&case).unwrap();
        let mut state = State::new(&case, &model);
        let mut path = LawPath::new(&model, &state);
        let end = [0.03, 0.02];
        let mut go = |part: f64| {
            stretch_to(&model, &mut state, end.map(|excess| part * excess));
            path.follow(&model, &state)
        };
        let there = (1..=100).map(|step| go(f64::from(step) / 100.0)).last().unwrap();
        let back = (0..100).rev().map(|step| go(f64::from(step) / 100.0)).last().unwrap();
        stretch_to(&model, &mut state, end);
        path.follow(&model, &state);
        let held: f64 = path.cells.iter().flatten().map(|cell| cell.held).sum();
        let told = model.ply_type(0).law_energy.as_ref().unwrap().at(end) * held;
        assert!(told.abs() > 1e-3 * held && (there - told).abs() < 0.02 * held, "{there} {told} {held}");
        assert!(back.abs() < 1e-6 * held, "{back} {held}");
    }

    #[test]
    fn another_way_to_the_same_place_makes_another_energy() {
        let case = case::from_str("patch", PATCH, &[]).unwrap();
        let model = Model::<f64>::new(&case).unwrap();
        let made = |corner: [f64; 2]| {
            let mut state = State::new(&case, &model);
            let mut path = LawPath::new(&model, &state);
            let mut last = 0.0;
            for (from, to) in [([0.0; 2], corner), (corner, [0.03, 0.02])] {
                for step in 1..=100 {
                    let part = f64::from(step) / 100.0;
                    stretch_to(&model, &mut state, [0, 1].map(|i| from[i] + part * (to[i] - from[i])));
                    last = path.follow(&model, &state);
                }
            }
            last
        };
        let [straight, round] = [made([0.015, 0.01]), made([0.03, 0.0])];
        assert!((straight / round - 1.0).abs() > 1e-3, "{straight} {round}");
    }
}
