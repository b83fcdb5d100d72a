//! Contact between neighbouring plies, over the whole pack.
//!
//! Every node remembers the element of the ply in front and of the ply behind that it is over, and walks from there; the broad phase holds
//! back most nodes, which touch nothing and stay where they are. What closes faster than its gap allows becomes a contact; each
//! node's mass is shared out among its contacts; then all impulses are found at once and added up ply by ply, in fixed order.

use std::ops::Range;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::model::Model;
use crate::model::layup::{SIDES, neighbour};
use crate::model::ply_type::PlyType;
use crate::num::scalar::Scalar;
use crate::physics::ply_contact;
use crate::solver::Context;
use crate::solver::contact::ply_move::{Drag, PlyMoveTotals, PushedRow};
use crate::solver::contact::ply_search::{FoundContacts, PlyContactPoint, PlySearch, ROWS, SearchPart};
use crate::solver::element_totals::field as element;
use crate::solver::node_update::{field as node, neighbours};
use crate::solver::state::{ActiveRegion, Rows, State, split, split_mut};
use crate::solver::sweep::RowKernels;

/// Contacts of a ply: against the ply in front, and against that behind, in parts of [`ROWS`] rows.
type Contacts = [Vec<FoundContacts>; SIDES];

/// Contact between the plies of a pack.
pub(crate) struct PlyContact {
    /// Inertia of the nodes of each ply type; by number, see [`PlySearch::across`].
    inertia: Vec<Vec<NodeInertia>>,
    /// Contacts of each ply.
    contacts: Vec<Contacts>,
    /// Impulses of each ply.
    accumulators: Vec<ImpulseAccumulator>,
    /// Largest distance that any node may have gone so far [m].
    pub(crate) travel: f64,
}

impl PlyContact {
    pub(crate) fn new<S: Scalar>(model: &Model<S>) -> Self {
        let plies = if model.plies.len() > 1 { model.plies.len() } else { 0 };
        let [rows, across] = [model.grid.rows + 1, model.grid.columns + 1];
        let inertia = |ply_type: &PlyType<S>| {
            let mut all = vec![NodeInertia::default(); rows * across];
            ply_type.nodes().for_each(|(r, c)| all[r * across + c] = NodeInertia::new(ply_type, r, c));
            all
        };
        let contacts = [(); SIDES].map(|()| vec![FoundContacts::default(); rows.div_ceil(ROWS)]);
        Self {
            inertia: if plies > 0 { model.ply_types.iter().map(inertia).collect() } else { Vec::new() },
            contacts: vec![contacts; plies],
            accumulators: vec![ImpulseAccumulator::new(rows, across); plies],
            travel: 0.0,
        }
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
        self.solve(model);
        self.apply(context, kernels, nothing);
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
        let whole = context.whole;
        let search = |(ply, side)| Some(PlySearch::new(model, state, ply, side, neighbour(ply, side, plies)?, whole));
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
        let (contacts, inertia) = (&self.contacts, &self.inertia);
        self.accumulators.par_iter_mut().enumerate().for_each(|(ply, accumulator)| {
            let inertia = &inertia[model.plies[ply].ply_type];
            for p in own(contacts, ply) {
                accumulator.share(p.node as usize, 1.0);
            }
            for p in others(contacts, ply) {
                for (at, weight) in accumulator.corners(p) {
                    if weight != 0.0 {
                        accumulator.share(at, weight * p.part / inertia[at].part);
                    }
                }
            }
        });
    }

    /// The impulse of every contact, each on its own.
    fn solve<S: Scalar>(&mut self, model: &Model<S>) {
        let (accumulators, inertia) = (&self.accumulators, &self.inertia);
        let side_of = |ply: usize| ContactSide {
            ply_type: model.ply_type(ply),
            inertia: &inertia[model.plies[ply].ply_type],
            accumulator: &accumulators[ply],
        };
        self.contacts.par_iter_mut().enumerate().for_each(|(ply, sides)| {
            for (side, found) in sides.iter_mut().enumerate() {
                if let Some(other) = neighbour(ply, side, accumulators.len()) {
                    let pair = [ply, other].map(side_of);
                    found.iter_mut().for_each(|found| solve(model, &pair, found));
                }
            }
        });
    }

    /// Gives the nodes their impulses, ply by ply.
    fn apply<S: Scalar>(&mut self, context: &mut Context<'_, S>, kernels: &dyn RowKernels<S>, nothing: &[S]) {
        let (kick, model) = (context.kick(), context.model);
        let State { nodes, elements, .. } = &mut *context.state;
        let applier =
            ImpulseApplier { model, elements, nothing, stride: [nodes.stride, nodes.row_length()], kernels, kick };
        let length = nodes.row_length() * (model.grid.rows + 1);
        let contacts = &self.contacts;
        let plies = self.accumulators.par_iter_mut().zip(nodes.data.par_chunks_mut(length)).enumerate();
        plies.for_each(|(ply, (accumulator, nodes))| {
            for p in own(contacts, ply) {
                accumulator.add(p.node as usize, p, 1.0);
            }
            for p in others(contacts, ply) {
                for (at, weight) in accumulator.corners(p) {
                    accumulator.add(at, p, -weight);
                }
            }
            applier.apply(ply, accumulator, nodes);
        });
    }

    /// Takes note of what contact did, ply after ply.
    fn collect<S: Scalar>(&mut self, context: &mut Context<'_, S>) {
        for (ply, (contacts, accumulator)) in self.contacts.iter().zip(&self.accumulators).enumerate() {
            let friction: f64 = contacts.iter().flatten().map(|found| found.friction).sum();
            for found in contacts.iter().flatten() {
                context.totals.ply_contacts += found.points.len() as u64;
                context.totals.ply_penetration = context.totals.ply_penetration.max(found.penetration);
            }
            let mesh = &context.model.ply_type(ply).mesh;
            context.balance.add_ply_contact(ply, mesh, &accumulator.totals, friction);
            context.state.active[ply] = context.state.active[ply].union(&accumulator.reach);
        }
    }
}

/// Inertia of a node in the whole scene: mirror planes hold no node in a single contact, only with its image.
#[derive(Clone, Copy, Default)]
struct NodeInertia {
    /// 1/mass, in the axes of the ply [1/kg].
    inverse: [f64; 3],
    /// Part of the node in the computed part of the scene.
    part: f64,
}

impl NodeInertia {
    fn new<S: Scalar>(ply_type: &PlyType<S>, row: usize, column: usize) -> Self {
        let (mesh, inverse) = (&ply_type.mesh, &ply_type.row_mass(row).inverse);
        let [mut x, mut y, mut z] = [0, 1, 2].map(|a| inverse[a][column].to_f64());
        let (part, [across_x, across_y]) = (mesh.part_of(row, column), mesh.cut_across(row, column));
        if across_x || across_y {
            z *= part;
            x = if across_x || x > 0.0 { z } else { 0.0 };
            y = if across_y || y > 0.0 { z } else { 0.0 };
        }
        Self { inverse: [x, y, z], part }
    }
}

/// A ply in contact with a neighbour: inertia of its nodes, and how many contacts share it.
struct ContactSide<'a, S> {
    ply_type: &'a PlyType<S>,
    inertia: &'a [NodeInertia],
    accumulator: &'a ImpulseAccumulator,
}

impl<S: Scalar> ContactSide<'_, S> {
    /// 1/mass along a direction that a node has for one of its contacts [1/kg], times its weight in that.
    #[inline(always)]
    fn compliance(&self, at: usize, weight: f64, along: &Vector3<f64>) -> f64 {
        let [x, y, z] = self.inertia[at].inverse;
        // A share below one would let a light touch of a corner throw it away.
        let weight = weight * self.accumulator.shares[at].max(1.0);
        if x == y && y == z {
            return weight * x;
        }
        let [p, q, r] = self.ply_type.mesh.to_ply((*along).into());
        weight * (p * p * x + q * q * y + r * r * z)
    }
}

/// The impulses of contacts of a ply with a neighbour.
fn solve<S: Scalar>(model: &Model<S>, [own, theirs]: &[ContactSide<'_, S>; 2], found: &mut FoundContacts) {
    for p in &mut found.points {
        let mut compliance = own.compliance(p.node as usize, 1.0, &p.normal);
        for (at, weight) in theirs.accumulator.corners(p) {
            compliance += theirs.compliance(at, weight, &p.normal);
        }
        if compliance <= 0.0 {
            continue;
        }
        let effective_mass = 1.0 / compliance;
        let (along, across) = ply_contact::impulse(&p.velocity, &p.normal, p.limit, effective_mass, model.ply_friction);
        let slide = p.velocity - p.normal * p.velocity.dot(&p.normal);
        found.friction -= across.dot(&(slide + across * (0.5 * compliance))) * p.part;
        p.impulse = (p.normal * along + across) * p.part;
        p.correction = effective_mass * p.recovery * p.part;
    }
}

/// Contacts of the nodes of a ply with its neighbours.
fn own(contacts: &[Contacts], ply: usize) -> impl Iterator<Item = &PlyContactPoint> {
    contacts[ply].iter().flatten().flat_map(|found| &found.points)
}

/// Contacts of nodes of the ply in front, and of that behind, with the cells of a ply.
fn others(contacts: &[Contacts], ply: usize) -> impl Iterator<Item = &PlyContactPoint> {
    let sides = (0..SIDES).filter_map(move |side| Some(&contacts[neighbour(ply, side, contacts.len())?][1 - side]));
    sides.flatten().flat_map(|found| &found.points)
}

/// Impulses that contacts give the nodes of a ply; by number, see [`PlySearch::across`].
#[derive(Clone, Default)]
struct ImpulseAccumulator {
    /// Contacts each node takes part in, by weight.
    shares: Vec<f64>,
    /// Impulse on each node, then what moves it without a velocity left [N·s].
    impulses: Vec<[f64; 6]>,
    /// Nodes of a row.
    across: usize,
    /// Columns of the nodes with a share, row by row.
    touched: Vec<Range<usize>>,
    /// Nodes moved in the last step.
    reach: ActiveRegion,
    /// Effect of moving them.
    totals: PlyMoveTotals,
}

impl ImpulseAccumulator {
    fn new(rows: usize, across: usize) -> Self {
        let touched = vec![0..0; rows];
        Self {
            shares: vec![0.0; rows * across],
            impulses: vec![[0.0; 6]; rows * across],
            across,
            touched,
            ..Self::default()
        }
    }

    /// Numbers of the corners of the cell of a contact, counter-clockwise, and their weights.
    #[inline(always)]
    fn corners(&self, point: &PlyContactPoint) -> impl Iterator<Item = (usize, f64)> + use<> {
        let first = point.corner as usize;
        [first, first + 1, first + self.across + 1, first + self.across].into_iter().zip(point.weights)
    }

    /// A node takes part in another contact, with this weight.
    #[inline(always)]
    fn share(&mut self, at: usize, weight: f64) {
        if self.shares[at] == 0.0 {
            let (touched, column) = (&mut self.touched[at / self.across], at % self.across);
            *touched = match touched.start == touched.end {
                true => column..column + 1,
                false => touched.start.min(column)..touched.end.max(column + 1),
            };
        }
        self.shares[at] += weight;
    }

    /// A node takes its part of a contact's impulse.
    #[inline(always)]
    fn add(&mut self, at: usize, point: &PlyContactPoint, weight: f64) {
        let impulse = &mut self.impulses[at];
        for a in 0..3 {
            impulse[a] += point.impulse[a] * weight;
            impulse[3 + a] += point.normal[a] * point.correction * weight;
        }
    }
}

/// Applier of the impulses to the nodes of a ply.
struct ImpulseApplier<'a, S> {
    model: &'a Model<S>,
    elements: &'a Rows<S>,
    /// A row of elements where there is none.
    nothing: &'a [S],
    /// Numbers per field and per row of nodes.
    stride: [usize; 2],
    kernels: &'a dyn RowKernels<S>,
    /// Time step of the velocities [s].
    kick: f64,
}

impl<S: Scalar> ImpulseApplier<'_, S> {
    /// Gives the nodes of a ply their impulses, and leaves of the accumulator what came of it.
    fn apply(&self, ply: usize, accumulator: &mut ImpulseAccumulator, nodes: &mut [S]) {
        let (model, [stride, length], across) = (self.model, self.stride, accumulator.across);
        let ply_type = model.ply_type(ply);
        (accumulator.reach, accumulator.totals) = Default::default();
        for (row, touched) in accumulator.touched.iter_mut().enumerate() {
            let range = std::mem::take(touched);
            if range.is_empty() {
                continue;
            }
            let masses = ply_type.row_mass(row);
            let line = row * across..(row + 1) * across;
            let pushed = PushedRow {
                around: neighbours(model, self.elements, self.nothing, ply, row),
                drag: ply_type.viscous.then(|| self.drag(ply_type, ply, row)),
                inverse: [&masses.inverse[0], &masses.inverse[1], &masses.inverse[2]],
                mass: &masses.mass,
                impulses: &accumulator.impulses[line.clone()],
                rotation: ply_type.mesh.rotation,
                range: range.clone(),
                times: [self.kick, model.dt],
            };
            let node = &mut nodes[row * length..][..node::COUNT * stride];
            let moved = self.kernels.ply_move(&pushed, &mut split_mut(node, stride), &mut accumulator.totals);
            if !moved.is_empty() {
                accumulator.reach = accumulator.reach.union(&ActiveRegion { rows: row..row + 1, columns: moved });
            }
            let line = line.start + range.start..line.start + range.end;
            accumulator.shares[line.clone()].fill(0.0);
            accumulator.impulses[line].fill([0.0; 6]);
        }
    }

    /// Viscous forces of the yarns around a row of nodes.
    fn drag<'a>(&'a self, ply_type: &'a PlyType<S>, ply: usize, row: usize) -> Drag<'a, S> {
        let (stride, first) = (self.elements.stride, self.model.grid.first_element_row(ply));
        let viscous = |row: usize| split(&self.elements.row(first + row)[element::COUNT * stride..], stride);
        let beside = [row.checked_sub(1), Some(row).filter(|row| *row < ply_type.mesh.rows)];
        Drag {
            rows: beside.map(|row| row.map_or([self.nothing; 2], viscous)),
            heights: beside.map(|row| row.map_or(1.0, |row| ply_type.mesh.widths(row, 0)[1])),
            width: &ply_type.columns.width,
            membrane: ply_type.element.membrane,
        }
    }
}
