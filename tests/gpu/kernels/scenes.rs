//! States to compare kernels on: random and at the edges of what a run meets.

use ripstop::case::{
    Backing, BackingMaterial, Case, Edge, Frame, Grading, HitPlace, LinesFrom, Opening, Rate, Variability, YarnStrength,
};
use ripstop::model::Model;
use ripstop::solver::element_force::BROKEN;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::ActiveRegion;
use ripstop::solver::state::State;

use super::packs::{self, Group};
use crate::support::patch::{self, affine};
use crate::support::{CROSSOVERS, Random, SOLVER_LAWS};

/// A state, and the kernels that have something to do in it.
pub(crate) struct Scene {
    pub(crate) name: &'static str,
    pub(crate) model: Model<f32>,
    pub(crate) state: State<f32>,
    /// Whether it is for the elements; in scenes of contact their yarns are weak.
    pub(crate) elements: bool,
    /// Whether its plies meet.
    pub(crate) pack: bool,
    /// Whether a free projectile meets held nodes.
    pub(crate) held: bool,
    /// Largest speed [m/s].
    pub(crate) speed: f64,
}

/// Ply, row of the storage and column of every element.
pub(super) fn element_places(model: &Model<f32>) -> Vec<[usize; 3]> {
    let stored = |[ply, row, column]: [usize; 3]| [ply, model.grid.first_element_row(ply) + row, column];
    model.element_places().map(stored).collect()
}

/// Marks which yarns of an element are alive.
pub(super) fn set_yarns(state: &mut State<f32>, row: usize, column: usize, alive: [bool; 2]) {
    for (yarn, alive) in alive.into_iter().enumerate() {
        state.elements.set(row, element::ALIVE + yarn, column + 1, if alive { 1.0 } else { 0.0 });
    }
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

/// That of a single ply, which is long: noise alone takes no node far away.
const UNEVEN: ([f64; 3], [f64; 3], f64) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.02);

/// A scene of elements whose yarns have no shock viscosity, and no fields for it.
const WITHOUT_VISCOSITY: &str = "no shock viscosity";

/// Every law, rigid and compressible; then one law with something unusual about the mesh or the fabric.
pub(super) fn element_scenes() -> Vec<Scene> {
    let names = [["published, rigid", "published, compressible"], ["variational, rigid", "variational, compressible"]];
    let mut out = Vec::new();
    for (n, c) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let (at, mut case) = (4 * n + c, patch::case(7, 5));
        let crossover = &mut case.fabric.crossover;
        (crossover.law, crossover.compression, crossover.gap) = (SOLVER_LAWS[n], CROSSOVERS[c], 0.0);
        if at % 3 == 1 {
            case.fabric.shear = None;
        }
        if n == 1 {
            // The other yarn becomes the unknown of the unit cell.
            let (warp, weft) = (&mut case.fabric.warp, &mut case.fabric.weft);
            std::mem::swap(&mut warp.modulus, &mut weft.modulus);
            std::mem::swap(&mut warp.linear_density, &mut weft.linear_density);
        }
        let edge = |n: usize| [Edge::Free, Edge::Clamped, Edge::Roller, Edge::Free][n % 4];
        let edges = &mut case.pack.edges;
        [edges.left, edges.right, edges.bottom, edges.top] = [edge(at), edge(at + 1), edge(at + 2), edge(at + at / 4)];
        case.pack.plies = DEFORMATIONS.len() as u32;
        out.push(deformed(names[n][c], case, if at == 4 { 0 } else { 17 }, at as u64));
    }
    let groups = [Group::turned(0), Group::coarse(90), Group::turned(30), Group::coarse(0)];
    let mut graded_pack = packs::case([20, 17], &groups);
    grade(&mut graded_pack, [-2e-3, 3e-3], 4.0);
    out.extend([
        deformed("the first step of a part", patch::case(7, 6), 0, 201),
        deformed("graded plies of two fabrics", graded_pack, 3, 202),
    ]);
    out.extend(SPECIAL.map(|(name, [columns, rows], plies, change)| {
        let mut case = patch::case(columns, rows);
        case.pack.plies = plies;
        change(&mut case);
        deformed(name, case, 3, 100 + columns as u64)
    }));
    out
}

type Special = (&'static str, [usize; 2], u32, fn(&mut Case));

/// Name, columns and rows, plies, change.
const SPECIAL: [Special; 14] = [
    ("a round window, graded", [15, 26], 2, |case| {
        grade(case, [3e-3, -2e-3], 4.0);
        frame(case, Opening::Round, 0.0);
    }),
    ("a rectangle with a free side and clamps at its corners", [14, 12], 2, |case| {
        case.pack.edges.left = Edge::Clamped;
        frame(case, Opening::Rectangle, 3e-3);
    }),
    ("only a part reached", [7, 6], 8, |_| {}),
    ("against clay", [9, 6], 3, |case| {
        case.pack.edges.left = Edge::Clamped;
        against_clay(case, 2e7, Some(2e-3));
    }),
    (WITHOUT_VISCOSITY, [7, 5], 8, |_| {}),
    ("yarns with curves", [11, 5], 8, |case| {
        let bent = |modulus: f64, points: [[f64; 2]; 4]| points.map(|[strain, part]| [strain, part * modulus]).to_vec();
        let (warp, weft) = (&mut case.fabric.warp, &mut case.fabric.weft);
        warp.curve = bent(warp.modulus, [[0.0, 0.0], [0.006, 0.003], [0.015, 0.012], [0.04, 0.022]]);
        weft.curve = bent(weft.modulus, [[0.0, 0.0], [0.004, 0.004], [0.02, 0.01], [0.05, 0.035]]);
    }),
    ("stress by the rate of strain", [9, 5], 8, |case| case.fabric.rate = Some(Rate { c: 2e4, p: 5.0 })),
    ("graded", [13, 26], 8, |case| {
        grade(case, [3e-3, -2e-3], 4.0);
        case.pack.edges.left = Edge::Roller;
        case.pack.edges.top = Edge::Clamped;
    }),
    ("graded, more lines than fit into a row of their table", [2600, 1], 1, |case| grade(case, [0.0; 2], 1.2)),
    ("failure over a length", [13, 9], 8, |case| narrow(case, [0.5, 0.4], 3.3e-3)),
    ("a yarn strained on one side", [17, 13], 8, |case| narrow(case, [0.25, 0.2], 0.7e-3)),
    ("failure over a length, graded", [13, 26], 8, |case| {
        narrow(case, [0.5, 0.4], 2.1e-3);
        grade_from(case, [3e-3, -2e-3], 4.0, LinesFrom::Hit);
    }),
    ("pieces of yarn of different strength, over a length", [13, 26], 8, |case| {
        narrow(case, [0.5, 0.4], 2.1e-3);
        grade_from(case, [3e-3, -2e-3], 4.0, LinesFrom::Hit);
        case.variability = Some(Variability {
            seed: 7,
            shot: Some(3),
            hit: HitPlace::Aimed,
            velocity: None,
            obliquity: None,
            yaw: None,
            modulus: None,
            crimp: None,
            yarn_strength: Some(YarnStrength {
                shape: 4.0,
                gauge_length: 1e-3,
                shortest_gauge: 1e-5,
                yarn_shape: Some(6.0),
            }),
        });
    }),
    ("several workgroups of the energy balance", [33, 35], 1, |case| {
        case.pack.edges.left = Edge::Roller;
        case.pack.edges.bottom = Edge::Clamped;
    }),
];

/// Clay behind the pack. Of 20 MPa it takes about a quarter of the speeds of the scenes of elements in a step.
pub(super) fn against_clay(case: &mut Case, pressure: f64, doubling_depth: Option<f64>) {
    case.backing = Some(Backing { material: BackingMaterial::Clay, gap: 0.01e-3, pressure, doubling_depth });
}

/// A frame whose opening is three quarters of the mesh, around its middle.
pub(super) fn frame(case: &mut Case, opening: Opening, corner: f64) {
    if opening == Opening::Round {
        let edges = &mut case.pack.edges;
        [edges.left, edges.right, edges.bottom, edges.top] = [Edge::Clamped; 4];
    }
    let mesh = &mut case.pack.mesh;
    let half = [0, 1].map(|axis| 0.375 * mesh.count[axis] as f64 * mesh.length[axis]);
    mesh.frame = Frame { opening, half, corner };
}

/// Elements that are narrower than the yarns, and a failure length [m].
fn narrow(case: &mut Case, [x, y]: [f64; 2], failure_length: f64) {
    case.pack.mesh.length[0] *= x;
    case.pack.mesh.length[1] *= y;
    case.solver.failure_length = failure_length;
}

/// Elements that grow away from a place in the pack up to a multiple of the finest.
pub(super) fn grade(case: &mut Case, hit: [f64; 2], coarsest: f64) {
    grade_from(case, hit, coarsest, LinesFrom::Edges);
}

/// Likewise, with lines counted from that place or from the edges.
fn grade_from(case: &mut Case, hit: [f64; 2], coarsest: f64, lines_from: LinesFrom) {
    let grading =
        Some(Grading { hit, way: [0.0; 2], fine: [1e-3; 2], growth_ratio: 1.6, max_size: coarsest, lines_from });
    case.pack.mesh.grading = grading;
    case.pack.layup.iter_mut().for_each(|layer| layer.mesh.grading = grading);
}

/// Stiffness of weak yarns over that of others.
const WEAK: f64 = 1e-5;

/// Yarns so weak that random places strain none too much, and that never break.
pub(super) fn weaken(mut model: Model<f32>) -> Model<f32> {
    for ply_type in &mut model.ply_types {
        for yarn in &mut ply_type.cell.yarn {
            (yarn.stiffness, yarn.failure_strain) = (WEAK * yarn.stiffness, 1e3);
        }
        ply_type.element.hourglass = ply_type.element.hourglass.map(|stiffness| WEAK * stiffness);
    }
    model
}

/// Plies deformed each in its own way; yarns, warm starts and last forces at random.
fn deformed(name: &'static str, mut case: Case, step: u64, seed: u64) -> Scene {
    case.solver.shock_viscosity = if name == WITHOUT_VISCOSITY { 0.0 } else { 0.3 };
    let model = Model::<f32>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    state.step = step;
    let (mut random, speed) = (Random(seed), 30.0);
    for [ply, row, column] in model.node_places() {
        let ply_type = model.ply_type(ply);
        let (f1, f2, noise) = if model.grid.plies == 1 { UNEVEN } else { DEFORMATIONS[ply % DEFORMATIONS.len()] };
        let uniform = affine(f1, f2, ply_type.mesh.reference(row, column));
        let at = model.grid.first_node_row(ply) + row;
        for a in 0..3 {
            let u = uniform[a] + noise * ply_type.mesh.length[a % 2] * random.between(-1.0, 1.0);
            state.nodes.set(at, node::DISPLACEMENT + a, column, u as f32);
            let free = ply_type.row_mass(row).inverse[a][column] > 0.0;
            let v = if free { random.between(-speed, speed) } else { 0.0 };
            state.nodes.set(at, node::VELOCITY + a, column, v as f32);
        }
    }
    state.reach_everything(&model);
    kill(&model, &mut state, &mut random, 0.1);
    random_elements(&model, &mut state, &mut random);
    if name.contains("part") {
        rest_outside(&model, &mut state, &ActiveRegion { rows: 2..4, columns: 1..5 });
    }
    if name.contains("one side") {
        strain_one_side(&model, &mut state);
    }
    Scene { name, model, state, elements: true, pack: false, held: false, speed }
}

/// Reaches a part of every ply alone. Nodes with an element outside are at rest in their places, and so are elements outside: both backends
/// compute some of those, too.
fn rest_outside(model: &Model<f32>, state: &mut State<f32>, part: &ActiveRegion) {
    for [ply, row, column] in model.node_places() {
        let inside = (part.rows.start + 1..part.rows.end).contains(&row)
            && (part.columns.start + 1..part.columns.end).contains(&column);
        let at = model.grid.first_node_row(ply) + row;
        for a in (0..3).filter(|_| !inside) {
            state.nodes.set(at, node::DISPLACEMENT + a, column, 0.0);
            state.nodes.set(at, node::VELOCITY + a, column, 0.0);
        }
    }
    let first = state.elements.fields - element::STRAIN;
    for [ply, row, column] in element_places(model) {
        let inside = part.rows.contains(&(row - model.grid.first_element_row(ply))) && part.columns.contains(&column);
        let whole = (0..2).all(|yarn| state.alive(row, column, yarn));
        for yarn in (0..2).filter(|_| !inside) {
            let strain = if state.alive(row, column, yarn) { 0.0 } else { BROKEN as f32 };
            let height = if whole { model.ply_type(ply).initial.height[yarn] as f32 } else { 0.0 };
            for (field, value) in [(first, strain), (element::HEIGHT, height), (element::COUNT, 0.0)] {
                state.elements.set(row, field + yarn, column + 1, value);
            }
        }
    }
    state.active.fill(part.clone());
}

/// One row of elements of each yarn strained to about twice what breaks it, the others hardly.
fn strain_one_side(model: &Model<f32>, state: &mut State<f32>) {
    let (mut random, first) = (Random(79), state.elements.fields - element::STRAIN);
    for [ply, row, column] in element_places(model) {
        for (yarn, across) in [row - model.grid.first_element_row(ply), column].into_iter().enumerate() {
            let over = if across % 4 == 1 { random.between(1.5, 2.8) } else { random.between(0.0, 0.6) };
            if state.alive(row, column, yarn) {
                let strain = model.ply_type(ply).cell.yarn[yarn].failure_strain * over;
                state.elements.set(row, first + yarn, column + 1, strain as f32);
            }
        }
    }
}

/// Fails yarns: each with that probability, and as often both of an element.
pub(super) fn kill(model: &Model<f32>, state: &mut State<f32>, random: &mut Random, share: f64) {
    for [_, row, column] in element_places(model) {
        let [one, both] = [(); 2].map(|()| random.between(0.0, 1.0));
        for yarn in 0..2 {
            let mine = one < share * (yarn + 1) as f64 && share * yarn as f64 <= one;
            if mine || both < share {
                state.elements.set(row, element::ALIVE + yarn, column + 1, 0.0);
            }
        }
    }
}

/// Warm starts beyond both ends of their range, and viscous forces up to a part of what breaks a yarn; eroded elements have none, nor have
/// those that nothing has reached.
pub(super) fn random_elements(model: &Model<f32>, state: &mut State<f32>, random: &mut Random) {
    let ply_type = &model.ply_types[0];
    let (mut drags, mut strains) = (Random(77), Random(78));
    for [ply, row, column] in element_places(model) {
        let [rows, columns] = state.active[ply].elements(&model.ply_type(ply).mesh);
        let reached = rows.contains(&(row - model.grid.first_element_row(ply))) && columns.contains(&column);
        let stands = if reached && state.is_intact(row, column) { 1.0 } else { 0.0 };
        let at = column + 1;
        for viscous in 0..if model.features().viscous { element::VISCOUS } else { 0 } {
            let force = stands * 0.002 * ply_type.cell.yarn[viscous].stiffness;
            state.elements.set(row, element::COUNT + viscous, at, (drags.between(-1.0, 1.0) * force) as f32);
        }
        for yarn in 0..if model.features().rate { element::RATE } else { 0 } {
            let added = stands * drags.between(0.0, 1.2);
            state.elements.set(row, element::COUNT + element::VISCOUS + yarn, at, added as f32);
        }
        for yarn in 0..2 {
            // From slack to as far beyond failure as a step strains a yarn.
            let limit = model.ply_type(ply).cell.yarn[yarn].failure_strain.min(0.05);
            let whole = reached && state.alive(row, column, yarn);
            let strain = if whole { limit * strains.between(0.5, 1.4) } else { BROKEN };
            state.elements.set(row, state.elements.fields - element::STRAIN + yarn, at, strain as f32);
            let height = ply_type.cell.height_sum * random.between(-0.2, 1.2);
            state.elements.set(row, element::HEIGHT + yarn, at, (stands * height) as f32);
        }
    }
}
