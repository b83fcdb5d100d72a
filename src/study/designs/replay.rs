//! A design written down as what a range officer does: ask for a shot, look at it, go on. Shots that were fired already answer; the first
//! one that was not ends the procedure with its velocity.

use crate::study::outcomes::{Outcomes, Shot};

/// The velocity that is asked for next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Asked(pub(super) f64);

/// Shots fired, and how many of them were asked for so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Replay<'a> {
    shots: &'a [Shot],
    seen: usize,
}

impl<'a> Replay<'a> {
    pub(super) fn new(shots: &'a [Shot]) -> Self {
        Self { shots, seen: 0 }
    }

    /// What became of the next shot; its velocity is computed only where it was not fired yet.
    pub(super) fn ask(&mut self, velocity: impl FnOnce() -> f64) -> Result<Shot, Asked> {
        let shot = self.shots.get(self.seen).ok_or_else(|| Asked(velocity()))?;
        self.seen += 1;
        Ok(*shot)
    }

    /// Shots asked for so far.
    pub(super) fn seen(&self) -> &'a [Shot] {
        &self.shots[..self.seen]
    }

    /// What became of them.
    pub(super) fn outcomes(&self) -> Outcomes {
        self.seen().iter().collect()
    }
}
