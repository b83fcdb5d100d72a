//! Wall time of the phases of the steps of a run.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// A phase of a step: a kernel with what is added up after it, or the record of what the step did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// `element_force`
    ElementForce,
    /// `node_update`
    NodeUpdate,
    /// `ply_contact`
    PlyContact,
    /// `projectile_contact`, with the motion of the body.
    ProjectileContact,
    /// History, outcome, and the watch over the numbers.
    Record,
}

impl Phase {
    const ALL: [Self; 5] =
        [Self::ElementForce, Self::NodeUpdate, Self::PlyContact, Self::ProjectileContact, Self::Record];

    /// Name of its kernel, as scripts know it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ElementForce => "element_force",
            Self::NodeUpdate => "node_update",
            Self::PlyContact => "ply_contact",
            Self::ProjectileContact => "projectile_contact",
            Self::Record => "record",
        }
    }
}

/// Adds up what each phase takes. A lap costs one reading of the clock.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stopwatch {
    spent: [Duration; Phase::ALL.len()],
    /// Elements and nodes in one sweep.
    both: Duration,
    #[serde(skip, default = "Instant::now")] // of this process alone
    last: Instant,
}

impl Default for Stopwatch {
    fn default() -> Self {
        Self { spent: Default::default(), both: Duration::ZERO, last: Instant::now() }
    }
}

impl Stopwatch {
    /// Starts a lap: time up to now belongs to no phase.
    pub fn start(&mut self) {
        self.last = Instant::now();
    }

    /// Ends a lap: time since the last call belongs to this phase.
    pub fn lap(&mut self, phase: Phase) {
        let now = Instant::now();
        self.spent[phase as usize] += now - self.last;
        self.last = now;
    }

    /// Ends a lap of elements and nodes in one sweep.
    pub(crate) fn lap_of_both(&mut self) {
        let now = Instant::now();
        self.both += now - self.last;
        self.last = now;
    }

    /// Every phase by name, and its wall time [s]. That of the sweeps is split as in the steps that did elements and nodes apart.
    pub fn seconds(&self) -> Vec<(&'static str, f64)> {
        let apart = [Phase::ElementForce, Phase::NodeUpdate].map(|phase| self.spent[phase as usize].as_secs_f64());
        let scale = 1.0 + self.both.as_secs_f64() / (apart[0] + apart[1]).max(f64::MIN_POSITIVE);
        let seconds = |phase: Phase| match phase {
            Phase::ElementForce => scale * apart[0],
            Phase::NodeUpdate => scale * apart[1],
            _ => self.spent[phase as usize].as_secs_f64(),
        };
        Phase::ALL.map(|phase| (phase.name(), seconds(phase))).to_vec()
    }
}
