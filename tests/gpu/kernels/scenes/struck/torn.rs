//! What is torn of the fabric that a projectile strikes.

use ripstop::model::Model;
use ripstop::physics::rigid_body::RigidBody;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::state::State;

use super::super::element_places;

/// Which yarns of an element are whole.
fn set_yarns(state: &mut State<f32>, row: usize, column: usize, alive: [bool; 2]) {
    for (yarn, alive) in alive.into_iter().enumerate() {
        state.elements.set(row, element::ALIVE + yarn, column + 1, if alive { 1.0 } else { 0.0 });
    }
}

/// Leaves nothing of the elements around a node near the middle in every other ply, and one of them in the rest.
pub(super) fn erode_around_a_node(model: &Model<f32>, state: &mut State<f32>) {
    let (row, column) = (5, 7);
    for (ply, r, c) in (0..model.grid.plies).flat_map(|ply| [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(r, c)| (ply, r, c)))
    {
        let stands = ply % 2 == 1 && (r, c) == (0, 1);
        let index = ply * model.grid.rows + row - 1 + r;
        set_yarns(state, index, column - 1 + c, [stands; 2]);
    }
}

/// Mends the yarn that runs under the body, so that it covers; where the scene says so a weft instead of a warp, or
/// everything but one cut on one side of every yarn.
pub(super) fn run_on(model: &Model<f32>, state: &mut State<f32>, body: &RigidBody, name: &str) {
    let (flap, weft) = (name.contains("flap"), name.contains("under a weft"));
    for [ply, row, column] in element_places(model) {
        let mesh = &model.ply_type(ply).mesh;
        let [x, y, _] = mesh.to_ply(body.position.into());
        let [under_row, under_column] = mesh.element_at([x, y]);
        let at = row - model.grid.first_element_row(ply);
        let mut set = |yarn: usize, alive: bool| {
            let alive = if alive { 1.0 } else { 0.0 };
            state.elements.set(row, element::ALIVE + yarn, column + 1, alive);
        };
        if flap {
            set(0, column != under_column + 3);
            set(1, at + 3 != under_row);
        } else if weft {
            set(0, column != under_column);
            if column == under_column {
                set(1, true);
            }
        } else if at == under_row + 2 {
            set(0, true); // beside the middle, where scenes leave nothing standing
        }
    }
}

/// Cuts warp on the right in every other ply, weft below in the rest: close by in the last two plies, in the others further away than a
/// yarn must run on to cover, in elements but not in length. Nothing is left of the other yarn.
fn cut_along(model: &Model<f32>, state: &mut State<f32>, body: &RigidBody) {
    for [ply, row, column] in element_places(model) {
        let (mesh, yarn) = (&model.ply_type(ply).mesh, ply % 2);
        let at = row - model.grid.first_element_row(ply);
        let middle = mesh.reference(at, column)[yarn] + 0.5 * mesh.size(at, column)[yarn];
        let away = (middle - body.position[yarn]) * [1.0, -1.0][yarn] / mesh.length[yarn];
        let whole = away < if ply < 2 { 11.0 } else { 4.5 };
        set_yarns(state, row, column, [0, 1].map(|other| whole && other == yarn));
    }
}

/// Tears what the name of the scene says.
pub(super) fn tear(model: &Model<f32>, state: &mut State<f32>, body: &RigidBody, name: &str) {
    if name.contains("hole") {
        for [_, row, column] in element_places(model) {
            state.elements.set(row, element::ALIVE + (row + column + 1) % 2, column + 1, 0.0);
        }
    }
    if name.contains("slit") {
        // What lies on the strip is torn; what lies on the flats is not.
        for [_, row, column] in element_places(model) {
            set_yarns(state, row, column, [!(4..7).contains(&row); 2]);
        }
    }
    if name.contains("no weft is left") {
        for [_, row, column] in element_places(model) {
            set_yarns(state, row, column, [true, false]);
        }
    }
    if name.contains("cut close") {
        cut_along(model, state, body);
    }
    if name.contains("coarse row") {
        // Of the elements under the body, the first corner of each lies further away than the finest elements are long.
        for [_, row, column] in element_places(model) {
            set_yarns(state, row, column, [row + 3 == model.grid.rows; 2]);
        }
    }
    if name.contains("torn turned") {
        // Where the body comes the ply behind has no yarn left; at that place of its own axes all are whole.
        for [_, row, column] in element_places(model).into_iter().filter(|place| place[0] == 1) {
            let [x, y, _] = model.reference(1, row - model.grid.first_element_row(1), column);
            let torn = (x - body.position.x).hypot(y - body.position.y) < 2.0 * body.body.radius;
            set_yarns(state, row, column, [!torn; 2]);
        }
    }
}
