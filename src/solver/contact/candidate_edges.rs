//! The edges of elements between nodes near the projectile, where contact is sampled on them.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::solver::state::State;

/// Edges from near nodes along rows and columns.
#[derive(Default)]
pub(crate) struct CandidateEdges {
    /// Ply, row and column of the near nodes, then of what else is at an end of an edge.
    pub(crate) places: Vec<[usize; 3]>,
    /// Reference positions of these, in the axes of the pack [m].
    pub(crate) reference: Vec<Vector3<f64>>,
    /// The two ends of each edge: from every candidate to the next node along its row, along its column.
    pub(crate) ends: Vec<[usize; 2]>,
}

impl CandidateEdges {
    /// Edges of nodes in storage order; none where contact is not sampled on them.
    pub(crate) fn of<S: Scalar>(model: &Model<S>, candidates: &[[usize; 3]]) -> Self {
        let from = candidates.iter().filter(|_| model.edges);
        let ends = |[ply, row, column]: [usize; 3]| [[ply, row, column + 1], [ply, row + 1, column]];
        let is_beyond = |place: &[usize; 3]| {
            let mesh = &model.ply_type(place[0]).mesh;
            place[1] <= mesh.rows && place[2] <= mesh.columns && candidates.binary_search(place).is_err()
        };
        // Two edges may end at one node beyond: two of it would each be given a part of its impulse, and one be lost.
        let beyond: BTreeSet<_> = from.clone().flat_map(|place| ends(*place)).filter(is_beyond).collect();
        let places: Vec<_> = candidates.iter().copied().chain(beyond).collect();
        let (near, far) = places.split_at(candidates.len());
        let find = |place: [usize; 3]| {
            near.binary_search(&place).or_else(|_| far.binary_search(&place).map(|at| near.len() + at)).ok()
        };
        let edges = |(from, place): (usize, &[usize; 3])| ends(*place).map(|to| Some([from, find(to)?]));
        let ends = from.enumerate().flat_map(edges).flatten().collect();
        let reference = places.iter().map(|[ply, row, column]| model.reference(*ply, *row, *column).into());
        Self { ends, reference: reference.collect(), places }
    }
}

/// Whether a yarn still runs along the edge between two nodes, the second on along a row or a column, in an element beside it: where
/// only the yarns across are left, nothing is there between two of them.
pub(crate) fn edge_stands<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    [[ply, row, column], [_, up, right]]: [[usize; 3]; 2],
) -> bool {
    let mesh = &model.ply_type(ply).mesh;
    let first = model.grid.first_element_row(ply);
    let yarn = usize::from(up > row);
    mesh.around(row, column)
        .filter(|&[r, c]| (r == row || up == row) && (c == column || right == column))
        .any(|[r, c]| state.alive(first + r, c, yarn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::solver::element_totals::field;

    #[test]
    fn an_edge_is_there_as_long_as_a_yarn_runs_along_it() {
        let case = case::shipped(&["/expect=[]", "/pack/width_mm=11.43", "/pack/height_mm=11.43"]);
        let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        let mut state = State::new(&case, &model);
        // Edges from node (4, 5): along warp between elements (3, 5) and (4, 5), along weft between (4, 4) and (4, 5).
        let edges =
            |state: &State<f64>| [[0, 4, 6], [0, 5, 5]].map(|next| edge_stands(&model, state, [[0, 4, 5], next]));
        for (yarn, beside) in [[3, 5], [4, 4]].into_iter().enumerate() {
            assert_eq!(edges(&state), [true; 2]);
            let cut = |state: &mut State<f64>, alive: f64, [row, column]: [usize; 2]| {
                state.elements.set(row, field::ALIVE + yarn, column + 1, alive);
            };
            cut(&mut state, 0.0, [4, 5]);
            assert_eq!(edges(&state), [true; 2], "the element on the other side still has its yarn {yarn}");
            cut(&mut state, 0.0, beside);
            assert_eq!(edges(&state), [yarn != 0, yarn != 1], "no yarn {yarn} is left along that edge");
            cut(&mut state, 1.0, [4, 5]);
            cut(&mut state, 1.0, beside);
        }
    }
}
