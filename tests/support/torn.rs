//! A patch of a ply that flies ahead of the projectile, torn out or held on one side.

use ripstop::case::Case;
use ripstop::model::Model;
use ripstop::num::scalar::Scalar;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;

use crate::scene::builtin;

/// Half the width of the patch [elements]; its yarns run on for long enough to cover.
pub(crate) const SEAM: isize = 20;

/// A ply of 80 by 80 even elements, with nothing asked of it.
pub(crate) const PLY: &[&str] = &[
    "/pack/width_mm=101.6",
    "/pack/height_mm=101.6",
    "/pack/elements_per_crossover=1",
    "/pack/mesh_grading=none",
    "/solver/contact_sampling=nodes",
    "/output/profile_times_us=[]",
    "/expect=[]",
];

/// A projectile that flies slowly behind a ply, and touches nothing before the end.
pub(crate) fn case(sets: &[&str]) -> Case {
    let slow = [
        "/projectile/velocity_m_s=20",
        "/projectile/standoff_mm=2",
        "/pack/initial_velocity_m_s=[0, 0, 150]",
        "/solver/end_time_us=70",
    ];
    builtin("cases/s720-1ply-155.json", &[PLY, &slow, sets].concat())
}

/// The larger of the distances of an element from the middle of the ply, in elements.
pub(crate) fn ring(r: isize, c: isize) -> isize {
    let away = |at: isize| if at < 0 { -at - 1 } else { at };
    away(r).max(away(c))
}

/// Cuts the yarns that `is_cut` names by row, column from the pack's centre, and yarn.
pub(crate) fn cut<S: Scalar>(model: &Model<S>, state: &mut State<S>, is_cut: impl Fn(isize, isize, usize) -> bool) {
    let mesh = &model.ply_type(0).mesh;
    let [column_0, row_0] = mesh.centre().map(|line| line as isize);
    for (row, column) in (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| (row, column))) {
        for yarn in (0..2).filter(|yarn| is_cut(row as isize - row_0, column as isize - column_0, *yarn)) {
            state.elements.set(row, element::ALIVE + yarn, column + 1, S::splat(0.0));
        }
    }
}

/// Sets a field of the nodes for which `value` has a number, by row and column from the pack's centre.
pub(crate) fn put<S: Scalar>(
    model: &Model<S>,
    state: &mut State<S>,
    field: usize,
    value: impl Fn(isize, isize) -> Option<f64>,
) {
    let mesh = &model.ply_type(0).mesh;
    let [column_0, row_0] = mesh.centre().map(|line| line as isize);
    for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
        if let Some(value) = value(row as isize - row_0, column as isize - column_0) {
            state.nodes.set(row, field, column, S::splat(value));
        }
    }
}

/// Tears the patch out on three sides, and on the fourth where `loose` says so. The rest is at rest, but for a node in a corner
/// that tears itself off: without a yarn that failed on the way nothing perforates.
pub(crate) fn tear<S: Scalar>(model: &Model<S>, state: &mut State<S>, loose: bool) {
    cut(model, state, |r, c, _| ring(r, c) == SEAM && (c != -SEAM - 1 || loose));
    put(model, state, node::VELOCITY + 2, |r, c| (r.abs().max(c.abs()) > SEAM).then_some(0.0));
    state.nodes.set(2, node::VELOCITY + 2, 2, S::splat(3000.0));
}
