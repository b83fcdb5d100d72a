//! What a run produces.

use serde::{Deserialize, Serialize};

use super::options::Skips;
use super::outcome::Outcome;
use super::profile::DeflectionProfile;
use crate::model::features::Features;
use crate::physics::mirror_planes::MirrorPlanes;
use crate::solver::energy_balance::{Balance, PlyMoment};
use crate::solver::{Divergence, FailureEvent};

/// One row of the history, at a time of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Sample {
    /// [s]
    pub time: f64,
    /// Along the line of flight [m/s].
    pub projectile_velocity: f64,
    /// Along the line of flight [m].
    pub projectile_displacement: f64,
    /// Mean since the last row, along the line of flight [N].
    pub contact_force: f64,
    /// Energies.
    pub balance: Balance,
    /// Warp and weft failures so far.
    pub failed: [u64; 2],
    /// Elements eroded so far.
    pub eroded: u64,
    /// Largest |z displacement| of standing fabric [m].
    pub deflection: f64,
    /// The same of the last ply [m].
    pub last_deflection: f64,
    /// Plies with failures and no whole element left ahead of the projectile.
    pub perforated_plies: u32,
}

/// One ply at a time of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlySample {
    /// [s]
    pub time: f64,
    /// Counted from the struck side.
    pub ply: usize,
    /// Energies and deflection.
    pub moment: PlyMoment,
    /// Warp and weft failures so far.
    pub failed: [u64; 2],
}

/// Where a run is, for the progress bar.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Progress {
    /// [s]
    pub time: f64,
    /// [s]
    pub end_time: f64,
    /// [m/s]
    pub velocity: f64,
    /// Yarns failed.
    pub failed: u64,
    /// Steps done.
    pub steps: u64,
    /// Elements.
    pub elements: usize,
}

/// Newton statistics of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct NewtonStatistics {
    /// Largest residual over the breaking tension of the weaker yarn [-].
    pub max_residual: f64,
    /// Residual evaluations per cell and step.
    pub mean_iterations: f64,
    /// Cells that did not meet the residual, summed over steps.
    pub unconverged: u64,
}

/// Everything a run produced.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Run {
    /// Verdict.
    pub outcome: Outcome,
    /// When the projectile came to rest, or to the velocity of the pack that carries it along [s].
    pub stop_time: Option<f64>,
    /// Velocity along the normal with which a projectile that a pack without a clamped edge has stopped flies on with it, at the end [m/s].
    pub carried_velocity: Option<f64>,
    /// Speed away from the pack, along its normal, of a projectile that flew back in a run that went on after it stopped [m/s].
    pub rebound_velocity: Option<f64>,
    /// History, ascending in time; the last row is the last state.
    pub history: Vec<Sample>,
    /// Yarn failures in order of step, ply, row, column.
    pub events: Vec<FailureEvent>,
    /// Deflection profiles asked for.
    pub profiles: Vec<DeflectionProfile>,
    /// Every ply of a pack of several, time by time.
    pub ply_history: Vec<PlySample>,
    /// Kinetic energy the projectile came with [J]; the first row of the history is after first contact.
    pub impact_energy: f64,
    /// Largest penetration of a node into the projectile [m].
    pub max_penetration: f64,
    /// Largest penetration of a node into a neighbouring ply [m].
    pub max_ply_penetration: f64,
    /// Largest |energy error| of the work ledger [-].
    pub energy_error: f64,
    /// Energy by state functions that nothing accounts for, where it was largest, over the initial energy [-].
    pub energy_gained: f64,
    /// Largest momentum error [-].
    pub momentum_error: f64,
    /// Largest hourglass energy over the largest internal energy [-].
    pub hourglass_fraction: f64,
    /// Unit-cell solver.
    pub newton: NewtonStatistics,
    /// Plies.
    pub plies: usize,
    /// Largest deflection of each ply, of fabric that hangs on something [m].
    pub deflections: Vec<f64>,
    /// Elements of the whole scene.
    pub elements: usize,
    /// Mirror planes that the scene was cut at: one part was computed, everything here is of the whole.
    pub planes: MirrorPlanes,
    /// Steps done.
    pub steps: u64,
    /// Elements times steps computed; mirror images and what was known to be at rest are left out.
    pub element_steps_computed: u64,
    /// What was left out.
    pub skips: Skips,
    /// [s]
    pub time_step: f64,
    /// What set it.
    pub step_set_by: &'static str,
    /// Terms of the model that the scene has.
    pub terms: Features,
    /// Time in the loop [s].
    pub loop_seconds: f64,
    /// Part of it in which the host did not wait for the device [s]; `None` on the processor.
    pub host_seconds: Option<f64>,
    /// Kernels and other phases of the loop by name, and how long each took [s]; what is missing from `loop_seconds` went elsewhere.
    pub kernel_seconds: Vec<(&'static str, f64)>,
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// Name of the graphics adapter.
    pub adapter: Option<String>,
    /// Worker threads.
    pub threads: usize,
    /// `f64` or `f32`.
    pub precision: &'static str,
    /// What went wrong, if the run became unstable.
    pub divergence: Option<Divergence>,
    /// What the device said when it was lost in mid-run; results end there.
    pub lost: Option<String>,
    /// Stopped by the user.
    pub interrupted: bool,
    /// The last checkpoint that could not be written, and why.
    pub checkpoint_error: Option<String>,
}

impl Run {
    /// Largest deflection of any ply, of fabric that hangs on something [m].
    pub fn deflection(&self) -> f64 {
        self.deflections.iter().copied().fold(0.0, f64::max)
    }

    /// Whether no yarn has failed.
    pub(crate) fn is_unbroken(&self) -> bool {
        self.history.last().is_some_and(|row| row.failed == [0; 2])
    }
}
