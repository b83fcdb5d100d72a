//! What differences between the backends are measured by, from the model and one state.

use nalgebra::Vector3;

use ripstop::kernels::projectile_contact::HELD;
use ripstop::model::{Model, PlyType};
use ripstop::solver::state::State;

/// A yarn that does not break at that strain counts as if it did.
const LARGEST_STRAIN: f64 = 0.05;

/// Some nine nodes of a ply lie under a face. Roundings of their impulses add as the root of their number.
const TOGETHER: f64 = 3.0;

/// Steepest slope that makes a gap of a place [-]: beyond it the gap is measured across.
const STEEPEST: f64 = 1.0;

/// Roundings of places in a gap, 2 of a node and 2 of the body, over all that a velocity by contact may have [-].
const OF_PLACES: f64 = 4.0 / 12.0;

/// Sizes whose roundings a difference is counted in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scales {
    /// Force of an element whose stronger yarn is about to break [N].
    pub(super) force: f64,
    /// The same as shock viscosity stores it, per weight of the element [N].
    pub(super) viscous_force: f64,
    /// Energy of an element whose yarns are about to break [J].
    pub(super) energy: f64,
    /// Half a span of a yarn, or the sum of heights if that is more [m].
    pub(super) height: f64,
    /// Smallest failure strain [-].
    pub(super) failure_strain: f64,
    /// Length of the shortest element [m].
    pub(super) shortest: f64,
    /// What places of the projectile are counted over: the same [m].
    pub(super) cell: f64,
    /// Largest displacement of a node, an element's length at least [m].
    pub(super) length: f64,
    /// Largest speed of a node or the projectile [m/s].
    pub(super) speed: f64,
    /// Velocity that closes a gap of `length` in a step, and `speed` [m/s]: a gap rounds like a displacement, and a contact closes it.
    pub(super) closing: f64,
    /// What places round like, as a gap [m]: the depth of the pack, and where the rim of the projectile is sampled its radius by the largest
    /// slope of a ply; `OF_PLACES` of them.
    pub(super) place: f64,
    /// Time step [s].
    pub(super) time_step: f64,
    /// Mass of the heaviest node [kg].
    pub(super) node_mass: f64,
    /// Mass of the projectile [kg]; 0 without one.
    pub(super) body_mass: f64,
    /// Radius of the projectile about its centre [m].
    pub(super) reach: f64,
    /// Angular momentum that impulses of nodes give the projectile [kg·m²/s].
    pub(super) spin: f64,
    /// Energy that impulses of nodes take at the largest speed: half of their product [J].
    pub(super) contact_energy: f64,
    /// Σ m|v| of nodes and projectile [kg·m/s].
    pub(super) momentum: f64,
}

impl Scales {
    /// Scales of a state. `least_speed`: speeds are at least that [m/s].
    pub(super) fn of(model: &Model<f32>, state: &State<f32>, least_speed: f64) -> Self {
        let of_types = |of: &dyn Fn(&PlyType<f32>) -> f64| model.ply_types.iter().map(of).fold(0.0, f64::max);
        let strain = |ply_type: &PlyType<f32>, yarn: usize| ply_type.cell.yarn[yarn].failure_strain.min(LARGEST_STRAIN);
        let tension =
            |ply_type: &PlyType<f32>, yarn: usize| ply_type.cell.yarn[yarn].stiffness * strain(ply_type, yarn);
        let shortest = model.ply_types.iter().map(|ply_type| ply_type.mesh.shortest()).fold(f64::INFINITY, f64::min);
        let motion = Motion::of(model, state);
        let body = model.projectile.as_ref();
        let impact = body.map_or(0.0, |body| body.velocity.norm());
        let speed = motion.fastest.max(impact).max(least_speed);
        let length = motion.farthest.max(shortest);
        let body_mass = body.map_or(0.0, |body| body.mass);
        let closing = speed + length / model.dt;
        let depth = model.plies.last().map_or(0.0, |ply| ply.z);
        let reach = body.map_or(0.0, |body| body.body.bounding_radius);
        Self {
            force: of_types(&|of| (0..2).map(|i| tension(of, i) * of.element.membrane[i]).fold(0.0, f64::max)),
            viscous_force: of_types(&|of| (0..2).map(|i| tension(of, i)).fold(0.0, f64::max)),
            energy: of_types(&|of| {
                let yarn = |i: usize| tension(of, i) * strain(of, i) * of.cell.yarn[i].half_span;
                of.element.cells * (yarn(0) + yarn(1))
            }),
            height: of_types(&|of| of.cell.height_sum.max(of.cell.yarn[0].half_span)),
            failure_strain: model
                .ply_types
                .iter()
                .map(|of| strain(of, 0).min(strain(of, 1)))
                .fold(f64::INFINITY, f64::min),
            shortest,
            cell: shortest,
            length,
            speed,
            closing,
            place: OF_PLACES
                * (depth + if model.features().edges { STEEPEST.min(motion.steepest) * reach } else { 0.0 }),
            time_step: model.dt,
            node_mass: motion.heaviest,
            body_mass,
            reach,
            spin: TOGETHER * motion.heaviest * closing * reach,
            contact_energy: 0.5 * TOGETHER * motion.heaviest * closing * speed,
            momentum: motion.momentum + body_mass * impact,
        }
    }

    /// The same where a free projectile meets held nodes, whose mass counts as that of [`HELD`] bodies. They bring it from its speed to
    /// rest: about a third of that speed in the mean.
    pub(super) fn held(self) -> Self {
        let (closing, node_mass) = (self.closing.max(0.35 * HELD * self.speed), self.node_mass.max(self.body_mass));
        Self { closing, node_mass, contact_energy: 0.5 * node_mass * closing * self.speed, ..self }
    }

    /// Impulse of a node that closes a gap [kg·m/s].
    pub(super) fn impulse(&self) -> f64 {
        self.node_mass * self.closing
    }

    /// Velocity that such an impulse gives the projectile, and its own [m/s].
    pub(super) fn body_velocity(&self) -> f64 {
        self.speed + self.impulse() / self.body_mass.max(f64::MIN_POSITIVE)
    }

    /// Way of such a velocity in a step, an element's length at least [m].
    pub(super) fn body_position(&self) -> f64 {
        self.cell.max(self.time_step * self.impulse() / self.body_mass.max(f64::MIN_POSITIVE))
    }
}

/// Largest numbers of the nodes.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    fastest: f64,
    farthest: f64,
    heaviest: f64,
    /// Slope between neighbouring nodes, against the ply at rest [-].
    steepest: f64,
    momentum: f64,
}

impl Motion {
    fn of(model: &Model<f32>, state: &State<f32>) -> Self {
        let mut out = Self::default();
        for ply in 0..model.grid.plies {
            let (ply_type, first) = (model.ply_type(ply), model.grid.first_node_row(ply));
            let mesh = &ply_type.mesh;
            for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
                let [moved, velocity] = [state.displacement(first + row, column), state.velocity(first + row, column)];
                let (mass, speed) = (f64::from(ply_type.row_mass(row).mass[column]), Vector3::from(velocity).norm());
                out.fastest = out.fastest.max(speed);
                out.farthest = out.farthest.max(Vector3::from(moved).norm());
                out.heaviest = out.heaviest.max(mass);
                out.momentum += mass * speed;
                let neighbours = [(row, column + 1), (row + 1, column)];
                for (r, c) in neighbours.into_iter().filter(|&(r, c)| r <= mesh.rows && c <= mesh.columns) {
                    let [[x, y], [further_x, further_y]] = [mesh.reference(row, column), mesh.reference(r, c)];
                    let rise = (state.displacement(first + r, c)[2] - moved[2]).abs();
                    out.steepest = out.steepest.max(rise / (further_x - x + further_y - y));
                }
            }
        }
        out
    }
}
