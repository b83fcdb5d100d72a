//! What a run has produced so far, and when the next record is due: the part of the host loop that every backend shares.
//!
//! Here, and only here, the part of a scene that mirror planes leave becomes the whole again: what comes in is of the
//! part, what goes into history, events and counts is of the whole.

mod result;
mod sample;

use serde::{Deserialize, Serialize};
use tracing::info;

use crate::case::Case;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::mirror_planes::MirrorPlanes;
use crate::physics::rigid_body::RigidBody;
use crate::run::deflection::Deflections;
use crate::run::due::sample_due;
use crate::run::outcome::Tracker;
use crate::run::pieces::{Hanging, free_pack};
use crate::run::profile::DeflectionProfile;
use crate::run::{PlySample, Progress, Sample, Skips};
use crate::solver::{Divergence, FailureEvent, StepTotals};
pub(crate) use result::Environment;
pub(crate) use sample::SampleInput;

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
            tracker: body.map(|b| Tracker::new(b, b.mass * copies, areal_density, free_pack(model))),
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
}
