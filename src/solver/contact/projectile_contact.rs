//! Projectile contact: kinematic and perfectly inelastic, with Coulomb friction.
//!
//! Nodes that would enter the body during the step share its normal velocity (less what closes a remaining gap),
//! momentum is conserved exactly, and no contact pulls. With G = (n, r × n) the common motion of a set
//! of nodes and the body is one 6 × 6 symmetric solve, (M + Σ κ G Gᵀ) V′ = M V + Σ κ G (n·v − target); an active-set
//! loop finds the nodes that push. There is no stiffness in it, so nothing depends on one.

use nalgebra::{Matrix6, Vector3, Vector6};

use crate::physics::rigid_body::RigidBody;
use crate::solver::contact::edge_contact::EdgeContact;

/// Changes of the set of pushing nodes allowed in one step.
pub const SET_CHANGES: usize = 40;
/// Sweeps of friction after the normal impulses are found. What they add to the approach of other points the next step takes up:
/// measured in docs/decisions/08.
pub const FRICTION_SWEEPS: usize = 3;
/// Rounding of relative velocities in double precision, over the largest speed of the body [-].
pub(crate) const NOISE: f64 = 1e-9;
/// Mass of a held node over that of the body, or over its own where that is more [-]. A step leaves the body a thousandth of its
/// speed, the steps after it take that. More would drown the body's momentum in the rounding of its speed in single precision.
pub const HELD: f64 = 1e3;

/// A node near the body during one step; by default the first of the pack, held, and out of touch.
#[derive(Clone, Debug, Default)]
pub struct ContactPoint {
    /// Ply of the node.
    pub ply: usize,
    /// Row of the node in its ply.
    pub row: usize,
    /// Column of the node.
    pub column: usize,
    /// Place in what is remembered of places and edges.
    pub origin: usize,
    /// Within reach of the body in the last step, but not active then.
    pub was_idle: bool,
    /// Gap at the start of the step [m].
    pub signed_distance: f64,
    /// Outward normal of the body.
    pub normal: Vector3<f64>,
    /// From the body's centre of mass [m].
    pub arm: Vector3<f64>,
    /// Node velocity before the step [m/s].
    pub before: Vector3<f64>,
    /// Node velocity after the step without contact [m/s].
    pub free: Vector3<f64>,
    /// Inverse mass by direction, 0 where held [1/kg].
    pub inverse: Vector3<f64>,
    /// Lumped mass [kg].
    pub mass: f64,
    /// Part of it that is there [-]: mirror planes leave a half or a quarter.
    pub part: f64,
    /// Coulomb coefficient [-].
    pub friction: f64,
    /// Inertia met along the normal, 1/(n·w n) [kg].
    pub effective_mass: f64,
    /// Normal impulse on the node [N·s].
    pub normal_impulse: f64,
    /// Friction impulse on the node [N·s].
    pub friction_impulse: Vector3<f64>,
    /// Impulse on the node through the edges beside it [N·s].
    pub edge_impulse: Vector3<f64>,
    /// Whether the node pushes.
    pub active: bool,
    /// Whether it shares nodes with other points: a point of the rim, or a node at the end of an edge with one.
    pub shared: bool,
}

impl ContactPoint {
    /// Impulse on the node [N·s].
    pub fn impulse(&self) -> Vector3<f64> {
        self.normal * self.normal_impulse + self.friction_impulse
    }

    /// Velocity with the impulses found [m/s].
    pub fn velocity(&self) -> Vector3<f64> {
        self.free + self.inverse.component_mul(&(self.impulse() + self.edge_impulse))
    }

    /// Whether contact changed the node's velocity.
    pub fn touched(&self) -> bool {
        self.normal_impulse > 0.0 || self.edge_impulse != Vector3::zeros()
    }

    /// Whether the node can move along the normal at all.
    pub fn is_free(&self) -> bool {
        self.normal.dot(&self.inverse.component_mul(&self.normal)) > 0.0
    }

    /// Ends the contact.
    fn release(&mut self) {
        self.active = false;
        self.normal_impulse = 0.0;
    }

    /// Fills in the inertia along the normal.
    pub fn set_effective_mass(&mut self, body_mass: f64) {
        let along = self.normal.dot(&self.inverse.component_mul(&self.normal));
        self.effective_mass = inertia_along(along, self.mass, body_mass);
    }
}

/// Inertia met along a normal [kg], of what a unit impulse moves at `along` [1/kg].
pub(crate) fn inertia_along(along: f64, mass: f64, body_mass: f64) -> f64 {
    1.0 / along.max(1.0 / (HELD * body_mass.max(mass)))
}

/// Sums of contact in one step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactTotals {
    /// Energy lost to the inelastic impact [J].
    pub dissipation: f64,
    /// Energy lost to friction [J].
    pub friction: f64,
    /// Work of the drive that holds a prescribed velocity [J].
    pub external: f64,
    /// Impulse on the body [N·s].
    pub impulse: [f64; 3],
    /// Impulse that went through held nodes into the supports [N·s], on the system.
    pub support: [f64; 3],
}

/// Finds the impulses of one step and applies them to the body; the caller applies them to the nodes. The last points are
/// those of the rim, as many as it has constraints.
pub fn resolve(body: &mut RigidBody, points: &mut [ContactPoint], edges: &mut EdgeContact, dt: f64) -> ContactTotals {
    let start = body.clone();
    edges.begin(points, body.mass);
    let twist = start.twist();
    for p in points.iter_mut() {
        let approach = p.free.dot(&p.normal) - twist.at(&p.arm).dot(&p.normal);
        // A first guess: what did not push in the last step mostly does not in this one.
        p.active = !p.was_idle && approach < closing_limit(p, dt);
    }
    solve_normal(&start, body, points, edges, dt);
    let share = friction_share(&start, points);
    for _ in 0..FRICTION_SWEEPS {
        if !update_friction(body, points, share) {
            break;
        }
        edges.propagate(points);
        apply(&start, body, points);
    }
    account(&start, body, points, points.len() - edges.constraints.len())
}

/// Relative normal velocity below which a node enters the body within the step: what closes its gap exactly.
fn closing_limit(p: &ContactPoint, dt: f64) -> f64 {
    -p.signed_distance.max(0.0) / dt
}

/// Normal impulses of the active set, with changes of the set until none pulls and none enters.
fn solve_normal(
    start: &RigidBody,
    body: &mut RigidBody,
    points: &mut [ContactPoint],
    edges: &mut EdgeContact,
    dt: f64,
) {
    let tolerance = NOISE * (start.speed_bound() + 1e-3);
    for change in 0..SET_CHANGES {
        common_velocity(start, body, points, edges, dt);
        let twist = body.twist();
        let mut changed = false;
        for p in points.iter_mut() {
            let approach = (p.velocity() - twist.at(&p.arm)).dot(&p.normal);
            if p.active && p.normal_impulse < 0.0 {
                p.release();
                changed = true;
            } else if !p.active && approach < closing_limit(p, dt) - tolerance && change < SET_CHANGES / 2 {
                p.active = true;
                changed = true;
            }
        }
        if !changed {
            return;
        }
    }
    common_velocity(start, body, points, edges, dt);
    // What still pulls is let go: the next step finds what enters.
    for p in points.iter_mut().filter(|p| p.normal_impulse < 0.0) {
        p.release();
    }
    edges.propagate(points);
    apply(start, body, points);
}

/// One solve for the body's motion with the active nodes attached, and their impulses.
fn common_velocity(
    start: &RigidBody,
    body: &mut RigidBody,
    points: &mut [ContactPoint],
    edges: &mut EdgeContact,
    dt: f64,
) {
    let [moves, turns] = start.freedom;
    let direction = |p: &ContactPoint| {
        let turn = if start.locked { Vector3::zeros() } else { p.arm.cross(&p.normal).component_mul(&turns) };
        stack(&p.normal.component_mul(&moves), &turn)
    };
    let mut motion = stack(&start.velocity, &start.angular_velocity());
    let mut matrix = Matrix6::identity();
    let mut right = Vector6::zeros();
    if start.prescribed {
        edges.eliminate(points, start.mass, direction, |p| closing_limit(p, dt), (&mut matrix, &mut right));
    } else {
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(nalgebra::Matrix3::identity() * start.mass));
        if !start.locked {
            matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&start.inertia());
        }
        right = stack(&(start.velocity * start.mass), &start.angular_momentum);
        for p in points.iter().filter(|p| p.active && !p.shared) {
            let g = direction(p);
            right += g * (p.effective_mass * (p.free.dot(&p.normal) - closing_limit(p, dt)));
            matrix += g * g.transpose() * p.effective_mass;
        }
        edges.eliminate(points, start.mass, direction, |p| closing_limit(p, dt), (&mut matrix, &mut right));
        if start.locked {
            for a in 3..6 {
                right[a] = 0.0;
            }
        }
        if let Some(factor) = matrix.cholesky() {
            motion = factor.solve(&right);
        }
    }
    edges.push(points, &motion);
    for p in points.iter_mut().filter(|p| p.active && !p.shared) {
        p.normal_impulse =
            p.effective_mass * (direction(p).dot(&motion) + closing_limit(p, dt) - p.free.dot(&p.normal));
    }
    edges.propagate(points);
    apply(start, body, points);
}

fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// Gives the body the opposite of every impulse, so that momentum is conserved whatever the solve did. What acts across a
/// mirror plane the image of the node cancels.
fn apply(start: &RigidBody, body: &mut RigidBody, points: &[ContactPoint]) {
    if start.prescribed {
        return;
    }
    let mut momentum = Vector3::zeros();
    let mut angular = Vector3::zeros();
    for p in points.iter().filter(|p| p.normal_impulse != 0.0) {
        let impulse = p.impulse();
        momentum -= impulse;
        angular -= p.arm.cross(&impulse);
    }
    let [moves, turns] = start.freedom;
    body.velocity = start.velocity + momentum.component_mul(&moves) / start.mass;
    if !start.locked {
        body.angular_momentum = start.angular_momentum + angular.component_mul(&turns);
    }
}

/// Friction impulses that stop the sliding, cut to μ times the normal impulse. True if any changed.
fn update_friction(body: &RigidBody, points: &mut [ContactPoint], share: f64) -> bool {
    let twist = body.twist();
    let mut changed = false;
    for p in points.iter_mut().filter(|p| p.normal_impulse > 0.0) {
        let slide = p.velocity() - twist.at(&p.arm);
        let slide = slide - p.normal * slide.dot(&p.normal);
        let wanted = p.friction_impulse - slide * (p.mass * share);
        let limit = p.friction * p.normal_impulse;
        let size = wanted.norm();
        let drag = if size > limit { wanted * (limit / size) } else { wanted };
        if (drag - p.friction_impulse).norm() > NOISE * limit {
            changed = true;
        }
        p.friction_impulse = drag;
    }
    changed
}

/// Share of what would stop each sliding node alone [-]. All are stopped at once: where they are heavier than the body at their places,
/// the body would be thrown beyond rest, the more so the more it turns, and gain energy.
fn friction_share(body: &RigidBody, points: &[ContactPoint]) -> f64 {
    if body.prescribed {
        return 1.0;
    }
    let [x, y, z] = body.body.inertia;
    let axis = body.orientation * Vector3::z();
    // At most, in any direction across the normal.
    let turned = |arm: &Vector3<f64>| {
        let square = arm.norm_squared();
        if body.locked { 0.0 } else { square / x.min(y) + (square - arm.dot(&axis).powi(2)) / z }
    };
    let pushing = points.iter().filter(|p| p.active && p.normal_impulse > 0.0);
    let load: f64 = pushing.map(|p| p.mass * (1.0 / body.mass + turned(&p.arm))).sum();
    1.0 / load.max(1.0)
}

/// Energy, work and momentum of the impulses found; the first points are `nodes` nodes.
fn account(start: &RigidBody, body: &RigidBody, points: &[ContactPoint], nodes: usize) -> ContactTotals {
    let mut totals = ContactTotals::default();
    let [before, after] = [start, body].map(RigidBody::twist);
    for p in points.iter().filter(|p| p.normal_impulse > 0.0) {
        let surface = before.at(&p.arm) + after.at(&p.arm);
        let mean = (p.before + p.velocity() - surface) * 0.5;
        totals.dissipation -= p.normal_impulse * p.normal.dot(&mean);
        totals.friction -= p.friction_impulse.dot(&mean);
        let impulse = p.impulse();
        if start.prescribed {
            totals.external += 0.5 * impulse.dot(&surface);
        }
        for a in 0..3 {
            totals.impulse[a] -= impulse[a];
        }
    }
    for p in points[..nodes].iter().filter(|p| p.touched()) {
        let impulse = p.impulse() + p.edge_impulse;
        for a in 0..3 {
            let held = p.inverse[a] <= 0.0;
            if start.prescribed {
                // The drive is the support; what goes into held nodes never reaches the fabric.
                totals.support[a] += if held { 0.0 } else { impulse[a] };
            } else if held {
                totals.support[a] -= impulse[a];
            }
        }
    }
    totals
}
