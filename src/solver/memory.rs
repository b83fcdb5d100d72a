//! What a stepper remembers from one step to the next.

use serde::{Deserialize, Serialize};

use super::Stepper;
use crate::model::Model;
use crate::num::scalar::Scalar;

/// Everything in a stepper that later steps depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepperState {
    /// How far any node may have gone so far [m].
    travel: f64,
    /// Ply, row, column of the nodes near the projectile.
    near: Vec<[u32; 3]>,
    /// How far they and the projectile may still approach each other before the list is stale [m].
    reserve: f64,
}

impl StepperState {
    /// Whether it names nodes of this model only.
    pub(crate) fn fits<S: Scalar>(&self, model: &Model<S>) -> bool {
        self.near.iter().map(|place| place.map(|at| at as usize)).all(|[ply, row, column]| {
            ply < model.plies.len()
                && row <= model.ply_type(ply).mesh.rows
                && column <= model.ply_type(ply).mesh.columns
        })
    }
}

impl<S: Scalar> Stepper<S> {
    /// What the next steps depend on.
    pub(crate) fn memory(&self) -> StepperState {
        let (near, reserve) = self.projectile.memory();
        StepperState { travel: self.plies.travel, near: near.to_vec(), reserve }
    }

    /// Goes on with the memory of another stepper of the same model.
    pub(crate) fn remember(&mut self, model: &Model<S>, memory: StepperState) {
        self.plies.travel = memory.travel;
        self.projectile.remember(model, memory.near, memory.reserve);
    }
}
