//! Rows of the history, and what becomes of the projectile by them.

use nalgebra::Vector3;
use tracing::info;

use super::RunRecord;
use crate::case::{Case, RunUntil};
use crate::physics::rigid_body::RigidBody;
use crate::run::due::look_due;
use crate::run::outcome::Outcome;
use crate::run::{PlySample, Sample};
use crate::solver::energy_balance::{Balance, PlyMoment};

/// Everything the history takes note of at one time of positions.
pub(crate) struct SampleInput<'a> {
    /// [s]
    pub(crate) time: f64,
    /// Time step [s].
    pub(crate) dt: f64,
    pub(crate) balance: Balance,
    /// What each ply holds.
    pub(crate) plies: &'a [PlyMoment],
    /// On the fabric since the last moment [N·s].
    pub(crate) impulse: Vector3<f64>,
    /// The projectile after the step, and what it was before.
    pub(crate) body: Option<(&'a RigidBody, Flight)>,
}

/// Velocity [m/s] and position [m] of the projectile.
pub(crate) type Flight = (Vector3<f64>, Vector3<f64>);

impl RunRecord {
    /// Whether what covers the projectile may have to be looked at closer after the step from `time` [s], as far as samples are
    /// known: never wrongly not, so that a device can be asked to wait there. `last`: time of the last sample.
    pub(crate) fn may_look(&self, case: &Case, last: Option<f64>, time: f64, dt: f64) -> bool {
        look_due(case, last, time, dt) && self.tracker.as_ref().is_some_and(|tracker| tracker.may_be_quiet(time))
    }

    /// Takes note of a closer look at the last sample: `held` tells whether fabric of a ply that is no faster than a speed [m/s] covers
    /// the projectile and can hold it.
    pub(crate) fn look(&mut self, case: &Case, body: &RigidBody, held: impl Fn(usize, f64) -> bool) {
        let (Some(tracker), Some(row)) = (&mut self.tracker, self.history.last_mut()) else { return };
        tracker.look(row.time, body, |speed| (0..self.failed.len()).any(|ply| held(ply, speed)));
        if tracker.outcome == Outcome::Perforated {
            row.perforated_plies = self.failed.iter().filter(|failed| **failed != [0; 2]).count() as u32;
        }
        self.decide(case);
    }

    /// Adds a row to the history and follows the projectile. `covered` tells whether whole fabric of a ply lies ahead of it. True where
    /// a closer [`look`](Self::look) at what covers it is due.
    #[must_use]
    pub(crate) fn sample(
        &mut self,
        case: &Case,
        at: &SampleInput<'_>,
        covered: impl Fn(&RigidBody, usize) -> bool,
    ) -> bool {
        let last = self.history.last().copied().unwrap_or_default();
        let failed = self.failed();
        let copies = self.planes.copies();
        let impulse = self.planes.whole(at.impulse);
        let mut row = Sample {
            time: at.time,
            balance: at.balance.times(copies as f64),
            failed,
            eroded: self.eroded * copies,
            deflection: at.plies.iter().map(|ply| ply.deflection).fold(0.0, f64::max),
            last_deflection: at.plies.last().map_or(0.0, |ply| ply.deflection),
            perforated_plies: last.perforated_plies,
            ..Sample::default()
        };
        let since = at.time - last.time;
        if !self.touched && impulse != Vector3::zeros() {
            self.touched = true;
            info!(time_us = at.time * 1e6, "first contact");
        }
        if let Some((body, (velocity, position))) = at.body {
            // The mean of the half-step velocities around this time; at the very start, the velocity given.
            let now = if self.history.is_empty() { velocity } else { (velocity + body.velocity) * 0.5 };
            row.projectile_velocity = now.dot(&body.flight);
            row.projectile_displacement = (position - body.start).dot(&body.flight);
            row.contact_force = impulse.dot(&body.flight) / if since > 0.0 { since } else { at.dt };
            if body.velocity.z > 0.0 {
                let torn = self.failed.iter().enumerate().filter(|(_, failed)| failed[0] + failed[1] > 0);
                let through = self.tracker.as_ref().is_some_and(|tracker| tracker.outcome == Outcome::Perforated);
                row.perforated_plies = torn.filter(|(ply, _)| through || !covered(body, *ply)).count() as u32;
            }
        }
        self.deflections.sample(at.plies);
        self.energy_error = self.energy_error.max(at.balance.error.abs());
        if at.balance.gained.abs() > self.energy_gained.abs() {
            self.energy_gained = at.balance.gained;
        }
        self.momentum_error = self.momentum_error.max(at.balance.momentum_error);
        if at.plies.len() > 1 {
            let row = |(ply, moment): (usize, &PlyMoment)| PlySample {
                time: at.time,
                ply,
                moment: PlyMoment {
                    kinetic: moment.kinetic * copies as f64,
                    stored: moment.stored * copies as f64,
                    deflection: moment.deflection,
                },
                failed: self.failed[ply],
            };
            self.plies.extend(at.plies.iter().enumerate().map(row));
        }
        let before = self.history.last().map(|sample| sample.time);
        self.history.push(row);
        let mut in_doubt = false;
        if let (Some(tracker), Some((body, _))) = (&mut self.tracker, at.body) {
            let all = || (0..at.plies.len()).any(|ply| covered(body, ply));
            tracker.update(at.time, body, impulse.norm(), self.touched || failed[0] + failed[1] > 0, all);
            in_doubt = tracker.in_doubt;
            self.decide(case);
        }
        in_doubt && look_due(case, before, at.time, at.dt)
    }

    /// Whether the last sample ends the run.
    fn decide(&mut self, case: &Case) {
        let Some(tracker) = &self.tracker else { return };
        let asked = match case.solver.run_until {
            RunUntil::Outcome => tracker.outcome != Outcome::Running,
            RunUntil::Separation => tracker.outcome == Outcome::Perforated || tracker.separated,
            RunUntil::EndTime => false,
        };
        let decided = asked && self.skips.outcome;
        if decided && !self.decided {
            let time = self.history.last().map_or(0.0, |sample| sample.time);
            info!(time_us = time * 1e6, outcome = tracker.outcome.word(), "outcome known");
        }
        self.decided |= decided;
    }
}
