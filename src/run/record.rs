//! Record of a run so far, and the times of its samples: the part of the host loop that every backend shares.
//!
//! Here, and only here, the part of a scene that mirror planes leave becomes the whole again: what comes in is of the part, what goes into
//! history, events and counts is of the whole.

use std::sync::Arc;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::attachment::{self, Deflections};
use super::outcome::{self, Outcome, Tracker};
use super::result::profile;
use super::{Observer, PlySample, Progress, Run, RunScalar, Sample, Skips};
use crate::case::{Case, RunUntil};
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::{MirrorPlanes, RigidBody};
use crate::solver::energy_balance::{Balance, EnergyBalance, PlyMoment};
use crate::solver::state::{Given, State};
use crate::solver::{self, FailureEvent, StepTotals};

/// Rounding allowed in comparing times, in steps.
const SLACK: f64 = 1e-6;
/// Least time between two closer looks at the fabric that covers the projectile, which take the whole state [s].
const LOOKS: f64 = 10e-6;

/// Velocity [m/s] and position [m] of the projectile.
pub(crate) type Flight = (Vector3<f64>, Vector3<f64>);

/// Record of a run so far.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct RunRecord {
    /// Results so far; until the end residuals in newtons, errors of energy in joules, counts of the part that is computed.
    pub(crate) run: Run,
    pub(crate) balance: EnergyBalance,
    /// Energy and momentum of the start, which the first sample takes.
    #[serde(skip)]
    pub(crate) given: Given,
    /// Residual evaluations, and unit cells solved.
    pub(crate) evaluations: [f64; 2],
    /// Failed warps and wefts of each ply.
    failed: Vec<[u64; 2]>,
    pub(crate) eroded: u64,
    deflections: Deflections,
    tracker: Option<Tracker>,
    /// The projectile has touched the fabric.
    touched: bool,
    /// The outcome that the case asks for is known.
    decided: bool,
}

impl RunRecord {
    /// Record of a run that begins with this projectile.
    pub(crate) fn new<S: Scalar>(model: &Model<S>, body: Option<&RigidBody>, skips: Skips) -> Self {
        let copies = model.planes.copies() as f64;
        let areal_density = model.plies.iter().map(|ply| model.ply_types[ply.ply_type].areal_density).sum();
        let free = attachment::free_pack(model);
        let run = Run {
            impact_energy: body.map_or(0.0, RigidBody::kinetic_energy) * copies,
            plies: model.plies.len(),
            elements: model.whole_elements(),
            planes: model.planes,
            skips,
            time_step: model.dt,
            ..Run::default()
        };
        Self {
            run,
            balance: EnergyBalance::of_part(model.planes),
            given: Given::default(),
            evaluations: [0.0; 2],
            failed: vec![[0; 2]; model.plies.len()],
            eroded: 0,
            deflections: Deflections::new(model.plies.len()),
            tracker: body.map(|b| {
                let mut tracker = Tracker::new(b, b.mass * copies, areal_density, free);
                tracker.backed = model.backing.is_some();
                tracker
            }),
            touched: false,
            decided: false,
        }
    }

    /// Whether something other than time or the user ends the run.
    pub(crate) fn is_over(&self) -> bool {
        self.run.divergence.is_some() || self.decided || self.run.lost.is_some()
    }

    /// Whether the step from the positions at `time` [s] is sampled.
    pub(crate) fn sample_due(&self, case: &Case, time: f64) -> bool {
        let last = self.run.history.last().map(|sample| sample.time);
        sample_due(case, last, time, self.run.time_step) || self.run.interrupted || self.run.divergence.is_some()
    }

    fn profile_due(&self, case: &Case, time: f64) -> bool {
        let next = case.output.profile_times.get(self.run.profiles.len());
        next.is_some_and(|due| time >= due - 0.5 * self.run.time_step)
    }

    /// Whether the record wants the state before the step from `time` [s].
    pub(crate) fn state_due(&self, case: &Case, time: f64) -> bool {
        self.profile_due(case, time) || self.deflections.is_due(case, time, self.run.time_step)
    }

    /// Whether the state itself is needed for that: fabric without failures is attached.
    pub(crate) fn needs_state(&self, case: &Case, time: f64) -> bool {
        self.profile_due(case, time) || self.failed() != [0; 2]
    }

    /// Takes what is due of the state before the step from `time` [s], and shows it to the observer where that is due.
    pub(crate) fn read_state<S: RunScalar>(
        &mut self,
        model: &Arc<Model<S>>,
        state: &State<S>,
        case: &Case,
        observer: &mut dyn Observer,
        time: f64,
    ) {
        let dt = self.run.time_step;
        if self.profile_due(case, time) {
            self.run.profiles.push(profile(model, state, case, time));
        }
        if self.deflections.is_due(case, time, dt) {
            let attached = |ply| attachment::attached(model, state, ply);
            let (since, found) = self.deflections.look(case, time, dt, &self.failed, attached);
            for (ply, most) in found {
                let rows = self.run.ply_history.iter_mut().rev().take_while(|row| row.time >= since);
                rows.filter(|row| row.ply == ply)
                    .for_each(|row| row.moment.deflection = row.moment.deflection.min(most));
            }
        }
        if observer.snapshot_due(time, dt) {
            observer.on_snapshot(&S::view(model, state));
        }
    }

    /// Adds the totals and failures of one step.
    pub(crate) fn add_step(&mut self, totals: &StepTotals, failures: &[FailureEvent]) {
        let run = &mut self.run;
        self.evaluations[0] += totals.iterations;
        self.evaluations[1] += totals.solved;
        run.newton.unconverged += totals.unconverged;
        run.newton.max_residual = run.newton.max_residual.max(totals.max_residual);
        run.max_penetration = run.max_penetration.max(totals.penetration);
        run.max_ply_penetration = run.max_ply_penetration.max(totals.ply_penetration);
        run.element_steps_computed += totals.computed;
        self.eroded += totals.eroded;
        self.add_failures(failures);
    }

    /// Adds yarn failures to the list and to the counts.
    pub(crate) fn add_failures<'a>(&mut self, failures: impl IntoIterator<Item = &'a FailureEvent>) {
        for failure in failures {
            self.failed[failure.ply as usize][usize::from(failure.yarn)] += self.run.planes.copies();
            self.run.events.push(*failure);
        }
    }

    /// Failed warps and wefts.
    fn failed(&self) -> [u64; 2] {
        [0, 1].map(|yarn| self.failed.iter().map(|ply| ply[yarn]).sum())
    }

    /// Progress so far.
    pub(crate) fn progress(&self, case: &Case) -> Progress {
        Progress {
            time: self.run.steps as f64 * self.run.time_step,
            end_time: case.solver.end_time,
            velocity: self.run.history.last().map_or(0.0, |sample| sample.projectile_velocity),
            failed: self.failed().iter().sum(),
            steps: self.run.steps,
            elements: self.run.elements,
        }
    }

    /// Adds a row to the history at `time` [s] from the last sample of the energy balance, and follows the projectile: after the step, and what
    /// it was before. `covered`: whether intact fabric of a ply lies ahead of it. True where a closer [`look`](Self::look) is due.
    #[must_use]
    pub(crate) fn sample(
        &mut self,
        case: &Case,
        time: f64,
        body: Option<(&RigidBody, Flight)>,
        covered: impl Fn(&RigidBody, usize) -> bool,
    ) -> bool {
        let (failed, copies, dt) = (self.failed(), self.run.planes.copies(), self.run.time_step);
        if self.run.history.is_empty() {
            self.run.fabric_energy = self.balance.begin(self.given) * copies as f64;
            self.run.exchanged_energy = self.given.measurable * copies as f64;
        }
        // The first row has no time before it: what acts at once belongs to the first interval.
        let impulse = match self.run.history.is_empty() {
            true => Vector3::zeros(),
            false => self.run.planes.whole(std::mem::take(&mut self.balance.contact_impulse).into()),
        };
        self.deflections.correct(&mut self.balance.plies);
        let (mut balance, plies) = (self.balance.balance(), &self.balance.plies);
        let before = self.run.history.last().copied();
        let last = before.unwrap_or_default();
        if failed != last.failed {
            // What broke was strained to its failure strain, whether or not in a step with a sample.
            balance.max_load = balance.max_load.max(1.0);
        }
        let mut row = Sample {
            time,
            balance: balance.times(copies as f64),
            failed,
            eroded: self.eroded * copies,
            perforated_plies: last.perforated_plies,
            ..Sample::default()
        };
        let since = time - last.time;
        self.touched |= impulse != Vector3::zeros();
        if let Some((body, (velocity, position))) = body {
            // The mean of the half-step velocities around this time; at the very start, the velocity given.
            let now = if before.is_none() { velocity } else { (velocity + body.velocity) * 0.5 };
            row.projectile_velocity = now.dot(&body.flight);
            row.projectile_displacement = (position - body.start).dot(&body.flight);
            row.contact_force = if since > 0.0 { impulse.dot(&body.flight) / since } else { 0.0 };
            if body.velocity.z > 0.0 {
                let torn = self.failed.iter().enumerate().filter(|(_, failed)| failed[0] + failed[1] > 0);
                let through = self.tracker.as_ref().is_some_and(|tracker| tracker.outcome == Outcome::Perforated);
                row.perforated_plies = torn.filter(|(ply, _)| through || !covered(body, *ply)).count() as u32;
            }
        }
        let run = &mut self.run;
        let Balance { projectile, external, error, gained, .. } = &mut row.balance;
        let put_in = run.fabric_energy + (run.impact_energy - *projectile).abs() + external.abs();
        run.exchanged_energy = run.exchanged_energy.max(put_in);
        run.energy_error = run.energy_error.max(error.abs());
        if gained.abs() > run.energy_gained.abs() {
            run.energy_gained = *gained;
        }
        *error /= run.exchanged_energy;
        *gained /= run.exchanged_energy;
        run.momentum_error = run.momentum_error.max(balance.momentum_error);
        let scale = copies as f64;
        let rows = plies.iter().zip(&self.failed).enumerate();
        run.ply_history.extend(rows.map(|(ply, (m, failed))| {
            let moment = PlyMoment { kinetic: m.kinetic * scale, stored: m.stored * scale, ..*m };
            PlySample { time, ply, moment, failed: *failed }
        }));
        run.history.push(row);
        let (Some(tracker), Some((body, _))) = (&mut self.tracker, body) else { return false };
        let any = || (0..self.failed.len()).any(|ply| covered(body, ply));
        tracker.update(time, body, impulse.norm(), self.touched || failed[0] + failed[1] > 0, any);
        let in_doubt = tracker.in_doubt;
        self.decide(case);
        in_doubt && look_due(case, before.map(|sample| sample.time), time, dt)
    }

    /// Whether a closer look may be due after the step from `time` [s], as far as samples are known: never wrongly not, so that a device can be
    /// asked to wait there. `last`: time of the last sample.
    pub(crate) fn may_look(&self, case: &Case, last: Option<f64>, time: f64) -> bool {
        look_due(case, last, time, self.run.time_step)
            && self.tracker.as_ref().is_some_and(|tracker| tracker.may_be_quiet(time))
    }

    /// Takes a closer look at the fabric that covers the projectile, in the state after the last sample.
    pub(crate) fn look<S: Scalar>(&mut self, case: &Case, model: &Model<S>, state: &State<S>) {
        let (Some(tracker), Some(row), Some(body)) = (&mut self.tracker, self.run.history.last_mut(), &state.body)
        else {
            return;
        };
        let held = |speed: f64| (0..self.failed.len()).any(|ply| outcome::is_held(model, state, body, ply, speed));
        tracker.look(row.time, body, held);
        if tracker.outcome == Outcome::Perforated {
            row.perforated_plies = self.failed.iter().filter(|failed| **failed != [0; 2]).count() as u32;
        }
        self.decide(case);
    }

    /// Ends the run with the last sample, if that is the one asked for.
    fn decide(&mut self, case: &Case) {
        let Some(tracker) = &self.tracker else { return };
        let asked = match case.solver.run_until {
            RunUntil::Outcome => tracker.outcome != Outcome::Running,
            RunUntil::Separation => tracker.outcome == Outcome::Perforated || tracker.separated,
            RunUntil::EndTime => false,
        };
        self.decided |= asked && self.run.skips.outcome;
    }

    /// Takes note of where and how the run diverged.
    pub(crate) fn diagnose<S: Scalar>(&mut self, model: &Model<S>, state: &State<S>, excess: (&str, f64)) {
        let available = self.balance.accounted_energy();
        self.run.divergence = Some(solver::diagnose(model, state, excess, available));
    }

    /// Results; what computed them is left to the backend.
    pub(crate) fn finish<S: Scalar>(self, model: &Model<S>, loop_seconds: f64) -> Run {
        let present = model.ply_types.iter().flat_map(|s| (0..2).filter(|i| s.present[*i]).map(|i| &s.cell.yarn[i]));
        let breaking = present.map(|yarn| yarn.tension(yarn.failure_strain.min(1.0)));
        let weakest = breaking.fold(f64::INFINITY, f64::min);
        let history = &self.run.history;
        // What clay takes is load that no yarn carries.
        let taken_up = |sample: &Sample| sample.balance.internal + sample.balance.backing;
        let internal = history.iter().map(taken_up).fold(0.0, f64::max);
        let hourglass = history.iter().map(|sample| sample.balance.hourglass).fold(0.0, f64::max);
        let mut run = self.run;
        if let Some(tracker) = &self.tracker {
            run.outcome = tracker.outcome;
            run.stop_time = tracker.stop_time;
            run.carried_velocity = tracker.carried_velocity();
            run.rebound_velocity = tracker.rebound_velocity;
        }
        let [held, all] = self.balance.frame;
        // A drive takes whatever there is.
        let is_free = model.projectile.as_ref().is_some_and(|body| !body.prescribed);
        run.frame_share = if is_free && all > 0.0 { held / all } else { 0.0 };
        run.hourglass_fraction = if internal > 0.0 { hourglass / internal } else { 0.0 };
        run.energy_error /= run.exchanged_energy;
        run.energy_gained /= run.exchanged_energy;
        run.newton.max_residual /= weakest;
        run.newton.mean_iterations = self.evaluations[0] / self.evaluations[1].max(1.0);
        run.newton.unconverged *= run.planes.copies();
        run.deflections = vec![0.0; run.plies];
        for (row, plies) in run.history.iter_mut().zip(run.ply_history.chunks(run.plies)) {
            for (largest, ply) in run.deflections.iter_mut().zip(plies) {
                row.last_deflection = ply.moment.deflection;
                row.deflection = row.deflection.max(row.last_deflection);
                *largest = largest.max(row.last_deflection);
            }
        }
        if run.plies == 1 {
            run.ply_history.clear();
        }
        run.events = whole_events(model, run.events);
        run.loop_seconds = loop_seconds;
        run.step_set_by = model.bound.set_by;
        run
    }
}

/// Whether positions at `time` belong into the history, whose last row is at `last` [s]. Time alone decides, so that every backend records
/// the same samples.
pub(super) fn sample_due(case: &Case, last: Option<f64>, time: f64, dt: f64) -> bool {
    last.is_none_or(|last| interval_over(case.output.history_interval, last, time, dt)) || time_up(case, time, dt)
}

/// Whether the first multiple of an interval after `last` lies before the step from `time`, `dt` long [s].
pub(crate) fn interval_over(interval: f64, last: f64, time: f64, dt: f64) -> bool {
    let count = (last / interval + 1e-9).floor() + 1.0;
    time >= count * interval - SLACK * dt
}

/// Whether a sample at `time`, the last one at `last` [s], is the first after a multiple of [`LOOKS`], or the last of all.
fn look_due(case: &Case, last: Option<f64>, time: f64, dt: f64) -> bool {
    let count = |time: f64| (time / LOOKS + 1e-9).floor();
    time_up(case, time, dt) || last.is_none_or(|last| count(time) > count(last))
}

/// Whether the run's time ends with positions at `time` [s].
pub(super) fn time_up(case: &Case, time: f64, dt: f64) -> bool {
    time >= case.solver.end_time - SLACK * dt
}

/// Failures of the part with those of its mirror images, each step in order of ply, row, column and yarn.
fn whole_events<S: Scalar>(model: &Model<S>, events: Vec<FailureEvent>) -> Vec<FailureEvent> {
    if model.planes == MirrorPlanes::NONE {
        return events;
    }
    let images = |event: FailureEvent| {
        let images = model.ply_type(event.ply as usize).mesh.images([event.i as usize, event.j as usize], 1);
        images.map(move |([column, row], _)| FailureEvent { i: column as u32, j: row as u32, ..event })
    };
    let mut all: Vec<_> = events.into_iter().flat_map(images).collect();
    all.sort_by_key(|e| (e.step, e.ply, e.j, e.i, e.yarn));
    all
}
