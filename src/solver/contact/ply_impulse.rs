//! Contact between neighbouring plies, over the whole pack.
//!
//! Every node remembers the element of the ply in front and of the ply behind that it is over, and walks from there; the broad phase holds
//! back most nodes, which touch nothing and stay where they are. What closes faster than its gap allows becomes a contact; each
//! node's mass is shared out among its contacts; then all impulses are found at once and added up ply by ply, in fixed order.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::model::Model;
use crate::model::layup::{SIDES, neighbour};
use crate::model::mesh::corners;
use crate::num::scalar::Scalar;
use crate::physics::ply_contact;
use crate::solver::Context;
use crate::solver::contact::ply_search::{FoundContacts, PlyContactPoint, PlySearch, PlyView, ROWS, SearchPart};
use crate::solver::element_totals::field as element;
use crate::solver::energy_balance::{NodeCorrection, add};
use crate::solver::node_update::{field as node, gather, neighbours};
use crate::solver::state::{ActiveRegion, Rows, State};
use crate::solver::sweep::RowKernels;

/// Contacts of a ply: against the ply in front, and against that behind, in parts of [`ROWS`] rows.
type Contacts = [Vec<FoundContacts>; SIDES];

/// Contact between the plies of a pack.
pub(crate) struct PlyContact {
    /// Contacts of each ply.
    contacts: Vec<Contacts>,
    /// Impulses of each ply.
    accumulators: Vec<ImpulseAccumulator>,
    /// Largest distance that any node may have gone so far [m].
    pub(crate) travel: f64,
}

impl PlyContact {
    pub(crate) fn new<S: Scalar>(model: &Model<S>) -> Self {
        let [nodes, rows] = if model.plies.len() > 1 { [model.nodes_per_ply(), model.grid.rows + 1] } else { [0; 2] };
        let contacts = [(); SIDES].map(|()| vec![FoundContacts::default(); rows.div_ceil(ROWS)]);
        let plies = model.plies.len();
        Self { contacts: vec![contacts; plies], accumulators: vec![ImpulseAccumulator::new(nodes); plies], travel: 0.0 }
    }

    /// Finds and applies the impulses of a step.
    pub(crate) fn resolve<S: Scalar>(
        &mut self,
        context: &mut Context<'_, S>,
        kernels: &dyn RowKernels<S>,
        nothing: &[S],
    ) {
        let model = context.model;
        let body = context.state.body.as_ref().map_or(0.0, |b| b.speed_bound());
        self.travel += model.dt * context.totals.max_speed.max(body);
        self.find(context, kernels);
        if self.contacts.iter().flatten().flatten().all(|found| found.points.is_empty()) {
            return;
        }
        self.share(model);
        self.solve(context);
        self.apply(context, nothing);
        self.collect(context);
    }

    /// Nodes that come too close to a cell of a neighbouring ply.
    fn find<S: Scalar>(&mut self, context: &mut Context<'_, S>, kernels: &dyn RowKernels<S>) {
        let model = context.model;
        let travel = self.travel;
        let mut over = std::mem::take(&mut context.state.over);
        let state = &*context.state;
        let plies = model.plies.len();
        let sides = (0..plies).flat_map(|ply| (0..SIDES).map(move |side| (ply, side)));
        let search = |(ply, side)| Some(PlySearch::new(model, state, ply, side, neighbour(ply, side, plies)?));
        let searches: Vec<_> = sides.map(search).collect();
        let found = self.contacts.iter_mut().flatten();
        let mut parts = Vec::new();
        for ((search, over), found) in searches.iter().zip(over.chunks_mut(model.nodes_per_ply())).zip(found) {
            found.iter_mut().for_each(FoundContacts::clear);
            if let Some(search) = search {
                parts.extend(search.parts(over, found, travel));
            }
        }
        // By rows, as the sweep shares them out, so that a thread mostly meets nodes of its own.
        parts.sort_by_key(|part: &SearchPart<'_, S>| part.rows.start);
        parts.par_iter_mut().with_max_len(1).for_each(|part| part.search(kernels));
        drop(parts);
        context.state.over = over;
    }

    /// Shares each node's mass out among its contacts, in the whole scene: a node on a mirror plane has the images of those
    /// that come from one side of it.
    fn share<S: Scalar>(&mut self, model: &Model<S>) {
        let across = model.grid.columns + 1;
        let contacts = &self.contacts;
        self.accumulators.par_iter_mut().enumerate().for_each(|(ply, accumulator)| {
            let mesh = &model.ply_type(ply).mesh;
            for ((row, column), weight, p) in parts(contacts, ply).filter(|(_, weight, _)| *weight != 0.0) {
                accumulator.share(row * across + column, weight.abs() * p.part / mesh.part_of(row, column));
            }
        });
    }

    /// The impulse of every contact, each on its own.
    fn solve<S: Scalar>(&mut self, context: &Context<'_, S>) {
        let (model, state) = (context.model, &*context.state);
        let accumulators = &self.accumulators;
        self.contacts.par_iter_mut().enumerate().for_each(|(ply, sides)| {
            for (side, found) in sides.iter_mut().enumerate() {
                if let Some(other) = neighbour(ply, side, accumulators.len()) {
                    let pair = [ply, other].map(|ply| (PlyView::new(model, state, ply), &accumulators[ply]));
                    found.iter_mut().for_each(|found| solve(model, &pair, found));
                }
            }
        });
    }

    /// Gives the nodes their impulses, ply by ply.
    fn apply<S: Scalar>(&mut self, context: &mut Context<'_, S>, nothing: &[S]) {
        let (kick, model) = (context.kick(), context.model);
        let across = model.grid.columns + 1;
        let State { nodes, elements, .. } = &mut *context.state;
        let length = nodes.row_length() * (model.grid.rows + 1);
        let applier = ImpulseApplier { model, elements, nothing, stride: [nodes.stride, nodes.row_length()], kick };
        let contacts = &self.contacts;
        let plies = self.accumulators.par_iter_mut().zip(nodes.data.par_chunks_mut(length)).enumerate();
        plies.for_each(|(ply, (accumulator, nodes))| {
            for ((row, column), weight, p) in parts(contacts, ply) {
                accumulator.add(row * across + column, p, weight);
            }
            applier.apply(ply, accumulator, nodes);
        });
    }

    /// Takes note of what contact did, ply after ply.
    fn collect<S: Scalar>(&mut self, context: &mut Context<'_, S>) {
        for (ply, (contacts, accumulator)) in self.contacts.iter().zip(&mut self.accumulators).enumerate() {
            let (effect, balance) = (&mut accumulator.effect, &mut *context.balance);
            let friction: f64 = contacts.iter().flatten().map(|found| found.friction).sum();
            for found in contacts.iter().flatten() {
                context.totals.ply_contacts += found.points.len() as u64;
                context.totals.ply_penetration = context.totals.ply_penetration.max(found.penetration);
            }
            balance.contact += effect.loss - friction;
            balance.separation += effect.correction_work;
            balance.work += effect.correction_work;
            balance.friction += friction;
            add(&mut balance.support, effect.support.map(|support| -support));
            effect.corrections.drain(..).for_each(|correction| balance.correct_node(ply, &correction));
            context.state.active[ply] = context.state.active[ply].union(&effect.reach);
        }
    }
}

/// The impulses of contacts of a ply with a neighbour, both with what is asked of their nodes.
fn solve<S: Scalar>(
    model: &Model<S>,
    [(own, accumulator), (theirs, their_accumulator)]: &[(PlyView<'_, S>, &ImpulseAccumulator); 2],
    found: &mut FoundContacts,
) {
    let at = |row: usize, column: usize| row * (model.grid.columns + 1) + column;
    for p in &mut found.points {
        let (row, column) = (p.row, p.column);
        let mut velocity = own.velocity(row, column);
        // A share below one would let a light touch of a corner throw it away.
        let mut compliance = accumulator.shares[at(row, column)].max(1.0) * own.inverse(row, column, &p.normal);
        for ((r, c), weight) in corners(p.cell).into_iter().zip(p.weights) {
            velocity -= theirs.velocity(r, c) * weight;
            compliance += weight * their_accumulator.shares[at(r, c)].max(1.0) * theirs.inverse(r, c, &p.normal);
        }
        if compliance <= 0.0 {
            continue;
        }
        let effective_mass = 1.0 / compliance;
        let (along, across) = ply_contact::impulse(&velocity, &p.normal, p.limit, effective_mass, model.ply_friction);
        let slide = velocity - p.normal * velocity.dot(&p.normal);
        found.friction -= across.dot(&(slide + across * (0.5 * compliance))) * p.part;
        p.impulse = (p.normal * along + across) * p.part;
        p.correction = p.normal * (effective_mass * p.recovery * p.part);
    }
}

/// Nodes of a ply in contacts, with their weight in each: those that are over a neighbour, then, below zero, the corners of cells that nodes of
/// the ply in front and of that behind are over.
fn parts(contacts: &[Contacts], ply: usize) -> impl Iterator<Item = ((usize, usize), f64, &PlyContactPoint)> {
    let own = contacts[ply].iter().flatten().flat_map(|found| &found.points);
    let own = own.map(|p| ((p.row, p.column), 1.0, p));
    let others = (0..SIDES).filter_map(move |side| Some(&contacts[neighbour(ply, side, contacts.len())?][1 - side]));
    let others = others.flatten().flat_map(|found| &found.points);
    own.chain(others.flat_map(|p| corners(p.cell).into_iter().zip(p.weights).map(move |(at, weight)| (at, -weight, p))))
}

/// Impulses that contacts give the nodes of a ply; shapes (rows + 1, columns + 1).
#[derive(Clone, Debug, Default)]
struct ImpulseAccumulator {
    /// Contacts each node takes part in, by weight.
    shares: Vec<f64>,
    /// Impulse on each node, then what moves it without a velocity left [N·s].
    impulse: Vec<[f64; 6]>,
    /// Nodes with a share.
    touched: Vec<usize>,
    /// Effect of the impulses.
    effect: Effect,
}

impl ImpulseAccumulator {
    fn new(nodes: usize) -> Self {
        Self { shares: vec![0.0; nodes], impulse: vec![[0.0; 6]; nodes], ..Self::default() }
    }

    /// A node takes part in another contact, with this weight.
    fn share(&mut self, at: usize, weight: f64) {
        if self.shares[at] == 0.0 {
            self.touched.push(at);
        }
        self.shares[at] += weight;
    }

    /// A node takes its part of a contact's impulse.
    fn add(&mut self, at: usize, point: &PlyContactPoint, weight: f64) {
        for a in 0..3 {
            self.impulse[at][a] += point.impulse[a] * weight;
            self.impulse[at][3 + a] += point.correction[a] * weight;
        }
    }
}

/// Effect of moving the nodes of a ply.
#[derive(Clone, Debug, Default)]
struct Effect {
    /// Kinetic energy lost [J].
    loss: f64,
    /// Work of moving nodes without a velocity, against all forces but those of shock viscosity [J].
    correction_work: f64,
    /// Impulse on held nodes, which the supports take, in the axes of the pack [N·s].
    support: [f64; 3],
    /// Nodes moved.
    reach: ActiveRegion,
    /// Nodes moved.
    corrections: Vec<NodeCorrection>,
}

/// Applier of the impulses to the nodes of a ply.
struct ImpulseApplier<'a, S> {
    model: &'a Model<S>,
    elements: &'a Rows<S>,
    /// A row of elements where there is none.
    nothing: &'a [S],
    /// Numbers per field and per row of nodes.
    stride: [usize; 2],
    /// Time step of the velocities [s].
    kick: f64,
}

impl<S: Scalar> ImpulseApplier<'_, S> {
    /// Gives the nodes of a ply their impulses, and leaves of the accumulator what came of it.
    fn apply(&self, ply: usize, accumulator: &mut ImpulseAccumulator, nodes: &mut [S]) {
        let (model, [stride, length]) = (self.model, self.stride);
        let ply_type = model.ply_type(ply);
        let (mesh, across) = (&ply_type.mesh, model.grid.columns + 1);
        let mut effect = Effect::default();
        let mut last = usize::MAX;
        let mut around = neighbours(model, self.elements, self.nothing, ply, 0);
        for at in accumulator.touched.drain(..) {
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
            let place = |field: usize| row * length + field * stride + column;
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
            add(&mut effect.support, mesh.to_pack(support));
            let pull = [0, 1, 2].map(|a| inverse[a] * force[a] * model.dt);
            let [free, now, pull] = [free, now, pull].map(|v| Vector3::from(mesh.to_pack(v)));
            effect.corrections.push(NodeCorrection { mass: masses.mass[column].to_f64(), free, now, pull });
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
            let element = self.elements.row(self.model.grid.first_element_row(ply) + r);
            let at = |field: usize| element[field * self.elements.stride + c + 1].to_f64();
            for (yarn, ahead) in [c == column, r == row].into_iter().enumerate() {
                let viscous = at(element::COUNT + yarn);
                // Slack yarns have none.
                if viscous == 0.0 {
                    continue;
                }
                let force = [0, 1, 2].map(|a| at(element::WARP_FORCE + 3 * yarn + a));
                let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
                if size > 0.0 {
                    let part = viscous * ply_type.element.membrane[yarn] * ply_type.mesh.widths(r, c)[1 - yarn] / size;
                    for a in 0..3 {
                        sum[a] += if ahead { part * force[a] } else { -part * force[a] };
                    }
                }
            }
        }
        sum
    }
}
