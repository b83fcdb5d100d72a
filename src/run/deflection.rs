//! Largest deflection of each ply: of fabric that hangs on an edge, or is most of a ply that is free all round.
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
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::case;

    fn ply(deflection: f64) -> [PlyMoment; 1] {
        [PlyMoment { stored: 0.0, deflection, kinetic: 0.0 }]
    }

    #[test]
    fn a_look_is_due_once_in_every_eightieth_of_the_run() {
        let case = case::shipped(&[]);
        let (apart, dt) = (case.solver.end_time / LOOKS, 1e-9);
        let mut deflections = Deflections::new(1);
        let hanging = |_| Hanging { deflection: 2e-3, loose: false };
        for look in 0..4 {
            let time = f64::from(look) * apart;
            assert!(!deflections.is_due(&case, time - dt, dt), "{look}");
            assert!(deflections.is_due(&case, time, dt), "{look}");
            deflections.look(&case, time, dt, &[[0; 2]], hanging);
        }
        // Two that were missed are one.
        deflections.look(&case, 6.0 * apart, dt, &[[0; 2]], hanging);
        assert!(!deflections.is_due(&case, 6.5 * apart, dt) && deflections.is_due(&case, 7.0 * apart, dt));
    }

    #[test]
    fn debris_counts_until_a_piece_is_found_loose_and_what_hangs_counts_always() {
        let case = case::shipped(&[]);
        let mut deflections = Deflections::new(1);
        deflections.sample(&ply(3e-3));
        deflections.sample(&ply(1e-3));
        assert_eq!(deflections.largest(), [3e-3]);
        // A ply without failure is not asked.
        deflections.look(&case, 0.0, 1e-9, &[[0; 2]], |_| Hanging { deflection: 9e-3, loose: true });
        assert_eq!(deflections.largest(), [3e-3]);
        deflections.sample(&ply(8e-3));
        deflections.look(&case, 0.0, 1e-9, &[[1, 0]], |_| Hanging { deflection: 4e-3, loose: true });
        assert_eq!(deflections.largest(), [4e-3], "what flew ahead before the look is forgotten");
        deflections.sample(&ply(20e-3));
        assert_eq!(deflections.largest(), [4e-3]);
        deflections.look(&case, 0.0, 1e-9, &[[0, 1]], |_| Hanging { deflection: 5e-3, loose: false });
        assert_eq!(deflections.largest(), [5e-3]);
    }
}
