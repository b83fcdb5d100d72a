//! States to compare kernels on: random and at the edges of what a run meets.

use ripstop::case::{Along, Case, Edge, Motion, Projectile, Rotation, Shape, ShearModulus};
use ripstop::kernels::element_force::field as element;
use ripstop::kernels::node_update::field as node;
use ripstop::model::Model;
use ripstop::state::State;

use crate::support::patch::{self, affine};
use crate::support::{CROSSOVERS, LAWS, Random, s720};

/// A state, and which kernels have something to do in it.
pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) case: Case,
    pub(crate) model: Model<f32>,
    pub(crate) state: State<f32>,
    /// Whether elements are evaluated; contact scenes bring random forces instead.
    pub(crate) elements: bool,
    /// Whether a free projectile meets held nodes.
    pub(crate) held: bool,
    /// Largest speed [m/s].
    pub(crate) speed: f64,
}

/// Uniform deformations (where the unit vectors along warp and weft go) and the noise added to them [element lengths];
/// every ply has its own: at rest, taut, breaking, compressed, sheared, sheared into locking, folded, collapsed.
const DEFORMATIONS: [([f64; 3], [f64; 3], f64); 8] = [
    ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 1e-3),
    ([1.025, 0.0, 0.01], [0.01, 1.015, 0.0], 0.004),
    ([1.045, 0.0, 0.0], [0.0, 1.035, 0.1], 0.02),
    ([0.92, 0.0, 0.1], [0.0, 0.9, 0.0], 0.02),
    ([1.0, 0.1, 0.0], [0.15, 1.0, 0.0], 0.02),
    ([0.95, -0.2, 0.0], [-0.6, 0.8, 0.0], 0.02),
    ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.4),
    ([0.2, 0.0, 0.0], [0.1, 0.25, 0.0], 0.02),
];

/// Every law, rigid and compressible, with the other terms in turn.
pub(crate) fn element_scenes() -> Vec<Scene> {
    let mut out = Vec::new();
    for (n, law) in LAWS.into_iter().enumerate() {
        for (c, compression) in CROSSOVERS.into_iter().enumerate() {
            let at = 2 * n + c;
            let mut case = patch::case(7, 5);
            case.fabric.crossover = s720(law, compression).crossover;
            match at % 3 {
                0 => secant(&mut case),
                1 => case.fabric.shear = None,
                _ => {}
            }
            if n % 2 == 1 {
                case.solver.hourglass = 0.0;
            }
            if n >= 2 {
                swap_yarns(&mut case);
            }
            let edges = [Edge::Free, Edge::Clamped, Edge::Roller, Edge::Free];
            case.pack.edges.left = edges[at % 4];
            case.pack.edges.right = edges[(at + 1) % 4];
            case.pack.edges.bottom = edges[(at + 2) % 4];
            case.pack.edges.top = edges[(at + at / 4) % 4];
            case.pack.plies = DEFORMATIONS.len() as u32;
            let step = if at == 2 || at == 4 { 0 } else { 17 };
            out.push(deformed(format!("{law:?}, {}", ["rigid", "compressible"][c]), case, step, at as u64));
        }
    }
    out.extend(special_scenes());
    out
}

/// One law, with something unusual about the mesh or the fabric.
fn special_scenes() -> Vec<Scene> {
    let plies = DEFORMATIONS.len() as u32;
    let special = |name: &str, columns: usize, rows: usize, change: &dyn Fn(&mut Case)| {
        let mut case = patch::case(columns, rows);
        change(&mut case);
        deformed(name.to_owned(), case, 3, 100 + columns as u64)
    };
    vec![
        special("one element", 1, 1, &|case| case.pack.plies = plies),
        special("several workgroups of the ledger", 33, 35, &|case| {
            case.pack.edges.left = Edge::Roller;
            case.pack.edges.bottom = Edge::Clamped;
        }),
        special("warp alone, one row", 70, 1, &|case| {
            case.pack.plies = plies;
            case.fabric.weft.present = false;
            case.fabric.weft.crimp = 0.0;
            case.pack.edges.left = Edge::Clamped;
            case.pack.edges.right = Edge::Clamped;
            case.pack.edges.bottom = Edge::Roller;
        }),
        special("yarns that do not touch and do not break, one column", 1, 70, &|case| {
            case.pack.plies = plies;
            case.fabric.crossover.gap = 1e-3;
            case.fabric.warp.failure_strain = 1.0;
            case.fabric.weft.failure_strain = 1.0;
            secant(case);
        }),
    ]
}

fn secant(case: &mut Case) {
    if let Some(shear) = &mut case.fabric.shear {
        shear.modulus = ShearModulus::Secant;
    }
}

/// Exchanges the fabric's yarns, so that the other one is the unknown of the unit cell.
fn swap_yarns(case: &mut Case) {
    std::mem::swap(&mut case.fabric.warp.modulus, &mut case.fabric.weft.modulus);
    std::mem::swap(&mut case.fabric.warp.linear_density, &mut case.fabric.weft.linear_density);
}

/// Plies deformed each in its own way; yarns, warm starts and last forces at random.
fn deformed(name: String, case: Case, step: u64, seed: u64) -> Scene {
    let model = Model::<f32>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    state.step = step;
    let mut random = Random(seed);
    let grid = model.grid;
    let speed = 30.0;
    for row in 0..grid.node_rows() {
        let (ply, in_ply) = grid.node_row(row);
        let (f1, f2, noise) = DEFORMATIONS[if grid.plies == 1 { 2 } else { ply % DEFORMATIONS.len() }];
        for column in 0..=grid.columns {
            let uniform = affine(f1, f2, grid.reference(in_ply, column));
            for a in 0..3 {
                let u = uniform[a] + noise * grid.length[a % 2] * random.between(-1.0, 1.0);
                state.nodes.set(row, node::DISPLACEMENT + a, column, u as f32);
                let free = model.row_mass(in_ply).inverse[a][column] > 0.0;
                let v = if free { random.between(-speed, speed) } else { 0.0 };
                state.nodes.set(row, node::VELOCITY + a, column, v as f32);
            }
        }
    }
    kill(&model, &mut state, &mut random, 0.1);
    random_elements(&model, &mut state, &mut random, 0.5);
    Scene { name, case, model, state, elements: true, held: false, speed }
}

/// Fails yarns: each with that probability, and as often both of an element.
fn kill(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, share: f64) {
    for row in 0..model.grid.element_rows() {
        for at in 1..=model.grid.columns {
            let [one, both] = [(); 2].map(|()| random.between(0.0, 1.0));
            for yarn in 0..2 {
                let mine = one < share * (yarn + 1) as f64 && share * yarn as f64 <= one;
                if mine || both < share {
                    state.elements.set(row, element::ALIVE + yarn, at, 0.0);
                }
            }
        }
    }
}

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

/// Warm starts beyond both ends of their range, and forces up to `share` of what breaks a yarn; eroded elements have none.
fn random_elements(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, share: f64) {
    let most = share * force_scale(model);
    let modes = model.element.hourglass[0] > 0.0;
    for row in 0..model.grid.element_rows() {
        for column in 0..model.grid.columns {
            let stands = if state.standing(row, column) { 1.0 } else { 0.0 };
            let at = column + 1;
            for field in 0..element::HEIGHT {
                let there = stands * if field < element::HOURGLASS || modes { 1.0 } else { 0.0 };
                state.elements.set(row, field, at, (there * random.between(-most, most)) as f32);
            }
            for yarn in 0..2 {
                let height = model.cell.height_sum * random.between(-0.2, 1.2);
                state.elements.set(row, element::HEIGHT + yarn, at, (stands * height) as f32);
            }
        }
    }
}

/// Force of an element whose stronger yarn is about to break [N].
pub(crate) fn force_scale(model: &Model<f32>) -> f64 {
    let yarn = |i: usize| model.cell.yarn[i].stiffness * 0.035 * model.element.membrane[i];
    yarn(0).max(yarn(1))
}

/// A steel-like projectile at 200 m/s.
fn projectile(shape: Shape) -> Projectile {
    Projectile {
        shape,
        edge_radius: 0.0,
        mass: 2e-5,
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
const OGIVE: Shape = Shape::Ogive { diameter: 7e-3, length: 8e-3, nose_length: 5e-3 };
const BLUNT: Shape = Shape::Ogive { diameter: 7e-3, length: 5e-3, nose_length: 5e-3 };
const FRAGMENT: Shape =
    Shape::Fragment { diameter: 7e-3, length: 6e-3, nose_flat: 3.2e-3, nose_angle: 0.611, roll: 0.5 };
const CONE: Shape = Shape::Cone { diameter: 7e-3, length: 8e-3, nose_length: 4e-3 };

/// Every shape, motion and kind of contact.
pub(crate) fn contact_scenes() -> Vec<Scene> {
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
        make("away from the fabric", SPHERE, &|p, _| p.standoff = 2e-3),
        make("cylinder in front of a hole", CYLINDER, &|_, _| {}),
        make("cylinder behind a faster plug", CYLINDER, &|p, case| {
            p.friction = 0.1;
            case.pack.edges.right = Edge::Clamped;
        }),
    ]
}

/// Fabric wrapped around the nose, a rounding to a step's travel away from it or inside it, at random speeds.
fn struck(name: &str, case: Case) -> Scene {
    let model = Model::<f32>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    let mut random = Random(name.len() as u64);
    let grid = model.grid;
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
    }
    for row in 0..grid.node_rows() {
        let (_, in_ply) = grid.node_row(row);
        for column in 0..=grid.columns {
            let [x, y] = grid.reference(in_ply, column);
            let mut at = nalgebra::Vector3::new(x, y, 0.0);
            if !touching {
                let inside = body.gap(&at).0 < 0.0;
                for _ in 0..30 {
                    let (gap, normal) = body.gap(&at);
                    let goes = inside && normal.z > 0.2;
                    at.z -= if goes { gap / normal.z } else { 0.0 };
                }
                let near = (at - body.position).xy().norm() < 1.5 * body.body.radius;
                if name.contains("edges") && near && random.between(0.0, 1.0) < 0.6 {
                    // Where the surface is nearest to a far point is an edge or a corner more often than a face; one in
                    // three lies about the axis, where the tip is.
                    let across = if random.between(0.0, 1.0) < 0.33 { 0.2 } else { 1.0 };
                    let [x, y, z] = random.vector(4.0 * body.body.reach);
                    let far = nalgebra::Vector3::new(across * x, across * y, z);
                    at = body.position + body.orientation.transform_vector(&far);
                    let (gap, normal) = body.gap(&at);
                    at -= normal * gap;
                }
                at += nalgebra::Vector3::from(random.vector(3e-6));
                if name.contains("rim") && random.between(0.0, 1.0) < 0.3 {
                    at.z -= 0.5e-3; // hangs behind the face, in its shadow or just beside it
                    let arm = at.xy() - body.position.xy();
                    if (arm.norm() - body.body.radius).abs() < 0.7e-3 {
                        let beside = body.position.xy() + arm * ((body.body.radius + 8e-6) / arm.norm());
                        (at.x, at.y) = (beside.x, beside.y);
                    }
                }
            }
            let moved = [at.x - x, at.y - y, at.z];
            for a in 0..3 {
                let free = model.row_mass(in_ply).inverse[a][column] > 0.0;
                // Away from the body as often as towards it.
                let forward = if a == 2 { if name.contains("plug") { 1.5 } else { 0.6 } } else { 0.0 };
                // One side is struck and turns the body; the other flies ahead of it until it does.
                let ahead = a == 2 && name.contains("one side") && at.x < body.position.x;
                let forward = if ahead { 0.92 } else { forward };
                let spread = if ahead { 1.0 } else { 40.0 };
                let v = if free { random.between(-spread, spread) + forward * speed } else { 0.0 };
                state.nodes.set(row, node::DISPLACEMENT + a, column, moved[a] as f32);
                state.nodes.set(row, node::VELOCITY + a, column, if touching { 0.0 } else { v as f32 });
            }
        }
    }
    if !touching {
        kill(&model, &mut state, &mut random, 0.3);
        if name == "sphere" {
            erode_around_a_node(&model, &mut state);
        }
        random_elements(&model, &mut state, &mut random, 0.2);
    }
    if name.contains("hole") {
        for (row, at) in (0..grid.rows).flat_map(|row| (1..=grid.columns).map(move |at| (row, at))) {
            state.elements.set(row, element::ALIVE + (row + at) % 2, at, 0.0);
        }
    }
    if name.contains("slit") {
        // What lies on the strip is torn; what lies on the flats is not.
        for (row, at) in (0..grid.rows).flat_map(|row| (1..=grid.columns).map(move |at| (row, at))) {
            let torn = (4..7).contains(&row);
            for yarn in 0..2 {
                state.elements.set(row, element::ALIVE + yarn, at, if torn { 0.0 } else { 1.0 });
            }
        }
    }
    state.body = Some(body);
    let held = name.contains("clamped");
    Scene { name: name.to_owned(), case, model, state, elements: false, held, speed }
}
