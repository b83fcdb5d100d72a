//! What a run has produced so far, and when the next record is due: the part of the host loop that every backend shares.
//!
//! Here, and only here, the part of a scene that mirror planes leave becomes the whole again: what comes in is of the
//! part, what goes into history, events and counts is of the whole.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tracing::info;

use crate::case::{Case, RunUntil};
use crate::kernels::rigid_body::RigidBody;
use crate::math::scalar::Scalar;
use crate::model::{MirrorPlanes, Model};
use crate::run::deflection::Deflections;
use crate::run::due::{look_due, sample_due};
use crate::run::outcome::{Outcome, Tracker};
use crate::run::pieces::Hanging;
use crate::run::profile::DeflectionProfile;
use crate::run::{NewtonStatistics, PlySample, Progress, Run, Sample, Skips};
use crate::solver::energy_balance::{Balance, PlyMoment};
use crate::solver::{Divergence, FailureEvent, StepTotals};

/// What computed a run.
pub(crate) struct Environment {
    /// `cpu` or `gpu`.
    pub(crate) backend: &'static str,
    /// Name of the graphics adapter.
    pub(crate) adapter: Option<String>,
    /// Worker threads.
    pub(crate) threads: usize,
    /// `f64` or `f32`.
    pub(crate) precision: &'static str,
    /// Time in the loop [s].
    pub(crate) loop_seconds: f64,
    /// Part of it in which the host did not wait for a device [s].
    pub(crate) host_seconds: Option<f64>,
    /// What each kernel took [s].
    pub(crate) kernel_seconds: Vec<(&'static str, f64)>,
}

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

/// What a run has produced so far.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct RunRecord {
    pub(crate) history: Vec<Sample>,
    pub(crate) events: Vec<FailureEvent>,
    pub(crate) profiles: Vec<DeflectionProfile>,
    /// Residual evaluations, and unit cells solved.
    pub(crate) newton: [f64; 2],
    pub(crate) unconverged: u64,
    /// [N]
    pub(crate) max_residual: f64,
    /// By ply.
    failed: Vec<[u64; 2]>,
    pub(crate) eroded: u64,
    /// Into the projectile, and of plies into each other [m].
    pub(crate) max_penetration: [f64; 2],
    /// Elements times steps computed.
    pub(crate) computed: u64,
    plies: Vec<PlySample>,
    deflections: Deflections,
    pub(crate) decided: bool,
    pub(crate) interrupted: bool,
    pub(crate) skips: Skips,
    #[serde(skip)] // a run in trouble does not go on
    pub(crate) divergence: Option<Divergence>,
    /// Why the device gave up, if it did.
    pub(crate) lost: Option<String>,
    tracker: Option<Tracker>,
    momentum_error: f64,
    energy_error: f64,
    /// Of the largest size so far [-].
    energy_gained: f64,
    impact_energy: f64,
    planes: MirrorPlanes,
    /// The projectile has touched the fabric.
    touched: bool,
}

impl RunRecord {
    /// An empty record of a shot with this projectile.
    pub(crate) fn new<S: Scalar>(model: &Model<S>, body: Option<&RigidBody>) -> Self {
        let copies = model.planes.copies() as f64;
        let areal_density = model.plies.iter().map(|ply| model.ply_types[ply.ply_type].areal_density).sum();
        Self {
            history: Vec::new(),
            events: Vec::new(),
            profiles: Vec::new(),
            newton: [0.0; 2],
            unconverged: 0,
            max_residual: 0.0,
            failed: vec![[0; 2]; model.plies.len()],
            eroded: 0,
            max_penetration: [0.0; 2],
            computed: 0,
            plies: Vec::new(),
            deflections: Deflections::new(model.plies.len()),
            decided: false,
            interrupted: false,
            skips: Skips::default(),
            divergence: None,
            lost: None,
            tracker: body.map(|b| Tracker::new(b, b.mass * copies, areal_density)),
            momentum_error: 0.0,
            energy_error: 0.0,
            energy_gained: 0.0,
            impact_energy: body.map_or(0.0, RigidBody::kinetic_energy) * copies,
            planes: model.planes,
            touched: false,
        }
    }

    /// Whether it can be the record of a run of this model that has taken a step: every place in it exists.
    pub(crate) fn fits<S: Scalar>(&self, model: &Model<S>) -> bool {
        let place = |event: &FailureEvent| {
            let ply = event.ply as usize;
            let mesh = (ply < model.plies.len()).then(|| &model.ply_type(ply).mesh);
            mesh.is_some_and(|mesh| (event.i as usize) < mesh.columns && (event.j as usize) < mesh.rows)
                && event.yarn < 2
        };
        self.failed.len() == model.plies.len()
            && self.deflections.plies() == model.plies.len()
            && self.tracker.is_some() == model.projectile.is_some()
            && self.planes == model.planes
            && !self.history.is_empty()
            && self.events.iter().all(place)
    }

    /// Whether something other than time ends the run.
    pub(crate) fn over(&self) -> bool {
        self.interrupted || self.over_but_interrupted()
    }

    /// Whether something other than time or the user ends the run.
    pub(crate) fn over_but_interrupted(&self) -> bool {
        self.divergence.is_some() || self.decided || self.lost.is_some()
    }

    /// Whether the step from the positions at `time` [s] is to be sampled.
    pub(crate) fn sample_due(&self, case: &Case, time: f64, dt: f64) -> bool {
        let last = self.history.last().map(|s| s.time);
        sample_due(case, last, time, dt) || self.interrupted || self.divergence.is_some()
    }

    /// Whether a profile is to be taken before the step from `time` [s].
    pub(crate) fn profile_due(&self, case: &Case, time: f64, dt: f64) -> bool {
        let next = case.output.profile_times.get(self.profiles.len());
        next.is_some_and(|t| time >= t - 0.5 * dt)
    }

    /// Whether the state before the step from `time` [s] is needed for what hangs on something.
    pub(crate) fn deflection_due(&self, case: &Case, time: f64, dt: f64) -> bool {
        self.deflections.is_due(case, time, dt)
    }

    /// Whether any yarn has failed.
    pub(crate) fn has_failures(&self) -> bool {
        self.failed.iter().any(|ply| *ply != [0; 2])
    }

    /// Takes note of what of each ply hangs on something at `time` [s].
    pub(crate) fn look_at_deflection(&mut self, case: &Case, time: f64, dt: f64, hanging: impl Fn(usize) -> Hanging) {
        self.deflections.look(case, time, dt, &self.failed, hanging);
    }

    /// Adds what one step did.
    pub(crate) fn add_step(&mut self, totals: &StepTotals, failures: &[FailureEvent]) {
        self.newton[0] += totals.iterations;
        self.newton[1] += totals.solved;
        self.unconverged += totals.unconverged;
        self.max_residual = self.max_residual.max(totals.max_residual);
        let penetration = [totals.penetration, totals.ply_penetration];
        self.max_penetration = [0, 1].map(|i| self.max_penetration[i].max(penetration[i]));
        self.computed += totals.computed;
        self.eroded += totals.eroded;
        self.add_failures(failures);
    }

    /// Adds yarn failures to the list and to the counts.
    pub(crate) fn add_failures(&mut self, failures: &[FailureEvent]) {
        if let (true, Some(first)) = (self.events.is_empty(), failures.first()) {
            let FailureEvent { step, ply, i, j, yarn, strain } = first;
            info!(
                step,
                ply,
                column = i,
                row = j,
                yarn = ["warp", "weft"][usize::from(*yarn)],
                strain,
                "first yarn failed"
            );
        }
        for f in failures {
            self.failed[f.ply as usize][usize::from(f.yarn)] += self.planes.copies();
        }
        self.events.extend_from_slice(failures);
    }

    /// Yarns failed, warp and weft.
    pub(crate) fn failed(&self) -> [u64; 2] {
        [0, 1].map(|yarn| self.failed.iter().map(|ply| ply[yarn]).sum())
    }

    /// Whether what covers the projectile may have to be looked at closer after the step from `time` [s], as far as samples are
    /// known: never wrongly not, so that a device can be asked to wait there. `last`: time of the last sample.
    pub(crate) fn may_look(&self, case: &Case, last: Option<f64>, time: f64, dt: f64) -> bool {
        look_due(case, last, time, dt) && self.tracker.as_ref().is_some_and(|tracker| tracker.may_be_quiet(time))
    }

    /// Takes note of a closer look: `held` tells whether fabric of a ply covers the projectile and can hold it. Where none
    /// does, the last sample is of a perforation.
    pub(crate) fn look(&mut self, case: &Case, held: impl Fn(usize) -> bool) {
        let Some(tracker) = &mut self.tracker else { return };
        if (0..self.failed.len()).any(held) {
            return;
        }
        tracker.outcome = Outcome::Perforated;
        let torn = self.failed.iter().filter(|failed| **failed != [0; 2]).count();
        if let Some(row) = self.history.last_mut() {
            row.perforated_plies = torn as u32;
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
            tracker.update(at.time, body, impulse.norm(), failed[0] + failed[1], all);
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

    /// Where the run is.
    pub(crate) fn progress(&self, case: &Case, time: f64, steps: u64, elements: usize) -> Progress {
        Progress {
            time,
            end_time: case.solver.end_time,
            velocity: self.history.last().map_or(0.0, |s| s.projectile_velocity),
            failed: self.failed().iter().sum(),
            steps,
            elements,
        }
    }

    /// The result after `steps` steps.
    pub(crate) fn into_run<S: Scalar>(self, model: &Model<S>, steps: u64, machine: Environment) -> Run {
        info!(steps, seconds = machine.loop_seconds, failed_yarns = self.failed().iter().sum::<u64>(), "loop ended");
        let present = model.ply_types.iter().flat_map(|s| (0..2).filter(|i| s.present[*i]).map(|i| &s.cell.yarn[i]));
        let breaking = present.map(|yarn| yarn.stiffness * yarn.failure_strain.min(1.0));
        let weakest = breaking.fold(f64::INFINITY, f64::min);
        let peak = |f: fn(&Balance) -> f64| self.history.iter().map(|s| f(&s.balance)).fold(0.0, f64::max);
        let internal = peak(|b| b.internal);
        Run {
            outcome: self.tracker.as_ref().map_or(Outcome::Running, |t| t.outcome),
            stop_time: self.tracker.as_ref().and_then(|t| t.stop_time),
            rebound_velocity: self.tracker.as_ref().and_then(|t| t.rebound_velocity),
            impact_energy: self.impact_energy,
            max_penetration: self.max_penetration[0],
            max_ply_penetration: self.max_penetration[1],
            energy_error: self.energy_error,
            energy_gained: self.energy_gained,
            momentum_error: self.momentum_error,
            hourglass_fraction: if internal > 0.0 { peak(|b| b.hourglass) / internal } else { 0.0 },
            newton: NewtonStatistics {
                max_residual: self.max_residual / weakest,
                mean_iterations: self.newton[0] / self.newton[1].max(1.0),
                unconverged: self.unconverged * self.planes.copies(),
            },
            elements: model.whole_elements(),
            planes: model.planes,
            plies: model.plies.len(),
            steps,
            element_steps_computed: self.computed,
            skips: self.skips,
            time_step: model.dt,
            step_set_by: model.bound.set_by,
            terms: model.features(),
            loop_seconds: machine.loop_seconds,
            host_seconds: machine.host_seconds,
            kernel_seconds: machine.kernel_seconds,
            backend: machine.backend,
            adapter: machine.adapter,
            threads: machine.threads,
            precision: machine.precision,
            divergence: self.divergence,
            lost: self.lost,
            interrupted: self.interrupted,
            checkpoint_error: None,
            history: self.history,
            events: whole_events(model, self.events),
            profiles: self.profiles,
            ply_history: self.plies,
            deflections: self.deflections.largest(),
        }
    }
}

/// Failures of the part with those of its mirror images, each step in order of ply, row, column and yarn.
fn whole_events<S: Scalar>(model: &Model<S>, events: Vec<FailureEvent>) -> Vec<FailureEvent> {
    if model.planes == MirrorPlanes::NONE {
        return events;
    }
    let images = |event: FailureEvent| {
        let images = model.ply_type(event.ply as usize).mesh.images([event.i as usize, event.j as usize]);
        images.map(move |[column, row]| FailureEvent { i: column as u32, j: row as u32, ..event })
    };
    let mut all: Vec<_> = events.into_iter().flat_map(images).collect();
    all.sort_by_key(|e| (e.step, e.ply, e.j, e.i, e.yarn));
    all
}
