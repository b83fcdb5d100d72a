//! Plies around touch: gaps and penetrations, rubbing, walking over each other's cells, with holes, at every angle.

use nalgebra::Vector3;
use ripstop::case::{self, Case};
use ripstop::model::Model;
use ripstop::model::layup::{PENETRATING, SIDES, neighbour};
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::ActiveRegion;
use ripstop::solver::state::State;
use serde_json::{Value, json};

use super::scenes::{Scene, against_clay, grade, kill, random_elements, weaken};
use crate::support::Random;
use crate::support::patch::fabric;

/// Largest component of the velocity of a node [m/s].
const SPEED: f64 = 200.0;
/// Slopes of the pack along X and Y: no direction of contact lies along an axis.
const SLOPE: [f64; 2] = [0.3, -0.2];

/// A ply of a pack.
#[derive(Clone, Copy)]
pub(super) struct Group {
    /// Direction of the warp [deg].
    angle: i32,
    /// Whether it is of the other fabric, with fewer yarns.
    coarse: bool,
    /// Left, right, bottom, top.
    edges: [&'static str; 4],
}

impl Group {
    /// A free ply of the fabric of the patches.
    pub(super) const fn turned(angle: i32) -> Self {
        Self { angle, coarse: false, edges: ["free"; 4] }
    }

    /// A free ply of another fabric.
    pub(super) const fn coarse(angle: i32) -> Self {
        Self { coarse: true, ..Self::turned(angle) }
    }

    pub(super) const fn with(self, edges: [&'static str; 4]) -> Self {
        Self { edges, ..self }
    }

    fn json(self) -> Value {
        let [left, right, bottom, top] = self.edges;
        let edges = json!({"left": left, "right": right, "bottom": bottom, "top": top});
        let mut group = json!({"plies": 1, "orientation_deg": self.angle, "edges": edges});
        if self.coarse {
            group["fabric"] = fabric("coarse", [15, 12], 0.2, 190.0);
        }
        group
    }
}

/// A pack of the fabric of the patches, sized in its columns and rows, flying at the speed of the scenes.
pub(super) fn case([columns, rows]: [usize; 2], groups: &[Group]) -> Case {
    let document = json!({
        "title": "pack",
        "fabric": fabric("unequal", [20, 15], 0.3, 255.2),
        "pack": {
            "width_mm": columns as f64 * 25.4 / 20.0, "height_mm": rows as f64 * 25.4 / 15.0, "edges": "free",
            "friction": 0.3, "initial_velocity_m_s": [0, 0, SPEED],
            "layup": groups.iter().map(|group| group.json()).collect::<Vec<_>>(),
        },
        "solver": {"end_time_us": 10, "hourglass": 0.05, "numerics": "paper"},
    });
    case::from_str("pack.json", &document.to_string(), &[]).unwrap()
}

/// Moves the cells that nodes are over by one or two: which cell it is says the state, not the reference place.
pub(super) fn astray(model: &Model<f32>, state: &mut State<f32>, random: &mut Random) {
    let across = model.grid.columns + 1;
    for (at, part) in state.over.chunks_mut(model.nodes_per_ply()).enumerate() {
        let (ply, side) = (at / SIDES, at % SIDES);
        let Some(other) = neighbour(ply, side, model.plies.len()) else { continue };
        let (own, theirs) = (&model.ply_type(ply).mesh, &model.ply_type(other).mesh);
        for (row, column) in (0..=own.rows).flat_map(|row| (0..=own.columns).map(move |column| (row, column))) {
            let cell = &mut part[row * across + column];
            let moved = |at: u32, count: usize, by: f64| (f64::from(at) + by).round().clamp(0.0, count as f64 - 1.0);
            let columns = theirs.columns as u32;
            let [r, c] = [random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
            let place = [moved(*cell / columns, theirs.rows, r), moved(*cell % columns, theirs.columns, c)];
            *cell = place[0] as u32 * columns + place[1] as u32;
        }
    }
}

/// Properties of a state that differ from the plain one.
#[derive(Clone, Copy)]
struct Kind {
    step: u64,
    /// Distance of plies sideways, at most [cells].
    cells: f64,
    /// Part of the yarns that are broken.
    holes: f64,
    /// Whether a strip of the second ply is folded flat.
    folded: bool,
    /// Rises of the second ply between its even rows and columns, which are ridges [m].
    pleats: f64,
    /// Nodes of the first ply that may have moved (rows, columns); all of every ply where none are given.
    reach: Option<[usize; 4]>,
}

const PLAIN: Kind = Kind { step: 17, cells: 3.0, holes: 0.0, folded: false, pleats: 0.0, reach: None };

type Pack = (&'static str, [usize; 2], &'static [Group], Kind, fn(&mut Case));

const ROLLERS: [&str; 4] = ["roller", "free", "clamped", "roller"];
const OTHERS: [&str; 4] = ["free", "clamped", "roller", "free"];
const SIDES_HELD: [&str; 4] = ["clamped", "free", "clamped", "free"];
const ONE_HELD: [&str; 4] = ["free", "clamped", "free", "free"];
const ALIKE: &[Group] = &[Group::turned(0), Group::turned(0)];

/// Name, columns and rows of the fabric of the patches, plies, state, change: every angle, fabric, edge and kind of contact.
const PACKS: [Pack; 11] = [
    ("two free plies", [9, 8], ALIKE, Kind { holes: 0.1, ..PLAIN }, |_| {}),
    ("plies against clay", [9, 8], ALIKE, PLAIN, |case| against_clay(case, 2e7, None)),
    (
        "quarter turns, rollers",
        [9, 8],
        &[Group::turned(0).with(ROLLERS), Group::turned(90).with(ROLLERS), Group::turned(-90).with(OTHERS)],
        Kind { cells: 1.0, ..PLAIN },
        |case| case.pack.spacing = Some(0.2e-3),
    ),
    (
        "thirty degrees, clamped, smooth",
        [9, 8],
        &[Group::turned(0).with(SIDES_HELD), Group::turned(30).with(SIDES_HELD), Group::turned(-30).with(ONE_HELD)],
        Kind { holes: 0.1, ..PLAIN },
        |case| case.pack.friction = 0.0,
    ),
    (
        "two fabrics, holes, no hourglass",
        [9, 8],
        &[Group::turned(0), Group::coarse(0), Group::coarse(30), Group::turned(90)],
        Kind { holes: 0.4, ..PLAIN },
        |case| (case.solver.hourglass, case.pack.spacing) = (0.0, Some(0.4e-3)),
    ),
    (
        "the first step",
        [9, 8],
        &[Group::coarse(90), Group::turned(0).with(SIDES_HELD)],
        Kind { step: 0, ..PLAIN },
        |case| case.pack.friction = 1.2,
    ),
    ("ridges", [24, 20], ALIKE, Kind { cells: 0.0, pleats: 3e-4, holes: 0.3, ..PLAIN }, |_| {}),
    (
        "folded cells",
        [9, 8],
        &[Group::turned(0), Group::turned(0), Group::coarse(0)],
        Kind { folded: true, cells: 0.7, ..PLAIN },
        |_| {},
    ),
    (
        "resting plies",
        [9, 8],
        &[Group::turned(0), Group::turned(90), Group::turned(0), Group::coarse(30)],
        Kind { reach: Some([3, 6, 4, 7]), ..PLAIN },
        |_| {},
    ),
    // Far from the centre, and early: what sees what is decided by places, not by the room for travel. A gap of two
    // micrometres keeps rounding from deciding what touches where the motion dies out.
    (
        "resting plies, a corner",
        [16, 14],
        &[Group::turned(0), Group::turned(90), Group::turned(0)],
        Kind { step: 1, reach: Some([1, 4, 11, 14]), ..PLAIN },
        |case| case.pack.spacing = Some(0.302e-3),
    ),
    (
        "graded plies",
        [30, 26],
        &[Group::turned(0), Group::turned(90), Group::coarse(30), Group::turned(0)],
        Kind { cells: 1.0, holes: 0.1, ..PLAIN },
        |case| {
            case.solver.shock_viscosity = 0.3;
            grade(case, [2e-3, -3e-3], 8.0);
        },
    ),
];

pub(super) fn scenes() -> Vec<Scene> {
    PACKS.map(pack).into()
}

fn pack((name, size, groups, kind, change): Pack) -> Scene {
    let mut case = case(size, groups);
    (case.pack.friction, case.solver.hourglass, case.solver.shock_viscosity) = (0.3, 0.05, 0.0);
    change(&mut case);
    let model = weaken(Model::new(&case).unwrap());
    let mut state = State::new(&case, &model);
    state.step = kind.step;
    let mut random = Random(1000 + name.len() as u64);
    match kind.reach {
        Some(reach) => rest(&model, &mut state, &mut random, reach),
        None => scatter(&model, &mut state, &mut random, &kind),
    }
    kill(&model, &mut state, &mut random, kind.holes);
    were_inside(&model, &mut state, &mut random);
    random_elements(&model, &mut state, &mut random);
    Scene { name, model, state, elements: false, pack: true, held: false, speed: SPEED }
}

/// Half of the nodes that may have moved were inside their neighbours before, wherever they are now.
fn were_inside(model: &Model<f32>, state: &mut State<f32>, random: &mut Random) {
    let across = model.grid.columns + 1;
    for (at, part) in state.over.chunks_mut(model.nodes_per_ply()).enumerate() {
        let reach = &state.active[at / SIDES];
        for (node, over) in part.iter_mut().enumerate() {
            let moves = reach.rows.contains(&(node / across)) && reach.columns.contains(&(node % across));
            *over |= if moves && random.between(0.0, 1.0) < 0.5 { PENETRATING } else { 0 };
        }
    }
}

/// Gives a node a displacement [m] and a velocity [m/s], both in the axes of the pack; held directions stand still.
fn put(
    model: &Model<f32>,
    state: &mut State<f32>,
    [ply, row, column]: [usize; 3],
    moved: &Vector3<f64>,
    speed: [f64; 3],
) {
    let ply_type = model.ply_type(ply);
    let [moved, velocity] = [(*moved).into(), speed].map(|v| ply_type.mesh.to_ply(v));
    let at = model.grid.first_node_row(ply) + row;
    for a in 0..3 {
        let free = ply_type.row_mass(row).inverse[a][column] > 0.0;
        let velocity = if free { velocity[a] } else { 0.0 };
        state.nodes.set(at, node::DISPLACEMENT + a, column, moved[a] as f32);
        state.nodes.set(at, node::VELOCITY + a, column, velocity as f32);
    }
}

/// Sloping plies shifted sideways against each other, their gaps around zero by what closes in a step or two; here and
/// there a node is deep inside its neighbour, or through it.
fn scatter(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, kind: &Kind) {
    state.reach_everything(model);
    let slope = SLOPE[0].hypot(SLOPE[1]).hypot(1.0);
    let mut depth = 0.0;
    for ply in 0..model.grid.plies {
        let mesh = &model.ply_type(ply).mesh;
        let [sx, sy] = [0, 1].map(|a| kind.cells * mesh.length[a] * random.between(-1.0, 1.0));
        for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
            let reference = Vector3::from(model.reference(ply, row, column));
            let noise = Vector3::from(random.vector(0.1 * mesh.shortest()));
            let folds = if kind.folded && ply == 1 && column == 4 { -0.98 * mesh.size(0, column - 1)[0] } else { 0.0 };
            let [fx, fy, _] = mesh.to_pack([folds, 0.0, 0.0]);
            let [x, y] = [reference.x + sx + noise.x + fx, reference.y + sy + noise.y + fy];
            let near = random.between(-1.5e-5, 1.5e-5);
            // One in ten goes deep into the neighbour in front, one in fifty all the way through it.
            let deep = match random.between(0.0, 1.0) {
                u if u < 0.02 => -8e-4,
                u if u < 0.1 => random.between(-2e-4, 0.0),
                _ => 0.0,
            };
            // Where the second ply is furthest behind, nodes of the first are behind it still.
            let far = (row % 2 + column % 2) as f64;
            let pleat = match ply {
                1 => kind.pleats * far,
                _ if kind.pleats > 0.0 && far == 2.0 => 2.0 * kind.pleats + 1.6 * model.plies[0].touching,
                _ => 0.0,
            };
            let z = SLOPE[0] * x + SLOPE[1] * y + (depth + near + deep + pleat) * slope;
            let speed = random.vector(SPEED / 3.0_f64.sqrt());
            put(model, state, [ply, row, column], &(Vector3::new(x, y, z) - reference), speed);
        }
        depth += model.plies[ply].touching;
    }
}

/// Plies at rest and in touch, but for a few nodes of the first, which move about.
fn rest(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, [top, bottom, left, right]: [usize; 4]) {
    for place in model.node_places() {
        put(model, state, place, &Vector3::zeros(), [0.0; 3]);
    }
    state.active.fill(ActiveRegion::default());
    state.active[0] = ActiveRegion { rows: top..bottom, columns: left..right };
    for (row, column) in (top..bottom).flat_map(|row| (left..right).map(move |column| (row, column))) {
        let moved = Vector3::from(random.vector(1e-5));
        let [x, y, z] = random.vector(0.4 * SPEED);
        put(model, state, [0, row, column], &moved, [x, y, z + 0.4 * SPEED]);
    }
}
