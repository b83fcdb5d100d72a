//! Fabric wrapped around a projectile: every shape, motion and kind of contact, and packs under it.

use nalgebra::Vector3;
use ripstop::case::{Along, Case, ContactSampling, Edge, Motion, Opening, Projectile, Rotation, Shape};
use ripstop::model::Model;
use ripstop::physics::rigid_body::RigidBody;
use ripstop::solver::contact::projectile_points::fabric_between;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::ActiveRegion;
use ripstop::solver::state::State;

use super::packs::{self, Group};
use super::scenes::{Scene, against_clay, element_places, frame, grade, kill, random_elements, set_yarns, weaken};
use crate::support::{Random, patch};
use Kind::{Between, Edges, Held, Resting, Rim, Slit, Weft};

/// Properties of a scene that differ from the plain one.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Nothing has moved, or been reached, before the first of the steps.
    Resting,
    /// Nodes lie at edges and corners of the body.
    Edges,
    /// Nodes hang behind the face, in its shadow or just beside it.
    Rim,
    /// A weft covers the body instead of a warp.
    Weft,
    /// Fabric is torn along a strip.
    Slit,
    /// A free body meets held nodes.
    Held,
    /// Contact is sampled at the edges between nodes too.
    Between,
}

const SPHERE: Shape = Shape::Sphere { diameter: 7e-3 };
const CYLINDER: Shape = Shape::Cylinder { diameter: 7e-3, length: 5e-3 };
const WIDE: Shape = Shape::Cylinder { diameter: 14e-3, length: 5e-3 };
const CONE: Shape = Shape::Cone { diameter: 7e-3, length: 8e-3, nose_length: 4e-3 };
const OGIVE: Shape = Shape::Ogive { diameter: 7e-3, length: 8e-3, nose_length: 5e-3 };
const FRAGMENT: Shape =
    Shape::Fragment { diameter: 7e-3, length: 6e-3, nose_flat: 3.2e-3, nose_angle: 0.611, roll: 0.5 };

type Change = fn(&mut Projectile, &mut Case);
type Struck = (&'static str, Shape, &'static [Group], &'static [Kind], Change);

const TURNED: [Group; 3] = [Group::turned(0), Group::turned(90), Group::turned(30)];

/// Name, shape, plies (of the patch where none are given), kinds, change.
const SCENES: [Struck; 28] = [
    ("sphere", SPHERE, &[], &[], |_, case| case.pack.plies = 13),
    ("sphere, spinning, oblique, friction", SPHERE, &[], &[], |p, case| {
        oblique(p);
        (p.mass, case.pack.plies) = (4e-6, 2);
    }),
    ("cylinder, yawed, friction", CYLINDER, &[], &[], |p, _| {
        oblique(p);
        p.edge_radius = 0.5e-3;
    }),
    ("rim of a flat cylinder", CYLINDER, &[], &[Rim], |p, _| p.friction = 0.1),
    ("cone", CONE, &[], &[], |p, case| (p.edge_radius, case.pack.plies) = (0.3e-3, 2)),
    ("edges of an ogive", OGIVE, &[], &[Edges], |p, case| (p.edge_radius, case.pack.plies) = (0.8e-3, 2)),
    ("ogive, side first", OGIVE, &[], &[], |p, _| p.yaw = 1.75),
    ("ogive, oblique, friction", OGIVE, &[], &[], |p, _| oblique(p)),
    ("fragment", FRAGMENT, &[], &[], |_, case| case.pack.plies = 3),
    ("edges of a fragment", FRAGMENT, &[], &[Edges], |p, case| {
        oblique(p);
        (p.edge_radius, case.pack.plies) = (0.6e-3, 3);
    }),
    ("fragment, side first", FRAGMENT, &[], &[], |p, case| (p.yaw, case.pack.plies) = (1.75, 2)),
    ("rim of a fragment", FRAGMENT, &[], &[Rim], |p, case| (p.friction, case.pack.plies) = (0.1, 3)),
    ("bar along warp, clamped ends", Shape::Bar { diameter: 5e-3, along: Along::Warp }, &[], &[Held], |p, case| {
        p.rotation = Rotation::Locked;
        (case.pack.edges.left, case.pack.edges.right) = (Edge::Clamped, Edge::Roller);
    }),
    ("bar along weft, driven, rough", Shape::Bar { diameter: 5e-3, along: Along::Weft }, &[], &[], |p, case| {
        (p.rotation, p.motion, p.friction) = (Rotation::Locked, Motion::Prescribed, 0.3);
        case.pack.edges.bottom = Edge::Clamped;
    }),
    ("locked cylinder in a clamped corner", CYLINDER, &[], &[Held], |p, case| corner(p, case)),
    ("sphere on plies against clay, friction", SPHERE, &[], &[], |p, case| {
        oblique(p);
        case.pack.plies = 2;
        against_clay(case, 2e6, Some(2e-3));
    }),
    ("sphere under a weft", SPHERE, &[], &[Weft], |_, _| {}),
    ("sphere in a round window", SPHERE, &[], &[Held], |p, case| {
        (p.rotation, case.pack.plies) = (Rotation::Locked, 8);
        frame(case, Opening::Round, 0.0);
    }),
    ("cylinder beside the middle of a graded ply, friction", CYLINDER, &[], &[], |p, case| {
        oblique(p);
        grade(case, [4e-3, 3e-3], 2.0);
    }),
    ("between nodes, yawed, friction", CYLINDER, &[], &[Between], |p, _| oblique(p)),
    ("between nodes, rounded, and behind the rim", CYLINDER, &[], &[Between, Rim], |p, _| {
        (p.edge_radius, p.friction) = (0.5e-3, 0.1);
    }),
    ("between nodes beside a slit", CYLINDER, &[], &[Between, Slit], |p, _| (p.offset, p.friction) = ([0.0; 2], 0.1)),
    ("between nodes of a clamped corner", CYLINDER, &[], &[Between, Held], |p, case| corner(p, case)),
    ("between nodes, wider than the plies are high", WIDE, &[], &[Between], |p, case| {
        (p.friction, case.pack.plies) = (0.1, 3);
    }),
    ("between nodes on turned plies, friction", CYLINDER, &TURNED, &[Between], |p, case| {
        rubbing(p, case);
        uncut(case);
    }),
    ("sphere on turned plies, friction", SPHERE, &[TURNED[0], TURNED[1], TURNED[2], TURNED[0]], &[], |p, case| {
        rubbing(p, case)
    }),
    (
        "cone on held plies with gaps",
        CONE,
        &[
            Group::turned(0).with(["clamped", "free", "clamped", "free"]),
            Group::turned(90).with(["roller", "free", "roller", "free"]),
        ],
        &[Held],
        |p, case| {
            (p.friction, p.offset, p.rotation) = (0.2, [-7.6e-3, -8.8e-3], Rotation::Locked);
            case.pack.spacing = Some(0.7e-3);
        },
    ),
    ("face of a cylinder exactly touching resting plies", CYLINDER, &TURNED, &[Resting], |_, case| uncut(case)),
];

/// Leaves turned plies whole, in a mesh like the first one's, where a frame would cut them.
fn uncut(case: &mut Case) {
    let mesh = case.pack.layup[0].mesh;
    case.pack.layup.iter_mut().for_each(|layer| layer.mesh = mesh);
}

/// Strikes askew, spinning and rubbing.
fn oblique(p: &mut Projectile) {
    (p.obliquity, p.azimuth, p.yaw) = (0.4, 0.7, 0.15);
    (p.angular_velocity, p.friction) = ([2e3, -3e3, 8e3], 0.25);
}

/// Rubs on plies that rub on each other.
fn rubbing(p: &mut Projectile, case: &mut Case) {
    (p.friction, case.pack.friction) = (0.4, 0.15);
    p.angular_velocity = [2e3, -3e3, 8e3];
}

/// Strikes a corner that is held along one side and rolls along the other.
fn corner(p: &mut Projectile, case: &mut Case) {
    (p.rotation, p.offset, p.friction) = (Rotation::Locked, [-6.5e-3, -7e-3], 0.2);
    (case.pack.edges.left, case.pack.edges.bottom) = (Edge::Clamped, Edge::Roller);
}

pub(super) fn scenes() -> Vec<Scene> {
    SCENES.map(struck).into()
}

/// Fabric wrapped around the nose of a projectile at 200 m/s, behind the fabric in front of it, a rounding to a step's travel away
/// from it or inside it, at random speeds.
fn struck((name, shape, groups, kinds, change): Struck) -> Scene {
    let mut p = Projectile {
        shape,
        edge_radius: 0.0,
        mass: 2e-5,
        density: None,
        axial_inertia: None,
        transverse_inertia: None,
        velocity: 200.0,
        offset: [0.2e-3, -0.3e-3],
        standoff: 0.0,
        obliquity: 0.0,
        azimuth: 0.0,
        yaw: 0.0,
        angular_velocity: [0.0; 3],
        friction: 0.0,
        motion: Motion::Free,
        rotation: Rotation::Free,
    };
    let is = |kind: Kind| kinds.contains(&kind);
    let mut case = if groups.is_empty() { patch::case(13, 11) } else { packs::case([13, 11], groups) };
    if is(Between) {
        case.solver.contact_sampling = ContactSampling::Edges;
    }
    change(&mut p, &mut case);
    case.projectile = Some(p);
    let model = weaken(Model::new(&case).unwrap());
    let mut state = State::new(&case, &model);
    let mut random = Random(name.len() as u64);
    let mut body = model.projectile.clone().unwrap();
    let speed = body.velocity.norm();
    if is(Resting) {
        state.active.fill(ActiveRegion::default());
    } else {
        state.reach_everything(&model);
        state.step = 40;
        body.velocity *= 0.9;
        body.velocity.x -= 3.0;
        body.position.z += if shape == CYLINDER { 0.8e-3 } else { 1.5e-3 };
        kill(&model, &mut state, &mut random, 0.3);
        if name == "sphere" {
            // Its fixed-point position carries within the first step.
            body.position.z = (body.position.z * 1024.0).round() / 1024.0 - 5e-6;
            erode_around_a_node(&model, &mut state);
        }
        if groups.len() > 1 {
            packs::astray(&model, &mut state, &mut random);
        }
        mend(&model, &mut state, &body, is(Weft));
        random_elements(&model, &mut state, &mut random);
    }
    for [_, row, column] in element_places(&model).into_iter().filter(|_| is(Slit)) {
        set_yarns(&mut state, row, column, [!(4..7).contains(&row); 2]);
    }
    place_nodes(&model, &mut state, &mut random, &body, speed, kinds);
    state.body = Some(body);
    Scene { name, model, state, elements: false, pack: false, held: is(Held), speed }
}

/// Leaves nothing of the elements around a node near the middle in every other ply, and one of them in the rest.
fn erode_around_a_node(model: &Model<f32>, state: &mut State<f32>) {
    for (ply, n) in (0..model.grid.plies).flat_map(|ply| (0..4).map(move |n| (ply, n))) {
        let (r, c) = (n / 2, n % 2);
        let stands = ply % 2 == 1 && n == 1;
        set_yarns(state, ply * model.grid.rows + 4 + r, 6 + c, [stands; 2]);
    }
}

/// Mends the yarn that runs under the body, so that it covers: a warp beside the middle, where scenes leave nothing standing, or a weft.
fn mend(model: &Model<f32>, state: &mut State<f32>, body: &RigidBody, weft: bool) {
    for [ply, row, column] in element_places(model) {
        let mesh = &model.ply_type(ply).mesh;
        let [x, y, _] = mesh.to_ply(body.position.into());
        let [under_row, under_column] = mesh.element_at([x, y]);
        let alive = [0, 1].map(|yarn| state.alive(row, column, yarn));
        if weft {
            let under = column == under_column;
            set_yarns(state, row, column, [!under, under || alive[1]]);
        } else if row - model.grid.first_element_row(ply) == under_row + 2 {
            let is_there = mesh.is_present(row - model.grid.first_element_row(ply), column);
            set_yarns(state, row, column, [is_there, alive[1]]);
        }
    }
}

/// Lays the nodes around a body, and gives them velocities by its speed at the start [m/s].
fn place_nodes(
    model: &Model<f32>,
    state: &mut State<f32>,
    random: &mut Random,
    body: &RigidBody,
    speed: f64,
    kinds: &[Kind],
) {
    let resting = kinds.contains(&Resting);
    for [ply, row, column] in model.node_places() {
        let mesh = &model.ply_type(ply).mesh;
        let reference = Vector3::from(model.reference(ply, row, column));
        let mut at = reference;
        if !resting {
            at = wrapped(random, kinds, body, &reference);
            at.z += fabric_between(model, state, [ply, row, column]);
        }
        let moved = mesh.to_ply((at - reference).into());
        let inverse = &model.ply_type(ply).row_mass(row).inverse;
        for a in 0..3 {
            // Away from the body as often as towards it.
            let free = inverse[a][column] > 0.0;
            let v = if free { random.between(-40.0, 40.0) + [0.0, 0.0, 0.6][a] * speed } else { 0.0 };
            let at = model.grid.first_node_row(ply) + row;
            state.nodes.set(at, node::DISPLACEMENT + a, column, moved[a] as f32);
            state.nodes.set(at, node::VELOCITY + a, column, if resting { 0.0 } else { v as f32 });
        }
    }
}

/// Place of a node on the body, were there no fabric in front of it.
fn wrapped(random: &mut Random, kinds: &[Kind], body: &RigidBody, reference: &Vector3<f64>) -> Vector3<f64> {
    let mut at = Vector3::new(reference.x, reference.y, 0.0);
    let inside = body.gap(&at).0 < 0.0;
    for _ in 0..30 {
        let (gap, normal) = body.gap(&at);
        at.z -= if inside && normal.z > 0.2 { gap / normal.z } else { 0.0 };
    }
    let near = (at - body.position).xy().norm() < 1.5 * body.body.radius;
    if kinds.contains(&Edges) && near && random.between(0.0, 1.0) < 0.6 {
        // Where the surface is nearest to a far point is an edge or a corner more often than a face; one in three lies
        // about the axis, where the tip is.
        let across = if random.between(0.0, 1.0) < 0.33 { 0.2 } else { 1.0 };
        let [x, y, z] = random.vector(4.0 * body.body.bounding_radius);
        at = body.position + body.orientation.transform_vector(&Vector3::new(across * x, across * y, z));
        let (gap, normal) = body.gap(&at);
        at -= normal * gap;
    }
    at += Vector3::from(random.vector(3e-6));
    if kinds.contains(&Rim) && random.between(0.0, 1.0) < 0.3 {
        at.z -= 0.5e-3;
        let arm = at.xy() - body.position.xy();
        if (arm.norm() - body.body.radius).abs() < 0.7e-3 {
            let beside = body.position.xy() + arm * ((body.body.radius + 8e-6) / arm.norm());
            (at.x, at.y) = (beside.x, beside.y);
        }
    }
    at
}
