//! Balance of energy and momentum, always on.
//!
//! Internal work is that of the internal forces on the nodes, by the trapezoidal rule; kinetic energy is taken at the time of the positions,
//! K = ½ Σ m v⁺·(v⁺ − Δt f/m). With these two the leapfrog keeps K + work + contact + friction − external constant to round-off: a difference
//! is an error of contact. The balance from state functions shows whether elements store the work done on them.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::model::Model;
use crate::model::mesh::{Grid, Mesh};
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::{MirrorPlanes, RigidBody};
use crate::solver::contact::ply_move::PlyMoveTotals;
use crate::solver::contact::projectile_contact::ContactTotals;
use crate::solver::element_totals::ElementTotals;
use crate::solver::node_update::NodeTotals;
use crate::solver::state::Given;
use crate::solver::to_pack;

/// Running sums and the last sample.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// Work done on the elements since the start [J]: what they hold, what failures released and what shock viscosity dissipated.
    pub work: f64,
    /// Work on them after the positions of the last step, not counted yet [J].
    pub(crate) half_step: f64,
    /// The part of it that shock viscosity dissipated [J].
    pub viscous: f64,
    /// Energy released by yarn failures: membrane and shear, hourglass [J].
    pub released: [f64; 2],
    /// Energy that the unit-cell law had made by itself in cells that have failed [J].
    pub law_released: f64,
    /// Lost in inelastic contact [J].
    pub contact: f64,
    /// Lost to friction [J].
    pub friction: f64,
    /// Work of moving nodes out of other plies, against the forces on them less those of shock viscosity, which store nothing [J].
    pub separation: f64,
    /// Taken by clay [J].
    pub backing: f64,
    /// Work of prescribed motion [J].
    pub external: f64,
    /// Impulse of supports and drives on fabric and projectile [N·s].
    pub support: [f64; 3],
    /// Impulses along the pack's normal between the projectile and held nodes, and all nodes, without their signs [N·s].
    pub(crate) frame: [f64; 2],
    /// Impulse of the projectile on the fabric since the last sample was taken [N·s].
    pub contact_impulse: [f64; 3],
    /// Fabric kinetic energy at the time of the positions of the last sample [J], as all that follows.
    pub(crate) kinetic: f64,
    /// Elastic energy by its state function [J].
    pub(crate) stored: f64,
    /// Energy that the unit-cell law has made in whole cells [J].
    pub(crate) law_energy: f64,
    /// Hourglass energy [J].
    pub(crate) hourglass: f64,
    /// Deepest crater in the clay [m].
    pub(crate) crater: f64,
    /// Largest yarn tension [N].
    pub(crate) max_tension: f64,
    /// Largest strain of a whole piece of yarn over its failure strain [-].
    pub(crate) max_load: f64,
    /// Projectile kinetic energy [J].
    projectile: f64,
    /// The part of it that fabric and projectile share; every sample sets it.
    #[serde(skip)]
    shared: f64,
    /// Momentum of fabric and free projectile [kg·m/s].
    pub(crate) momentum: [f64; 3],
    /// Energies and deflections of the plies.
    pub plies: Vec<PlyMoment>,
    initial: Option<Initial>,
    planes: MirrorPlanes,
}

/// Energies and deflection of a ply at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PlyMoment {
    /// Kinetic energy [J].
    pub kinetic: f64,
    /// Elastic energy by its state function [J].
    pub stored: f64,
    /// Largest |z displacement| of standing fabric [m].
    pub deflection: f64,
}

/// A touched node: mass [kg], velocities before and after contact, and what the forces at the time of the positions do to the velocity in a
/// step [m/s].
#[derive(Clone, Debug)]
pub(crate) struct NodeCorrection {
    pub(crate) mass: f64,
    pub(crate) free: Vector3<f64>,
    pub(crate) now: Vector3<f64>,
    pub(crate) pull: Vector3<f64>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Initial {
    stored: f64,
    hourglass: f64,
    law_energy: f64,
    total: f64,
    scale: f64,
    momentum: [f64; 3],
    momentum_scale: f64,
}

/// Energies at one time [J]; the columns of `history.csv`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Balance {
    /// Fabric kinetic energy.
    pub kinetic: f64,
    /// Elastic work, less what failures released.
    pub internal: f64,
    /// Elastic energy by its state function (equal to `internal` for conservative laws).
    pub stored: f64,
    /// Made by the unit-cell law itself, whose force is not the slope of an energy.
    pub law: f64,
    /// Hourglass energy.
    pub hourglass: f64,
    /// Dissipated by shock viscosity.
    pub viscous: f64,
    /// Lost in inelastic contact.
    pub contact: f64,
    /// Lost to friction.
    pub friction: f64,
    /// Made by moving nodes out of other plies.
    pub separation: f64,
    /// Taken by clay behind the pack.
    pub backing: f64,
    /// Released by failures.
    pub failure: f64,
    /// Projectile kinetic energy.
    pub projectile: f64,
    /// Work of prescribed motion.
    pub external: f64,
    /// Error of the balance from the work on the elements, total − initial total; of a sample over the energy exchanged so far [-].
    pub error: f64,
    /// Error of the balance from state functions: energy that nothing accounts for, the law's own share apart, over the same [-].
    pub gained: f64,
    /// Length of the momentum error vector over the initial momentum (or the largest impulse) [-].
    pub momentum_error: f64,
    /// Deepest crater in the clay behind the pack [m].
    pub crater: f64,
    /// Largest yarn tension [N].
    pub max_tension: f64,
    /// Largest strain of a piece of yarn over its failure strain, as failure judges it [-].
    pub max_load: f64,
}

impl Balance {
    /// Balance of a number of scenes like this.
    #[must_use]
    pub fn times(mut self, copies: f64) -> Self {
        let Self { kinetic, internal, stored, law, hourglass, viscous, failure, .. } = &mut self;
        for of_fabric in [kinetic, internal, stored, law, hourglass, viscous, failure] {
            *of_fabric *= copies;
        }
        let Self { contact, friction, separation, backing, projectile, external, error, gained, .. } = &mut self;
        for exchanged in [contact, friction, separation, backing, projectile, external, error, gained] {
            *exchanged *= copies;
        }
        self
    }
}

/// Adds a vector to a sum.
pub(crate) fn add(sum: &mut [f64; 3], part: impl Into<[f64; 3]>) {
    sum.iter_mut().zip(part.into()).for_each(|(sum, part)| *sum += part);
}

impl EnergyBalance {
    /// Balance of the part of a scene that these planes leave. Momentum across them it does not look at: in the whole it cancels.
    pub(crate) fn of_part(planes: MirrorPlanes) -> Self {
        Self { planes, ..Self::default() }
    }

    /// Adds the contact of one step.
    pub(crate) fn add_contact(&mut self, c: &ContactTotals) {
        self.contact += c.dissipation;
        self.friction += c.friction;
        self.external += c.external;
        self.frame[0] += c.support[2].abs();
        self.frame[1] += c.impulse[2].abs();
        add(&mut self.contact_impulse, c.impulse.map(|impulse| -impulse));
        add(&mut self.support, c.support);
    }

    /// Takes the element sums of a sampling step, row by row. `loads`: see [`yarn_loads`](super::failure::yarn_loads).
    pub(crate) fn sample_elements(&mut self, rows: &[ElementTotals], grid: &Grid, loads: [f64; 2]) {
        let sum = |of: fn(&ElementTotals) -> f64| rows.iter().map(of).sum::<f64>();
        self.stored = sum(|row| row.stored);
        self.hourglass = sum(|row| row.hourglass);
        self.law_energy = sum(|row| row.law_energy);
        [self.max_tension, self.max_load] = loads;
        self.plies.clear();
        self.plies.extend(rows.chunks(grid.rows).map(|rows| PlyMoment {
            stored: rows.iter().map(|row| row.stored).sum(),
            deflection: rows.iter().map(|row| row.max_deflection).fold(0.0, f64::max),
            kinetic: 0.0,
        }));
    }

    /// Takes the node sums of a sampling step, row by row.
    pub(crate) fn sample_nodes<S: Scalar>(&mut self, rows: &[NodeTotals], model: &Model<S>) {
        self.momentum = [0.0; 3];
        for (index, row) in rows.iter().enumerate() {
            add(&mut self.momentum, to_pack(model, index, row.momentum));
        }
        self.crater = rows.iter().map(|row| row.clay[1]).fold(0.0, f64::max);
        let kinetic = |rows: &[NodeTotals]| rows.iter().map(|row| row.kinetic + row.work[1]).sum();
        self.kinetic = kinetic(rows);
        let plies = self.plies.iter_mut().zip(rows.chunks(model.grid.rows + 1));
        plies.for_each(|(ply, rows)| ply.kinetic = kinetic(rows));
    }

    /// Replaces a touched node's share of work, kinetic energy and momentum.
    pub(crate) fn correct_node(&mut self, ply: usize, node: &NodeCorrection) {
        let NodeCorrection { mass, free, now, pull } = node;
        let work = -0.5 * mass * pull.dot(&(now - free));
        let change = 0.5 * mass * (now - free).dot(&(now + free)) + work;
        self.correct(ply, [work, change], (now - free) * *mass);
    }

    /// Adds to the work of the half step to come and to the kinetic energy [J], and to the momentum, what contact changes in a ply.
    fn correct(&mut self, ply: usize, [half_step, kinetic]: [f64; 2], momentum: impl Into<[f64; 3]>) {
        self.half_step += half_step;
        self.kinetic += kinetic;
        if let Some(ply) = self.plies.get_mut(ply) {
            ply.kinetic += kinetic;
        }
        add(&mut self.momentum, momentum);
    }

    /// Takes what contact with other plies did to the nodes of a ply; `friction` of its contacts [J].
    pub(crate) fn add_ply_contact(&mut self, ply: usize, mesh: &Mesh, moved: &PlyMoveTotals, friction: f64) {
        self.contact += moved.loss - friction;
        self.friction += friction;
        self.separation += moved.correction_work;
        self.work += moved.correction_work;
        self.correct(ply, [moved.half_step, moved.kinetic], mesh.to_pack(moved.momentum));
        add(&mut self.support, mesh.to_pack(moved.support).map(|support| -support));
    }

    /// Takes the projectile of a sampling step, after contact.
    pub(crate) fn sample_body(&mut self, body: &RigidBody) {
        self.projectile = body.kinetic_energy();
        // What a drive keeps up would only round: it may be a million times what it does to the fabric.
        self.shared = body.own_energy();
        // Momentum of a driven body is the drive's affair; what it gave the fabric counts as support.
        if !body.prescribed {
            add(&mut self.momentum, body.velocity * body.mass);
        }
    }

    /// Fixes what later samples are compared with. Gives the energy of the fabric, of pre-tension, deflection and motion [J].
    pub fn begin(&mut self, given: Given) -> f64 {
        // What fails at once was there too.
        let stored = self.stored + self.released[0];
        // A slack ply that is bent holds hourglass energy and nothing else; rounding may make it less than nothing.
        let hourglass = self.hourglass + self.released[1];
        let at_rest = (stored + hourglass).max(0.0);
        let scale = given.energy + at_rest;
        // Fabric that is let go swings to and fro: its momentum and that of its supports may come to nothing, what it moves does not.
        let momentum_scale = given.momentum.norm().max((2.0 * at_rest * given.fabric_mass).sqrt());
        let law_energy = self.law_energy + self.law_released;
        let (total, momentum) = (self.total(), [0, 1, 2].map(|a| self.momentum[a] - self.support[a]));
        self.initial = Some(Initial { stored, hourglass, law_energy, total, scale, momentum, momentum_scale });
        given.fabric_energy + at_rest
    }

    fn total(&self) -> f64 {
        self.kinetic + self.work + self.contact + self.friction + self.backing + self.shared
            - self.external
            - self.separation
    }

    /// Work done on the hourglass stiffness since the start, by its state function and what failures released [J].
    fn hourglass_work(&self) -> f64 {
        self.hourglass + self.released[1] - self.initial.map_or(0.0, |i| i.hourglass)
    }

    /// Energy that the unit-cell law itself has made since the start [J].
    fn law(&self) -> f64 {
        self.law_energy + self.law_released - self.initial.map_or(0.0, |i| i.law_energy)
    }

    /// Energy by state functions beyond what was put in and what the law makes, at the last sample: what the arithmetic invented [J].
    pub(crate) fn gained(&self) -> f64 {
        let Some(i) = self.initial else { return 0.0 };
        let unearned = self.stored + self.viscous + self.released[0] - i.stored + self.hourglass_work() - self.work;
        self.total() - i.total + unearned - self.law()
    }

    /// The balance at the last sample; its errors of energy are in joules.
    pub fn balance(&self) -> Balance {
        let stored = self.initial.map_or(self.stored, |i| i.stored);
        let mut out = Balance {
            kinetic: self.kinetic,
            internal: stored + self.work - self.hourglass_work() - self.viscous - self.released[0],
            stored: self.stored,
            law: self.law(),
            hourglass: self.hourglass,
            viscous: self.viscous,
            contact: self.contact,
            friction: self.friction,
            separation: self.separation,
            backing: self.backing,
            crater: self.crater,
            failure: self.released[0] + self.released[1],
            projectile: self.projectile,
            external: self.external,
            max_tension: self.max_tension,
            max_load: self.max_load,
            ..Balance::default()
        };
        if let Some(i) = self.initial {
            (out.error, out.gained) = (self.total() - i.total, self.gained());
            let (mut worst, mut supports) = (0.0, 0.0_f64);
            for a in (0..3).filter(|a| *a == 2 || !self.planes.0[*a]) {
                let off: f64 = self.momentum[a] - self.support[a] - i.momentum[a];
                worst += off * off;
                supports += self.support[a] * self.support[a];
            }
            let scale = i.momentum_scale.max(supports.sqrt());
            out.momentum_error = if scale > 0.0 { f64::sqrt(worst) / scale } else { f64::sqrt(worst) };
        }
        out
    }

    /// Energy that was ever available to the fabric and the projectile [J].
    pub(crate) fn accounted_energy(&self) -> f64 {
        self.initial.map_or(f64::INFINITY, |i| i.scale) + self.external.max(0.0)
    }

    /// Energy that was never put in, or that is no number: its kind, and how much [J]. `fabric`: its kinetic energy [J]; `body`: the
    /// projectile, which counts where it flies freely; `sampled`: the balance knows all kinds now.
    pub(crate) fn excess(&self, fabric: f64, body: Option<&RigidBody>, sampled: bool) -> Option<(&'static str, f64)> {
        let kinetic = fabric + body.map_or(0.0, |b| if b.prescribed { 0.0 } else { b.kinetic_energy() });
        let (limit, whole) = (1.5 * self.accounted_energy(), self.accounted_energy() + self.gained());
        if !(kinetic <= limit && self.work.is_finite()) {
            Some(("kinetic energy", kinetic))
        } else if sampled && whole > limit {
            Some(("energy by state functions", whole))
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn errors_of_momentum_are_over_what_was_put_in_or_as_they_are_where_nothing_was() {
        let mut nothing = EnergyBalance::default();
        nothing.begin(Given::default());
        let balance = nothing.balance();
        assert_eq!([balance.error, balance.gained, balance.momentum_error], [0.0; 3]);

        let mut moving = EnergyBalance::default();
        (moving.kinetic, moving.momentum) = (8.0, [0.0, 0.0, 4.0]);
        let momentum = Vector3::new(0.0, 0.0, 4.0);
        let fabric_energy = moving.begin(Given { fabric_energy: 8.0, momentum, fabric_mass: 1.0, ..Given::default() });
        (moving.kinetic, moving.momentum) = (10.0, [0.0, 0.0, 5.0]);
        let balance = moving.balance();
        assert_eq!([fabric_energy, balance.error, balance.momentum_error], [8.0, 2.0, 1.0 / 4.0]);
        // What the supports took is no error, and counts as put in.
        moving.support = [3.0, 0.0, 9.0];
        (moving.kinetic, moving.momentum) = (8.0, [0.0, 0.0, 13.0]);
        assert_eq!(moving.balance().momentum_error, 3.0 / 90.0_f64.sqrt());
    }
}
