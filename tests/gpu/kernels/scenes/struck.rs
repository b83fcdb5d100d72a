//! Fabric wrapped around a projectile: every shape, motion and kind of contact, and packs under it.

use nalgebra::Vector3;
use ripstop::case::{Along, Case, ContactSampling, Edge, Motion, Projectile, Rotation, Shape};
use ripstop::kernels::element_force::field as element;
use ripstop::kernels::node_update::field as node;
use ripstop::kernels::rigid_body::RigidBody;
use ripstop::model::Model;
use ripstop::solver::active_region::ActiveRegion;
use ripstop::solver::fabric_between;
use ripstop::solver::state::State;

use super::packs::{self, Group};
use super::{Scene, kill, random_elements};
use crate::support::Random;
use crate::support::patch;

/// Leaves nothing of the elements around a node near the middle in every other ply, and one of them in the rest.
fn erode_around_a_node(model: &Model<f32>, state: &mut State<f32>) {
    let (row, column) = (5, 7);
    for (ply, r, c) in (0..model.grid.plies).flat_map(|ply| [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(r, c)| (ply, r, c)))
    {
        let stands = ply % 2 == 1 && (r, c) == (0, 1);
        let index = ply * model.grid.rows + row - 1 + r;
        for yarn in 0..2 {
            state.elements.set(index, element::ALIVE + yarn, column + c, if stands { 1.0 } else { 0.0 });
        }
    }
}

/// A steel-like projectile at 200 m/s.
fn projectile(shape: Shape) -> Projectile {
    Projectile {
        shape,
        edge_radius: 0.0,
        mass: 2e-5,
        density: None,
        inertia: None,
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
    }
}

const SPHERE: Shape = Shape::Sphere { diameter: 7e-3 };
const CYLINDER: Shape = Shape::Cylinder { diameter: 7e-3, length: 5e-3 };
const CONE: Shape = Shape::Cone { diameter: 7e-3, length: 8e-3, nose_length: 4e-3 };
const OGIVE: Shape = Shape::Ogive { diameter: 7e-3, length: 8e-3, nose_length: 5e-3 };
const BLUNT: Shape = Shape::Ogive { diameter: 7e-3, length: 5e-3, nose_length: 5e-3 };
const FRAGMENT: Shape =
    Shape::Fragment { diameter: 7e-3, length: 6e-3, nose_flat: 3.2e-3, nose_angle: 0.611, roll: 0.5 };

/// Every shape, motion and kind of contact.
pub(crate) fn scenes() -> Vec<Scene> {
    let make = |name: &str, shape: Shape, change: &dyn Fn(&mut Projectile, &mut Case)| {
        let mut p = projectile(shape);
        let mut case = patch::case(13, 11);
        change(&mut p, &mut case);
        case.projectile = Some(p);
        struck(name, case)
    };
    let oblique = |p: &mut Projectile| {
        (p.obliquity, p.azimuth, p.yaw) = (0.4, 0.7, 0.15);
        p.angular_velocity = [2e3, -3e3, 8e3];
        p.friction = 0.25;
    };
    vec![
        make("sphere", SPHERE, &|_, case| case.pack.plies = 13),
        make("sphere, spinning, oblique, friction", SPHERE, &|p, case| {
            oblique(p);
            p.mass = 4e-6;
            case.pack.plies = 2;
        }),
        make("face of a cylinder exactly touching", CYLINDER, &|_, _| {}),
        make("cylinder, yawed, friction", CYLINDER, &|p, _| {
            oblique(p);
            p.edge_radius = 0.5e-3;
        }),
        make("light cylinder, one side of the face", CYLINDER, &|p, _| {
            p.mass = 2e-6;
            p.inertia = Some([2e-12, 2e-12]);
            p.friction = 0.7;
        }),
        make("rim of a flat cylinder", CYLINDER, &|p, _| p.friction = 0.1),
        make("cone", CONE, &|p, case| {
            p.edge_radius = 0.3e-3;
            case.pack.plies = 2;
        }),
        make("cone, oblique, friction", CONE, &|p, _| oblique(p)),
        make("edges of an ogive", OGIVE, &|p, case| {
            p.edge_radius = 0.8e-3;
            case.pack.plies = 2;
        }),
        make("ogive, side first", OGIVE, &|p, _| p.yaw = 1.75),
        make("edges of an ogive, tail first", BLUNT, &|p, _| {
            (p.yaw, p.velocity) = (2.9, 500.0); // gaps are measured from the nose, with the rounding of its distance
            p.edge_radius = 0.3e-3;
        }),
        make("ogive, oblique, friction", OGIVE, &|p, _| oblique(p)),
        make("fragment", FRAGMENT, &|_, case| case.pack.plies = 3),
        make("edges of a fragment", FRAGMENT, &|p, case| {
            oblique(p);
            p.edge_radius = 0.6e-3;
            case.pack.plies = 3;
        }),
        make("rounded fragment", FRAGMENT, &|p, case| {
            oblique(p);
            p.edge_radius = 0.6e-3;
            case.pack.plies = 3;
        }),
        make("fragment, side first", FRAGMENT, &|p, case| {
            p.yaw = 1.75;
            case.pack.plies = 2;
        }),
        make("edges of a fragment, tail first", FRAGMENT, &|p, case| {
            (p.yaw, p.velocity) = (2.9, 500.0); // gaps are measured from the nose, with the rounding of its distance
            p.edge_radius = 0.3e-3;
            case.pack.plies = 2;
        }),
        make("fragment in front of a slit", FRAGMENT, &|p, _| {
            if let Shape::Fragment { roll, .. } = &mut p.shape {
                *roll = 0.0;
            }
            p.offset = [0.0; 2];
        }),
        make("rim of a fragment", FRAGMENT, &|p, case| {
            p.friction = 0.1;
            case.pack.plies = 3;
        }),
        make("bar along warp, clamped ends", Shape::Bar { diameter: 5e-3, along: Along::Warp }, &|p, case| {
            p.rotation = Rotation::Locked;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.right = Edge::Roller;
        }),
        make("bar along weft, driven, rough", Shape::Bar { diameter: 5e-3, along: Along::Weft }, &|p, case| {
            p.rotation = Rotation::Locked;
            p.motion = Motion::Prescribed;
            p.friction = 0.3;
            case.pack.edges.bottom = Edge::Clamped;
        }),
        make("locked cylinder in a clamped corner", CYLINDER, &|p, case| {
            p.rotation = Rotation::Locked;
            p.offset = [-6.5e-3, -7e-3];
            p.friction = 0.2;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.bottom = Edge::Roller;
        }),
        make("free sphere at a clamped edge", SPHERE, &|p, case| {
            p.offset = [-7e-3, 1e-3];
            p.mass = 1e-4;
            case.pack.edges.left = Edge::Clamped;
        }),
        make("driven spinning sphere at a held edge", SPHERE, &|p, case| {
            oblique(p);
            p.offset = [0.0, 8e-3];
            p.motion = Motion::Prescribed;
            case.pack.edges.top = Edge::Clamped;
        }),
        make("sphere under a weft", SPHERE, &|_, _| {}),
        make("away from the fabric", SPHERE, &|p, _| p.standoff = 2e-3),
        make("cylinder in front of a hole", CYLINDER, &|_, _| {}),
        make("cylinder beside the middle of a graded ply, friction", CYLINDER, &|p, case| {
            oblique(p);
            super::grade(case, [4e-3, 3e-3], 2.0);
        }),
        make("graded yarns cut close and far away", CYLINDER, &|_, case| {
            (case.pack.columns, case.pack.rows, case.pack.plies) = (49, 43, 4);
            super::grade(case, [0.0; 2], 4.0);
        }),
        make("coarse row beside the middle", CYLINDER, &|p, case| {
            (case.pack.columns, case.pack.rows) = (49, 43);
            super::grade(case, [-2e-2, -2e-2], 8.0);
            let mesh = &Model::<f32>::new(case).unwrap().ply_types[0].mesh;
            p.offset = mesh.reference(mesh.rows - 2, mesh.columns - 2);
        }),
        make("cylinder behind a faster flap", CYLINDER, &|p, case| {
            p.friction = 0.1;
            case.pack.edges.right = Edge::Clamped;
        }),
    ]
}

/// Where the rim of the face is sampled between nodes too.
pub(crate) fn rim_scenes() -> Vec<Scene> {
    let make = |name: &str, groups: &[Group], change: &dyn Fn(&mut Projectile, &mut Case)| {
        let mut p = projectile(CYLINDER);
        let mut case = if groups.is_empty() { patch::case(13, 11) } else { packs::case([13, 11], groups) };
        case.solver.contact_sampling = ContactSampling::Edges;
        change(&mut p, &mut case);
        case.projectile = Some(p);
        struck(name, case)
    };
    let oblique = |p: &mut Projectile| {
        (p.obliquity, p.azimuth, p.yaw) = (0.4, 0.7, 0.15);
        p.angular_velocity = [2e3, -3e3, 8e3];
        p.friction = 0.25;
    };
    let turned = Group::turned;
    vec![
        make("between nodes, light", &[], &|p, _| {
            p.mass = 2e-6;
            p.inertia = Some([2e-12, 2e-12]);
        }),
        make("between nodes, yawed, friction", &[], &|p, _| oblique(p)),
        make("between nodes, rounded, and behind the rim", &[], &|p, _| {
            p.edge_radius = 0.5e-3;
            p.friction = 0.1;
        }),
        make("between nodes beside a slit", &[], &|p, _| (p.offset, p.friction) = ([0.0; 2], 0.1)),
        make("between nodes where no weft is left", &[], &|p, _| (p.offset, p.friction) = ([0.0; 2], 0.1)),
        make("between nodes, driven, rough, at a held edge", &[], &|p, case| {
            p.motion = Motion::Prescribed;
            p.friction = 0.3;
            p.offset = [-7e-3, 1e-3];
            case.pack.edges.left = Edge::Clamped;
        }),
        make("between nodes of a clamped corner", &[], &|p, case| {
            p.rotation = Rotation::Locked;
            p.offset = [-6.5e-3, -7e-3];
            p.friction = 0.2;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.bottom = Edge::Roller;
        }),
        make("between nodes on turned plies, friction", &[turned(0), turned(90), turned(30)], &|p, case| {
            (p.friction, case.pack.friction) = (0.4, 0.15);
            p.angular_velocity = [2e3, -3e3, 8e3];
        }),
        make("between nodes on graded plies, friction", &[turned(0), turned(90)], &|p, case| {
            (p.friction, case.pack.friction) = (0.4, 0.15);
            super::grade(case, [-2e-3, 3e-3], 3.0);
        }),
        make("between nodes exactly touching resting plies", &[turned(0), turned(90)], &|p, _| p.friction = 0.1),
    ]
}

/// Packs under a projectile: which plies are in front of a node, and which of them are gone there, decides what it meets.
pub(crate) fn pack_scenes() -> Vec<Scene> {
    let make = |name: &str, groups: &[Group], shape: Shape, change: &dyn Fn(&mut Projectile, &mut Case)| {
        let mut p = projectile(shape);
        let mut case = packs::case([13, 11], groups);
        change(&mut p, &mut case);
        case.projectile = Some(p);
        struck(name, case)
    };
    let (turned, coarse) = (Group::turned, Group::coarse);
    vec![
        make(
            "sphere on turned plies, friction",
            &[turned(0), turned(90), turned(30), turned(0)],
            SPHERE,
            &|p, case| {
                (p.friction, case.pack.friction) = (0.4, 0.15);
                p.angular_velocity = [2e3, -3e3, 8e3];
            },
        ),
        make("rough cylinder on two fabrics", &[coarse(0), turned(0), coarse(90)], CYLINDER, &|p, case| {
            (p.friction, case.pack.friction) = (0.1, 0.5);
            case.pack.spacing = Some(0.2e-3);
        }),
        make("cone on held plies with gaps", &[turned(0).held(), turned(90).rolling()], CONE, &|p, case| {
            p.friction = 0.2;
            p.offset = [-7.6e-3, -8.8e-3];
            p.rotation = Rotation::Locked;
            case.pack.spacing = Some(0.7e-3);
        }),
        make(
            "sphere on graded plies, friction",
            &[turned(0), turned(90), turned(30), turned(0), turned(90), turned(0)],
            SPHERE,
            &|p, case| {
                (p.friction, case.pack.friction) = (0.4, 0.15);
                super::grade(case, [4e-3, -5e-3], 2.0);
            },
        ),
        make("cone in front of a torn turned ply", &[turned(0), turned(90)], CONE, &|p, _| p.offset = [4e-3, 5e-3]),
        // Nothing has moved, or been reached, before the first of the steps.
        make(
            "face of a cylinder exactly touching resting plies",
            &[turned(0), turned(90), turned(30)],
            CYLINDER,
            &|_, _| {},
        ),
    ]
}

/// Mends the yarn that runs under the body, so that it covers; where the scene says so a weft instead of a warp, or
/// everything but one cut on one side of every yarn.
fn run_on(model: &Model<f32>, state: &mut State<f32>, body: &RigidBody, name: &str) {
    let (flap, weft) = (name.contains("flap"), name.contains("under a weft"));
    for [ply, row, column] in super::element_places(model) {
        let mesh = &model.ply_type(ply).mesh;
        let [x, y, _] = mesh.to_ply(body.position.into());
        let [under_row, under_column] = mesh.element_at([x, y]);
        let at = row - model.grid.first_element_row(ply);
        let mut set = |yarn: usize, alive: bool| {
            let alive = if alive { 1.0 } else { 0.0 };
            state.elements.set(row, element::ALIVE + yarn, column + 1, alive);
        };
        if flap {
            set(0, column != under_column + 3);
            set(1, at + 3 != under_row);
        } else if weft {
            set(0, column != under_column);
            if column == under_column {
                set(1, true);
            }
        } else if at == under_row + 2 {
            set(0, true); // beside the middle, where scenes leave nothing standing
        }
    }
}

/// Cuts warp on the right in every other ply, weft below in the rest: close by in the last two plies, in the others further away than a
/// yarn must run on to cover, in elements but not in length. Nothing is left of the other yarn.
fn cut_along(model: &Model<f32>, state: &mut State<f32>, body: &RigidBody) {
    for [ply, row, column] in super::element_places(model) {
        let (mesh, yarn) = (&model.ply_type(ply).mesh, ply % 2);
        let at = row - model.grid.first_element_row(ply);
        let middle = mesh.reference(at, column)[yarn] + 0.5 * mesh.size(at, column)[yarn];
        let away = (middle - body.position[yarn]) * [1.0, -1.0][yarn] / mesh.length[yarn];
        let whole = away < if ply < 2 { 11.0 } else { 4.5 };
        state.elements.set(row, element::ALIVE + yarn, column + 1, if whole { 1.0 } else { 0.0 });
        state.elements.set(row, element::ALIVE + 1 - yarn, column + 1, 0.0);
    }
}

/// Fabric wrapped around the nose, behind the fabric in front of it, a rounding to a step's travel away from it or inside
/// it, at random speeds.
fn struck(name: &str, case: Case) -> Scene {
    let model = Model::<f32>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    if name.contains("resting") {
        state.active.fill(ActiveRegion::nothing());
    } else {
        state.reach_everything(&model);
    }
    let mut random = Random(name.len() as u64);
    let mut body = model.projectile.clone().unwrap();
    let touching = name.contains("exactly");
    let speed = body.velocity.norm();
    if !touching {
        state.step = 40;
        body.velocity *= 0.9;
        body.velocity.x -= 3.0;
        let inside = if matches!(case.projectile.as_ref().map(|p| p.shape), Some(CYLINDER)) { 0.8e-3 } else { 1.5e-3 };
        body.position.z += if name.contains("away") { 0.0 } else { inside };
        if name == "sphere" {
            // Its fixed-point position carries within the first step.
            body.position.z = (body.position.z * 1024.0).round() / 1024.0 - 5e-6;
        }
        kill(&model, &mut state, &mut random, 0.3);
        if name == "sphere" {
            erode_around_a_node(&model, &mut state);
        }
        if name.contains(" on ") {
            packs::astray(&model, &mut state, &mut random);
        }
        run_on(&model, &mut state, &body, name);
        random_elements(&model, &mut state, &mut random, 0.2);
    }
    if name.contains("hole") {
        for [_, row, column] in super::element_places(&model) {
            state.elements.set(row, element::ALIVE + (row + column + 1) % 2, column + 1, 0.0);
        }
    }
    if name.contains("slit") {
        // What lies on the strip is torn; what lies on the flats is not.
        for [_, row, column] in super::element_places(&model) {
            let torn = (4..7).contains(&row);
            for yarn in 0..2 {
                state.elements.set(row, element::ALIVE + yarn, column + 1, if torn { 0.0 } else { 1.0 });
            }
        }
    }
    if name.contains("no weft is left") {
        for [_, row, column] in super::element_places(&model) {
            for (yarn, left) in [1.0, 0.0].into_iter().enumerate() {
                state.elements.set(row, element::ALIVE + yarn, column + 1, left);
            }
        }
    }
    if name.contains("cut close") {
        cut_along(&model, &mut state, &body);
    }
    if name.contains("coarse row") {
        // Of the elements under the body, the first corner of each lies further away than the finest elements are long.
        for [_, row, column] in super::element_places(&model) {
            let whole = if row + 3 == model.grid.rows { 1.0 } else { 0.0 };
            (0..2).for_each(|yarn| state.elements.set(row, element::ALIVE + yarn, column + 1, whole));
        }
    }
    if name.contains("torn turned") {
        // Where the body comes the ply behind has no yarn left; at that place of its own axes all are whole.
        for [_, row, column] in super::element_places(&model).into_iter().filter(|place| place[0] == 1) {
            let [x, y, _] = model.reference(1, row - model.grid.first_element_row(1), column);
            let torn = (x - body.position.x).hypot(y - body.position.y) < 2.0 * body.body.radius;
            for yarn in 0..2 {
                state.elements.set(row, element::ALIVE + yarn, column + 1, if torn { 0.0 } else { 1.0 });
            }
        }
    }
    for ply in 0..model.grid.plies {
        let mesh = &model.ply_type(ply).mesh;
        for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
            let reference = Vector3::from(model.reference(ply, row, column));
            let mut at = reference;
            if !touching {
                at = wrapped(&mut random, name, &body, &reference);
                at.z += fabric_between(&model, &state, ply, row, column);
            }
            let moved = mesh.to_ply((at - reference).into());
            let inverse = &model.ply_type(ply).row_mass(row).inverse;
            for a in 0..3 {
                // Away from the body as often as towards it.
                let forward = if a == 2 { if name.contains("flap") { 1.5 } else { 0.6 } } else { 0.0 };
                // One side is struck and turns the body; the other flies ahead of it until it does.
                let ahead = a == 2 && name.contains("one side") && at.x < body.position.x;
                let forward = if ahead { 0.92 } else { forward };
                let spread = if ahead { 1.0 } else { 40.0 };
                let free = inverse[a][column] > 0.0;
                let v = if free { random.between(-spread, spread) + forward * speed } else { 0.0 };
                let at = model.grid.first_node_row(ply) + row;
                state.nodes.set(at, node::DISPLACEMENT + a, column, moved[a] as f32);
                state.nodes.set(at, node::VELOCITY + a, column, if touching { 0.0 } else { v as f32 });
            }
        }
    }
    state.body = Some(body);
    let held = name.contains("clamped") || name.contains("held plies");
    Scene { name: name.to_owned(), model, state, elements: false, pack: false, held, speed }
}

/// Where a node lies on the body, were there no fabric in front of it.
fn wrapped(random: &mut Random, name: &str, body: &RigidBody, reference: &Vector3<f64>) -> Vector3<f64> {
    let mut at = Vector3::new(reference.x, reference.y, 0.0);
    let inside = body.gap(&at).0 < 0.0;
    for _ in 0..30 {
        let (gap, normal) = body.gap(&at);
        let goes = inside && normal.z > 0.2;
        at.z -= if goes { gap / normal.z } else { 0.0 };
    }
    let near = (at - body.position).xy().norm() < 1.5 * body.body.radius;
    if name.contains("edges") && near && random.between(0.0, 1.0) < 0.6 {
        // Where the surface is nearest to a far point is an edge or a corner more often than a face; one in three lies
        // about the axis, where the tip is.
        let across = if random.between(0.0, 1.0) < 0.33 { 0.2 } else { 1.0 };
        let [x, y, z] = random.vector(4.0 * body.body.bounding_radius);
        let far = Vector3::new(across * x, across * y, z);
        at = body.position + body.orientation.transform_vector(&far);
        let (gap, normal) = body.gap(&at);
        at -= normal * gap;
    }
    at += Vector3::from(random.vector(3e-6));
    if name.contains("rim") && random.between(0.0, 1.0) < 0.3 {
        at.z -= 0.5e-3; // hangs behind the face, in its shadow or just beside it
        let arm = at.xy() - body.position.xy();
        if (arm.norm() - body.body.radius).abs() < 0.7e-3 {
            let beside = body.position.xy() + arm * ((body.body.radius + 8e-6) / arm.norm());
            (at.x, at.y) = (beside.x, beside.y);
        }
    }
    at
}
