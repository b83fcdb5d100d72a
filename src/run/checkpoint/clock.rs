//! How long all parts of a run have computed.

use std::time::Instant;

use super::Checkpoint;

/// Time in the loop, of all parts of a run.
pub(crate) struct LoopClock {
    before: f64,
    start: Instant,
}

impl Default for LoopClock {
    fn default() -> Self {
        Self { before: 0.0, start: Instant::now() }
    }
}

impl LoopClock {
    /// The clock of a run that goes on.
    pub(crate) fn after(checkpoint: &Checkpoint) -> Self {
        Self { before: checkpoint.head().spent.r#loop, ..Self::default() }
    }

    /// [s]
    pub(crate) fn seconds(&self) -> f64 {
        self.before + self.start.elapsed().as_secs_f64()
    }
}
