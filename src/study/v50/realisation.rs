//! The search for the thresholds of one realisation: on the mesh of its case, then on the finer one where that was asked for.

use super::threshold::{FurtherShots, Rungs, ThresholdSearch, Wanted, middle};
use crate::study::batch::ShotOrder;
use crate::study::outcomes::Shot;

/// First step of a search on the finer mesh, over the threshold on the coarser one.
const REFINED_STEP: f64 = 0.02;
/// Realisations that are shot further above their thresholds too, for the residual velocities, and where.
const FURTHER: (u32, &[f64]) = (8, &[1.15, 1.4]);

/// What is known of the threshold of a realisation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FoundThreshold {
    /// Highest stop below it and lowest perforation above it [m/s]; or why there is none.
    pub(super) bracket: Result<[f64; 2], String>,
    pub(super) monotone: bool,
    /// The bracket on the finer mesh [m/s], where it was looked for and found.
    pub(super) refined: Option<[f64; 2]>,
}

/// Where a search begins [m/s] and its first step, in rungs.
#[derive(Clone, Copy)]
pub(super) struct Start {
    pub(super) velocity: f64,
    pub(super) step: i32,
}

/// A search under way.
pub(super) struct RealisationSearch {
    realisation: u32,
    rungs: Rungs,
    search: ThresholdSearch,
    /// Mesh of the search: 0 is that of the case, 1 the finer one.
    mesh: usize,
    /// Meshes that are searched.
    meshes: usize,
    found: FoundThreshold,
}

impl RealisationSearch {
    /// A search on so many meshes.
    pub(super) fn new(realisation: u32, rungs: Rungs, start: Start, meshes: usize) -> Self {
        let beyond = if realisation < FURTHER.0 { FURTHER.1 } else { &[] };
        let search = ThresholdSearch::new(rungs, start.velocity, start.step, FurtherShots { beside: true, beyond });
        let found = FoundThreshold { bracket: Err("no bracket".to_owned()), monotone: true, refined: None };
        Self { realisation, rungs, search, mesh: 0, meshes, found }
    }

    /// The mesh of the next shot, and the shot; `None` once the search is over.
    pub(super) fn wanted(&mut self) -> Option<(usize, ShotOrder)> {
        while self.mesh < self.meshes {
            match self.search.wanted() {
                Wanted::Shot(rung) => {
                    let velocity = Some(self.rungs.velocity(rung));
                    return Some((self.mesh, ShotOrder { shot: self.realisation, velocity }));
                }
                Wanted::Nothing => self.end(self.search.bracket().ok_or_else(|| "no bracket".to_owned())),
                Wanted::NoThreshold => self.end(Err("no velocity from 2 to 4900 m/s changes the outcome".to_owned())),
            }
        }
        None
    }

    /// Takes note of the outcome of the shot that was wanted; or why it has none, which ends the search on its mesh.
    pub(super) fn see(&mut self, outcome: Result<Shot, String>) {
        match (outcome, self.search.wanted()) {
            (Ok(shot), Wanted::Shot(rung)) => self.search.see(rung, shot.perforated),
            (Ok(_), _) => {}
            (Err(reason), _) => self.end(Err(reason)),
        }
    }

    /// Ends the search on its mesh; that on the finer one begins where it ended.
    fn end(&mut self, bracket: Result<[f64; 2], String>) {
        if self.mesh == 1 {
            self.found.refined = bracket.ok();
        } else {
            self.found.monotone = bracket.is_err() || self.search.is_monotone();
            match &bracket {
                Ok(bracket) => {
                    let step = (REFINED_STEP / self.rungs.width).round() as i32;
                    self.search = ThresholdSearch::new(self.rungs, middle(*bracket), step, FurtherShots::NONE);
                }
                Err(_) => self.meshes = 1,
            }
            self.found.bracket = bracket;
        }
        self.mesh += 1;
    }

    /// What was found.
    pub(super) fn found(self) -> FoundThreshold {
        self.found
    }
}
