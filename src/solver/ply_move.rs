//! The nodes of a ply take the impulses of its contacts.

use nalgebra::Vector3;

use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::solver::active_region::ActiveRegion;
use crate::solver::element_totals::field as element;
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::gather::gather;
use crate::solver::gather::neighbours;
use crate::solver::node_update::field as node;
use crate::solver::state::Rows;

use crate::solver::ply_search::PlyContactPoint;

/// Impulses that contacts give the nodes of a ply; shapes (rows + 1, columns + 1).
#[derive(Clone, Debug, Default)]
pub(super) struct ImpulseAccumulator {
    /// Contacts each node takes part in, by weight.
    pub(super) shares: Vec<f64>,
    /// Impulse on each node, then what moves it without a velocity left [N·s].
    impulse: Vec<[f64; 6]>,
    /// Nodes with a share.
    touched: Vec<u32>,
    /// Effect of the impulses.
    pub(super) effect: Effect,
}

impl ImpulseAccumulator {
    pub(super) fn new(nodes: usize) -> Self {
        Self { shares: vec![0.0; nodes], impulse: vec![[0.0; 6]; nodes], ..Self::default() }
    }

    /// A node takes part in another contact, with this weight.
    pub(super) fn share(&mut self, at: usize, weight: f64) {
        if self.shares[at] == 0.0 {
            self.touched.push(at as u32);
        }
        self.shares[at] += weight;
    }

    /// A node takes its part of a contact's impulse.
    pub(super) fn add(&mut self, at: usize, point: &PlyContactPoint, weight: f64) {
        for a in 0..3 {
            self.impulse[at][a] += point.impulse[a] * weight;
            self.impulse[at][3 + a] += point.correction[a] * weight;
        }
    }
}

/// Effect of moving the nodes of a ply.
#[derive(Clone, Debug, Default)]
pub(super) struct Effect {
    /// Kinetic energy lost [J].
    pub(super) loss: f64,
    /// Work of moving nodes without a velocity, against all forces but those of shock viscosity [J].
    pub(super) correction_work: f64,
    /// Impulse on held nodes, which the supports take, in the axes of the pack [N·s].
    pub(super) support: [f64; 3],
    /// Nodes moved.
    pub(super) reach: ActiveRegion,
    /// In sampled steps.
    corrections: Vec<Correction>,
}

impl Effect {
    /// Changes of kinetic energy and momentum at the time of the positions, added to the balance.
    pub(super) fn correct(&mut self, balance: &mut EnergyBalance, ply: usize) {
        for c in self.corrections.drain(..) {
            balance.correct_node(ply, c.mass, &c.free, &c.now, &c.pull);
        }
    }
}

/// A node's mass, its velocities before and after contact, and what forces change it by in a step.
#[derive(Clone, Debug)]
struct Correction {
    mass: f64,
    free: Vector3<f64>,
    now: Vector3<f64>,
    pull: Vector3<f64>,
}

/// Applier of the impulses to the nodes of a ply.
pub(super) struct ImpulseApplier<'a, S> {
    pub(super) model: &'a Model<S>,
    pub(super) elements: &'a Rows<S>,
    /// A row of elements where there is none.
    pub(super) nothing: &'a [S],
    /// Numbers per field of nodes.
    pub(super) stride: usize,
    /// Time step of the velocities [s].
    pub(super) kick: f64,
    /// Whether the step is sampled.
    pub(super) sample: bool,
}

impl<S: Scalar> ImpulseApplier<'_, S> {
    /// Gives the nodes of a ply their impulses, and leaves of the accumulator what came of it.
    pub(super) fn apply(&self, ply: usize, accumulator: &mut ImpulseAccumulator, nodes: &mut [S]) {
        let (model, stride) = (self.model, self.stride);
        let ply_type = model.ply_type(ply);
        let (mesh, across) = (&ply_type.mesh, model.grid.columns + 1);
        let mut effect = Effect::default();
        let mut last = usize::MAX;
        let mut around = neighbours(model, self.elements, self.nothing, ply, 0);
        for at in accumulator.touched.drain(..) {
            let at = at as usize;
            let (row, column) = (at / across, at % across);
            accumulator.shares[at] = 0.0;
            let [x, y, z, p, q, r] = std::mem::replace(&mut accumulator.impulse[at], [0.0; 6]);
            let [impulse, correction] = [[x, y, z], [p, q, r]].map(|v| mesh.to_ply(v));
            if impulse == [0.0; 3] && correction == [0.0; 3] {
                continue;
            }
            effect.reach.activate(row, column);
            let masses = ply_type.row_mass(row);
            let inverse = [0, 1, 2].map(|a| masses.inverse[a][column].to_f64());
            if row != last {
                around = neighbours(model, self.elements, self.nothing, ply, row);
                last = row;
            }
            let force = gather(S::splat(0.0), &around, column).map(Scalar::to_f64);
            let viscous = if correction == [0.0; 3] { correction } else { self.viscous(ply, row, column) };
            let place = |field: usize| (row * node::COUNT + field) * stride + column;
            let free = [0, 1, 2].map(|a| nodes[place(node::VELOCITY + a)].to_f64());
            let now = [0, 1, 2].map(|a| free[a] + inverse[a] * impulse[a]);
            let mut support = [0.0; 3];
            for a in 0..3 {
                let u = nodes[place(node::DISPLACEMENT + a)].to_f64();
                let moved = model.dt * inverse[a] * correction[a];
                nodes[place(node::DISPLACEMENT + a)] = S::splat(u + (model.dt * (now[a] - free[a]) + moved));
                // Viscosity sees velocities alone: against it nothing is stored, and nothing dissipated.
                effect.correction_work -= (force[a] - viscous[a]) * moved;
                nodes[place(node::VELOCITY + a)] = S::splat(now[a]);
                let before = free[a] - inverse[a] * force[a] * self.kick;
                effect.loss -= 0.5 * impulse[a] * (before + now[a]);
                if inverse[a] <= 0.0 {
                    support[a] = impulse[a];
                }
            }
            let support = mesh.to_pack(support);
            for a in 0..3 {
                effect.support[a] += support[a];
            }
            if self.sample {
                let pull = [0, 1, 2].map(|a| inverse[a] * force[a] * model.dt);
                let [free, now, pull] = [free, now, pull].map(|v| Vector3::from(mesh.to_pack(v)));
                effect.corrections.push(Correction { mass: masses.mass[column].to_f64(), free, now, pull });
            }
        }
        accumulator.effect = effect;
    }

    /// Shock viscosity's part of the force on a node [N]. It is taken along the whole force of a yarn, which trellis shear turns a little
    /// away from the yarn.
    fn viscous(&self, ply: usize, row: usize, column: usize) -> [f64; 3] {
        let ply_type = self.model.ply_type(ply);
        let mut sum = [0.0; 3];
        if !ply_type.viscous {
            return sum;
        }
        for [r, c] in ply_type.mesh.around(row, column) {
            let element = self.model.grid.first_element_row(ply) + r;
            let widths = ply_type.mesh.widths(r, c);
            for (yarn, ahead) in [c == column, r == row].into_iter().enumerate() {
                let at = |field: usize| self.elements.get(element, field, c + 1).to_f64();
                let force = [0, 1, 2].map(|a| at(element::WARP_FORCE + 3 * yarn + a));
                let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
                if size > 0.0 {
                    let part = at(element::COUNT + yarn) * ply_type.element.membrane[yarn] * widths[1 - yarn] / size;
                    for a in 0..3 {
                        sum[a] += if ahead { part * force[a] } else { -part * force[a] };
                    }
                }
            }
        }
        sum
    }
}
