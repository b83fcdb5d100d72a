//! A ply as the animation shows it.

use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::solver::element_totals::field as element;
use crate::solver::node_update::field as node;
use crate::solver::state::State;

/// Squared force of a yarn that is broken.
pub(super) const BROKEN: f64 = -1.0;
/// Lines of nodes on either side of the point of impact that are all kept.
pub(super) const DENSE: usize = 8;

/// A ply as the animation shows it: cells between the lines of nodes that were kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AnimatedPly {
    /// Counted from the struck side.
    pub ply: usize,
    /// Nodes kept along the warp and along the weft, counted in the whole ply.
    pub lines: [Vec<usize>; 2],
    /// Elements of the whole ply along warp and weft.
    pub elements: [usize; 2],
    /// Line of nodes along the weft, and along the warp, nearest to the point of impact: among those kept.
    pub hit: [usize; 2],
    /// Reference positions of the nodes kept, in the axes of the pack, row by row [m].
    pub reference: Vec<[f32; 3]>,
    /// The lines, counted in the part that is computed.
    pub(super) own: [Vec<usize>; 2],
}

impl AnimatedPly {
    pub(super) fn new<S: Scalar>(model: &Model<S>, ply: usize, hit: [f64; 2], most: usize) -> Self {
        let mesh = &model.ply_type(ply).mesh;
        let place = mesh.to_ply([hit[0], hit[1], 0.0]);
        let (counts, first) = ([mesh.columns, mesh.rows], mesh.first_in_whole());
        let side = (most as f64).sqrt() as usize;
        let axis = |own: usize| KeptLines { last: counts[own], hit: mesh.nearest_line(own, place[own]) };
        let own = [0, 1].map(|a| axis(a).lines(side));
        let whole = [0, 1].map(|a| own[a].iter().map(|line| line + first[a]).collect());
        let reference = own[1].iter().flat_map(|row| own[0].iter().map(move |column| (*row, *column)));
        Self {
            ply,
            elements: mesh.whole_counts(),
            hit: [0, 1].map(|a| own[a].partition_point(|line| *line < axis(a).hit)),
            reference: reference.map(|(row, column)| model.reference(ply, row, column).map(|x| x as f32)).collect(),
            lines: whole,
            own,
        }
    }

    /// A row of nodes at these places.
    #[cfg(test)]
    pub(super) fn for_tests(reference: Vec<[f32; 3]>) -> Self {
        let lines: [Vec<usize>; 2] = [(0..reference.len()).collect(), vec![0]];
        Self { ply: 0, elements: [reference.len(), 1], hit: [0; 2], reference, own: lines.clone(), lines }
    }

    /// Whether lists that belong together are of one length, and all places are within them.
    pub(super) fn is_sound(&self) -> bool {
        let [columns, rows] = [0, 1].map(|a| self.lines[a].len());
        self.reference.len() == columns * rows
            && (0..2).all(|a| self.own[a].len() == self.lines[a].len() && self.hit[a] < self.lines[a].len())
            && (0..2).all(|a| self.lines[a].last().is_some_and(|last| *last <= self.elements[a]))
            && self.lines.iter().all(|lines| lines.is_sorted())
    }

    /// Cells along warp and weft.
    pub fn counts(&self) -> [usize; 2] {
        [0, 1].map(|own| self.own[own].len().saturating_sub(1))
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        let [columns, rows] = self.counts();
        columns * rows
    }

    /// Displacements of the nodes kept of a row.
    pub(super) fn displacements<S: Scalar>(
        &self,
        model: &Model<S>,
        state: &State<S>,
        row: usize,
        out: &mut [[f32; 3]],
    ) {
        let mesh = &model.ply_type(self.ply).mesh;
        let row = state.nodes.row(model.grid.first_node_row(self.ply) + row);
        let [x, y, z] = [0, 1, 2].map(|a| &row[(node::DISPLACEMENT + a) * state.nodes.stride..]);
        for (column, out) in self.own[0].iter().zip(out) {
            *out = mesh.to_pack([x, y, z].map(|u| u[*column].to_f64())).map(|u| u as f32);
        }
    }

    /// Tensions in a row of cells, between two rows of nodes.
    pub(super) fn tensions<S: Scalar>(
        &self,
        model: &Model<S>,
        state: &State<S>,
        rows: &[usize],
        cells: &mut [[Option<f32>; 2]],
    ) {
        // From the force of an element to that of one of its yarns.
        let per_yarn = model.ply_type(self.ply).element.membrane.map(|membrane| (1.0 / membrane) as f32);
        let first = model.grid.first_element_row(self.ply);
        let columns = self.own[0].last().map_or(0, |last| *last);
        let mut most = vec![[BROKEN; 2]; cells.len()];
        // A warp yarn goes through a cell along a row of elements, a weft yarn along a column.
        let mut wefts = vec![0.0; columns];
        for row in rows[0]..rows[1] {
            let [warps, here] = squares(state.elements.row(first + row), state.elements.stride, columns);
            for (cell, span) in most.iter_mut().zip(self.own[0].windows(2)) {
                cell[0] = warps[span[0]..span[1]].iter().copied().fold(0.0, end_to_end).max(cell[0]);
            }
            wefts.iter_mut().zip(here).for_each(|(all, one)| *all = end_to_end(*all, one));
        }
        for (cell, span) in most.iter_mut().zip(self.own[0].windows(2)) {
            cell[1] = wefts[span[0]..span[1]].iter().copied().fold(BROKEN, f64::max);
        }
        for (cell, squares) in cells.iter_mut().zip(most) {
            let tension = |yarn: usize| per_yarn[yarn] * squares[yarn].sqrt() as f32;
            *cell = [0, 1].map(|yarn| (squares[yarn] != BROKEN).then(|| tension(yarn)));
        }
    }
}

/// Squared force of the yarns in a row of elements, warp and weft [N²].
fn squares<S: Scalar>(row: &[S], stride: usize, columns: usize) -> [Vec<f64>; 2] {
    [element::WARP_FORCE, element::WEFT_FORCE].map(|force| {
        // Element c is at c + 1.
        let field = |field: usize| &row[field * stride + 1..field * stride + 1 + columns];
        let yarn = usize::from(force == element::WEFT_FORCE);
        let [x, y, z] = [force, force + 1, force + 2].map(field);
        let forces = field(element::ALIVE + yarn).iter().zip(x).zip(y.iter().zip(z));
        let square = |((alive, x), (y, z)): ((&S, &S), (&S, &S))| {
            let [x, y, z] = [x, y, z].map(|force| force.to_f64());
            if alive.to_f64() > 0.5 { x * x + y * y + z * z } else { BROKEN }
        };
        forces.map(square).collect()
    })
}

/// The larger of two squared forces along a yarn; a yarn that is broken in one place is broken. What is no number counts as none.
pub(super) fn end_to_end(one: f64, other: f64) -> f64 {
    if one == BROKEN || other == BROKEN { BROKEN } else { one.max(other) }
}

/// Nodes of a ply along one of its own axes.
#[derive(Clone, Copy)]
pub(super) struct KeptLines {
    pub(super) last: usize,
    /// Nearest to the point of impact.
    pub(super) hit: usize,
}

impl KeptLines {
    /// Lines to keep, at most so many: gaps grow with the distance from the point of impact as little as need be.
    pub(super) fn lines(self, most: usize) -> Vec<usize> {
        let growths = (0..).map(|n| 0.02 * f64::from(n));
        let found = growths.map(|growth| self.graded(growth)).find(|lines| lines.len() <= most.max(2 * DENSE + 8));
        found.unwrap_or_default()
    }

    fn graded(self, growth: f64) -> Vec<usize> {
        let (first, last) = (0, self.last);
        let gap = |at: usize| 1 + (growth * at.abs_diff(self.hit).saturating_sub(DENSE) as f64) as usize;
        let next = |at: &usize, end: usize| {
            (*at != end).then(|| {
                let step = gap(*at).min(at.abs_diff(end));
                if end > *at { at + step } else { at - step }
            })
        };
        let down = std::iter::successors(Some(self.hit), |at| next(at, first)).skip(1);
        let up = std::iter::successors(Some(self.hit), |at| next(at, last));
        let mut lines: Vec<usize> = down.chain(up).collect();
        lines.sort_unstable();
        lines
    }
}
