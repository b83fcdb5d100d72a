//! Results of a run, with the deflection profiles along one yarn direction and the wave quantities read from them.

use serde::{Deserialize, Serialize};

use super::outcome::Outcome;
use super::{Skips, snapshot};
use crate::case::{Along, Case};
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::{Cut, MirrorPlanes};
use crate::solver::energy_balance::{Balance, PlyMoment};
use crate::solver::state::{State, node_position};
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
    /// Mean since the last row, along the line of flight; 0 in the first [N].
    pub contact_force: f64,
    /// Energies.
    pub balance: Balance,
    /// Warp and weft failures so far.
    pub failed: [u64; 2],
    /// Elements eroded so far.
    pub eroded: u64,
    /// Largest |z displacement| of intact fabric that is attached to an edge [m]. Debris does not count.
    pub deflection: f64,
    /// Largest deflection of the last ply, the back face [m].
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
    /// Energy of the fabric before the shot: of pre-tension, deflection and motion [J].
    pub fabric_energy: f64,
    /// Most energy that the fabric ever had from the projectile, from drives and from before the shot [J]: what errors are held against.
    pub exchanged_energy: f64,
    /// Share of the impulse of a free projectile along the pack's normal that held nodes took [-].
    pub frame_share: f64,
    /// Largest penetration of a node into the projectile [m].
    pub max_penetration: f64,
    /// Largest penetration of a node into a neighbouring ply [m].
    pub max_ply_penetration: f64,
    /// Largest |energy error| of the work done, over the energy exchanged [-].
    pub energy_error: f64,
    /// Energy by state functions that nothing accounts for, where it was largest, over the energy exchanged [-].
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
}

/// One node of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ProfilePoint {
    /// Reference position along the profile, from the point of impact [m].
    pub reference: f64,
    /// Present position along the profile, from the point of impact [m].
    pub position: f64,
    /// z displacement [m].
    pub deflection: f64,
    /// Fabric strain from this node to the next, Λ − 1 (0 at the last) [-].
    pub strain: f64,
    /// Elastic force along the yarns of the element after this node, per reference width (0 at the last) [N/m].
    pub force: f64,
}

/// A line of nodes at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DeflectionProfile {
    /// [s]
    pub time: f64,
    /// In order of position.
    pub points: Vec<ProfilePoint>,
}

/// Profile of the first ply along the line of nodes nearest to the point of impact.
pub(crate) fn profile<S: Scalar>(model: &Model<S>, state: &State<S>, case: &Case, time: f64) -> DeflectionProfile {
    let mesh = &model.ply_type(0).mesh;
    let impact = case.projectile.as_ref().map_or([0.0; 2], |p| p.offset);
    let impact = mesh.to_ply([impact[0], impact[1], 0.0]);
    let (axis, across) = if case.output.profile_along == Along::Warp { (0, 1) } else { (1, 0) };
    let count = [mesh.columns, mesh.rows][axis];
    let line = mesh.nearest_line(across, impact[across]);
    let place = |n: usize| if axis == 0 { [line, n] } else { [n, line] };
    let position = |n: usize| {
        let [row, column] = place(n);
        node_position(model, state, [0, row, column])
    };
    let element = |n: usize| {
        let [row, column] = place(n);
        let [row, column] = [row.min(mesh.rows - 1), column.min(mesh.columns - 1)];
        let strain = (position(n + 1) - position(n)).norm() / mesh.size(row, column)[axis] - 1.0;
        [strain, snapshot::membrane_force(model, state, [row, column], axis)]
    };
    let point = |((n, side), after): ((usize, f64), Option<usize>)| {
        let ([row, column], here) = (place(n), position(n));
        let [strain, force] = after.map_or([0.0; 2], element);
        ProfilePoint {
            reference: side * (mesh.reference(row, column)[axis] - impact[axis]),
            position: side * (mesh.to_ply(here.into())[axis] - impact[axis]),
            deflection: here.z,
            strain,
            force,
        }
    };
    // Nodes and elements of the whole line in order of position, with those that are mirror images.
    let (own, image) = (|n: usize| (n, 1.0), |n: usize| (n, -1.0));
    let (nodes, elements): (Vec<_>, Vec<_>) = match mesh.cut[axis] {
        Cut::Nowhere => ((0..=count).map(own).collect(), (0..count).collect()),
        Cut::First => {
            let nodes = (1..=count).rev().map(image).chain((0..=count).map(own));
            (nodes.collect(), (0..count).rev().chain(0..count).collect())
        }
        Cut::Last => {
            let nodes = (0..count).map(own).chain((0..=count).rev().map(image));
            (nodes.collect(), (0..count).chain((0..count).rev()).collect())
        }
    };
    let after = elements.into_iter().map(Some).chain([None]);
    DeflectionProfile { time, points: nodes.into_iter().zip(after).map(point).collect() }
}

impl DeflectionProfile {
    /// Points at and beyond the point of impact.
    fn outward(&self) -> impl Iterator<Item = &ProfilePoint> {
        self.points.iter().filter(|p| p.reference > -1e-12)
    }

    /// Kink: the place in space where the straight flank of the transverse wave meets the plane [m].
    ///
    /// `None` without deflection.
    pub fn kink(&self) -> Option<f64> {
        let peak = self.outward().map(|p| p.deflection.abs()).fold(0.0, f64::max);
        if peak <= 0.0 {
            return None;
        }
        // Least squares of position on deflection over the middle of the flank.
        let flank = self.outward().map(|p| [p.deflection.abs(), p.position]);
        let flank: Vec<[f64; 2]> = flank.filter(|[d, _]| (0.2..0.8).contains(&(d / peak))).collect();
        let sum = |of: fn(f64, f64) -> f64| flank.iter().map(|[d, x]| of(*d, *x)).sum::<f64>();
        let (n, w, x) = (flank.len() as f64, sum(|d, _| d), sum(|_, x| x));
        let (ww, wx) = (sum(|d, _| d * d), sum(|d, x| d * x));
        let determinant = n * ww - w * w;
        (n >= 3.0 && determinant > 0.0).then(|| (x * ww - w * wx) / determinant)
    }

    /// Median strain between kink and longitudinal front [-].
    pub fn plateau_strain(&self) -> Option<f64> {
        let peak = self.outward().map(|p| p.strain).fold(0.0, f64::max);
        let reach = self.outward().filter(|p| p.strain > 0.3 * peak).map(|p| p.reference).fold(0.0, f64::max);
        let kink = self.kink().unwrap_or(0.0);
        let from = kink + 0.15 * (reach - kink);
        let to = reach - 0.15 * (reach - kink);
        let mut strains: Vec<f64> =
            self.outward().filter(|p| (from..to).contains(&p.reference)).map(|p| p.strain).collect();
        strains.sort_by(f64::total_cmp);
        strains.get(strains.len() / 2).copied()
    }

    /// Reference position of the longitudinal front [m]: where a step of the plateau's strain would hold the same
    /// elongation. An undamped mesh spreads a shock into a train of waves whose first one runs ahead; the elongation
    /// it carries does not.
    pub fn front(&self) -> Option<f64> {
        let plateau = self.plateau_strain().filter(|p| *p > 0.0)?;
        let points: Vec<&ProfilePoint> = self.outward().collect();
        let elongation: f64 = points.windows(2).map(|w| w[0].strain * (w[1].reference - w[0].reference)).sum();
        Some(elongation / plateau)
    }
}
