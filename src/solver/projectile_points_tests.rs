use super::*;
use std::path::Path;

use crate::case;
use crate::solver::element_totals::field;

/// A case with changes, its model and its state at the start.
fn scene(case: &str, sets: &[&str]) -> (Model<f64>, State<f64>) {
    let sets: Vec<String> = ["/expect=[]"].iter().chain(sets).map(|set| (*set).to_owned()).collect();
    let case = case::read(Path::new(case), &sets).unwrap_or_else(|error| unreachable!("{error}"));
    let model = Model::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
    let state = State::new(&case, &model);
    (model, state)
}

#[test]
fn fabric_between_counts_the_elements_in_front_that_stand() {
    let sets = ["/pack/plies=3", "/pack/width_mm=11.43", "/pack/height_mm=8.89", "/projectile=null"];
    let (model, mut state) = scene("cases/s728-4ply-91.json", &sets);
    let mesh = &model.ply_type(0).mesh;
    // Plies alike: the same element of each is in front of a node.
    let front = |ply: usize, row: usize, column: usize| {
        let at = (ply * SIDES * (mesh.rows + 1) + row) * (mesh.columns + 1) + column;
        let element = layup::element(state.over[at]);
        [element / mesh.columns, element % mesh.columns]
    };
    let (row, column) = (mesh.rows / 2, mesh.columns / 2);
    let [first, second] = [1, 2].map(|ply| front(ply, row, column));
    let between = |state: &State<f64>| fabric_between(&model, state, 2, row, column);
    let [a, b] = [0, 1].map(|ply: usize| model.plies[ply].touching);
    assert_eq!(between(&state), b + a);
    let mut cut = |ply: usize, [row, column]: [usize; 2], alive: f64| {
        let row = model.grid.first_element_row(ply) + row;
        (0..2).for_each(|yarn| state.elements.set(row, field::ALIVE + yarn, column + 1, alive));
        fabric_between(&model, &state, 2, mesh.rows / 2, mesh.columns / 2)
    };
    assert_eq!(cut(0, first, 0.0), b);
    assert_eq!(cut(1, second, 0.0), 0.0);
    assert_eq!(cut(0, first, 1.0), a);
    // Holes elsewhere change nothing.
    let others = (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| [row, column]));
    assert!(others.filter(|place| *place != first).all(|place| cut(0, place, 0.0) == a));
}

#[test]
fn an_edge_is_there_as_long_as_a_yarn_runs_along_it() {
    let sets = ["/pack/width_mm=11.43", "/pack/height_mm=11.43"];
    let (model, mut state) = scene("cases/s720-1ply-155.json", &sets);
    // Edges from node (4, 5): along warp between elements (3, 5) and (4, 5), along weft between (4, 4) and (4, 5).
    let edges = |state: &State<f64>| [[0, 4, 6], [0, 5, 5]].map(|next| edge_stands(&model, state, [[0, 4, 5], next]));
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
