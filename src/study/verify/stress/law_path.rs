//! Energy that the published unit-cell law makes by itself, along the way that every element takes.
//!
//! The ledger tells it along a straight way from rest, from a table. Where the way is another one, as that of a stretched ply let go, it may be
//! off by a third of itself. Here W is the integral of the in-plane forces over the stretches of each step, by Simpson's rule: a step that
//! is too long for a kink, or a force that is not the law's, still shows as energy gained.

use crate::kernels::crossover::{Equilibrium, LawKernel, UnitCellParameters, cell_energy, solve};
use crate::kernels::element_geometry::ElementGeometry;
use crate::kernels::kinematics::{differences, kinematics};
use crate::kernels::node_update::field as node;
use crate::model::{Model, PlyType};
use crate::num::scalar::Scalar;
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
#[path = "law_path_tests.rs"]
mod tests;
