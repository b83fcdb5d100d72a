//! Results of a run.

use serde::{Deserialize, Serialize};

use super::options::Skips;
use super::outcome::Outcome;
use super::profile::DeflectionProfile;
use crate::physics::rigid_body::MirrorPlanes;
use crate::solver::energy_balance::{Balance, PlyMoment};
use crate::solver::{Divergence, FailureEvent};

/// One row of the history, at a time of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Sample {
    /// [s]
    pub time: f64,
    /// Velocity of the projectile along its line of flight [m/s].
    pub projectile_velocity: f64,
    /// Displacement of the projectile along its line of flight [m].
    pub projectile_displacement: f64,
    /// Mean since the last row, along the line of flight [N].
    pub contact_force: f64,
    /// Energies.
    pub balance: Balance,
    /// Warp and weft failures so far.
    pub failed: [u64; 2],
    /// Elements eroded so far.
    pub eroded: u64,
    /// Largest |z displacement| of intact fabric [m].
    pub deflection: f64,
    /// Largest |z displacement| of intact fabric of the last ply [m].
    pub last_deflection: f64,
    /// Plies with failures and no intact element left ahead of the projectile.
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

/// Newton statistics of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct NewtonStatistics {
    /// Largest residual over the breaking tension of the weaker yarn [-].
    pub max_residual: f64,
    /// Residual evaluations per cell and step.
    pub mean_iterations: f64,
    /// Cells that did not meet the residual, summed over steps.
    pub unconverged: u64,
}

/// Results of a run. What a checkpoint leaves out is set when the run begins or ends.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Run {
    /// Outcome of the shot.
    pub outcome: Outcome,
    /// Time at which the projectile came to rest, or to the velocity of the pack that carries it along [s].
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
    /// Kinetic energy of the projectile before impact [J]; the first row of the history is after first contact.
    pub impact_energy: f64,
    /// Largest penetration of a node into the projectile [m].
    pub max_penetration: f64,
    /// Largest penetration of a node into a neighbouring ply [m].
    pub max_ply_penetration: f64,
    /// Largest |energy error| of the work done [-].
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
    /// Largest deflection of each ply, of attached fabric [m].
    pub deflections: Vec<f64>,
    /// Elements of the whole scene.
    pub elements: usize,
    /// Mirror planes that the scene was cut at: one part was computed, everything here is of the whole.
    pub planes: MirrorPlanes,
    /// Steps done.
    pub steps: u64,
    /// Elements times steps computed, without mirror images and what was known to be at rest.
    pub element_steps_computed: u64,
    /// Skips of the run.
    pub skips: Skips,
    /// Time step [s].
    pub time_step: f64,
    /// Bound that set the time step.
    #[serde(skip)]
    pub step_set_by: &'static str,
    /// Time in the loop [s].
    #[serde(skip)]
    pub loop_seconds: f64,
    /// Part of it in which the host did not wait for the device [s]; `None` on the processor.
    #[serde(skip)]
    pub host_seconds: Option<f64>,
    /// Kernels and other phases of the loop by name, with their time [s]; what is missing from `loop_seconds` went elsewhere.
    #[serde(skip)]
    pub kernel_seconds: Vec<(&'static str, f64)>,
    /// `cpu` or `gpu`.
    #[serde(skip)]
    pub backend: &'static str,
    /// Name of the graphics adapter.
    #[serde(skip)]
    pub adapter: Option<String>,
    /// Worker threads.
    #[serde(skip)]
    pub threads: usize,
    /// `f64` or `f32`.
    #[serde(skip)]
    pub precision: &'static str,
    /// Divergence, if the run became unstable.
    #[serde(skip)]
    pub divergence: Option<Divergence>,
    /// Words of the driver when the device was lost in mid-run; results end there.
    #[serde(skip)]
    pub lost: Option<String>,
    /// Stopped by the user.
    pub interrupted: bool,
    /// The last checkpoint that could not be written, and why.
    #[serde(skip)]
    pub checkpoint_error: Option<String>,
}

impl Run {
    /// Largest deflection of any ply, of attached fabric [m].
    pub fn deflection(&self) -> f64 {
        self.deflections.iter().copied().fold(0.0, f64::max)
    }

    /// Whether no yarn has failed.
    pub(crate) fn is_unbroken(&self) -> bool {
        self.history.last().is_some_and(|row| row.failed == [0; 2])
    }
}
