//! Checkpoints: a run that goes on from one is the run that was never interrupted.
//!
//! Promises: from 20 random steps of a shot, in f64 and f32, for one ply and for a pack with failures, friction, profiles and
//! mirror planes, the resumed run has the same bits everywhere (history, failures, profiles, plies, summary, last
//! state), on any number of threads; a file that is damaged, cut short, foreign or of another run is refused by name.
//! Red when: something that later steps depend on is not in the file, or is not put back as it was; a bit of the file
//! changes and nobody notices.

mod equality;
mod keeping;
mod refusal;

use std::fs::File;

use ripstop::case::Case;
use ripstop::run::RunScalar;
use ripstop::run::checkpoint::{Checkpoint, Checkpointable, Header};
use ripstop::run::{Options, Simulation, Skips};
use tempfile::TempDir;

use crate::kept::ply;

/// Where a run on the processor writes its checkpoints.
struct Shelf(TempDir);

impl Shelf {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn save<S: RunScalar>(&self, case: &Case, simulation: &Simulation<S>) -> Checkpoint {
        let path = self.0.path().join(format!("{}.bin", simulation.state.step));
        let head = Header::new(case, &Options::default(), 1e-6);
        simulation.save(&head, &[], &mut File::create(&path).unwrap()).unwrap();
        Checkpoint::open(&path).unwrap_or_else(|e| panic!("{e}"))
    }
}

fn start<S: RunScalar>(case: &Case) -> Simulation<S> {
    Simulation::with_skips(case, Skips::default()).unwrap_or_else(|e| panic!("{e}"))
}
