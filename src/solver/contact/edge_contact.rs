//! Points of contact between two nodes: where the rim of a flat face crosses the edges of elements.
//!
//! With contact at nodes alone, the width of the face in a row of elements depends on where the nodes under it lie. Then the yarns of
//! one row carry a part of their neighbours' load. The rim crosses the straight edge between two nodes at a point that moves without
//! jumps: that point must not enter the face either.
//!
//! The impulse of such a point is shared by both nodes, so points with a common node depend on each other: with
//! K = N M⁻¹ Nᵀ of those that push, K p = G V′ + target − n·v takes the place of p = κ(…) in
//! [`projectile_contact`](super::projectile_contact).
//!
//! K is small, the points of the rim and the nodes at their edges, and falls into blocks: where the rim crosses two opposite edges of an
//! element one after the other, these share no node. Most blocks have two or three members, the longest lie where the rim runs
//! along a diagonal of the elements.

use std::ops::Range;

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::solver::contact::projectile_contact::{ContactPoint, inertia_along};

/// Compliance added to the diagonal of K, over itself in the whole scene [-]: two points that ask the same of a node share its impulse.
///
/// A point close to a node has the small weight w at the far one. With this compliance s it gives the far node w/(w² + s) of
/// its error, 1/(2√s) = 16 times at most, so that single precision rounds to what is allowed (docs/decisions/08).
pub const SHARED: f64 = 1e-3;
/// Least pivot, over the diagonal of K [-]: below [`SHARED`], so that only rounding could reach it.
pub const FLOOR: f64 = 1e-7;

/// The nodes at the ends of the edge that a point of the rim lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeConstraint {
    /// Places among the points of contact.
    pub nodes: [usize; 2],
    /// Share of each in the point [-], 1 together.
    pub weights: [f64; 2],
}

impl EdgeConstraint {
    /// The nodes with their weights.
    pub fn ends(&self) -> impl Iterator<Item = (usize, f64)> {
        self.nodes.into_iter().zip(self.weights)
    }

    /// Vector at the point, from those of the nodes.
    pub fn between(&self, of_node: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        self.ends().map(|(node, weight)| of_node(node) * weight).sum()
    }
}

/// Points of contact that depend on each other, and room for their equations.
#[derive(Clone, Debug, Default)]
pub struct EdgeContact {
    /// Constraint of each of the last points of contact.
    pub constraints: Vec<EdgeConstraint>,
    /// Sum of weights at each node [-].
    weights: Vec<f64>,
    /// Parent of each node in the tree of its block; a root is its own parent.
    blocks: Vec<usize>,
    /// Points that push and share nodes, ply by ply.
    members: Vec<usize>,
    /// Block and place of each of `members`, in this order.
    keys: Vec<[usize; 2]>,
    /// Places of `members` block by block, and the ends of the blocks among these.
    order: Vec<usize>,
    ends: Vec<usize>,
    /// Block by block K, then its Cholesky factor: lower triangle by rows [1/kg].
    factors: Vec<f64>,
    /// K⁻¹ G by rows, block by block.
    motions: Vec<[f64; 6]>,
    /// K⁻¹ (n·v − target), block by block.
    excesses: Vec<[f64; 1]>,
    /// Place of a member among these, by its place in `members`.
    places: Vec<usize>,
}

impl EdgeContact {
    /// Begins a step: nothing is known of its equations yet.
    pub(crate) fn begin(&mut self, points: &mut [ContactPoint], body_mass: f64) {
        self.share_masses(points, body_mass);
        self.propagate(points);
    }

    /// Nodes that a point moves, with weights.
    fn parts(&self, points: usize, at: usize) -> [(usize, f64); 2] {
        match (at + self.constraints.len()).checked_sub(points) {
            Some(constraint) => {
                [0, 1].map(|end| (self.constraints[constraint].nodes[end], self.constraints[constraint].weights[end]))
            }
            None => [(at, 1.0), (at, 0.0)],
        }
    }

    /// Gives every point of the rim its share of the masses of its nodes, by its weight among the points there: what
    /// friction meets.
    pub fn share_masses(&mut self, points: &mut [ContactPoint], body_mass: f64) {
        let (nodes, crossings) = points.split_at_mut(points.len() - self.constraints.len());
        self.weights.clear();
        self.weights.resize(nodes.len(), 0.0);
        for (p, constraint) in crossings.iter().zip(&self.constraints) {
            for (node, weight) in constraint.ends() {
                // In the whole scene: a point has images at a node on a mirror plane.
                self.weights[node] += weight * p.part;
            }
        }
        for (p, constraint) in crossings.iter_mut().zip(&self.constraints) {
            let mut inverse = Vector3::zeros();
            let mut unheld = 0.0;
            for (node, weight) in constraint.ends() {
                let share = weight * self.weights[node] / p.part;
                inverse += nodes[node].inverse * share;
                unheld += share / nodes[node].mass;
            }
            p.inverse = inverse;
            // Between two held nodes it has a mass like they have, though nothing moves it.
            p.mass = if inverse.amax() > 0.0 { inverse.amax() } else { unheld }.recip();
            p.set_effective_mass(body_mass);
        }
    }

    /// Propagates impulses from the edges to their nodes, and velocities from the nodes to the edges.
    pub(crate) fn propagate(&self, points: &mut [ContactPoint]) {
        let (nodes, crossings) = points.split_at_mut(points.len() - self.constraints.len());
        for constraint in &self.constraints {
            for node in constraint.nodes {
                nodes[node].edge_impulse = Vector3::zeros();
            }
        }
        for (p, constraint) in crossings.iter().zip(&self.constraints) {
            for (node, weight) in constraint.ends() {
                nodes[node].edge_impulse += p.impulse() * weight;
            }
        }
        for (p, constraint) in crossings.iter_mut().zip(&self.constraints) {
            p.free = constraint.between(|node| nodes[node].velocity()) - p.inverse.component_mul(&p.impulse());
        }
    }

    /// Adds GᵀK⁻¹G and GᵀK⁻¹(n·v − target) of the points that share nodes to the equations of the body's motion.
    pub(crate) fn eliminate(
        &mut self,
        points: &[ContactPoint],
        body_mass: f64,
        direction: impl Fn(&ContactPoint) -> Vector6<f64>,
        target: impl Fn(&ContactPoint) -> f64,
        (matrix, right): (&mut Matrix6<f64>, &mut Vector6<f64>),
    ) {
        let count = points.len();
        self.members.clear();
        self.members.extend((0..count).filter(|at| points[*at].active && points[*at].shared));
        // The order in which they add to the equations of the body.
        self.members.sort_by_key(|at| points[*at].ply);
        self.factor(points, body_mass, &direction);
        self.excesses.clear();
        for &place in &self.order {
            let at = self.members[place];
            let free: Vector3<f64> =
                self.parts(count, at).into_iter().map(|(node, weight)| points[node].free * weight).sum();
            self.excesses.push([free.dot(&points[at].normal) - target(&points[at])]);
        }
        let mut factors = &self.factors[..];
        for of in ranges(&self.ends) {
            let (factor, others) = factors.split_at(start(of.len()));
            substitute(factor, &mut self.excesses[of]);
            factors = others;
        }
        for (&at, &place) in self.members.iter().zip(&self.places) {
            let g = direction(&points[at]);
            *matrix += g * Vector6::from_row_slice(&self.motions[place]).transpose();
            *right += g * self.excesses[place][0];
        }
    }

    /// Fills `factors` and `motions` in.
    fn factor(&mut self, points: &[ContactPoint], body_mass: f64, direction: impl Fn(&ContactPoint) -> Vector6<f64>) {
        self.find_blocks(points.len() - self.constraints.len());
        self.motions.clear();
        self.motions.extend(self.order.iter().map(|place| <[f64; 6]>::from(direction(&points[self.members[*place]]))));
        let mut factors = std::mem::take(&mut self.factors);
        factors.clear();
        for of in ranges(&self.ends) {
            let first = factors.len();
            self.fill(points, body_mass, &self.order[of.clone()], &mut factors);
            factorize(&mut factors[first..], of.len());
            substitute(&factors[first..], &mut self.motions[of]);
        }
        self.factors = factors;
    }

    /// Sorts the members by block; `nodes`: how many points are of nodes.
    fn find_blocks(&mut self, nodes: usize) {
        self.blocks.clear();
        self.blocks.extend(0..nodes);
        for &at in self.members.iter().filter(|at| **at >= nodes) {
            let [one, other] = self.constraints[at - nodes].nodes.map(|node| root(&mut self.blocks, node));
            self.blocks[one.max(other)] = one.min(other);
        }
        self.keys.clear();
        for (place, &at) in self.members.iter().enumerate() {
            let node = at.checked_sub(nodes).map_or(at, |constraint| self.constraints[constraint].nodes[0]);
            self.keys.push([root(&mut self.blocks, node), place]);
        }
        self.keys.sort_unstable();
        self.order.clear();
        self.order.extend(self.keys.iter().map(|[_, place]| *place));
        self.ends.clear();
        let mut end = 0;
        for of in self.keys.chunk_by(|[one, _], [other, _]| one == other) {
            end += of.len();
            self.ends.push(end);
        }
        self.places.clear();
        self.places.resize(self.order.len(), 0);
        for (at, place) in self.order.iter().enumerate() {
            self.places[*place] = at;
        }
    }

    /// Normal impulses for a motion of the body, after [`Self::eliminate`].
    pub fn push(&self, points: &mut [ContactPoint], motion: &Vector6<f64>) {
        for ((&place, row), [excess]) in self.order.iter().zip(&self.motions).zip(&self.excesses) {
            points[self.members[place]].normal_impulse = Vector6::from_row_slice(row).dot(motion) - excess;
        }
    }

    /// Compliance added to the entry of a point on the diagonal of K [1/kg]. A node on a mirror plane adds as much as it would in the
    /// whole scene, where the images of the points on its edges push it too.
    fn compliance(&self, points: &[ContactPoint], at: usize) -> f64 {
        let (normal, part) = (points[at].normal, points[at].part);
        let of_node = |(node, weight): (usize, f64)| {
            let along = normal.dot(&points[node].inverse.component_mul(&normal));
            weight * weight * points[node].part / part * along
        };
        SHARED * self.parts(points.len(), at).into_iter().map(of_node).sum::<f64>()
    }

    /// Adds K of a block to `matrix`.
    fn fill(&self, points: &[ContactPoint], body_mass: f64, block: &[usize], matrix: &mut Vec<f64>) {
        let count = points.len();
        let members = || block.iter().map(|place| self.members[*place]);
        for (row, a) in members().enumerate() {
            for b in members().take(row + 1) {
                let mut sum = 0.0;
                for (of_a, weight_a) in self.parts(count, a) {
                    for (of_b, weight_b) in self.parts(count, b) {
                        if of_a == of_b {
                            let turned = points[of_a].inverse.component_mul(&points[b].normal);
                            sum += weight_a * weight_b * turned.dot(&points[a].normal);
                        }
                    }
                }
                matrix.push(sum);
            }
            let compliance = self.compliance(points, a);
            if let Some(last) = matrix.last_mut() {
                *last = 1.0 / inertia_along(*last, points[a].mass, body_mass) + compliance;
            }
        }
    }
}

/// Root of the tree of a node: every node points to another one of its tree, the root to itself. Shortens the path.
pub(crate) fn root(parent: &mut [usize], mut node: usize) -> usize {
    while parent[node] != node {
        parent[node] = parent[parent[node]];
        node = parent[node];
    }
    node
}

/// Ranges between successive ends, the first from 0.
fn ranges(ends: &[usize]) -> impl Iterator<Item = Range<usize>> {
    std::iter::once(&0).chain(ends).zip(ends).map(|(first, end)| *first..*end)
}

/// First entry of a row of a lower triangle.
fn start(row: usize) -> usize {
    row * (row + 1) / 2
}

/// Cholesky factor of K in its place.
fn factorize(a: &mut [f64], count: usize) {
    for i in 0..count {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[start(i) + k] * a[start(j) + k]).sum();
            let left = a[start(i) + j] - sum;
            let floor = FLOOR * a[start(i) + i].abs();
            a[start(i) + j] = if i == j { left.max(floor).sqrt() } else { left / a[start(j) + j] };
        }
    }
}

/// Both substitutions with a factor, on every column.
fn substitute<const COLUMNS: usize>(a: &[f64], x: &mut [[f64; COLUMNS]]) {
    let count = x.len();
    for i in 0..count {
        eliminate(x, i, 0..i, a[start(i) + i], |k| a[start(i) + k]);
    }
    for i in (0..count).rev() {
        eliminate(x, i, i + 1..count, a[start(i) + i], |k| a[start(k) + i]);
    }
}

/// A row of a substitution, of the rows that are known.
#[inline(always)]
fn eliminate<const COLUMNS: usize>(
    x: &mut [[f64; COLUMNS]],
    row: usize,
    known: Range<usize>,
    pivot: f64,
    factor: impl Fn(usize) -> f64,
) {
    let mut sums = [0.0; COLUMNS];
    for k in known {
        for (sum, x) in sums.iter_mut().zip(&x[k]) {
            *sum += factor(k) * x;
        }
    }
    for (x, sum) in x[row].iter_mut().zip(sums) {
        *x = (*x - sum) / pivot;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn two_points_that_ask_the_same_are_solved_with_the_floor_under_the_second() {
        // K of two equal points, row by row; its second pivot is nothing.
        let mut a = [4.0, 4.0, 4.0];
        let mut x = [[8.0; 7]; 2];
        factorize(&mut a, x.len());
        substitute(&a, &mut x);
        assert_eq!(a, [2.0, 2.0, (FLOOR * 4.0).sqrt()]);
        assert!(x.iter().flatten().all(|x| x.is_finite()));
        assert!((0..7).all(|column| (x[0][column] + x[1][column] - 2.0).abs() < 1e-9), "{x:?}");
    }

    #[test]
    fn members_are_sorted_into_blocks_that_share_no_node() {
        let edge = |from, to| EdgeConstraint { nodes: [from, to], weights: [0.5; 2] };
        // Two chains, with the edges in no order; nodes 2, 5 and 7 push, too, 7 alone.
        let mut rim = EdgeContact {
            constraints: vec![edge(4, 5), edge(0, 1), edge(2, 6), edge(3, 4), edge(1, 2)],
            members: vec![2, 5, 7, 8, 9, 10, 11, 12],
            ..EdgeContact::default()
        };
        rim.find_blocks(8);
        let blocks: Vec<Vec<_>> =
            ranges(&rim.ends).map(|of| rim.order[of].iter().map(|place| rim.members[*place]).collect()).collect();
        assert_eq!(blocks, [vec![2, 9, 10, 12], vec![5, 8, 11], vec![7]]);
        assert!(rim.order.iter().enumerate().all(|(at, place)| rim.places[*place] == at));
    }
}
