//! Contact between neighbouring plies, over the whole pack.
//!
//! Every node remembers the element of the ply in front and of the ply behind that it is over, and walks from there. What
//! closes faster than its gap allows becomes a contact; each node's mass is shared out among its contacts; then all
//! impulses are found at once and added up ply by ply, in fixed order.

use std::ops::Range;

use nalgebra::Vector3;
use rayon::prelude::*;

use super::projectile::node_stands;
use super::{Frame, neighbours};
use crate::kernels::node_update::{self, field as node};
use crate::kernels::ply_contact::{self, PASSED, SLOP, WALK};
use crate::model::{Mesh, Model, Sheet, over::SIDES, over::neighbour};
use crate::number::Scalar;
use crate::reach::Reach;
use crate::state::{Rows, State};

/// A node that comes too close to a cell of the neighbouring ply.
#[derive(Clone, Debug)]
struct Point {
    /// 0: the ply in front, 1: the ply behind.
    side: u8,
    row: u32,
    column: u32,
    /// Row and column of the cell.
    cell: [u32; 2],
    /// Of the cell's corners.
    weights: [f64; 4],
    /// Unit vector along which the node is driven out.
    push: Vector3<f64>,
    /// Least velocity along it [m/s].
    limit: f64,
    /// Speed at which the node is moved out of the surface [m/s].
    recovery: f64,
    /// On the node [N·s].
    impulse: Vector3<f64>,
    /// The same for moving it out, without a velocity left [N·s].
    shift: Vector3<f64>,
}

/// What contact does to one ply in a step.
#[derive(Clone, Debug, Default)]
struct PlyWork {
    points: Vec<Point>,
    /// Contacts each node takes part in, by weight, shape (rows + 1, columns + 1).
    shares: Vec<f64>,
    /// Impulse on each node, then what moves it without a velocity left [N·s]; the same shape.
    impulse: Vec<[f64; 6]>,
    /// Nodes with a share.
    touched: Vec<u32>,
    /// Deepest node inside a neighbouring ply [m].
    penetration: f64,
    /// Lost by the nodes of this ply, and by friction of its points [J].
    loss: f64,
    friction: f64,
    /// Work of moving nodes without a velocity, against membrane and hourglass forces [J].
    lifted: [f64; 2],
    /// Impulse on held nodes, which the supports take [N·s].
    support: [f64; 3],
    /// Change of the kinetic energy and momentum at the time of the positions; in ledger steps.
    corrections: Vec<Correction>,
    reach: Option<Reach>,
}

#[derive(Clone, Debug)]
struct Correction {
    mass: f64,
    free: Vector3<f64>,
    now: Vector3<f64>,
    pull: Vector3<f64>,
}

/// Contact between the plies of a pack.
pub(super) struct PlyContact {
    plies: Vec<PlyWork>,
    /// How far any node may have gone so far [m].
    travel: f64,
}

impl PlyContact {
    pub(super) fn new<S: Scalar>(model: &Model<S>) -> Self {
        let nodes = if model.plies.len() > 1 { model.nodes_per_ply() } else { 0 };
        let work = PlyWork { shares: vec![0.0; nodes], impulse: vec![[0.0; 6]; nodes], ..PlyWork::default() };
        Self { plies: vec![work; model.plies.len()], travel: 0.0 }
    }

    /// Finds and applies the impulses of a step.
    pub(super) fn resolve<S: Scalar>(&mut self, frame: &mut Frame<'_, S>, nothing: &[S]) {
        let model = frame.model;
        let body = frame.state.body.as_ref().map_or(0.0, |b| b.speed_bound());
        self.travel += model.dt * frame.totals.max_speed.max(body);
        self.find(frame);
        if self.plies.iter().all(|ply| ply.points.is_empty()) {
            return;
        }
        self.share(model);
        self.solve(frame);
        self.apply(frame, nothing);
        self.collect(frame);
    }

    /// Nodes that come too close to a cell of a neighbouring ply.
    fn find<S: Scalar>(&mut self, frame: &mut Frame<'_, S>) {
        let model = frame.model;
        let travel = self.travel;
        let mut over = std::mem::take(&mut frame.state.over);
        let state = &*frame.state;
        let per_ply = SIDES * model.nodes_per_ply();
        let work = |(ply, (work, over)): (usize, (&mut PlyWork, &mut [u32]))| {
            work.points.clear();
            work.penetration = 0.0;
            for (side, over) in over.chunks_mut(per_ply / SIDES).enumerate() {
                if let Some(other) = neighbour(ply, side, model.plies.len()) {
                    let look = Look::new(model, state, ply, side, other);
                    look.all(&mut work.points, &mut work.penetration, over, travel);
                }
            }
        };
        self.plies.par_iter_mut().zip(over.par_chunks_mut(per_ply)).enumerate().for_each(work);
        frame.state.over = over;
    }

    /// Shares each node's mass out among its contacts.
    fn share<S: Scalar>(&mut self, model: &Model<S>) {
        let across = model.grid.columns + 1;
        let mut shares: Vec<_> =
            self.plies.iter_mut().map(|w| (std::mem::take(&mut w.shares), std::mem::take(&mut w.touched))).collect();
        let plies = &self.plies;
        shares.par_iter_mut().enumerate().for_each(|(ply, (shares, touched))| {
            touched.clear();
            let mut add = |at: usize, weight: f64| {
                if shares[at] == 0.0 {
                    touched.push(at as u32);
                }
                shares[at] += weight;
            };
            for p in &plies[ply].points {
                add(p.row as usize * across + p.column as usize, 1.0);
            }
            for p in against(plies, ply) {
                for (at, weight) in corners(p.cell, across).into_iter().zip(p.weights) {
                    if weight > 0.0 {
                        add(at, weight);
                    }
                }
            }
        });
        for (work, (shares, touched)) in self.plies.iter_mut().zip(shares) {
            (work.shares, work.touched) = (shares, touched);
        }
    }

    /// The impulse of every contact, each on its own.
    fn solve<S: Scalar>(&mut self, frame: &Frame<'_, S>) {
        let (model, state) = (frame.model, &*frame.state);
        let across = model.grid.columns + 1;
        let mut points: Vec<_> = self.plies.iter_mut().map(|w| (std::mem::take(&mut w.points), 0.0)).collect();
        let plies = &self.plies;
        points.par_iter_mut().enumerate().for_each(|(ply, (points, friction))| {
            let own = View::new(model, state, ply);
            let around = [0, 1].map(|side| neighbour(ply, side, plies.len()));
            let views = around.map(|other| other.map(|other| (View::new(model, state, other), &plies[other].shares)));
            for p in points {
                let Some((theirs, shares)) = &views[usize::from(p.side)] else { continue };
                let [row, column] = [p.row as usize, p.column as usize];
                let mut velocity = own.velocity(row, column);
                // A share below one would let a light touch of a corner throw it away.
                let mut compliance =
                    plies[ply].shares[row * across + column].max(1.0) * own.inverse(row, column, &p.push);
                let cell = p.cell.map(|at| at as usize);
                for ((r, c), weight) in places(cell).into_iter().zip(p.weights) {
                    velocity -= theirs.velocity(r, c) * weight;
                    compliance += weight * shares[r * across + c].max(1.0) * theirs.inverse(r, c, &p.push);
                }
                if compliance <= 0.0 {
                    continue;
                }
                let kappa = 1.0 / compliance;
                let (normal, drag) = ply_contact::impulse(&velocity, &p.push, p.limit, kappa, model.ply_friction);
                let slide = velocity - p.push * velocity.dot(&p.push);
                *friction -= drag.dot(&(slide + drag * (0.5 * compliance)));
                p.impulse = p.push * normal + drag;
                p.shift = p.push * (kappa * p.recovery);
            }
        });
        for (work, (points, friction)) in self.plies.iter_mut().zip(points) {
            (work.points, work.friction) = (points, friction);
        }
    }

    /// Gives the nodes their impulses, ply by ply.
    fn apply<S: Scalar>(&mut self, frame: &mut Frame<'_, S>, nothing: &[S]) {
        let across = frame.model.grid.columns + 1;
        let mut sums: Vec<_> = self.plies.iter_mut().map(|w| std::mem::take(&mut w.impulse)).collect();
        let plies = &self.plies;
        sums.par_iter_mut().enumerate().for_each(|(ply, impulse)| {
            let mut add = |at: usize, p: &Point, weight: f64| {
                for a in 0..3 {
                    impulse[at][a] += p.impulse[a] * weight;
                    impulse[at][3 + a] += p.shift[a] * weight;
                }
            };
            for p in &plies[ply].points {
                add(p.row as usize * across + p.column as usize, p, 1.0);
            }
            for p in against(plies, ply) {
                for (at, weight) in corners(p.cell, across).into_iter().zip(p.weights) {
                    add(at, p, -weight);
                }
            }
        });
        for (work, impulse) in self.plies.iter_mut().zip(sums) {
            work.impulse = impulse;
        }
        let (kick, sample, model) = (frame.kick(), frame.sample, frame.model);
        let State { nodes, elements, .. } = &mut *frame.state;
        let (length, elements) = (nodes.row_length() * (model.grid.rows + 1), &*elements);
        let stride = nodes.stride;
        let work = |(ply, (work, nodes)): (usize, (&mut PlyWork, &mut [S]))| {
            move_nodes(model, elements, nothing, ply, work, nodes, stride, [kick, f64::from(u8::from(sample))]);
        };
        self.plies.par_iter_mut().zip(nodes.data.par_chunks_mut(length)).enumerate().for_each(work);
    }

    /// Takes note of what contact did, ply after ply.
    fn collect<S: Scalar>(&mut self, frame: &mut Frame<'_, S>) {
        for (ply, work) in self.plies.iter_mut().enumerate() {
            let totals = &mut frame.totals;
            totals.ply_penetration = totals.ply_penetration.max(work.penetration);
            totals.ply_contacts += work.points.len() as u64;
            frame.ledger.contact += work.loss - work.friction - work.lifted[0] - work.lifted[1];
            frame.ledger.work += work.lifted[0];
            frame.ledger.friction += work.friction;
            for a in 0..3 {
                frame.ledger.support[a] -= work.support[a];
            }
            for c in work.corrections.drain(..) {
                frame.ledger.correct_node(ply, c.mass, &c.free, &c.now, &c.pull);
            }
            if let Some(reach) = work.reach.take() {
                frame.state.reach[ply] = frame.state.reach[ply].union(&reach);
            }
        }
    }
}

/// The points of the neighbouring plies that lie on a ply: of the one in front, then of the one behind.
fn against(plies: &[PlyWork], ply: usize) -> impl Iterator<Item = &Point> {
    let front = ply.checked_sub(1).map_or(&[][..], |front| &plies[front].points);
    let rear = plies.get(ply + 1).map_or(&[][..], |rear| &rear.points);
    front.iter().filter(|p| p.side == 1).chain(rear.iter().filter(|p| p.side == 0))
}

/// Corners of a cell, counter-clockwise.
fn places([row, column]: [usize; 2]) -> [(usize, usize); 4] {
    [(row, column), (row, column + 1), (row + 1, column + 1), (row + 1, column)]
}

/// The same as places among a ply's nodes.
fn corners(cell: [u32; 2], across: usize) -> [usize; 4] {
    places(cell.map(|at| at as usize)).map(|(row, column)| row * across + column)
}

/// Adds a ply's impulses to its nodes. `kick`: time step of the velocities [s], and whether the ledger takes energies.
#[allow(clippy::too_many_arguments, reason = "one place calls it, with what it has split apart for the threads")]
fn move_nodes<S: Scalar>(
    model: &Model<S>,
    elements: &Rows<S>,
    nothing: &[S],
    ply: usize,
    work: &mut PlyWork,
    nodes: &mut [S],
    stride: usize,
    [kick, sample]: [f64; 2],
) {
    let sheet = model.sheet(ply);
    let (mesh, across) = (&sheet.mesh, model.grid.columns + 1);
    work.loss = 0.0;
    work.lifted = [0.0; 2];
    work.support = [0.0; 3];
    let mut reach = Reach::nothing();
    let mut last = usize::MAX;
    let mut around = neighbours(model, elements, nothing, ply, 0);
    for at in work.touched.drain(..) {
        let at = at as usize;
        let (row, column) = (at / across, at % across);
        work.shares[at] = 0.0;
        let [x, y, z, p, q, r] = std::mem::replace(&mut work.impulse[at], [0.0; 6]);
        let [impulse, shift] = [[x, y, z], [p, q, r]].map(|v| mesh.to_ply(v));
        if impulse == [0.0; 3] && shift == [0.0; 3] {
            continue;
        }
        reach.touch(row, column);
        let masses = sheet.row_mass(row);
        let inverse = [0, 1, 2].map(|a| masses.inverse[a][column].to_f64());
        if row != last {
            around = neighbours(model, elements, nothing, ply, row);
            last = row;
        }
        let [membrane, mode] = node_update::gather_parts::<S>(&around, column).map(|f| f.map(Scalar::to_f64));
        let force = [0, 1, 2].map(|a| membrane[a] + mode[a]);
        let place = |field: usize| (row * node::COUNT + field) * stride + column;
        let free = [0, 1, 2].map(|a| nodes[place(node::VELOCITY + a)].to_f64());
        let now = [0, 1, 2].map(|a| free[a] + inverse[a] * impulse[a]);
        let mut support = [0.0; 3];
        for a in 0..3 {
            let u = nodes[place(node::DISPLACEMENT + a)].to_f64();
            let moved = model.dt * inverse[a] * shift[a];
            nodes[place(node::DISPLACEMENT + a)] = S::splat(u + (model.dt * (now[a] - free[a]) + moved));
            work.lifted[0] -= membrane[a] * moved;
            work.lifted[1] -= mode[a] * moved;
            nodes[place(node::VELOCITY + a)] = S::splat(now[a]);
            let before = free[a] - inverse[a] * force[a] * kick;
            work.loss -= 0.5 * impulse[a] * (before + now[a]);
            if inverse[a] <= 0.0 {
                support[a] = impulse[a];
            }
        }
        let support = mesh.to_pack(support);
        for a in 0..3 {
            work.support[a] += support[a];
        }
        if sample > 0.0 {
            let pull = [0, 1, 2].map(|a| inverse[a] * force[a] * model.dt);
            let [free, now, pull] = [free, now, pull].map(|v| Vector3::from(mesh.to_pack(v)));
            work.corrections.push(Correction { mass: masses.mass[column].to_f64(), free, now, pull });
        }
    }
    work.reach = (!reach.is_nothing()).then_some(reach);
}

/// A ply as contact sees it: in the axes of the pack.
#[derive(Clone, Copy)]
struct View<'a, S> {
    sheet: &'a Sheet<S>,
    mesh: &'a Mesh,
    z: f64,
    turned: bool,
    /// Rows of the ply's nodes.
    nodes: &'a [S],
    stride: usize,
}

impl<'a, S: Scalar> View<'a, S> {
    fn new(model: &'a Model<S>, state: &'a State<S>, ply: usize) -> Self {
        let sheet = model.sheet(ply);
        let length = state.nodes.row_length();
        let first = model.grid.first_node_row(ply);
        Self {
            sheet,
            mesh: &sheet.mesh,
            z: model.plies[ply].z,
            turned: sheet.mesh.turn != [1.0, 0.0],
            nodes: &state.nodes.data[first * length..(first + sheet.mesh.rows + 1) * length],
            stride: state.nodes.stride,
        }
    }

    #[inline(always)]
    fn vector(&self, field: usize, row: usize, column: usize) -> [f64; 3] {
        let at = (row * node::COUNT + field) * self.stride + column;
        [self.nodes[at].to_f64(), self.nodes[at + self.stride].to_f64(), self.nodes[at + 2 * self.stride].to_f64()]
    }

    #[inline(always)]
    fn to_pack(self, vector: [f64; 3]) -> Vector3<f64> {
        Vector3::from(if self.turned { self.mesh.to_pack(vector) } else { vector })
    }

    /// [m/s]
    #[inline(always)]
    fn velocity(&self, row: usize, column: usize) -> Vector3<f64> {
        self.to_pack(self.vector(node::VELOCITY, row, column))
    }

    /// Position at the end of the step [m].
    #[inline(always)]
    fn position(&self, row: usize, column: usize) -> Vector3<f64> {
        let [x, y, z] = self.vector(node::DISPLACEMENT, row, column);
        let [p, q] = self.mesh.reference(row, column);
        self.to_pack([p + x, q + y, self.z + z])
    }

    /// 1/mass along a direction [1/kg].
    fn inverse(&self, row: usize, column: usize, along: &Vector3<f64>) -> f64 {
        let inverse = &self.sheet.row_mass(row).inverse;
        let [x, y, z] = [0, 1, 2].map(|a| inverse[a][column].to_f64());
        if x == y && y == z {
            return x;
        }
        let [p, q, r] = self.mesh.to_ply((*along).into());
        p * p * x + q * q * y + r * r * z
    }
}

/// The search for contacts of one ply with one neighbour.
struct Look<'a, S> {
    model: &'a Model<S>,
    state: &'a State<S>,
    ply: usize,
    side: usize,
    other: usize,
    own: View<'a, S>,
    theirs: View<'a, S>,
    /// Distance of mid-planes in touch, and mean thickness [m].
    touching: f64,
    thickness: f64,
    /// Of a cell of the neighbour at rest [m²].
    area: f64,
}

impl<'a, S: Scalar> Look<'a, S> {
    fn new(model: &'a Model<S>, state: &'a State<S>, ply: usize, side: usize, other: usize) -> Self {
        let [own, theirs] = [ply, other].map(|ply| View::new(model, state, ply));
        Self {
            touching: model.plies[ply.min(other)].touching,
            thickness: 0.5 * (own.sheet.thickness + theirs.sheet.thickness),
            area: theirs.mesh.length[0] * theirs.mesh.length[1],
            model,
            state,
            ply,
            side,
            other,
            own,
            theirs,
        }
    }

    /// Every node that anything may have reached.
    fn all(&self, points: &mut Vec<Point>, penetration: &mut f64, over: &mut [u32], travel: f64) {
        let (own, theirs) = (self.own.mesh, self.theirs.mesh);
        let reach = &self.state.reach;
        let region = reach[self.ply].union(&reach[self.other].seen_from(theirs, own, travel));
        let across = self.model.grid.columns + 1;
        let Reach { rows, columns } = region;
        for row in rows {
            for column in Range::clone(&columns) {
                let over = &mut over[row * across + column];
                if let Some((point, depth)) = self.node(row, column, over) {
                    if depth > *penetration && self.is_whole(row, column, *over as usize) {
                        *penetration = depth;
                    }
                    points.extend(point);
                }
            }
        }
    }

    /// Whether nothing has failed around a node and in the cell it is over: torn edges stick into each other.
    fn is_whole(&self, row: usize, column: usize, over: usize) -> bool {
        let whole = |sheet: &Sheet<S>, row: usize, column: usize| {
            (0..2).all(|yarn| !sheet.present[yarn] || self.state.alive(row, column, yarn))
        };
        let grid = &self.model.grid;
        let (own, theirs) = (self.own.mesh, self.theirs.mesh);
        let cell = [grid.first_element_row(self.other) + over / theirs.columns, over % theirs.columns];
        let rows = row.max(1) - 1..(row + 1).min(own.rows);
        let mut columns = column.max(1) - 1..(column + 1).min(own.columns);
        let first = grid.first_element_row(self.ply);
        whole(self.theirs.sheet, cell[0], cell[1])
            && columns.all(|c| rows.clone().all(|r| whole(self.own.sheet, first + r, c)))
    }

    /// Looks at one node: a contact if it closes too fast, and its depth [m].
    ///
    /// The place is looked at as it would be at the end of the step; what came too close on the way is known from there.
    #[inline]
    fn node(&self, row: usize, column: usize, over: &mut u32) -> Option<(Option<Point>, f64)> {
        let (model, dt) = (self.model, self.model.dt);
        let mesh = self.theirs.mesh;
        let position = self.own.position(row, column);
        let mut cell = [*over as usize / mesh.columns, *over as usize % mesh.columns];
        let mut foot = None;
        for _ in 0..=WALK {
            let corner = places(cell).map(|(r, c)| self.theirs.position(r, c));
            foot = ply_contact::foot(&corner, &position, self.area);
            let next = foot.map_or(cell, |f| ply_contact::next_cell(cell, f.at, mesh.rows, mesh.columns));
            if next == cell {
                break;
            }
            cell = next;
        }
        *over = (cell[0] * mesh.columns + cell[1]) as u32;
        let foot = foot.filter(|f| ply_contact::is_over(f.at, cell, mesh.rows, mesh.columns))?;
        let sign = if self.side == 0 { 1.0 } else { -1.0 };
        let end = sign * foot.height - self.touching;
        // What would only just touch is left alone: rounding would decide it, and with it the shares of all around it.
        if end >= -SLOP * self.thickness || end < -PASSED * self.thickness {
            return None;
        }
        let stands = self.state.standing(model.grid.first_element_row(self.other) + cell[0], cell[1]);
        if !stands || !node_stands(model, self.state, self.ply, row, column) {
            return None;
        }
        let push = foot.normal * sign;
        let weights = ply_contact::weights(foot.at);
        let mut velocity = self.own.velocity(row, column);
        for ((r, c), weight) in places(cell).into_iter().zip(weights) {
            velocity -= self.theirs.velocity(r, c) * weight;
        }
        let along = velocity.dot(&push);
        let gap = end - along * dt;
        let limit = ply_contact::closing_limit(gap, dt);
        let recovery = ply_contact::recovery(gap, SLOP * self.thickness, along, dt);
        let point = (along < limit || recovery > 0.0).then(|| Point {
            side: self.side as u8,
            row: row as u32,
            column: column as u32,
            cell: cell.map(|at| at as u32),
            weights,
            push,
            limit,
            recovery,
            impulse: Vector3::zeros(),
            shift: Vector3::zeros(),
        });
        Some((point, -gap))
    }
}
