//! The result of a run, from its record.

use tracing::info;

use super::RunRecord;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::mirror_planes::MirrorPlanes;
use crate::run::outcome::Outcome;
use crate::run::{NewtonStatistics, Run};
use crate::solver::FailureEvent;
use crate::solver::energy_balance::Balance;

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

impl RunRecord {
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
            carried_velocity: self.tracker.as_ref().and_then(|t| t.carried_velocity()),
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
