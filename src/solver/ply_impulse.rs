//! Contact between neighbouring plies, over the whole pack.
//!
//! Every node remembers the element of the ply in front and of the ply behind that it is over, and walks from there; the broad phase holds
//! back most nodes, which touch nothing and stay where they are. What closes faster than its gap allows becomes a contact; each
//! node's mass is shared out among its contacts; then all impulses are found at once and added up ply by ply, in fixed order.

use crate::solver::broad_phase::BroadPhase;
use crate::solver::ply_move::{ImpulseAccumulator, ImpulseApplier};
use crate::solver::ply_search::{FoundContacts, PlyContactPoint, PlySearch, ROWS, SearchPart};
use crate::solver::ply_view::PlyView;
use rayon::prelude::*;

use crate::model::Model;
use crate::model::layup::{SIDES, neighbour};
use crate::model::mesh::corners;
use crate::num::scalar::Scalar;
use crate::num::simd::Vectors;
use crate::physics::ply_contact;
use crate::solver::Context;
use crate::solver::row_kernels::KernelScalar;
use crate::solver::state::State;

/// Contacts of a ply: against the ply in front, and against that behind, in parts of [`ROWS`] rows.
#[derive(Clone, Debug)]
struct Contacts([Vec<FoundContacts>; SIDES]);

impl Contacts {
    /// Contacts found, part by part.
    fn found(&self) -> impl Iterator<Item = &FoundContacts> {
        self.0.iter().flatten()
    }

    /// Contacts with either neighbour, in order.
    fn points(&self) -> impl Iterator<Item = &PlyContactPoint> {
        self.found().flat_map(|found| &found.points)
    }

    /// Contacts with the ply in front, or with that behind.
    fn points_on(&self, side: usize) -> impl Iterator<Item = &PlyContactPoint> {
        self.0[side].iter().flat_map(|found| &found.points)
    }
}

/// Contact between the plies of a pack.
pub(super) struct PlyContact<S> {
    /// Contacts of each ply.
    contacts: Vec<Contacts>,
    /// Impulses of each ply.
    accumulators: Vec<ImpulseAccumulator>,
    broad_phase: Box<dyn BroadPhase<S>>,
    /// Largest distance that any node may have gone so far [m].
    pub(super) travel: f64,
}

impl<S: KernelScalar> PlyContact<S> {
    pub(super) fn new(model: &Model<S>, vectors: Vectors) -> Self {
        let [nodes, rows] = if model.plies.len() > 1 { [model.nodes_per_ply(), model.grid.rows + 1] } else { [0; 2] };
        let contacts = Contacts([(); SIDES].map(|()| vec![FoundContacts::default(); rows.div_ceil(ROWS)]));
        let plies = model.plies.len();
        Self {
            contacts: vec![contacts; plies],
            accumulators: vec![ImpulseAccumulator::new(nodes); plies],
            broad_phase: S::broad_phase(vectors),
            travel: 0.0,
        }
    }

    /// Finds and applies the impulses of a step.
    pub(super) fn resolve(&mut self, context: &mut Context<'_, S>, nothing: &[S]) {
        let model = context.model;
        let body = context.state.body.as_ref().map_or(0.0, |b| b.speed_bound());
        self.travel += model.dt * context.totals.max_speed.max(body);
        self.find(context);
        if self.contacts.iter().all(|contacts| contacts.points().next().is_none()) {
            return;
        }
        self.share(model);
        self.solve(context);
        self.apply(context, nothing);
        self.collect(context);
    }

    /// Nodes that come too close to a cell of a neighbouring ply.
    fn find(&mut self, context: &mut Context<'_, S>) {
        let model = context.model;
        let travel = self.travel;
        let mut over = std::mem::take(&mut context.state.over);
        let state = &*context.state;
        let plies = model.plies.len();
        let sides = (0..plies).flat_map(|ply| (0..SIDES).map(move |side| (ply, side)));
        let search = |(ply, side)| Some(PlySearch::new(model, state, ply, side, neighbour(ply, side, plies)?));
        let searches: Vec<_> = sides.map(search).collect();
        let found = self.contacts.iter_mut().flat_map(|contacts| &mut contacts.0);
        let mut parts = Vec::new();
        for ((search, over), found) in searches.iter().zip(over.chunks_mut(model.nodes_per_ply())).zip(found) {
            found.iter_mut().for_each(FoundContacts::clear);
            if let Some(search) = search {
                parts.extend(search.parts(over, found, travel));
            }
        }
        // By rows, as the sweep shares them out, so that a thread mostly meets nodes of its own.
        parts.sort_by_key(SearchPart::first_row);
        parts.par_iter_mut().with_max_len(1).for_each(|part| part.search(&*self.broad_phase));
        drop(parts);
        context.state.over = over;
    }

    /// Shares each node's mass out among its contacts, in the whole scene: a node on a mirror plane has the images of those
    /// that come from one side of it.
    fn share(&mut self, model: &Model<S>) {
        let across = model.grid.columns + 1;
        let contacts = &self.contacts;
        self.accumulators.par_iter_mut().enumerate().for_each(|(ply, accumulator)| {
            let mesh = &model.ply_type(ply).mesh;
            for p in contacts[ply].points() {
                accumulator.share(p.row as usize * across + p.column as usize, 1.0);
            }
            for p in against(contacts, ply) {
                for ((row, column), weight) in corners(p.cell.map(|at| at as usize)).into_iter().zip(p.weights) {
                    if weight > 0.0 {
                        accumulator.share(row * across + column, weight * p.part / mesh.part_of(row, column));
                    }
                }
            }
        });
    }

    /// The impulse of every contact, each on its own.
    fn solve(&mut self, context: &Context<'_, S>) {
        let (model, state) = (context.model, &*context.state);
        let accumulators = &self.accumulators;
        self.contacts.par_iter_mut().enumerate().for_each(|(ply, Contacts(sides))| {
            for (side, found) in sides.iter_mut().enumerate() {
                if let Some(other) = neighbour(ply, side, accumulators.len()) {
                    let pair = [ply, other].map(|ply| (PlyView::new(model, state, ply), &accumulators[ply]));
                    found.iter_mut().for_each(|found| solve(model, &pair, found));
                }
            }
        });
    }

    /// Gives the nodes their impulses, ply by ply.
    fn apply(&mut self, context: &mut Context<'_, S>, nothing: &[S]) {
        let (kick, sample, model) = (context.kick(), context.sample, context.model);
        let across = model.grid.columns + 1;
        let State { nodes, elements, .. } = &mut *context.state;
        let length = nodes.row_length() * (model.grid.rows + 1);
        let applier = ImpulseApplier { model, elements, nothing, stride: nodes.stride, kick, sample };
        let contacts = &self.contacts;
        let plies = self.accumulators.par_iter_mut().zip(nodes.data.par_chunks_mut(length)).enumerate();
        plies.for_each(|(ply, (accumulator, nodes))| {
            for p in contacts[ply].points() {
                accumulator.add(p.row as usize * across + p.column as usize, p, 1.0);
            }
            for p in against(contacts, ply) {
                for (at, weight) in corner_nodes(p.cell, across).into_iter().zip(p.weights) {
                    accumulator.add(at, p, -weight);
                }
            }
            applier.apply(ply, accumulator, nodes);
        });
    }

    /// Takes note of what contact did, ply after ply.
    fn collect(&mut self, context: &mut Context<'_, S>) {
        for (ply, (contacts, accumulator)) in self.contacts.iter().zip(&mut self.accumulators).enumerate() {
            let (effect, balance) = (&mut accumulator.effect, &mut *context.balance);
            let friction: f64 = contacts.found().map(|found| found.friction).sum();
            for found in contacts.found() {
                context.totals.ply_contacts += found.points.len() as u64;
                context.totals.ply_penetration = context.totals.ply_penetration.max(found.penetration);
            }
            balance.contact += effect.loss - friction;
            balance.separation += effect.correction_work;
            balance.work += effect.correction_work;
            balance.friction += friction;
            for a in 0..3 {
                balance.support[a] -= effect.support[a];
            }
            effect.correct(balance, ply);
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
        let [row, column] = [p.row as usize, p.column as usize];
        let mut velocity = own.velocity(row, column);
        // A share below one would let a light touch of a corner throw it away.
        let mut compliance = accumulator.shares[at(row, column)].max(1.0) * own.inverse(row, column, &p.normal);
        for ((r, c), weight) in corners(p.cell.map(|at| at as usize)).into_iter().zip(p.weights) {
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

/// The points of the neighbouring plies that lie on a ply: of the one in front, then of the one behind.
fn against(contacts: &[Contacts], ply: usize) -> impl Iterator<Item = &PlyContactPoint> {
    let points =
        move |side: usize| neighbour(ply, side, contacts.len()).map(|other| contacts[other].points_on(1 - side));
    points(0).into_iter().flatten().chain(points(1).into_iter().flatten())
}

/// Corners of a cell as places among a ply's nodes.
fn corner_nodes(cell: [u32; 2], across: usize) -> [usize; 4] {
    corners(cell.map(|at| at as usize)).map(|(row, column)| row * across + column)
}
