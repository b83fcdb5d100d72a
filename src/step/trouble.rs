//! Where a run went wrong: numbers that are not finite, and the fastest node.

use nalgebra::Vector3;

use super::Trouble;
use crate::kernels::element_force::field as element;
use crate::kernels::node_update::field as node;
use crate::model::{Mesh, Model};
use crate::number::Scalar;
use crate::state::State;

/// Ply, row and column of the fastest node, and its speed [m/s].
pub fn fastest_node<S: Scalar>(model: &Model<S>, state: &State<S>) -> ([usize; 3], f64) {
    let mut fastest = ([0; 3], 0.0);
    for [ply, row, column] in nodes(model) {
        let speed = Vector3::from(state.velocity(model.grid.first_node_row(ply) + row, column)).norm();
        if speed > fastest.1 {
            fastest = ([ply, row, column], speed);
        }
    }
    fastest
}

/// Every node: ply, row, column.
pub fn nodes<S: Scalar>(model: &Model<S>) -> impl Iterator<Item = [usize; 3]> {
    (0..model.plies.len()).flat_map(move |ply| {
        let Mesh { rows, columns, .. } = model.sheet(ply).mesh;
        (0..=rows).flat_map(move |row| (0..=columns).map(move |column| [ply, row, column]))
    })
}

/// Every element: ply, row, column.
pub fn elements<S: Scalar>(model: &Model<S>) -> impl Iterator<Item = [usize; 3]> {
    (0..model.plies.len()).flat_map(move |ply| {
        let Mesh { rows, columns, .. } = model.sheet(ply).mesh;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [ply, row, column]))
    })
}

/// Looks for numbers that are not finite: which kernel made them, and where.
pub fn find_trouble<S: Scalar>(model: &Model<S>, state: &State<S>) -> Option<Trouble> {
    let grid = &model.grid;
    let bad = |x: &S| !x.to_f64().is_finite();
    let trouble = |kernel, name: &str, x: S, place| {
        Some(Trouble { step: state.step, kernel, quantity: format!("{name} = {x:?}"), place })
    };
    let names = ["membrane force along warp", "membrane force along weft", "hourglass force", "yarn height"];
    for place in elements(model) {
        let [ply, row, column] = place;
        let number = |f: usize| state.elements.get(grid.first_element_row(ply) + row, f, column + 1);
        if let Some(f) = (0..element::ALIVE).find(|f| bad(&number(*f))) {
            return trouble("element_force", names[f / 3], number(f), place);
        }
    }
    for place in nodes(model) {
        let [ply, row, column] = place;
        let number = |f: usize| state.nodes.get(grid.first_node_row(ply) + row, f, column);
        if let Some(f) = (0..node::COUNT).find(|f| bad(&number(*f))) {
            let name = if f < node::VELOCITY { "displacement" } else { "velocity" };
            return trouble("node_update", name, number(f), place);
        }
    }
    None
}
