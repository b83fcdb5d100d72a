//! The search: which nodes of a ply come too close to a cell of its neighbour.

use std::ops::Range;

use nalgebra::Vector3;

use crate::model::layup::PENETRATING;
use crate::model::mesh::{Mesh, corners};
use crate::model::ply_type::PlyType;
use crate::model::{Model, layup};
use crate::num::scalar::Scalar;
use crate::physics::ply_contact::{self, MAX_INITIAL_PENETRATION, NO_PLANES, Planes, SLOP, WALK};
use crate::solver::node_update::field as node;
use crate::solver::state::{ActiveRegion, State, node_stands, split};
use crate::solver::sweep::RowKernels;

/// A ply as contact sees it, in the axes of the pack, and the state of its nodes.
#[derive(Clone, Copy)]
pub struct PlyView<'a, S> {
    pub(crate) ply_type: &'a PlyType<S>,
    pub mesh: &'a Mesh,
    /// At rest [m].
    pub(crate) z: f64,
    turned: bool,
    /// Rows of the ply's nodes.
    nodes: &'a [S],
    stride: usize,
    /// Numbers per row of nodes.
    length: usize,
}

impl<'a, S: Scalar> PlyView<'a, S> {
    pub(crate) fn new(model: &'a Model<S>, state: &'a State<S>, ply: usize) -> Self {
        let ply_type = model.ply_type(ply);
        let length = state.nodes.row_length();
        let first = model.grid.first_node_row(ply);
        Self {
            ply_type,
            mesh: &ply_type.mesh,
            z: model.plies[ply].z,
            turned: ply_type.mesh.rotation != [1.0, 0.0],
            nodes: &state.nodes.data[first * length..(first + ply_type.mesh.rows + 1) * length],
            stride: state.nodes.stride,
            length,
        }
    }

    /// Displacements of a row of nodes, in the ply's axes [m].
    #[inline(always)]
    pub(crate) fn row(&self, row: usize) -> [&'a [S]; 3] {
        let start = row * self.length + node::DISPLACEMENT * self.stride;
        split(&self.nodes[start..start + 3 * self.stride], self.stride)
    }

    #[inline(always)]
    fn vector(&self, field: usize, row: usize, column: usize) -> [f64; 3] {
        let at = row * self.length + field * self.stride + column;
        [self.nodes[at].to_f64(), self.nodes[at + self.stride].to_f64(), self.nodes[at + 2 * self.stride].to_f64()]
    }

    #[inline(always)]
    fn to_pack(self, vector: [f64; 3]) -> Vector3<f64> {
        Vector3::from(if self.turned { self.mesh.to_pack(vector) } else { vector })
    }

    /// [m/s]
    #[inline(always)]
    pub(crate) fn velocity(&self, row: usize, column: usize) -> Vector3<f64> {
        self.to_pack(self.vector(node::VELOCITY, row, column))
    }

    /// Position at the end of the step [m].
    #[inline(always)]
    pub(crate) fn position(&self, row: usize, column: usize) -> Vector3<f64> {
        let [x, y, z] = self.vector(node::DISPLACEMENT, row, column);
        let [p, q] = self.mesh.reference(row, column);
        self.to_pack([p + x, q + y, self.z + z])
    }
}

/// A node that comes too close to a cell of the neighbouring ply.
#[derive(Clone, Debug)]
pub struct PlyContactPoint {
    /// Numbers of the node in its ply, and of the cell's first corner in the neighbouring one; see [`PlySearch::across`].
    pub(crate) node: u32,
    pub(crate) corner: u32,
    /// Weights of the cell's corners [-].
    pub(crate) weights: [f64; 4],
    /// Part of the node, and so of the contact, that is in the computed part of the scene.
    pub(crate) part: f64,
    /// Unit vector along which the node is driven out.
    pub(crate) normal: Vector3<f64>,
    /// Of the node, relative to the cell [m/s].
    pub(crate) velocity: Vector3<f64>,
    /// Least velocity along the normal [m/s].
    pub(crate) limit: f64,
    /// Speed at which the node is moved out of the surface [m/s].
    pub(crate) recovery: f64,
    /// On the node [N·s].
    pub(crate) impulse: Vector3<f64>,
    /// Impulse along the normal that moves it out without a velocity left [N·s].
    pub(crate) correction: f64,
}

/// Rows of nodes of a part.
pub const ROWS: usize = 8;

/// Contacts found in some rows of a ply's nodes, against one neighbour.
#[derive(Clone, Debug, Default)]
pub struct FoundContacts {
    /// Contacts, in the order of the nodes.
    pub(crate) points: Vec<PlyContactPoint>,
    /// Deepest node of whole fabric inside the neighbouring ply [m].
    pub(crate) penetration: f64,
    /// Lost by friction of the points [J].
    pub(crate) friction: f64,
    /// Candidates that were looked at.
    pub candidates: Vec<[usize; 2]>,
}

impl FoundContacts {
    /// Keeps nothing but the memory.
    pub(crate) fn clear(&mut self) {
        self.points.clear();
        self.candidates.clear();
        (self.penetration, self.friction) = (0.0, 0.0);
    }
}

/// Some rows of a search, which one thread does.
pub struct SearchPart<'a, S> {
    pub search: &'a PlySearch<'a, S>,
    pub rows: Range<usize>,
    pub columns: Range<usize>,
    /// Cells that the nodes of the rows are over.
    pub over: &'a mut [u32],
    pub found: &'a mut FoundContacts,
}

impl<S: Scalar> SearchPart<'_, S> {
    /// Searches from every node that the broad phase lets through.
    pub(crate) fn search(&mut self, kernels: &dyn RowKernels<S>) {
        kernels.broad_phase(self);
        let Self { search, rows, over, found, .. } = self;
        let across = search.across();
        for &[row, column] in &found.candidates {
            let over = &mut over[(row - rows.start) * across + column];
            if let Some((point, depth)) = search.node(row, column, over) {
                if depth > found.penetration && search.is_whole(row, column, layup::element(*over)) {
                    found.penetration = depth;
                }
                found.points.extend(point);
            }
        }
    }
}

/// Distances that differ by less are those to the edge that two cells share [-].
const SAME: f64 = 1e-12;

/// Touch of a node and a cell of the neighbouring ply, or its distance from that.
struct Touch {
    cell: [usize; 2],
    /// Weights of the cell's corners [-].
    weights: [f64; 4],
    /// Unit vector along which the node is driven out.
    normal: Vector3<f64>,
    /// Along it, beyond the distance at which plies touch [m].
    gap: f64,
}

/// The search for contacts of one ply with one neighbour.
#[derive(Clone, Copy)]
pub struct PlySearch<'a, S> {
    model: &'a Model<S>,
    state: &'a State<S>,
    ply: usize,
    side: usize,
    other: usize,
    pub own: PlyView<'a, S>,
    pub(crate) theirs: PlyView<'a, S>,
    /// Column, row of the nodes on mirror planes.
    pub(crate) planes: [Option<usize>; 2],
    /// Distance of mid-planes in touch, and mean thickness [m].
    pub(crate) touching: f64,
    pub(crate) thickness: f64,
    /// See [`Context::whole`](crate::solver::Context::whole).
    whole: bool,
}

impl<'a, S: Scalar> PlySearch<'a, S> {
    pub fn new(model: &'a Model<S>, state: &'a State<S>, ply: usize, side: usize, other: usize, whole: bool) -> Self {
        let [own, theirs] = [ply, other].map(|ply| PlyView::new(model, state, ply));
        Self {
            touching: model.plies[ply.min(other)].touching,
            thickness: model.plies[ply.min(other)].thickness,
            planes: own.mesh.on_planes(model.mirror),
            model,
            state,
            ply,
            side,
            other,
            own,
            theirs,
            whole,
        }
    }

    /// Nodes stored for a row of them.
    pub fn across(&self) -> usize {
        self.model.grid.columns + 1
    }

    /// Every node that anything may have reached, in parts of a few rows; each fills one of `found`. Parts are the same whatever has
    /// been reached, so that what they add up is.
    pub(crate) fn parts(
        &'a self,
        over: &'a mut [u32],
        found: &'a mut [FoundContacts],
        travel: f64,
    ) -> impl Iterator<Item = SearchPart<'a, S>> {
        let (own, theirs) = (self.own.mesh, self.theirs.mesh);
        let reach = &self.state.active;
        let ActiveRegion { rows, columns } = reach[self.ply].union(&reach[self.other].seen_from(theirs, own, travel));
        let across = self.across();
        let part = move |(index, (over, found)): (usize, (&'a mut [u32], &'a mut FoundContacts))| {
            let first = index * ROWS;
            let (start, end) = (rows.start.max(first), rows.end.min(first + ROWS));
            (start < end).then(|| SearchPart {
                search: self,
                rows: start..end,
                columns: columns.clone(),
                over: &mut over[(start - first) * across..(end - first) * across],
                found,
            })
        };
        over.chunks_mut(ROWS * across).zip(found).enumerate().filter_map(part)
    }

    /// Whether nothing has failed around a node and in the cell it is over: torn edges stick into each other.
    fn is_whole(&self, row: usize, column: usize, over: usize) -> bool {
        let (grid, state) = (&self.model.grid, self.state);
        let columns = self.theirs.mesh.columns;
        let [first, theirs] = [self.ply, self.other].map(|ply| grid.first_element_row(ply));
        state.is_undamaged(self.theirs.ply_type, theirs + over / columns, over % columns)
            && self.own.mesh.around(row, column).all(|[r, c]| state.is_undamaged(self.own.ply_type, first + r, c))
    }

    /// The mirror planes that a node lies on.
    #[inline]
    pub(crate) fn planes_at(&self, row: usize, column: usize) -> Planes {
        if Some(column) != self.planes[0] && Some(row) != self.planes[1] {
            return NO_PLANES;
        }
        let mut planes = NO_PLANES;
        for (own, at) in [column, row].into_iter().enumerate() {
            let axis = self.own.mesh.own_axis(own).filter(|_| self.planes[own] == Some(at));
            if let Some((theirs, axis)) = axis.and_then(|axis| Some((self.theirs.mesh.own_axis(axis)?, axis))) {
                planes[theirs] = Some(axis);
            }
        }
        planes
    }

    /// Looks at one node: a contact if it closes too fast, and its depth [m].
    ///
    /// The place is looked at as it would be at the end of the step; what came too close on the way is known from there.
    #[inline]
    pub fn node(&self, row: usize, column: usize, over: &mut u32) -> Option<(Option<PlyContactPoint>, f64)> {
        let columns = self.theirs.mesh.columns;
        let position = self.own.position(row, column);
        let (start, was_inside) = (layup::element(*over), *over & PENETRATING != 0);
        let cell = [start / columns, start % columns];
        let corner = self.corners(cell);
        if ply_contact::is_apart(
            &corner,
            &position,
            self.sign(),
            self.touching - SLOP * self.thickness,
            self.theirs.mesh.area(cell[0], cell[1]),
        ) {
            if was_inside {
                *over = start as u32;
            }
            return None;
        }
        let (cell, touch) = self.touch(cell, corner, &position, self.planes_at(row, column));
        let [r, c] = touch.as_ref().map_or(cell, |touch| touch.cell);
        *over = (r * columns + c) as u32;
        let found = touch.and_then(|touch| self.contact(row, column, &touch, was_inside));
        if found.is_some() {
            *over |= PENETRATING;
        }
        found
    }

    /// 1 where the neighbour is in front, −1 where it is behind.
    #[inline(always)]
    pub(crate) fn sign(&self) -> f64 {
        if self.side == 0 { 1.0 } else { -1.0 }
    }

    /// Places of the corners of a cell of the neighbour [m].
    #[inline(always)]
    fn corners(&self, cell: [usize; 2]) -> [Vector3<f64>; 4] {
        corners(cell).map(|(r, c)| self.theirs.position(r, c))
    }

    /// Whether a cell of the neighbour carries load.
    fn stands(&self, cell: [usize; 2]) -> bool {
        self.whole || self.state.is_intact(self.model.grid.first_element_row(self.other) + cell[0], cell[1])
    }

    /// Walks from a cell, whose corners are known, to that which a point is over; and how it stands over it. `planes`: that it
    /// lies on.
    #[inline]
    fn touch(
        &self,
        mut cell: [usize; 2],
        mut corner: [Vector3<f64>; 4],
        position: &Vector3<f64>,
        planes: Planes,
    ) -> ([usize; 2], Option<Touch>) {
        let (mesh, sign) = (self.theirs.mesh, self.sign());
        let mut left = [cell; WALK];
        for walk in 0..=WALK {
            let Some(foot) =
                ply_contact::closest_point(&corner, position, self.theirs.mesh.area(cell[0], cell[1]), planes)
            else {
                break;
            };
            if ply_contact::is_over(foot.at, cell, mesh.rows, mesh.columns, mesh.cut) {
                let gap = sign * foot.height - self.touching;
                let weights = ply_contact::weights(foot.at);
                return (cell, Some(Touch { cell, weights, normal: foot.normal * sign, gap }));
            }
            let next = ply_contact::next_cell(cell, foot.at, mesh.rows, mesh.columns);
            if left[..walk].contains(&next) {
                // Cells send the point to each other: it is beyond the ridge between them. On a mirror plane the image of the place nearest
                // to it is as near.
                let touch = if planes == NO_PLANES { self.on_ridge(cell, foot.at, position) } else { None };
                return (cell, touch);
            }
            if next == cell || walk == WALK {
                break;
            }
            left[walk] = cell;
            cell = next;
            corner = self.corners(cell);
        }
        (cell, None)
    }

    /// Position of a point over the cells that meet at the corner of a cell to which its foot points: over the nearest of them, or of
    /// their edges.
    fn on_ridge(&self, [row, column]: [usize; 2], at: [f64; 2], position: &Vector3<f64>) -> Option<Touch> {
        let (mesh, sign) = (self.theirs.mesh, self.sign());
        let (mut nearest, mut hole) = (None::<Touch>, f64::INFINITY);
        let mut least = f64::INFINITY;
        // In an order that is its own mirror image.
        let [down, right] = [at[1], at[0]].map(|x| if x > 0.0 { 1 } else { -1 });
        for [r, c] in [[0, 0], [0, right], [down, 0], [down, right]] {
            let (r, c) = (row.wrapping_add_signed(r), column.wrapping_add_signed(c));
            if r >= mesh.rows || c >= mesh.columns {
                continue;
            }
            let cell = [r, c];
            let corner = self.corners(cell);
            let Some(foot) =
                ply_contact::closest_point(&corner, position, self.theirs.mesh.area(cell[0], cell[1]), NO_PLANES)
            else {
                continue;
            };
            let (arm, at) = match ply_contact::is_over(foot.at, cell, mesh.rows, mesh.columns, mesh.cut) {
                true => (foot.normal * foot.height, foot.at),
                false => ply_contact::on_edge(&corner, position, foot.at),
            };
            let distance = arm.norm();
            if !self.stands(cell) {
                hole = distance.min(hole);
            } else if distance < least * (1.0 - SAME) {
                least = distance;
                let weights = ply_contact::weights(at);
                let touch = || Touch { cell, weights, normal: arm / distance, gap: distance - self.touching };
                nearest = (sign * arm.dot(&foot.normal) > 0.0).then(touch);
            }
        }
        // No node stands over the rim of a hole, which is as near to the hole as to its neighbour.
        nearest.filter(|_| hole > least + SLOP * self.thickness)
    }

    /// A contact if a node that touches closes too fast, and its depth [m].
    #[inline]
    fn contact(
        &self,
        row: usize,
        column: usize,
        touch: &Touch,
        was_inside: bool,
    ) -> Option<(Option<PlyContactPoint>, f64)> {
        let dt = self.model.dt;
        // What would only just touch is left alone: rounding would decide it, and with it the shares of all around it.
        if touch.gap >= -SLOP * self.thickness
            || !self.stands(touch.cell)
            || !(self.whole || node_stands(self.model, self.state, [self.ply, row, column]))
        {
            return None;
        }
        let mut velocity = self.own.velocity(row, column);
        for ((r, c), weight) in corners(touch.cell).into_iter().zip(touch.weights) {
            velocity -= self.theirs.velocity(r, c) * weight;
        }
        let along = velocity.dot(&touch.normal);
        let gap = touch.gap - along * dt;
        if !was_inside && gap < -MAX_INITIAL_PENETRATION * self.thickness {
            return None;
        }
        let limit = ply_contact::closing_limit(gap, dt);
        let recovery = ply_contact::recovery(gap, self.thickness, along, dt);
        let number = |[row, column]: [usize; 2]| (row * self.across() + column) as u32;
        let point = (along < limit || recovery > 0.0).then(|| PlyContactPoint {
            node: number([row, column]),
            corner: number(touch.cell),
            weights: touch.weights,
            part: self.own.mesh.part_of(row, column),
            normal: touch.normal,
            velocity,
            limit,
            recovery,
            impulse: Vector3::zeros(),
            correction: 0.0,
        });
        Some((point, -gap))
    }
}
