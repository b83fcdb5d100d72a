//! Largest deflection of each ply: of fabric that hangs on an edge, or is most of a ply without a clamped edge.
//!
//! Debris flies ahead of the fabric that it came from, and must not count. What a piece of fabric hangs on is told by the whole state
//! ([`hanging`](crate::run::pieces::hanging)), which is too much for every sample. Before anything has come loose every sample counts; so the state is
//! looked at from time to time, and pieces never grow together again. From the first loose piece on, what hangs is measured at
//! these looks alone.

use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::run::pieces::Hanging;
use crate::solver::energy_balance::PlyMoment;

/// Looks between the start and the end time.
const LOOKS: f64 = 80.0;

/// Deflections so far, ply by ply.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Deflections {
    plies: Vec<Largest>,
    /// Looks whose time has come.
    looks: u64,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Largest {
    /// Up to the last look [m].
    known: f64,
    /// Of the samples since then [m].
    since: f64,
    /// A piece has come loose.
    loose: bool,
}

impl Deflections {
    pub(crate) fn new(plies: usize) -> Self {
        Self { plies: vec![Largest::default(); plies], looks: 0 }
    }

    /// Plies.
    pub(crate) fn plies(&self) -> usize {
        self.plies.len()
    }

    /// Whether the state is to be looked at before the step from `time` [s]. Time alone decides, so that every backend looks at
    /// the same states.
    pub(crate) fn is_due(&self, case: &Case, time: f64, dt: f64) -> bool {
        case.projectile.is_some() && time >= self.looks as f64 * (case.solver.end_time / LOOKS) - 0.5 * dt
    }

    /// Takes the deflections of a sample, debris included.
    pub(crate) fn sample(&mut self, plies: &[PlyMoment]) {
        for (own, ply) in self.plies.iter_mut().zip(plies).filter(|(own, _)| !own.loose) {
            own.since = own.since.max(ply.deflection);
        }
    }

    /// Takes what hangs at `time` [s]; `hanging` is asked of plies that have failed alone.
    pub(crate) fn look(
        &mut self,
        case: &Case,
        time: f64,
        dt: f64,
        failed: &[[u64; 2]],
        hanging: impl Fn(usize) -> Hanging,
    ) {
        while self.is_due(case, time, dt) {
            self.looks += 1;
        }
        for (ply, own) in self.plies.iter_mut().enumerate() {
            if failed[ply] != [0; 2] {
                let hanging = hanging(ply);
                own.loose |= hanging.loose;
                own.known = own.known.max(hanging.deflection);
            }
            if !own.loose {
                own.known = own.known.max(own.since);
            }
            own.since = 0.0;
        }
    }

    /// The largest of each ply [m].
    pub(crate) fn largest(&self) -> Vec<f64> {
        self.plies.iter().map(|ply| if ply.loose { ply.known } else { ply.known.max(ply.since) }).collect()
    }
}

#[cfg(test)]
#[path = "deflection_tests.rs"]
mod tests;
