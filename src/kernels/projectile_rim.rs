//! Points of contact between two nodes: where the rim of a flat face crosses the edges of elements.
//!
//! Sampled at nodes alone, a face is as wide in every row of elements as the nodes under it happen to lie, and the yarns
//! of the row that lies best carry what is its neighbours' share. The rim crosses the straight edge between two nodes
//! at a point that moves with the projectile without jumps: that point must not enter the face either.
//!
//! Such a point pushes both nodes by its place between them, so points that share a node are no longer independent: with
//! K = N M⁻¹ Nᵀ of those that push, K p = G V′ + target − n·v takes the place of p = κ(…) in
//! [`projectile_contact`](super::projectile_contact). K is small: the points of the rim and the nodes at their edges.

use std::ops::Range;

use nalgebra::{Matrix6, Vector3, Vector6};

use super::projectile_contact::{ContactPoint, inertia_along};

/// What is added to the diagonal of K, over itself in the whole scene [-]: two points that ask the same of a node share its impulse.
///
/// A point close to a node has the small weight w at the far one. With this compliance s it gives the far node w/(w² + s) of
/// its error, 1/(2√s) = 16 times at most, so that single precision rounds to what is allowed (`benches/NOTES.md`).
pub const SHARED: f64 = 1e-3;
/// Least pivot, over the diagonal of K [-]: below [`SHARED`], so that only rounding could reach it.
pub const FLOOR: f64 = 1e-7;

/// The nodes at the ends of the edge that a point of the rim lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeConstraint {
    /// Places among the points of contact.
    pub nodes: [usize; 2],
    /// What each has of the point [-], 1 together.
    pub weights: [f64; 2],
}

impl EdgeConstraint {
    /// The nodes with their weights.
    pub fn ends(&self) -> impl Iterator<Item = (usize, f64)> {
        self.nodes.into_iter().zip(self.weights)
    }

    /// What the nodes have at the point.
    pub fn between(&self, of_node: impl Fn(usize) -> Vector3<f64>) -> Vector3<f64> {
        self.ends().map(|(node, weight)| of_node(node) * weight).sum()
    }
}

/// Points of contact that depend on each other, and room for their equations.
#[derive(Clone, Debug, Default)]
pub struct Rim {
    /// Of the last points of contact, one each.
    pub constraints: Vec<EdgeConstraint>,
    /// Those that push and share nodes.
    members: Vec<usize>,
    /// K, then its Cholesky factor: lower triangle by rows [1/kg].
    matrix: Vec<f64>,
    /// Of the nodes, without normal impulses [m/s].
    free: Vec<Vector3<f64>>,
    /// K⁻¹ [G | n·v − target] by rows.
    solved: Vec<[f64; 7]>,
}

impl Rim {
    /// Forgets every point.
    pub fn clear(&mut self) {
        self.constraints.clear();
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
    pub(crate) fn share_masses(&self, points: &mut [ContactPoint], body_mass: f64) {
        let nodes = points.len() - self.constraints.len();
        for at in 0..self.constraints.len() {
            let mut inverse = Vector3::zeros();
            let mut unheld = 0.0;
            for (node, weight) in self.constraints[at].ends() {
                // In the whole scene: a point has images at a node on a mirror plane.
                let all = self.constraints.iter().zip(&points[nodes..]);
                let others =
                    all.flat_map(|(constraint, p)| constraint.ends().map(|(other, weight)| (other, weight * p.part)));
                let of_node = others.filter(|(other, _)| *other == node).map(|(_, weight)| weight).sum::<f64>();
                let share = weight * of_node / points[nodes + at].part;
                inverse += points[node].inverse * share;
                unheld += share / points[node].mass;
            }
            let p = &mut points[nodes + at];
            p.inverse = inverse;
            // Between two held nodes it has a mass like they have, though nothing moves it.
            p.mass = if inverse.amax() > 0.0 { inverse.amax() } else { unheld }.recip();
            p.set_kappa(body_mass);
        }
    }

    /// Tells nodes what the rim gives them, and the rim how its nodes move.
    pub(crate) fn propagate(&self, points: &mut [ContactPoint]) {
        let (nodes, rim) = points.split_at_mut(points.len() - self.constraints.len());
        for constraint in &self.constraints {
            for node in constraint.nodes {
                nodes[node].edge_impulse = Vector3::zeros();
            }
        }
        for (p, constraint) in rim.iter().zip(&self.constraints) {
            for (node, weight) in constraint.ends() {
                nodes[node].edge_impulse += p.impulse() * weight;
            }
        }
        for (p, constraint) in rim.iter_mut().zip(&self.constraints) {
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
        // Points of different plies move no common node: each ply has equations of its own.
        self.members.sort_by_key(|at| points[*at].ply);
        self.free_of_pushes(points);
        self.solved.clear();
        for &at in &self.members {
            let g = direction(&points[at]);
            let free: Vector3<f64> =
                self.parts(count, at).into_iter().map(|(node, weight)| self.free[node] * weight).sum();
            let excess = free.dot(&points[at].normal) - target(&points[at]);
            self.solved.push([g[0], g[1], g[2], g[3], g[4], g[5], excess]);
        }
        let mut first = 0;
        while first < self.members.len() {
            let ply = points[self.members[first]].ply;
            let of_ply = self.members[first..].iter().take_while(|at| points[**at].ply == ply).count();
            self.fill(points, body_mass, first..first + of_ply);
            factor_and_solve(&mut self.matrix, &mut self.solved[first..first + of_ply]);
            first += of_ply;
        }
        for (&at, row) in self.members.iter().zip(&self.solved) {
            let g = direction(&points[at]);
            *matrix += g * Vector6::from_row_slice(&row[..6]).transpose();
            *right += g * row[6];
        }
    }

    /// Normal impulses for a motion of the body, after [`Self::eliminate`].
    pub fn push(&self, points: &mut [ContactPoint], motion: &Vector6<f64>) {
        for (&at, row) in self.members.iter().zip(&self.solved) {
            points[at].normal_impulse = Vector6::from_row_slice(&row[..6]).dot(motion) - row[6];
        }
    }

    /// Velocities of the nodes with friction alone: the normal impulses of the points beside one are unknown like its own.
    fn free_of_pushes(&mut self, points: &[ContactPoint]) {
        let (nodes, rim) = points.split_at(points.len() - self.constraints.len());
        self.free.clear();
        self.free.extend(nodes.iter().map(|p| p.free + p.inverse.component_mul(&p.friction_impulse)));
        for (p, constraint) in rim.iter().zip(&self.constraints) {
            for (node, weight) in constraint.ends() {
                self.free[node] += nodes[node].inverse.component_mul(&p.friction_impulse) * weight;
            }
        }
    }

    /// What is added to the entry of a point on the diagonal of K [1/kg]. A node on a mirror plane adds as much as it would in the
    /// whole scene, where the images of the points on its edges push it too.
    fn compliance(&self, points: &[ContactPoint], at: usize) -> f64 {
        let (normal, part) = (points[at].normal, points[at].part);
        let of_node = |(node, weight): (usize, f64)| {
            let along = normal.dot(&points[node].inverse.component_mul(&normal));
            weight * weight * points[node].part / part * along
        };
        SHARED * self.parts(points.len(), at).into_iter().map(of_node).sum::<f64>()
    }

    /// K of some members.
    fn fill(&mut self, points: &[ContactPoint], body_mass: f64, of: Range<usize>) {
        let count = points.len();
        self.matrix.clear();
        for row in of.clone() {
            let a = self.members[row];
            for &b in &self.members[of.start..=row] {
                let mut sum = 0.0;
                for (of_a, weight_a) in self.parts(count, a) {
                    for (of_b, weight_b) in self.parts(count, b) {
                        if of_a == of_b {
                            let turned = points[of_a].inverse.component_mul(&points[b].normal);
                            sum += weight_a * weight_b * turned.dot(&points[a].normal);
                        }
                    }
                }
                self.matrix.push(sum);
            }
            let compliance = self.compliance(points, a);
            if let Some(last) = self.matrix.last_mut() {
                *last = 1.0 / inertia_along(*last, points[a].mass, body_mass) + compliance;
            }
        }
    }
}

/// Cholesky factor of K in its place, and both substitutions on every column.
fn factor_and_solve(a: &mut [f64], x: &mut [[f64; 7]]) {
    let count = x.len();
    let start = |row: usize| row * (row + 1) / 2;
    for i in 0..count {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[start(i) + k] * a[start(j) + k]).sum();
            let left = a[start(i) + j] - sum;
            let floor = FLOOR * a[start(i) + i].abs();
            a[start(i) + j] = if i == j { left.max(floor).sqrt() } else { left / a[start(j) + j] };
        }
        for column in 0..7 {
            let sum: f64 = (0..i).map(|k| a[start(i) + k] * x[k][column]).sum();
            x[i][column] = (x[i][column] - sum) / a[start(i) + i];
        }
    }
    for i in (0..count).rev() {
        for column in 0..7 {
            let sum: f64 = (i + 1..count).map(|k| a[start(k) + i] * x[k][column]).sum();
            x[i][column] = (x[i][column] - sum) / a[start(i) + i];
        }
    }
}

#[cfg(test)]
#[path = "projectile_rim_tests.rs"]
mod tests;
