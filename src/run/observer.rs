//! Observers of a run, and the view they get of it.

use std::sync::Arc;

use serde::{Serialize, de::DeserializeOwned};

use crate::model::Model;
use crate::run::checkpoint::Checkpointable;
use crate::solver::row_kernels::KernelScalar;
use crate::solver::state::State;

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Progress {
    /// Time of the positions [s].
    pub time: f64,
    /// End of the run [s].
    pub end_time: f64,
    /// Velocity of the projectile along its line of flight [m/s].
    pub velocity: f64,
    /// Yarns failed.
    pub failed: u64,
    /// Steps done.
    pub steps: u64,
    /// Elements.
    pub elements: usize,
}

/// Observer of a run. It is called on the thread that drives the run, so whatever takes long belongs on another.
///
/// A closure that takes [`Progress`] follows progress alone, `()` nothing at all.
pub trait Observer: Send {
    /// Called when rows of the history have been added.
    fn on_progress(&mut self, _progress: &Progress) {}
    /// Whether it wants the state at `time` [s], `dt` [s] after the last. Nothing but time may decide, and the states it has taken: it is also
    /// asked about times to come.
    fn snapshot_due(&self, _time: f64, _dt: f64) -> bool {
        false
    }
    /// Called with the state at a time that is due, before the next step.
    fn on_snapshot(&mut self, _view: &View<'_>) {}
    /// Called with the state after the last step. A device that has run past the end of the run has none.
    fn on_end(&mut self, _view: &View<'_>) {}
    /// Whether it wants to save the run before the step from `time` [s], `dt` [s] long. Nothing but time may decide, and what it has saved.
    fn checkpoint_due(&self, _time: f64, _dt: f64) -> bool {
        false
    }
    /// Called with the run at a time when it wants to save it, or before the user ends it. `loop_seconds`: time in the loop so far [s].
    fn on_checkpoint(&mut self, _run: &dyn Checkpointable, _loop_seconds: f64) {}
}

/// Model and state, for an observer to look at. Its contents may change with any release: a
/// [`SnapshotTaker`](crate::run::frame::SnapshotTaker) makes a frame of it.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum View<'a> {
    /// In double precision.
    #[doc(hidden)]
    Double(&'a Arc<Model<f64>>, &'a State<f64>),
    /// In single precision, which a graphics processor always computes in.
    #[doc(hidden)]
    Single(&'a Arc<Model<f32>>, &'a State<f32>),
}

impl View<'_> {
    /// Steps done.
    pub fn step(&self) -> u64 {
        match self {
            Self::Double(_, state) => state.step,
            Self::Single(_, state) => state.step,
        }
    }

    /// Time of the positions, and of a step [s].
    pub fn clock(&self) -> [f64; 2] {
        let dt = match self {
            Self::Double(model, _) => model.dt,
            Self::Single(model, _) => model.dt,
        };
        [self.step() as f64 * dt, dt]
    }
}

/// Precision of runs on the processor.
pub trait RunScalar: KernelScalar + Serialize + DeserializeOwned {
    /// View of a state.
    fn view<'a>(model: &'a Arc<Model<Self>>, state: &'a State<Self>) -> View<'a>;
}

impl RunScalar for f64 {
    fn view<'a>(model: &'a Arc<Model<Self>>, state: &'a State<Self>) -> View<'a> {
        View::Double(model, state)
    }
}

impl RunScalar for f32 {
    fn view<'a>(model: &'a Arc<Model<Self>>, state: &'a State<Self>) -> View<'a> {
        View::Single(model, state)
    }
}

impl Observer for () {}

impl<F: FnMut(&Progress) + Send> Observer for F {
    fn on_progress(&mut self, progress: &Progress) {
        self(progress);
    }
}
