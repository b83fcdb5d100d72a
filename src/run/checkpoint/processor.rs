//! A run on the processor: to a checkpoint and back.

use std::io::{self, Write};

use super::body::BodyMotion;
use super::{Checkpoint, CheckpointFault, Checkpointable, Header, Reader, Writer, write};
use crate::case::Case;
use crate::model::layup::{SIDES, neighbour};
use crate::model::{Model, layup};
use crate::num::scalar::Scalar;
use crate::run::{RunError, RunScalar, Simulation};
use crate::solver::active_region::ActiveRegion;
use crate::solver::state::State;
use crate::solver::state::StepperState;

impl<S: RunScalar> Checkpointable for Simulation<S> {
    fn time(&self) -> f64 {
        Self::time(self)
    }

    fn save(&self, head: &Header, followed: &[u8], to: &mut dyn Write) -> io::Result<()> {
        let head = Header { step: self.state.step, time: self.time(), time_step: self.model.dt, ..head.clone() };
        write(to, &head, followed, |contents| {
            contents.value(&self.balance)?;
            contents.value(&self.record)?;
            contents.value(&self.stepper.memory())?;
            contents.value(&self.stepper.stopwatch)?;
            save_state(&self.state, contents)
        })
    }
}

impl<S: RunScalar> Simulation<S> {
    /// A run that goes on from a checkpoint, bit by bit as the one that wrote it.
    ///
    /// # Errors
    /// When the case cannot become a model, or the checkpoint is not one of it.
    pub fn resume(case: &Case, checkpoint: &Checkpoint) -> Result<Self, RunError> {
        let mut simulation = Self::with_skips(case, checkpoint.head().skips)?;
        checkpoint.contents(|contents| {
            simulation.balance = contents.value("sums of energy")?;
            simulation.record = contents.value("results so far")?;
            let memory: StepperState = contents.value("nodes near the projectile")?;
            let Simulation { model, state, stepper, .. } = &mut simulation;
            if !memory.fits(model) {
                return Err(CheckpointFault::Contents("nodes near the projectile"));
            }
            stepper.remember(model, memory);
            stepper.stopwatch = contents.value("time that each kernel took")?;
            state.step = checkpoint.head().step;
            read_state(model, state, contents)?;
            let fits = simulation.record.fits(&simulation.model);
            if fits { Ok(()) } else { Err(CheckpointFault::Contents("results so far")) }
        })?;
        Ok(simulation)
    }
}

fn save_state<S: Scalar>(state: &State<S>, contents: &mut Writer<'_>) -> io::Result<()> {
    contents.value(&state.body.as_ref().map(BodyMotion::of))?;
    contents.value(&state.active)?;
    contents.numbers(&state.nodes.data)?;
    contents.numbers(&state.elements.data)?;
    contents.numbers(&state.over)
}

fn read_state<S: Scalar>(
    model: &Model<S>,
    state: &mut State<S>,
    contents: &mut Reader<'_>,
) -> Result<(), CheckpointFault> {
    match (contents.value::<Option<BodyMotion>>("motion of the projectile")?, &mut state.body) {
        (Some(motion), Some(body)) => motion.give(body),
        (None, None) => {}
        _ => return Err(CheckpointFault::Contents("motion of the projectile")),
    }
    let reach: Vec<ActiveRegion> = contents.value("what has moved")?;
    let within = |(ply, reach): (usize, &ActiveRegion)| {
        let whole = ActiveRegion::whole(&model.ply_type(ply).mesh);
        reach.rows.end <= whole.rows.end && reach.columns.end <= whole.columns.end
    };
    if reach.len() != model.plies.len() || !reach.iter().enumerate().all(within) {
        return Err(CheckpointFault::Contents("what has moved"));
    }
    state.active = reach;
    contents.numbers(&mut state.nodes.data, "nodes")?;
    contents.numbers(&mut state.elements.data, "elements")?;
    contents.numbers(&mut state.over, "what nodes are over")?;
    if is_over_elements(model, &state.over) { Ok(()) } else { Err(CheckpointFault::Contents("what nodes are over")) }
}

/// Whether every node is over an element that the neighbouring ply has.
fn is_over_elements<S: Scalar>(model: &Model<S>, all: &[u32]) -> bool {
    all.chunks(model.nodes_per_ply()).enumerate().all(|(at, part)| {
        let count = neighbour(at / SIDES, at % SIDES, model.plies.len()).map_or(1, |other| {
            let mesh = &model.ply_type(other).mesh;
            mesh.rows * mesh.columns
        });
        part.iter().all(|over| layup::element(*over) < count)
    })
}
