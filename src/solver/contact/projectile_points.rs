//! The nodes near the projectile, and its contact with them.
//!
//! Plies pressed between the projectile and a node carry its push: the gap of a node is measured after moving it towards
//! the struck side by the thickness of the fabric that lies between, hole by hole. So the projectile meets a stack of plies
//! in one solve, with the mass of all of them, and contact between plies has only their differences to deal with.

use nalgebra::Vector3;

use crate::model::layup::SIDES;
use crate::model::{Model, layup};
use crate::num::scalar::Scalar;
use crate::physics::projectile_shape::FAR;
use crate::physics::rigid_body::RigidBody;
use crate::solver::Context;
use crate::solver::contact::broad_phase::find_candidates;
use crate::solver::contact::candidate_edges::{CandidateEdges, edge_stands};
use crate::solver::contact::edge_contact::{EdgeConstraint, EdgeContact};
use crate::solver::contact::projectile_contact::{self, ContactPoint};
use crate::solver::energy_balance::NodeCorrection;
use crate::solver::node_update::{field as node, gather, neighbours};
use crate::solver::state::{State, node_stands};

/// Steps a list of nearby nodes is meant to last.
const CANDIDATE_STEPS: f64 = 24.0;
/// Steps for which a place must be clear of the body not to be looked at: more than one, for contact moves nodes beyond the bound of a step.
const CLEAR_STEPS: f64 = 2.0;

/// The nodes near the projectile.
#[derive(Default)]
pub(crate) struct ProjectileContact {
    /// Ply, row, column, in storage order.
    pub(crate) candidates: Vec<[usize; 3]>,
    /// Distance that nodes and body may still approach each other before `candidates` are stale [m].
    pub(crate) skin: f64,
    /// Edges between the candidates.
    edges: CandidateEdges,
    /// Places, then edges, that might have touched in the last step and did not push.
    pub(crate) idle: Vec<bool>,
    /// Distance that nodes and body may have approached each other since the list was made [m].
    travelled: f64,
    /// By places, then edges: what `travelled` must reach before one is looked at again [m].
    clear: Vec<f64>,
    /// Candidates by their place in `edges`, as far as they were looked at in this step.
    nodes: Vec<Option<CandidateNode>>,
    points: Vec<ContactPoint>,
    /// Place among the points of each place.
    point_of: Vec<Option<usize>>,
    /// Points where the rim crosses edges of elements.
    crossings: Vec<ContactPoint>,
    edge_contact: EdgeContact,
}

/// A node, or a point between two, against the body.
struct ContactSample {
    gap: f64,
    normal: Vector3<f64>,
    /// At the start of the step [m].
    position: Vector3<f64>,
    /// [m/s]
    free: Vector3<f64>,
    /// Thickness of the fabric between it and the struck side [m].
    between: f64,
}

/// A node in one step.
struct CandidateNode {
    sample: ContactSample,
    /// Without the fabric between, in the body's frame [m].
    pressed: Vector3<f64>,
}

impl ProjectileContact {
    /// Takes a list of the nodes near the body, and how far they may still approach each other before it is stale [m].
    pub(crate) fn remember<S: Scalar>(&mut self, model: &Model<S>, candidates: Vec<[usize; 3]>, skin: f64) {
        self.edges = CandidateEdges::of(model, &candidates);
        let count = self.edges.places.len() + self.edges.ends.len();
        (self.idle, self.clear, self.travelled) = (vec![false; count], vec![0.0; count], 0.0);
        (self.candidates, self.skin) = (candidates, skin);
    }

    /// Finds and applies the impulses of a step.
    pub(crate) fn resolve<S: Scalar>(&mut self, context: &mut Context<'_, S>, body: &mut RigidBody, nothing: &[S]) {
        let model = context.model;
        let travel = model.dt * (context.totals.max_speed + body.speed_bound());
        if !travel.is_finite() {
            return; // the run stops on its own check of the numbers
        }
        self.skin -= travel;
        if self.skin < 0.0 {
            let skin = CANDIDATE_STEPS * travel;
            let edge = if model.edges { body.rim_depth } else { 0.0 };
            self.remember(model, find_candidates(model, context.state, body, skin + travel + edge), skin);
        }
        self.travelled += travel;
        // Fabric that is missing lets nodes come nearer by the thickness of a ply at once.
        let due = if context.whole { self.travelled + CLEAR_STEPS * travel } else { f64::INFINITY };
        self.nodes.clear();
        self.nodes.resize_with(self.edges.places.len(), || None);
        self.point_of.clear();
        self.point_of.resize(self.edges.places.len(), None);
        if !context.whole {
            self.sample_candidates(context, body);
        }
        self.gather_points(context, body, nothing, due);
        if model.edges {
            self.gather_crossings(context, body, nothing, due);
        }
        self.idle.fill(false);
        if self.points.is_empty() {
            return;
        }
        context.balance.add_contact(&projectile_contact::resolve(
            body,
            &mut self.points,
            &mut self.edge_contact,
            model.dt,
        ));
        for p in self.points.iter().filter(|p| p.signed_distance.is_finite()) {
            self.idle[p.origin] = true;
        }
        for p in self.points.iter().filter(|p| p.active) {
            self.idle[p.origin] = false;
        }
        let nodes = self.points.len() - self.edge_contact.constraints.len();
        let kick = context.kick();
        for p in self.points[..nodes].iter().filter(|p| p.touched()) {
            let velocity = p.velocity();
            let mesh = &model.ply_type(p.ply).mesh;
            let change = mesh.to_ply((velocity - p.free).into());
            let own = mesh.to_ply(velocity.into());
            let row = model.grid.first_node_row(p.ply) + p.row;
            for a in 0..3 {
                let u = context.state.nodes.get(row, node::DISPLACEMENT + a, p.column).to_f64();
                context.state.nodes.set(row, node::DISPLACEMENT + a, p.column, S::splat(u + model.dt * change[a]));
                context.state.nodes.set(row, node::VELOCITY + a, p.column, S::splat(own[a]));
            }
            context.state.active[p.ply].activate(p.row, p.column);
            let pull = (p.free - p.before) * (model.dt / kick);
            context.balance.correct_node(p.ply, &NodeCorrection { mass: p.mass, free: p.free, now: velocity, pull });
        }
    }

    /// Samples the candidates, and the other ends of their edges, where fabric is missing.
    fn sample_candidates<S: Scalar>(&mut self, context: &Context<'_, S>, body: &RigidBody) {
        let (model, state) = (context.model, &*context.state);
        let mut next = 0;
        for at in 0..self.edges.places.len() {
            let between = self.between(model, state, self.edges.places[at], &mut next);
            self.nodes[at] = Some(sample_node(context, body, &self.edges, at, between));
        }
    }

    /// [`fabric_between`] of a node, from that of the node in front of it, which is sampled by then, mostly: its ply comes first. `next`: where that
    /// is looked for, after the one in front of the last node.
    fn between<S: Scalar>(&self, model: &Model<S>, state: &State<S>, place: [usize; 3], next: &mut usize) -> f64 {
        let Some((thickness, front)) = fabric_in_front(model, state, place) else { return 0.0 };
        let near = &self.edges.places[..self.candidates.len()];
        let known = if near.get(*next) == Some(&front) { Some(*next) } else { near.binary_search(&front).ok() };
        *next = known.map_or(*next, |at| at + 1);
        let sampled = known.and_then(|at| self.nodes[at].as_ref());
        thickness + sampled.map_or_else(|| fabric_between(model, state, front), |node| node.sample.between)
    }

    /// The nodes that may touch the body in this step.
    fn gather_points<S: Scalar>(&mut self, context: &mut Context<'_, S>, body: &RigidBody, nothing: &[S], due: f64) {
        let (model, state) = (context.model, &*context.state);
        let misses = misses(body, model.dt);
        self.points.clear();
        for (at, place) in self.candidates.iter().enumerate() {
            if self.clear[at] > due || (!context.whole && !node_stands(model, state, *place)) {
                continue;
            }
            let depth = model.plies[place[0]].depth;
            let node = self.nodes[at].get_or_insert_with(|| sample_node(context, body, &self.edges, at, depth));
            let (gap, normal) = body.contact_distance(&node.pressed);
            // One that hangs behind the rim is far away until it is inside.
            self.clear[at] = self.travelled + if gap < FAR { gap } else { body.clearance(&node.pressed) };
            context.totals.penetration = context.totals.penetration.max(-gap);
            let sample = ContactSample { gap, normal, ..node.sample };
            if misses(&sample) {
                continue;
            }
            let point = contact_point(context, body, nothing, *place, &sample);
            if body.prescribed && !point.is_free() {
                continue; // both are held, and no finite impulse would change that
            }
            self.point_of[at] = Some(self.points.len());
            self.points.push(ContactPoint { origin: at, was_idle: self.idle[at], ..point });
        }
    }

    /// The points where the rim of a flat face crosses edges of elements and that may touch it in this step. The nodes at the
    /// ends of the edges join the others, far away where they do not touch the body themselves.
    fn gather_crossings<S: Scalar>(&mut self, context: &Context<'_, S>, body: &RigidBody, nothing: &[S], due: f64) {
        let (model, state) = (context.model, &*context.state);
        let Self { edges, nodes: candidates, point_of, points, crossings, edge_contact, idle, clear, .. } = self;
        crossings.clear();
        edge_contact.constraints.clear();
        let (profile, axis) = (&body.body.profile, body.orientation.transform_vector(&Vector3::z()));
        let misses = misses(body, model.dt);
        for (edge, &ends) in edges.ends.iter().enumerate() {
            let origin = edges.places.len() + edge;
            if clear[origin] > due {
                continue;
            }
            let places = ends.map(|end| edges.places[end]);
            let depth = model.plies[places[0][0]].depth;
            for end in ends {
                candidates[end].get_or_insert_with(|| sample_node(context, body, edges, end, depth));
            }
            let [Some(first), Some(second)] = ends.map(|end| candidates[end].as_ref()) else { continue };
            let [from, to] = [first, second].map(|end| end.pressed);
            clear[origin] = self.travelled + profile.rim_clearance(from.into(), to.into());
            for at in profile.rim_crossings(from.into(), to.into()).into_iter().filter(|at| !at.is_nan()) {
                if !edge_stands(model, state, places) {
                    break;
                }
                let both = [first, second].map(|end| &end.sample);
                let mix = |read: fn(&ContactSample) -> Vector3<f64>| read(both[0]) * (1.0 - at) + read(both[1]) * at;
                let crossing = ContactSample {
                    gap: profile.height_over_face((from * (1.0 - at) + to * at).into()),
                    normal: axis,
                    position: mix(|end| end.position),
                    free: mix(|end| end.free),
                    between: both[0].between.max(both[1].between),
                };
                if crossing.gap < -body.rim_depth || misses(&crossing) {
                    continue;
                }
                let weights = [1.0 - at, at];
                let as_met = |k: usize| contact_point(context, body, nothing, places[k], both[k]);
                let can_move =
                    |k: usize| weights[k] > 0.0 && ContactPoint { normal: crossing.normal, ..as_met(k) }.is_free();
                if body.prescribed && !can_move(0) && !can_move(1) {
                    continue; // as above
                }
                let nodes = [0, 1].map(|k| {
                    let point = *point_of[ends[k]].get_or_insert_with(|| {
                        points.push(as_met(k));
                        points.len() - 1
                    });
                    points[point].shared = true;
                    point
                });
                let constraint = EdgeConstraint { nodes, weights };
                let point = ContactPoint {
                    before: constraint.between(|node| points[node].before),
                    part: nodes.map(|node| points[node].part).into_iter().fold(0.0, f64::max),
                    origin,
                    was_idle: idle[origin],
                    ..at_place(points[nodes[0]].clone(), model, body, &crossing)
                };
                crossings.push(point);
                edge_contact.constraints.push(constraint);
            }
        }
        points.append(crossings);
    }
}

/// A place before contact, out of touch, with so much fabric between it and the struck side [m].
fn sample_node<S: Scalar>(
    context: &Context<'_, S>,
    body: &RigidBody,
    edges: &CandidateEdges,
    at: usize,
    between: f64,
) -> CandidateNode {
    let (model, state, [ply, row, column]) = (context.model, &*context.state, edges.places[at]);
    let (row, mesh) = (model.grid.first_node_row(ply) + row, &model.ply_type(ply).mesh);
    let free = Vector3::from(mesh.to_pack(state.velocity(row, column)));
    let moved = Vector3::from(mesh.to_pack(state.displacement(row, column)));
    let position = edges.reference[at] + moved - free * model.dt;
    let pressed = body.to_body(&(position - Vector3::new(0.0, 0.0, between)));
    CandidateNode {
        pressed,
        sample: ContactSample { gap: f64::INFINITY, normal: Vector3::z(), position, free, between },
    }
}

/// Whether a body cannot touch a point within a step.
fn misses(body: &RigidBody, dt: f64) -> impl Fn(&ContactSample) -> bool {
    // Velocity that the body may gain at any place under impulses: one that turns may reach a little further than its velocity now takes it.
    let (position, twist, gain) = (body.position, body.twist(), 0.1 * body.speed_bound());
    move |sample| {
        let approach = (sample.free - twist.at(&(sample.position - position))).dot(&sample.normal);
        sample.gap + dt * (approach - gain) > 0.0
    }
}

/// A node as contact sees it.
fn contact_point<S: Scalar>(
    context: &Context<'_, S>,
    body: &RigidBody,
    nothing: &[S],
    [ply, row, column]: [usize; 3],
    sample: &ContactSample,
) -> ContactPoint {
    let (model, state) = (context.model, &*context.state);
    let ply_type = model.ply_type(ply);
    let m = ply_type.row_mass(row);
    let [x, y, z] = [0, 1, 2].map(|a| m.inverse[a][column].to_f64());
    let inverse = Vector3::from(turned(ply_type.mesh.rotation, [x, y, z]));
    let around = neighbours(model, &state.elements, nothing, ply, row);
    let force = gather(S::splat(0.0), &around, column).map(Scalar::to_f64);
    let force = Vector3::from(ply_type.mesh.to_pack(force));
    let point = ContactPoint {
        ply,
        row,
        column,
        before: sample.free - inverse.component_mul(&force) * context.kick(),
        inverse,
        mass: m.mass[column].to_f64(),
        part: ply_type.mesh.part_of(row, column),
        ..ContactPoint::default()
    };
    at_place(point, model, body, sample)
}

/// A point with the masses of a node, at a sample.
fn at_place<S: Scalar>(node: ContactPoint, model: &Model<S>, body: &RigidBody, sample: &ContactSample) -> ContactPoint {
    let mut point = ContactPoint {
        signed_distance: sample.gap,
        normal: sample.normal,
        arm: sample.position - body.position,
        free: sample.free,
        // What the projectile rubs against is the fabric it touches; further plies rub against each other.
        friction: if sample.between > 0.0 { model.friction.min(model.ply_friction) } else { model.friction },
        ..node
    };
    point.set_effective_mass(body.mass);
    point
}

/// Inverse masses by direction of a ply in the axes of the pack. Rollers, which tell the directions apart, hold only
/// plies laid along the pack's axes.
fn turned([c, s]: [f64; 2], [x, y, z]: [f64; 3]) -> [f64; 3] {
    if x == y { [x, y, z] } else { [c * c * x + s * s * y, s * s * x + c * c * y, z] }
}

/// Thickness of the fabric between a node and the struck side [m]: of each ply in front whose element there stands.
pub fn fabric_between<S: Scalar>(model: &Model<S>, state: &State<S>, place: [usize; 3]) -> f64 {
    fabric_in_front(model, state, place)
        .map_or(0.0, |(thickness, front)| thickness + fabric_between(model, state, front))
}

/// Thickness of the ply in front of a node [m], 0 where its element there does not stand, and the node of it to go on from: the corner nearest to
/// the node by its place.
fn fabric_in_front<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    [ply, row, column]: [usize; 3],
) -> Option<(f64, [usize; 3])> {
    let front = ply.checked_sub(1)?;
    let [mesh, behind] = [front, ply].map(|ply| &model.ply_type(ply).mesh);
    let at = (ply * SIDES * (model.grid.rows + 1) + row) * (model.grid.columns + 1) + column;
    let element = layup::element(state.over[at]);
    let [r, c] = [element / mesh.columns, element % mesh.columns];
    let stands = state.is_intact(model.grid.first_element_row(front) + r, c);
    let [x, y] = behind.reference(row, column);
    let [x, y, _] = mesh.to_ply(behind.to_pack([x, y, 0.0]));
    let ([left, below], [length, height]) = (mesh.reference(r, c), mesh.size(r, c));
    let place = [front, r + usize::from(y - below > 0.5 * height), c + usize::from(x - left > 0.5 * length)];
    Some((if stands { model.plies[front].touching } else { 0.0 }, place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::case;
    use crate::solver::Stepper;
    use crate::solver::element_totals::field;
    use crate::solver::energy_balance::EnergyBalance;

    /// A case with changes, its model and its state at the start.
    fn scene(case: &str, sets: &[&str]) -> (Model<f64>, State<f64>) {
        let sets: Vec<String> = ["/expect=[]"].iter().chain(sets).map(|set| (*set).to_owned()).collect();
        let case = case::read(Path::new(case), &sets).unwrap_or_else(|error| unreachable!("{error}"));
        let model = Model::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        let state = State::new(&case, &model);
        (model, state)
    }

    #[test]
    fn fabric_between_counts_the_elements_in_front_that_stand() {
        let sets = ["/pack/plies=3", "/pack/width_mm=11.43", "/pack/height_mm=8.89", "/projectile=null"];
        let (model, mut state) = scene("cases/s728-4ply-91.json", &sets);
        let mesh = &model.ply_type(0).mesh;
        // Plies alike: the same element of each is in front of a node.
        let front = |ply: usize, row: usize, column: usize| {
            let at = (ply * SIDES * (mesh.rows + 1) + row) * (mesh.columns + 1) + column;
            let element = layup::element(state.over[at]);
            [element / mesh.columns, element % mesh.columns]
        };
        let (row, column) = (mesh.rows / 2, mesh.columns / 2);
        let [first, second] = [1, 2].map(|ply| front(ply, row, column));
        let between = |state: &State<f64>| fabric_between(&model, state, [2, row, column]);
        let [a, b] = [0, 1].map(|ply: usize| model.plies[ply].touching);
        assert_eq!(between(&state), b + a);
        let mut cut = |ply: usize, [row, column]: [usize; 2], alive: f64| {
            let row = model.grid.first_element_row(ply) + row;
            (0..2).for_each(|yarn| state.elements.set(row, field::ALIVE + yarn, column + 1, alive));
            fabric_between(&model, &state, [2, mesh.rows / 2, mesh.columns / 2])
        };
        assert_eq!(cut(0, first, 0.0), b);
        assert_eq!(cut(1, second, 0.0), 0.0);
        assert_eq!(cut(0, first, 1.0), a);
        // Holes elsewhere change nothing.
        let others = (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| [row, column]));
        assert!(others.filter(|place| *place != first).all(|place| cut(0, place, 0.0) == a));
    }

    #[test]
    fn what_is_clear_of_the_body_need_not_be_looked_at() {
        let common = r#""mass_g": 1.5, "velocity_m_s": 300, "offset_mm": [0.7, -0.4], "obliquity_deg": 25"#;
        let shapes = [
            r#""shape": "cylinder", "diameter_mm": 5.5, "length_mm": 6, "yaw_deg": 12"#,
            r#""shape": "fragment", "diameter_mm": 5, "length_mm": 6, "angular_velocity_rad_s": [3000, -2000, 9000]"#,
            r#""shape": "sphere", "diameter_mm": 4"#,
        ];
        for (shape, plies) in shapes.into_iter().flat_map(|shape| [(shape, 1), (shape, 3)]) {
            let sets = [
                format!("/projectile={{{shape}, {common}}}"),
                format!("/pack/plies={plies}"),
                "/pack/width_mm=22".to_owned(),
                "/pack/height_mm=22".to_owned(),
            ];
            let (model, state) = scene("cases/s728-4ply-91.json", &sets.each_ref().map(String::as_str));
            let run = || (state.clone(), Stepper::new(&model), EnergyBalance::default());
            let (mut runs, mut looked_at) = ([run(), run()], [0; 2]);
            for step in 0..220 {
                for (all, (state, stepper, balance)) in runs.iter_mut().enumerate() {
                    if all == 1 {
                        let memory = stepper.memory();
                        stepper.remember(&model, memory); // which does not hold what is clear
                    }
                    stepper.step(&model, state, balance, false);
                    looked_at[all] += stepper.projectile.nodes.iter().flatten().count();
                }
                assert!(runs[0].0.nodes.data == runs[1].0.nodes.data, "{shape}, {plies} plies, step {step}");
            }
            let speed = runs[0].0.body.as_ref().map_or(f64::INFINITY, |body| body.velocity.norm());
            assert!(speed < 298.0, "{shape} touched nothing");
            assert!(4 * looked_at[0] < 3 * looked_at[1], "{shape}, {plies} plies: {looked_at:?}");
        }
    }
}
