//! A patch of a ply that flies ahead of the projectile, torn out or held on one side.

use ripstop::case::Case;
use ripstop::model::Model;
use ripstop::num::scalar::Scalar;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;

use crate::scene::builtin;

/// Half the width of the patch [elements]; its yarns run on for long enough to cover.
const SEAM: isize = 20;

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

/// Tears the patch out on three sides, and on the fourth where `loose` says so. The rest is at rest, but for a node in a corner
/// that tears itself off: without a yarn that failed on the way nothing perforates.
pub(crate) fn tear<S: Scalar>(model: &Model<S>, state: &mut State<S>, loose: bool) {
    let mesh = &model.ply_type(0).mesh;
    let [column_0, row_0] = mesh.centre().map(|line| line as isize);
    let away = |at: isize| if at < 0 { -at - 1 } else { at };
    for row in 0..mesh.rows {
        for column in 0..mesh.columns {
            let [r, c] = [row as isize - row_0, column as isize - column_0];
            let held = c == -SEAM - 1 && !loose;
            if away(r).max(away(c)) == SEAM && !held {
                for yarn in 0..2 {
                    state.elements.set(row, element::ALIVE + yarn, column + 1, S::splat(0.0));
                }
            }
        }
    }
    for row in 0..=mesh.rows {
        for column in 0..=mesh.columns {
            if (row as isize - row_0).abs().max((column as isize - column_0).abs()) > SEAM {
                state.nodes.set(row, node::VELOCITY + 2, column, S::splat(0.0));
            }
        }
    }
    state.nodes.set(2, node::VELOCITY + 2, 2, S::splat(3000.0));
}
