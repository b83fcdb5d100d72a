//! Fabric wrapped around a projectile: every shape, motion and kind of contact, and packs under it.

mod torn;
mod wrapped;

use ripstop::case::{Along, Case, ContactSampling, Edge, Motion, Projectile, Rotation, Shape};
use ripstop::model::Model;

use super::Scene;
use super::packs::{self, Group};
use crate::support::patch;
use wrapped::struck;

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

/// Fabric that a projectile of a shape strikes, with changes of both.
fn make(name: &str, shape: Shape, change: impl Fn(&mut Projectile, &mut Case)) -> Scene {
    let mut p = projectile(shape);
    let mut case = patch::case(13, 11);
    change(&mut p, &mut case);
    case.projectile = Some(p);
    struck(name, case)
}

/// Strikes askew, spinning and rubbing.
fn oblique(p: &mut Projectile) {
    (p.obliquity, p.azimuth, p.yaw) = (0.4, 0.7, 0.15);
    p.angular_velocity = [2e3, -3e3, 8e3];
    p.friction = 0.25;
}

/// Every shape, motion and kind of contact.
pub(crate) fn scenes() -> Vec<Scene> {
    [shapes(), held(), torn_or_graded()].into_iter().flatten().collect()
}

/// Every shape, from the front, from the side and from behind.
fn shapes() -> Vec<Scene> {
    vec![
        make("sphere", SPHERE, |_, case| case.pack.plies = 13),
        make("sphere, spinning, oblique, friction", SPHERE, |p, case| {
            oblique(p);
            p.mass = 4e-6;
            case.pack.plies = 2;
        }),
        make("face of a cylinder exactly touching", CYLINDER, |_, _| {}),
        make("cylinder, yawed, friction", CYLINDER, |p, _| {
            oblique(p);
            p.edge_radius = 0.5e-3;
        }),
        make("light cylinder, one side of the face", CYLINDER, |p, _| {
            p.mass = 2e-6;
            p.inertia = Some([2e-12, 2e-12]);
            p.friction = 0.7;
        }),
        make("rim of a flat cylinder", CYLINDER, |p, _| p.friction = 0.1),
        make("cone", CONE, |p, case| {
            p.edge_radius = 0.3e-3;
            case.pack.plies = 2;
        }),
        make("cone, oblique, friction", CONE, |p, _| oblique(p)),
        make("edges of an ogive", OGIVE, |p, case| {
            p.edge_radius = 0.8e-3;
            case.pack.plies = 2;
        }),
        make("ogive, side first", OGIVE, |p, _| p.yaw = 1.75),
        make("edges of an ogive, tail first", BLUNT, |p, _| {
            (p.yaw, p.velocity) = (2.9, 500.0); // gaps are measured from the nose, with the rounding of its distance
            p.edge_radius = 0.3e-3;
        }),
        make("ogive, oblique, friction", OGIVE, |p, _| oblique(p)),
        make("fragment", FRAGMENT, |_, case| case.pack.plies = 3),
        make("edges of a fragment", FRAGMENT, |p, case| {
            oblique(p);
            p.edge_radius = 0.6e-3;
            case.pack.plies = 3;
        }),
        make("rounded fragment", FRAGMENT, |p, case| {
            oblique(p);
            p.edge_radius = 0.6e-3;
            case.pack.plies = 3;
        }),
        make("fragment, side first", FRAGMENT, |p, case| {
            p.yaw = 1.75;
            case.pack.plies = 2;
        }),
        make("edges of a fragment, tail first", FRAGMENT, |p, case| {
            (p.yaw, p.velocity) = (2.9, 500.0); // gaps are measured from the nose, with the rounding of its distance
            p.edge_radius = 0.3e-3;
            case.pack.plies = 2;
        }),
        make("fragment in front of a slit", FRAGMENT, |p, _| {
            if let Shape::Fragment { roll, .. } = &mut p.shape {
                *roll = 0.0;
            }
            p.offset = [0.0; 2];
        }),
        make("rim of a fragment", FRAGMENT, |p, case| {
            p.friction = 0.1;
            case.pack.plies = 3;
        }),
    ]
}

/// Bodies that are locked or driven, and fabric that is held.
fn held() -> Vec<Scene> {
    vec![
        make("bar along warp, clamped ends", Shape::Bar { diameter: 5e-3, along: Along::Warp }, |p, case| {
            p.rotation = Rotation::Locked;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.right = Edge::Roller;
        }),
        make("bar along weft, driven, rough", Shape::Bar { diameter: 5e-3, along: Along::Weft }, |p, case| {
            p.rotation = Rotation::Locked;
            p.motion = Motion::Prescribed;
            p.friction = 0.3;
            case.pack.edges.bottom = Edge::Clamped;
        }),
        make("locked cylinder in a clamped corner", CYLINDER, |p, case| {
            p.rotation = Rotation::Locked;
            p.offset = [-6.5e-3, -7e-3];
            p.friction = 0.2;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.bottom = Edge::Roller;
        }),
        make("free sphere at a clamped edge", SPHERE, |p, case| {
            p.offset = [-7e-3, 1e-3];
            p.mass = 1e-4;
            case.pack.edges.left = Edge::Clamped;
        }),
        make("driven spinning sphere at a held edge", SPHERE, |p, case| {
            oblique(p);
            p.offset = [0.0, 8e-3];
            p.motion = Motion::Prescribed;
            case.pack.edges.top = Edge::Clamped;
        }),
    ]
}

/// Fabric of which a part is gone, or whose elements differ in size.
fn torn_or_graded() -> Vec<Scene> {
    vec![
        make("sphere under a weft", SPHERE, |_, _| {}),
        make("away from the fabric", SPHERE, |p, _| p.standoff = 2e-3),
        make("cylinder in front of a hole", CYLINDER, |_, _| {}),
        make("cylinder beside the middle of a graded ply, friction", CYLINDER, |p, case| {
            oblique(p);
            super::grade(case, [4e-3, 3e-3], 2.0);
        }),
        make("graded yarns cut close and far away", CYLINDER, |_, case| {
            (case.pack.columns, case.pack.rows, case.pack.plies) = (49, 43, 4);
            super::grade(case, [0.0; 2], 4.0);
        }),
        make("coarse row beside the middle", CYLINDER, |p, case| {
            (case.pack.columns, case.pack.rows) = (49, 43);
            super::grade(case, [-2e-2, -2e-2], 8.0);
            let mesh = &Model::<f32>::new(case).unwrap().ply_types[0].mesh;
            p.offset = mesh.reference(mesh.rows - 2, mesh.columns - 2);
        }),
        make("cylinder behind a faster flap", CYLINDER, |p, case| {
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
