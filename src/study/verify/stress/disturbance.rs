//! What no case can ask for: changes of the state of a run.

use crate::kernels::element_force::field as element;
use crate::kernels::node_update::field as node;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::solver;
use crate::solver::state::State;

/// A change of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Perturbation {
    /// Every free node is moved by up to so many element lengths, at the start.
    Noise(f64),
    /// These yarn directions are broken in every element, at the start.
    Broken([bool; 2]),
    /// A velocity in the middle of the first ply is no number: before this step on the processor, at the start on a
    /// graphics processor.
    NotANumber(u64),
}

impl Perturbation {
    /// The step before which the state changes.
    pub(super) fn step(self) -> u64 {
        match self {
            Self::NotANumber(step) => step,
            Self::Noise(_) | Self::Broken(_) => 0,
        }
    }

    /// Changes a state.
    pub(super) fn apply<S: Scalar>(self, model: &Model<S>, state: &mut State<S>) {
        match self {
            Self::Noise(size) => shake(model, state, size),
            Self::Broken(yarns) => {
                for [ply, row, column] in solver::elements(model) {
                    for yarn in (0..2).filter(|yarn| yarns[*yarn]) {
                        let at = model.grid.first_element_row(ply) + row;
                        state.elements.set(at, element::ALIVE + yarn, column + 1, S::splat(0.0));
                    }
                }
            }
            Self::NotANumber(_) => {
                let mesh = &model.ply_type(0).mesh;
                state.nodes.set(mesh.rows / 2, node::VELOCITY + 1, mesh.columns / 2, S::splat(f64::NAN));
            }
        }
        // What was changed may lie where nothing has arrived yet.
        state.reach_everything(model);
    }
}

/// Displaces free nodes by seeded noise of `size` element lengths along each axis.
fn shake<S: Scalar>(model: &Model<S>, state: &mut State<S>, size: f64) {
    let mut random = 0x9e37_79b9_7f4a_7c15_u64;
    for [ply, row, column] in solver::nodes(model) {
        let ply_type = model.ply_type(ply);
        let at = model.grid.first_node_row(ply) + row;
        for axis in 0..3 {
            // Xorshift, top 53 bits: uniform in [-1, 1).
            for (left, by) in [(true, 13), (false, 7), (true, 17)] {
                random ^= if left { random << by } else { random >> by };
            }
            let unit = (random >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
            if ply_type.row_mass(row).inverse[axis][column].to_f64() > 0.0 {
                let length = ply_type.mesh.shortest();
                let old = state.nodes.get(at, node::DISPLACEMENT + axis, column).to_f64();
                state.nodes.set(at, node::DISPLACEMENT + axis, column, S::splat(old + size * length * unit));
            }
        }
    }
}
